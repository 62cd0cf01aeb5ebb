"""Hidden effects that are not linear: damping that grows with the speed, and a gain that grows with the error."""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from benchmarks.blind.generator.effect import Context, Effect
from benchmarks.blind.generator.world import World
from benchmarks.blind.hidden import altered
from drillid.arrays import Floats
from drillid.discrepancy.learning.law_kinds import BitLaw, ControlLaw, LawKind
from drillid.discrepancy.learning.law_window import LawWindow
from drillid.physics.nonlinear import ErrorLaw, SpeedLaw

_SPEEDS = np.linspace(-20.0, 60.0, 1601)
_STEP = 0.1
"""rad/s, of derivatives."""
_ERRORS = np.linspace(-8.0, 8.0, 1601)


def drag(speed: Floats) -> Floats:
    """Torque per size against a speed in rad/s: the damping grows with the speed."""
    return np.asarray(speed * np.abs(speed), dtype=float)


def hardening(error: Floats) -> Floats:
    """Torque per size against a speed error in rad/s: the gain grows with the square of the error."""
    return np.asarray(error**3 / 3, dtype=float)


@dataclass(frozen=True)
class LawEffect:
    """One effect with the law that it is."""

    effect: Effect
    kind: LawKind
    law: Callable[[Floats], Floats]
    """Per size."""

    def with_tangent(self, window: LawWindow, size: float) -> LawWindow:
        """A window without the effect, with its tangent at the mean in the base model, as a fit would have it."""
        model = window.window_model
        if not isinstance(self.kind, BitLaw):
            return window
        steps = window.mean_speed + np.array([-_STEP, _STEP])
        slope = size * float(np.diff(self.law(steps))[0]) / (2 * _STEP)
        bit = replace(model.system.bit, damping=model.system.bit.damping + slope)
        return replace(window, window_model=replace(model, system=replace(model.system, bit=bit)))


def _with_drag(world: World, size: float, context: Context) -> World:
    return altered(world, rig=altered(world.rig, law=SpeedLaw(_SPEEDS, size * drag(_SPEEDS))))


def _with_hardening(world: World, size: float, context: Context) -> World:
    return altered(world, rig=altered(world.rig, control_law=ErrorLaw(_ERRORS, size * hardening(_ERRORS))))


LAWS: dict[str, LawEffect] = {
    "growing_drag": LawEffect(
        Effect("growing_drag", _with_drag, (0.05, 60.0), linear=False, in_catalogue=False), BitLaw(), drag
    ),
    "growing_gain": LawEffect(
        Effect("growing_gain", _with_hardening, (1.0, 4e4), linear=False, in_catalogue=False),
        ControlLaw(),
        hardening,
    ),
}
"""N m s²/rad² and N m s³/rad³."""
