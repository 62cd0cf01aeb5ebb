"""What a cause is: a small class that changes the linear model of a window, or is told by a detection in its record."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any, ClassVar

from drillid.discrepancy.detectors.detector import Detector
from drillid.discrepancy.rules import BOUND_REACHED
from drillid.physics.equipment import Controller, DrillingSystem, Section, TopDrive
from drillid.physics.responses import command_mobility
from drillid.physics.sensor import Recording
from drillid.physics.top_drive import control


@dataclass(frozen=True)
class WindowModel:
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

    def with_course(self, added: Sequence[Any]) -> WindowModel:
        """The same with damping added at the bit, N m s/rad in each of several parts of the window."""
        mean = sum(added) / len(added)
        course = self.course * (len(added) // len(self.course))
        moved = tuple(before + more - mean for before, more in zip(course, added, strict=True))
        return replace(self, system=self._with_bit_damping(mean), course=moved)

    def with_top_drive(self, **figures: Any) -> WindowModel:
        """The same with other figures of the top drive."""
        top_drive: TopDrive = replace(self.system.top_drive, **figures)
        return replace(self, system=replace(self.system, top_drive=top_drive))

    def with_controller(self, **figures: Any) -> WindowModel:
        """The same with other figures of the speed control."""
        controller: Controller = replace(self.system.top_drive.controller, **figures)
        return self.with_top_drive(controller=controller)

    def with_string(self, *sections: Section) -> WindowModel:
        """The same with another string."""
        return replace(self, system=replace(self.system, string=sections))


@dataclass(frozen=True)
class OperatingPoint:
    """What a cause may know of each window; figures of shape (window, 1)."""

    speed: Any
    """rad/s, mean of the top drive."""
    torque: Any
    """N m, mean at the bit, or of the command where no more is known."""
    length: Any
    """m, of the pipe by the logged depth."""


@dataclass(frozen=True)
class Size:
    """How large a cause is."""

    name: str
    unit: str
    typical: float
    """Usual size where the cause is present; its prior is normal about zero with this deviation, or a wider one."""
    low: float
    """Physical bounds."""
    high: float

    @property
    def fixed(self) -> bool:
        """Whether there is nothing to fit: the cause is present or not."""
        return self.low == self.high

    def at_bound(self, value: float) -> bool:
        """Whether a fitted size ran into a bound beyond which it is no longer physical; none is no bound."""
        return not self.fixed and (
            value >= self.high * BOUND_REACHED or (self.low < 0 and value <= self.low * BOUND_REACHED)
        )


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
    action: ClassVar[str]
    """What a drilling supervisor can do about it."""
    size: ClassVar[Size]
    shapes: ClassVar[tuple[float, ...]] = (0.0,)
    shape_step: ClassVar[float] = 0.0
    """Step in which a continuous shape is refined; 0 where the shapes are all there are."""
    is_place: ClassVar[bool] = False
    """Whether the shape is a place along the pipe, as a share from the top."""
    regime: ClassVar[bool] = False
    """Whether the linear responses too go wrong where only a detection tells the cause."""
    moves: ClassVar[bool] = False
    """Whether it changes the response while a window lasts, which its detection shows, and that response's mean too."""
    detector: ClassVar[Detector | None] = None
    """Looks for it in the window's record; None where only the linear responses show it."""
    stands_alone: ClassVar[bool] = False
    """Whether its detection is never shared with causes that look like it."""
    marks_intervals: ClassVar[bool] = False
    """Whether it is the name of an interval of depth whose fitted parameters leave the level of their run."""

    def extend(
        self, window_model: WindowModel, size: Any, shape: float, operating_point: OperatingPoint
    ) -> WindowModel:
        """The window's model with the cause at a size; size 0 changes nothing.

        Causes that only a detection tells leave the linear model as it is.
        """
        return window_model

    @property
    def is_linear(self) -> bool:
        """Whether the linear model shows it."""
        return type(self).extend is not Cause.extend and not self.moves

    @property
    def disturbs_responses(self) -> bool:
        """Whether it may be what linear responses show as unknown."""
        return self.is_linear

    def allows(self, other: Cause) -> bool:
        """Whether another cause's detection counts beside its own."""
        return True

    def can_have(self, size: float, size_error: float) -> bool:
        """Whether a detected size is one that it may have."""
        return True

    def described(self, evidence: str) -> str:
        """It in a sentence's words, for the evidence of a verdict."""
        return self.meaning
