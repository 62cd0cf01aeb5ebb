"""What a cause is: a small class that changes the linear model of a window, or is told by a detection in its record."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any, ClassVar

from drillid.physics.equipment import Controller, DrillingSystem, Section, TopDrive
from drillid.physics.responses import command_mobility
from drillid.physics.sensor import Recording
from drillid.physics.top_drive import control

ACTIONS = {
    "drive_lag": "Tune the speed control for the lag, and ask the drive's maker for the torque loop's bandwidth.",
    "actuator_gain": "Have the torque calibration of the drive checked: every torque limit is off by the same share.",
    "delay_jitter": "Have the link between controller and drive checked; leave more margin in the speed control.",
    "torque_limit": "Raise the torque limit if the string allows it, or expect more stick-slip at this limit.",
    "torque_rate_limit": "Have the drive's ramp limit raised, or do not count on the control at high frequency.",
    "controller_gain": "Compare the gains in the drive's settings with the data sheet and correct the wrong one.",
    "speed_filter": "Look for a filter on the speed in the drive's settings and write it into the rig's data sheets.",
    "torque_filter": "Look for a filter on the torque in the drive's settings and write it into the rig's data sheets.",
    "gear_backlash": "Have the gear of the top drive looked at; keep the mean torque well above zero.",
    "speed_scale": "Have the speed sensor's calibration checked against a count of revolutions.",
    "sign_or_unit": "Correct sign or unit of the channel in the rig description, then run again.",
    "clock_offset": "Have the recorder's clocks set by one source; until then shift the speed by the offset.",
    "recorder_filter": "Ask for the record before its filter, or write the filter into the rig's data sheets.",
    "clock_drift": "Have the recorder's clocks disciplined by one source.",
    "quantisation": "Ask for the speed in finer steps; nothing on the rig is wrong.",
    "aliased_tone": "Have a filter put before the recorder's sampling; look for what vibrates.",
    "once_per_revolution": "Have encoder, coupling and gear of the top drive checked for run-out.",
    "extra_section": "Compare the string in the hole with the tally.",
    "tapered_string": "Compare the string in the hole with the tally: a second size of pipe is likely.",
    "local_damping_zone": "Mind this depth when tripping: ream or circulate there, and look at the cuttings.",
    "mud_drag": "Expect more torque at higher speed; check the mud's viscosity.",
    "hysteretic_damping": "Nothing to mend: use the extended model where damping matters.",
    "coulomb_contact": "Turn faster or add lubricant: the wall feeds stick-slip at this speed.",
    "wave_speed": "Nothing to mend: enter the tool joints or the pipe's true wave speed in the rig's data sheets.",
    "distributed_bha": "Compare the bottom-hole assembly with the tally.",
    "motor_compliance": "Enter the motor's stiffness in the rig description.",
    "regenerative_cutting": "Change speed or weight: the bit's blades feed vibration at this speed.",
    "stribeck_cutting": "Turn faster or take weight off: the rock feeds stick-slip at this speed.",
    "stuck_slip_regimes": "Turn faster or take weight off until the bit no longer stands; the figures of these windows "
    "do not hold for smooth drilling.",
    "length_growth": "Use shorter windows at this rate of penetration.",
    "parameter_drift": "Look at what changed while the windows lasted: formation, weight or hole cleaning.",
    "regime_change": "Look at what changed there: hole size, cuttings, formation or vibration; a caliper log and the "
    "cuttings returns tell more.",
}
"""What a drilling supervisor can do about each cause."""


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
    """Whether the linear responses too go wrong where only a detection tells the cause."""
    moves: ClassVar[bool] = False
    """Whether it changes the response while a window lasts, which its sign tells, and that response's mean too."""

    def extend(
        self, window_model: WindowModel, size: Any, shape: float, operating_point: OperatingPoint
    ) -> WindowModel:
        """The window's model with the cause at a size; size 0 changes nothing.

        Causes that only a detection tells leave the linear model as it is.
        """
        return window_model

    @property
    def is_linear(self) -> bool:
        """Whether the linear model tells it."""
        return type(self).extend is not Cause.extend and not self.moves


@dataclass(frozen=True)
class Symptom:
    """Something that a rig as the model has it does not show, whatever its cause."""

    family: str
    """Part of the chain where it shows."""
    meaning: str
    """In plain words."""
    separated_by: str
    """What would tell its cause."""


SYMPTOMS = {
    "line": Symptom("sensor", "a tone stands out of the record's noise", "windows at other speeds of the top drive"),
    "trend": Symptom("time", "the answer to the sweep moves while a window lasts", "what was changed meanwhile"),
    "control_trend": Symptom("control", "the control's answer moves while a window lasts", "the drive's own log"),
}
"""By name; none is the name of a cause."""
