"""Wells of a rig with a hidden effect, and the size at which the ideal test begins to see it, simulated in time."""

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from benchmarks.blind.generator import cases as own
from benchmarks.blind.generator.effect import Effect
from benchmarks.blind.generator.rigs import draw_data_sheet, draw_equipment, draw_segments
from benchmarks.blind.generator.world import World, base_world
from benchmarks.blind.hidden import Hidden
from benchmarks.blind.ideal.ideal import Ideal
from benchmarks.blind.ideal.own import OwnResponses
from benchmarks.blind.ideal.responses import Kind
from benchmarks.kept import pickled
from benchmarks.learn.effects import HIDEABLE
from benchmarks.learn.law_effects import LAWS
from benchmarks.learn.measurement import FOLDER
from drillid.arrays import Floats
from drillid.config.settings import Settings
from drillid.discrepancy.evidence import Evidence, OperatingPoints
from drillid.discrepancy.gather import Series, gather
from drillid.fleet.provenance import digest, source_hash

WINDOWS = 12
LEARNING = 4
"""The first windows, which learning has."""
SEEN = 6.0
"""√λ of the ideal test, unaware of the effect, at which half of all sets would be told."""
_SEAL = 90210
_ROUNDS, _CLOSE = 12, 0.04
_EFFECTS: Mapping[str, Effect] = own.EFFECTS | {name: each.effect for name, each in (HIDEABLE | LAWS).items()}


@dataclass(frozen=True)
class Case(own.Case):
    """A well with what is hidden in it."""

    def world(self, window: int, nuisances: Floats | None = None, hidden: tuple[Hidden, ...] | None = None) -> World:
        """One window with the hidden effects, or with other ones."""
        world = base_world(self.equipment, self.segments[window], nuisances)
        for effect in self.hidden if hidden is None else hidden:
            world = _EFFECTS[effect.name].apply(world, effect.size, self.context(effect))
        return world


class CaseResponses(OwnResponses):
    """A case for the ideal test."""

    effects: Mapping[str, Kind] = _EFFECTS


def well(rig: int, number: int, windows: int = WINDOWS) -> Case:
    """A well of a rig without anything hidden: the rig's seed draws the equipment, the number the drilling."""
    equipment = draw_equipment(np.random.default_rng([_SEAL, rig]))
    generator = np.random.default_rng([_SEAL, rig, number])
    segments = draw_segments(generator, equipment, windows)
    sheet = draw_data_sheet(generator, equipment)
    return Case(100 * rig + number, equipment, segments, sheet, (), True, bool(generator.random() < 0.7))


@dataclass(frozen=True)
class Seen:
    """How large an effect must be in a well to be seen."""

    size: float
    """At which √λ is SEEN; infinite where its largest is not seen."""
    largest: float
    shape: float
    """Drawn for the rig."""


def seen(case: Case, name: str) -> Seen:
    """The size of an effect at which the ideal test begins to see it in the windows of a well that learning has."""
    case = replace(case, segments=case.segments[:LEARNING])
    shape = float(np.random.default_rng([_SEAL, case.seed // 100, len(name)]).random())
    ideal = Ideal(case, CaseResponses(case))
    low, largest = HIDEABLE[name].effect.range(case.world(0, hidden=()), case.context(Hidden(name, 0.0, shape)))
    high = largest
    for _ in range(_ROUNDS):
        middle = float(np.sqrt(low * high))
        reached = np.sqrt(max(ideal.noncentrality((Hidden(name, middle, shape),)), 0.0))
        if abs(reached / SEEN - 1) < _CLOSE:
            return Seen(middle, largest, shape)
        low, high = (low, middle) if reached > SEEN else (middle, high)
    return Seen(np.inf, largest, shape)


def evidence_of(case: Case) -> Evidence:
    """Evidence about a case from its simulated logs, without detections; kept in a file."""
    code = source_hash("drillid.discrepancy.gather", "drillid.simulation.simulate", "benchmarks.learn.cases")
    path = FOLDER / "evidence" / f"{digest([code, str(case)])}.pickle"
    return pickled(path, lambda: _gathered(case))


def _gathered(case: Case) -> Evidence:
    windows = [own.simulated(case, number) for number in range(len(case.segments))]
    lost = np.full_like(windows[0]["speed"], np.nan)
    series = [
        Series(window["sweep"], window["speed"], window["command"] if case.command_logged else lost)
        for window in windows
    ]
    points = OperatingPoints(
        np.array([segment.hole_depth for segment in case.segments]),
        np.array([segment.pipe_length for segment in case.segments]) + float(case.equipment.collars.length),
        np.array([window["speed"].mean() for window in windows]),
        np.array([window["command"].mean() for window in windows]),
        np.full(len(windows), case.equipment.weight_on_bit),
    )
    return gather(series, own.RATE, points, case.data_sheet, Settings(), detecting=False)
