"""What a cause is: a small class that changes the linear model of a window, or is told by a sign in its record."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any, ClassVar

from drillid.physics.equipment import Controller, DrillingSystem, Section, TopDrive
from drillid.physics.responses import command_mobility
from drillid.physics.sensor import Recording
from drillid.physics.top_drive import control


@dataclass(frozen=True)
class Setup:
    """One window as the base model sees it: the drilling system, and how the speed is recorded."""

    system: DrillingSystem
    """In the mean over the window."""
    recording: Recording
    course: tuple[Any, ...] = (0.0,)
    """N m s/rad, damping at the bit beyond its mean in parts of the window that follow each other and last as long."""

    def mobility(self, s: Any) -> Any:
        """Recorded speed per sweep torque in the mean over the window, rad/(N m s)."""
        first, *further = (command_mobility(self._with_bit_damping(more), s) for more in self.course)
        return self.recording.transfer(s) * (sum(further, first) / len(self.course) if further else first)

    def control(self, s: Any) -> Any:
        """What the control takes back per recorded speed, N m s/rad."""
        return control(self.system.top_drive.controller, s) / self.recording.transfer(s)

    def _with_bit_damping(self, more: Any) -> DrillingSystem:
        bit = self.system.bit
        return replace(self.system, bit=replace(bit, damping=bit.damping + more))

    def with_course(self, added: Sequence[Any]) -> "Setup":
        """The same with damping added at the bit, N m s/rad in each of several parts of the window."""
        mean = sum(added) / len(added)
        course = self.course * (len(added) // len(self.course))
        moved = tuple(before + more - mean for before, more in zip(course, added, strict=True))
        return replace(self, system=self._with_bit_damping(mean), course=moved)

    def with_top_drive(self, **figures: Any) -> "Setup":
        """The same with other figures of the top drive."""
        top_drive: TopDrive = replace(self.system.top_drive, **figures)
        return replace(self, system=replace(self.system, top_drive=top_drive))

    def with_controller(self, **figures: Any) -> "Setup":
        """The same with other figures of the speed control."""
        controller: Controller = replace(self.system.top_drive.controller, **figures)
        return self.with_top_drive(controller=controller)

    def with_string(self, *sections: Section) -> "Setup":
        """The same with another string."""
        return replace(self, system=replace(self.system, string=sections))


@dataclass(frozen=True)
class Circumstances:
    """What a cause may know of each window; figures of shape (window, 1)."""

    speed: Any
    """rad/s, mean of the top drive."""
    torque: Any
    """N m, mean at the bit, or of the command where no more is known."""
    length: Any
    """m, of the pipe by the logged depth."""


WIDE = 5.0
"""Factor by which sizes may exceed what is usual: half of the prior is so much wider."""
_WITHIN = 0.99
"""Share of a bound that counts as reaching it."""


@dataclass(frozen=True)
class Size:
    """How large a cause is."""

    name: str
    unit: str
    typical: float
    """Usual size where the cause is present; its prior is normal about zero with this deviation, or with WIDE of it."""
    low: float
    """Physical bounds."""
    high: float

    @property
    def fixed(self) -> bool:
        """Whether there is nothing to fit: the cause is present or not."""
        return self.low == self.high

    def at_bound(self, value: float) -> bool:
        """Whether a fitted size ran into a bound beyond which it is no longer physical; none is no bound."""
        return not self.fixed and (value >= self.high * _WITHIN or (self.low < 0 and value <= self.low * _WITHIN))


class Cause:
    """One cause of what a simulation gets wrong; every entry of the catalogue is a final subclass.

    `shapes` are settings that are tried one by one, such as a place along the string; a cause with none has the
    one shape 0.
    """

    name: ClassVar[str]
    """Identifier in verdicts."""
    family: ClassVar[str]
    """Part of the chain that it sits in."""
    port: ClassVar[str]
    """Where it acts: drive, control, sensor, clock, top, string, bit or disturbance."""
    meaning: ClassVar[str]
    """The cause in plain words."""
    looks_like: ClassVar[tuple[str, ...]] = ()
    """Causes that show nearly the same."""
    separated_by: ClassVar[str]
    """What would tell it from those."""
    size: ClassVar[Size]
    shapes: ClassVar[tuple[float, ...]] = (0.0,)
    shape_meaning: ClassVar[str] = ""
    """What a shape is, with its unit; empty where there is one only."""
    shape_step: ClassVar[float] = 0.0
    """Step in which a continuous shape is refined; 0 where the shapes are all there are."""
    is_place: ClassVar[bool] = False
    """Whether the shape is a place along the pipe, as a share from the top."""
    regime: ClassVar[bool] = False
    """Whether the linear responses too go wrong where only a sign tells the cause."""
    moves: ClassVar[bool] = False
    """Whether it changes the response while a window lasts, which its sign tells, and that response's mean too."""

    def extend(self, setup: Setup, size: Any, shape: float, circumstances: Circumstances) -> Setup:
        """The window's model with the cause at a size; size 0 changes nothing.

        Causes that only a sign tells leave the linear model as it is.
        """
        return setup

    @property
    def is_linear(self) -> bool:
        """Whether the linear model tells it."""
        return type(self).extend is not Cause.extend and not self.moves
