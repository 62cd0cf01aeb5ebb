"""What is hidden: causes taken out of the catalogue, and effects that it never had, with the true model of each.

They act on the rig of the time-domain simulator. The true model is what the best possible extension would be: the same
effect as a cause whose size is fitted.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from benchmarks.blind.generator import cases as own
from benchmarks.blind.generator.effect import Context, Effect
from benchmarks.blind.generator.world import World
from drillid.discrepancy.catalogue import CATALOGUE, Cause, OperatingPoint, Size, WindowModel
from drillid.discrepancy.inference.coordinates import Extension
from drillid.discrepancy.learning.term import depth_of
from drillid.physics.attachments import MountedInertia, with_joint, with_law, with_lump
from drillid.physics.equipment import Section
from drillid.physics.strings import String, cut

RIPPLE, PIECES = 600.0, 12
"""m, length of a ripple of the pipe's wall, and pieces of each."""
LOSS = 0.2
"""Of a mounted inertia."""
MOTOR_INERTIA = 2e5
"""Inertia of a second motor per compliance, kg m² N m: of housings that grow with the motor."""


def place(shape: float) -> float:
    """Share of the string above what hangs in it."""
    return 0.3 + 0.4 * shape


def own_frequency(shape: float) -> float:
    """Hz, of a mounted inertia."""
    return float(0.6 * 5.0 ** ((7 * shape) % 1.0))


def _mount(string: String, depth: Any, size: Any, shape: float) -> String:
    return with_law(string, depth, MountedInertia(size, own_frequency(shape), LOSS))


def _motor(string: String, depth: Any, size: Any, shape: float) -> String:
    return with_lump(with_joint(string, depth, size), depth + 40.0, inertia=MOTOR_INERTIA * size)


def _rippled(string: String, depth: Any, size: Any, shape: float) -> String:
    """Polar moment of the pipe that varies along it as a sine."""
    pipe, *below = string
    rest: String = (pipe,)
    above: list[Section] = []
    piece = RIPPLE / PIECES
    count = int(np.min(np.asarray(getattr(pipe.length, "value", pipe.length))) / piece)
    for number in range(count):
        part, rest = cut(rest, piece) if number < count - 1 else (rest, ())
        factor = 1 + size * float(np.sin(2 * np.pi * ((number + 0.5) / PIECES + shape)))
        above += [replace(section, polar_moment=section.polar_moment * factor) for section in part]
    return (*above, *rest, *below)


Change = Callable[[String, Any, Any, float], String]
"""String, depth, size and shape → the string with the effect."""


def _applied(change: Change) -> Callable[[World, float, Context], World]:
    def apply(world: World, size: float, context: Context) -> World:
        string = world.rig.system.string
        total = sum(section.length for section in string)
        collars = sum(section.length for section in string[1:])
        mean = context.first.pipe_length + collars
        # it goes down with the string
        depth = total - (1 - place(context.shape)) * mean
        return world.with_system(string=change(string, depth, size, context.shape))

    return apply


class TrueModel(Cause):
    """The effect itself as a cause; the shape is the case's."""

    family, port = "learnt", "string"
    meaning, separated_by, action = "the truth", "", ""

    def __init__(self, name: str, change: Change, size: Size) -> None:
        self.name, self.change, self.size = name, change, size  # type: ignore[misc]

    def extend(
        self, window_model: WindowModel, size: Any, shape: float, operating_point: OperatingPoint
    ) -> WindowModel:
        """The effect on the window's string."""
        depth = depth_of(place(shape), window_model, operating_point)
        return window_model.with_string(*self.change(window_model.system.string, depth, size, shape))


@dataclass(frozen=True)
class Hideable:
    """One effect with its true model."""

    effect: Effect
    truth: Cause
    removed: str = ""
    """Name of the cause that is taken out of the catalogue."""
    shapes: tuple[float, ...] = ()
    """Shapes of the true model in the catalogue; that of the case where there is none."""

    def extensions(self, shape: float) -> list[tuple[Extension, ...]]:
        """The true model, at each of its shapes."""
        return [(Extension(self.truth, each),) for each in self.shapes or (shape,)]


def _never(name: str, change: Change, size: Size, sizes: tuple[float, float]) -> Hideable:
    return Hideable(Effect(name, _applied(change), sizes, in_catalogue=False), TrueModel(name, change, size))


def _taken_out(name: str) -> Hideable:
    cause = CATALOGUE[name]
    return Hideable(own.EFFECTS[name], cause, name, cause.shapes)


HIDEABLE: dict[str, Hideable] = {
    hideable.effect.name: hideable
    for hideable in (
        _never("mounted_inertia", _mount, Size("inertia", "kg m²", 50.0, 0.0, 4e3), (0.5, 800.0)),
        _never("rippled_pipe", _rippled, Size("relative amplitude", "1", 0.1, -0.9, 0.9), (0.01, 0.6)),
        _never("second_motor", _motor, Size("compliance", "rad/(N m)", 2e-5, 0.0, 2e-3), (1e-6, 4e-4)),
        *map(_taken_out, ("drive_lag", "mud_drag", "torque_filter")),
    )
}
"""All that is hidden, by name."""
