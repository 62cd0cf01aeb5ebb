"""The two worlds of the proof: whose cases are drawn, simulated and handed to the engines alike."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.blind.generator import cases as own
from benchmarks.blind.generator.effects_string import zone_middle
from benchmarks.blind.hidden import Hidden, kept_records
from benchmarks.blind.other_world import cases as other
from benchmarks.blind.other_world.effects_string import zone
from benchmarks.blind.other_world.rig import DENSITY
from drillid.arrays import Floats
from drillid.fleet.provenance import digest, source_hash

AnyCase = own.Case | other.Case
FOLDER = Path("results/blind")
STANDS = 0.01
"""Share of the time from which a bit counts as standing."""
SELDOM = 0.02
"""s, interval of the control from which its samples show in a record of 50 Hz."""
OFF_DOCUMENTS = 4.0
"""Tolerances by which documents may be off before it is a fault of its own: once in 16,000 where errors are normal."""


@dataclass(frozen=True)
class World:
    """A generator of cases."""

    name: str
    plain_case: Callable[..., tuple[Any, np.random.Generator]]
    """Seed and number of windows → a case without hidden causes, and the generator for further draws."""
    effects: Mapping[str, Any]

    @property
    def named(self) -> list[str]:
        """Causes that the vocabulary has a name for, in turn."""
        return [name for name, effect in self.effects.items() if effect.in_catalogue]

    @property
    def nameless(self) -> list[str]:
        """Effects that no catalogue holds."""
        return [name for name, effect in self.effects.items() if not effect.in_catalogue]


WORLDS = {
    world.name: world
    for world in (World("own", own.plain_case, own.EFFECTS), World("other", other.plain_case, other.EFFECTS))
}


def world_of(case: AnyCase) -> World:
    """The world that a case belongs to."""
    return WORLDS["own" if isinstance(case, own.Case) else "other"]


def records_of(case: AnyCase) -> own.Records:
    """Records of a case, cached in a file."""
    if isinstance(case, own.Case):
        return own.simulate_case(case)
    simulated = partial(other.simulated, case)
    return own.Records(**kept_records(records_path(case), len(case.segments), simulated))


def simulated(case: AnyCase, window: int, nuisances: Floats) -> dict[str, Floats]:
    """Channels of one window, each (samples,), of a case's rig with other nuisances, offsets from the truth (12,)."""
    module = own if isinstance(case, own.Case) else other
    return module.simulated(case, window, nuisances=nuisances)


def records_path(case: AnyCase) -> Path:
    """Cache file of a case's records, named after a hash of the simulator's code and input."""
    if isinstance(case, own.Case):
        return case.path
    windows = [str(case.window(number)) for number in range(len(case.segments))]
    key = [source_hash("benchmarks.blind.other_world.cases"), windows, case.seed, case.command_logged]
    return FOLDER / "cases" / f"{digest(key)}.npz"


def bit_stands(case: AnyCase) -> bool:
    """Whether the bit stands for some of the time in any of a case's windows."""
    return bool(records_of(case).standing.max() > STANDS)


def documents(case: AnyCase) -> Any:
    """What the engine is told of the rig."""
    return case.data_sheet if isinstance(case, own.Case) else case.sheet


def depths(case: AnyCase) -> tuple[Floats, Floats]:
    """Hole and bit depth of the windows, (W,) m."""
    collars = float(case.equipment.collars.length) if isinstance(case, own.Case) else case.rig.collar_length
    hole = np.array([segment.hole_depth for segment in case.segments])
    return hole, np.array([segment.pipe_length for segment in case.segments]) + collars


def weight(case: AnyCase) -> float:
    """Mean weight on bit, N."""
    return case.equipment.weight_on_bit if isinstance(case, own.Case) else case.rig.weight_on_bit


def present(case: AnyCase) -> frozenset[str]:
    """Causes that a rig has by its own nature, in a size that may be seen: a control that reads the speed seldom, and
    a clock or a travel time so far off the tolerance that its documents state that no normal error explains it.
    """
    if isinstance(case, own.Case):
        return frozenset()
    rig, sheet = case.rig, case.sheet
    off = {
        "clock_offset": abs(rig.recording.offset) / sheet.clock_error,
        "wave_speed": abs(rig.pipe.density / DENSITY - 1) / sheet.length_relative,
    }
    seldom = {"sample_and_hold"} if rig.control.interval >= SELDOM else set()
    return frozenset(seldom | {name for name, deviations in off.items() if deviations > OFF_DOCUMENTS})


def place(case: AnyCase, hidden: Hidden) -> float:
    """Depth of the middle of a zone of damping, m."""
    if isinstance(case, own.Case):
        return zone_middle(case.context(hidden))
    return zone(case.context(hidden))[0]
