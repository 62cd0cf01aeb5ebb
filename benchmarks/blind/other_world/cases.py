"""Sealed cases of the second world: what is hidden is drawn from a seed, and the data are simulated by themselves."""

from dataclasses import dataclass

import numpy as np

from benchmarks.blind.hidden import Hidden, Sealed
from benchmarks.blind.other_world import effects_string, effects_top
from benchmarks.blind.other_world.effect import Context, Effect
from benchmarks.blind.other_world.record import record
from benchmarks.blind.other_world.rig import Window
from benchmarks.blind.other_world.rigs import Rig, Segment, Sheet, base_window, draw_rig, draw_segments, draw_sheet
from benchmarks.blind.other_world.simulate import simulate
from drillid.arrays import Floats
from drillid.excitation.torques import SWEEP_PERIOD

EFFECTS: dict[str, Effect] = {
    effect.name: effect for module in (effects_top, effects_string) for effect in module.EFFECTS
}
"""All that can be hidden."""
WINDOW_S = 600.0
_STANDING = 0.05
"""Share of its mean speed below which the bit stands."""
_SEAL = 31415
"""First element of the seeds of all cases."""


@dataclass(frozen=True)
class Case(Sealed):
    """One sealed case."""

    seed: int
    rig: Rig
    segments: tuple[Segment, ...]
    sheet: Sheet
    hidden: tuple[Hidden, ...]
    removed: bool
    """Whether the catalogue lacks the hidden cause, or the engine's copy of it does."""
    command_logged: bool

    def context(self, hidden: Hidden, window: int = 0) -> Context:
        """Context for the effect of a hidden cause in a window."""
        return Context(self.rig, self.segments[window], self.segments[0], hidden.shape, self.seed)

    def window(self, number: int, hidden: tuple[Hidden, ...] | None = None, nuisances: Floats | None = None) -> Window:
        """One window with the hidden causes, or with other ones."""
        window = base_window(self.rig, self.segments[number], nuisances)
        for cause in self.hidden if hidden is None else hidden:
            window = EFFECTS[cause.name].apply(window, cause.size, self.context(cause, number))
        return window


def plain_case(seed: int, windows: int | None = None) -> tuple[Case, np.random.Generator]:
    """A case without hidden causes, and the random generator for further draws."""
    generator = np.random.default_rng([_SEAL, seed])
    rig = draw_rig(generator)
    segments = draw_segments(generator, rig, windows)
    sheet = draw_sheet(generator, rig)
    return Case(seed, rig, segments, sheet, (), False, bool(generator.random() < 0.7)), generator


def simulated(
    case: Case, number: int, hidden: tuple[Hidden, ...] | None = None, nuisances: Floats | None = None
) -> dict[str, Floats]:
    """Channels of one window, each (rows,), and `standing`, the share of the time in which the bit stands.

    Noise depends on case and window alone, so that the same rig is simulated with and without a cause.
    """
    window, seed = case.window(number, hidden, nuisances), [_SEAL, case.seed, number]
    result = simulate(window, SWEEP_PERIOD, WINDOW_S, seed)
    phase = float(np.random.default_rng([*seed, 9]).uniform(0, 2 * np.pi))
    rows = record(result, window.recording, SWEEP_PERIOD, WINDOW_S, phase)
    bit = np.abs(result.bit_speed[round(SWEEP_PERIOD / result.step) :])
    if not case.command_logged:
        rows["command"] = np.full_like(rows["speed"], np.nan)
    return {**rows, "standing": np.array(np.mean(bit < _STANDING * bit.mean()))}
