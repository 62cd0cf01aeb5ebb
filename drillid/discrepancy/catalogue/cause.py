"""The interface of causes: small classes that change the linear model of a window, or are detected in its record."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any, ClassVar

import numpy as np

from drillid.arrays import Complex
from drillid.discrepancy.detectors.detector import Detector
from drillid.discrepancy.rules import BOUND_REACHED
from drillid.physics.dual_numbers import primal, vanishes
from drillid.physics.equipment import Controller, DrillingSystem, Section, TopDrive
from drillid.physics.held_control import Filters, Held, beyond, read_and_kept
from drillid.physics.responses import command_mobility, string_admittance
from drillid.physics.sensor import Recording
from drillid.physics.top_drive import control, drive


@dataclass(frozen=True)
class WindowModel:
    """Model of one window: the drilling system, and the recording of its speed."""

    system: DrillingSystem
    """Mean over the window."""
    recording: Recording
    course: tuple[Any, ...] = (0.0,)
    """N m s/rad, deviation of the damping at the bit from its mean in successive, equally long parts of the window."""
    control_interval: Any = 0.0
    """s, at which the control samples and holds; 0 where it is continuous."""
    folding: Held | None = None
    """What its holding folds into readings, once `held` has put its cumulants into the system."""

    def mobility(self, s: Any) -> Any:
        """Recorded speed per sweep torque in the mean over the window, rad/(N m s)."""
        held = self.held()
        parts = [held._with_bit_damping(more) for more in self.course]
        if held.folding is None:
            return held.recording.transfer(s) * _mean([command_mobility(part, s) for part in parts])
        strings = [string_admittance(part, s) for part in parts]
        read, kept = held.folding.images(s, *_load_at_multiples(held.system))
        mobilities = [_folded_mobility(held.system.top_drive, string, s, held.folding, read) for string in strings]
        return held._kept(s, strings, read, kept) * _mean(mobilities)

    def control(self, s: Any) -> Any:
        """Response of the speed control: torque opposing the speed per recorded speed, N m s/rad."""
        held = self.held()
        controller = held.system.top_drive.controller
        if held.folding is None:
            return control(controller, s) / held.recording.transfer(s)
        strings = [string_admittance(held._with_bit_damping(more), s) for more in self.course]
        images = held.folding.images(s, *_load_at_multiples(held.system))
        return control(controller, s, held.folding.interval) / held._kept(s, strings, *images)

    def _kept(self, s: Complex, strings: Sequence[Any], read: Complex, kept: Complex) -> Any:
        """Recorded speed per speed that the control reads, which folds `read`, the record `kept`, rad/(N m s)."""
        assert self.folding is not None
        loads = [primal(_load(self.system.top_drive, string, s)) for string in strings]
        ratio = _mean([(1 + kept * load) / (1 + read * load) for load in loads])
        return beyond(self.recording, self.folding.later).transfer(s) * ratio

    def held(self) -> WindowModel:
        """The same with continuous control: its holding adds to the delays of drive and recording, and is kept as what
        it folds beyond these cumulants.
        """
        interval = self.control_interval
        if vanishes(interval):
            return self
        top_drive, recording = self.system.top_drive, self.recording
        arguments = interval, top_drive.delay, recording.lateness, self._filters()
        read, later = read_and_kept(*arguments)
        folding = Held.of(*arguments, (read, later)) if top_drive.controller.matching is None else None
        variance = top_drive.hold_variance + read[0]
        top_drive = replace(top_drive, hold_variance=variance, hold_skewness=read[1], hold_higher=read[2:])
        variance = recording.hold_variance + later[0]
        recording = replace(recording, hold_variance=variance, hold_skewness=later[1], hold_higher=later[2:])
        system = replace(self.system, top_drive=top_drive)
        return replace(self, system=system, recording=recording, control_interval=0.0, folding=folding)

    @property
    def continuous_system(self) -> DrillingSystem:
        """The system under continuous control, for tuning, stability, modes, responses in time and the simulator.

        The mean lateness of holding, h/2, is part of T_d. The cumulants that `held` adds are a series in ωh for the
        measured band: above it they grow without bound where one has the wrong sign, while these need the response
        up to 200 Hz.
        """
        return self.with_top_drive(hold_variance=0.0, hold_skewness=0.0, hold_higher=(0.0, 0.0)).system

    def _filters(self) -> Filters:
        top_drive, recording = self.system.top_drive, self.recording
        jitter = top_drive.delay_jitter
        corner_time = 1 / (2 * np.pi * recording.filter_frequency)
        variances = jitter * jitter, recording.variance
        return Filters(
            top_drive.lag, top_drive.controller.speed_filter, *variances, corner_time, recording.filter_order
        )

    def _with_bit_damping(self, more: Any) -> DrillingSystem:
        bit = self.system.bit
        return replace(self.system, bit=replace(bit, damping=bit.damping + more))

    def with_course(self, added: Sequence[Any]) -> WindowModel:
        """The same with damping added at the bit, N m s/rad, in each of several parts of the window."""
        mean = sum(added) / len(added)
        course = self.course * (len(added) // len(self.course))
        moved = tuple(before + more - mean for before, more in zip(course, added, strict=True))
        return replace(self, system=self._with_bit_damping(mean), course=moved)

    def with_top_drive(self, **parameters: Any) -> WindowModel:
        """The same with other parameters of the top drive."""
        top_drive: TopDrive = replace(self.system.top_drive, **parameters)
        return replace(self, system=replace(self.system, top_drive=top_drive))

    def with_controller(self, **parameters: Any) -> WindowModel:
        """The same with other parameters of the speed control."""
        controller: Controller = replace(self.system.top_drive.controller, **parameters)
        return self.with_top_drive(controller=controller)

    def with_recording(self, **parameters: Any) -> WindowModel:
        """The same with other parameters of the recorder."""
        recording: Recording = replace(self.recording, **parameters)
        return replace(self, recording=recording)

    def with_string(self, *sections: Section) -> WindowModel:
        """The same with another string."""
        return replace(self, system=replace(self.system, string=sections))


def _mean(values: Sequence[Any]) -> Any:
    first, *further = values
    return sum(further, first) / len(values) if further else first


def _load_at_multiples(system: DrillingSystem) -> tuple[Any, Any]:
    """Inertia of the top drive, kg m², and characteristic admittance of the pipe, N m s/rad."""
    return system.top_drive.inertia, system.string[0].characteristic_admittance


def _load(top_drive: TopDrive, string: Any, s: Complex) -> Any:
    """Torque per speed of top drive and string, N m s/rad; derivatives to the inertia are left out, as what is folded
    is relative to it.
    """
    return primal(top_drive.inertia) * s + string


def _folded_mobility(top_drive: TopDrive, string: Any, s: Complex, held: Held, read: Complex) -> Any:
    """Speed that the control reads per sweep torque, rad/(N m s), with a string's admittance below."""
    driven = drive(beyond(top_drive, held.read), s) * held.steps(s) * (1 + read * _load(top_drive, string, s))
    return driven / (top_drive.inertia * s + string + driven * control(top_drive.controller, s, held.interval))


@dataclass(frozen=True)
class OperatingPoint:
    """Operating point of each window, as causes use it; values of shape (window, 1)."""

    speed: Any
    """rad/s, mean of the top drive."""
    torque: Any
    """N m, mean at the bit, or of the command where that is unknown."""
    length: Any
    """m, of the pipe, from the logged depth."""


@dataclass(frozen=True)
class Size:
    """Size of a cause: the parameter that is fitted."""

    name: str
    unit: str
    typical: float
    """Typical size where the cause is present; its prior is normal about zero with this standard deviation, or a wider
    one."""
    low: float
    """Physical bounds."""
    high: float

    @property
    def fixed(self) -> bool:
        """Whether there is nothing to fit: the cause is present or not."""
        return self.low == self.high

    def at_bound(self, value: float) -> bool:
        """Whether a fitted size has reached a physical bound; a lower bound of zero, no effect, does not count."""
        return not self.fixed and (
            value >= self.high * BOUND_REACHED or (self.low < 0 and value <= self.low * BOUND_REACHED)
        )


_PROPER_NAMES = {"bha": "BHA", "coulomb": "Coulomb", "stribeck": "Stribeck"}


def words_of(verdict: str) -> str:
    """A verdict, its causes by their names, as text: 'coulomb_contact|drive_lag' is 'Coulomb contact or drive lag'."""
    names = verdict.replace("|", " or ").replace("_", " ").split(" ")
    return " ".join(_PROPER_NAMES.get(name, name) for name in names)


class Cause:
    """A cause of misfit between model and data; every entry of the catalogue is a final subclass.

    `shapes` are discrete settings that are tried one by one, such as a place along the string; a cause without any has
    the single shape 0.
    """

    name: ClassVar[str]
    """Identifier in verdicts."""
    family: ClassVar[str]
    """Part of the measurement chain that it belongs to."""
    port: ClassVar[str]
    """Where it acts: drive, control, sensor, clock, top, string, bit or disturbance."""
    headline: ClassVar[str] = ""
    """What a driller would say, with what to do: the first sentence of a report; the meaning where it is empty.

    {size} stands for the size, {place} for ' at 1200 m', and {more}, {higher}, {high}, {longer}, {later}, {up} for
    words that the size's sign turns round.
    """
    meaning: ClassVar[str]
    """The cause in plain words."""
    looks_like: ClassVar[tuple[str, ...]] = ()
    """Causes with nearly the same effect."""
    separated_by: ClassVar[str]
    """Measurement that would distinguish it from those."""
    action: ClassVar[str]
    """What a drilling supervisor can do about it."""
    shared_by: ClassVar[str] = ""
    """What wells that share the cause have in common: rig, section or tool; empty where it is a well's own."""
    size: ClassVar[Size]
    shapes: ClassVar[tuple[float, ...]] = (0.0,)
    shape_step: ClassVar[float] = 0.0
    """Initial step of the search over a continuous shape; 0 where the shapes are discrete."""
    shape_is_fitted: ClassVar[bool] = False
    """Whether a further parameter of its shape, such as a width, is fitted together with its size."""
    is_place: ClassVar[bool] = False
    """Whether the shape is a place along the pipe, as a share from the top."""
    distorts_responses: ClassVar[bool] = False
    """Whether it also distorts the linear responses, although only a detection identifies it."""
    time_varying: ClassVar[bool] = False
    """Whether it changes the response within a window: its detection shows the change, the linear response the mean."""
    detector: ClassVar[Detector | None] = None
    """Its detector in the window's record; None where only the linear responses show it."""
    stands_alone: ClassVar[bool] = False
    """Whether its detection is specific, so that it never forms a class with causes that look like it."""
    marks_intervals: ClassVar[bool] = False
    """Whether interval changes, fitted parameters that deviate from the level of their run, are named as this cause."""

    def extend(
        self, window_model: WindowModel, size: Any, shape: float, operating_point: OperatingPoint
    ) -> WindowModel:
        """The window's model with the cause at a size; size 0 changes nothing.

        Causes identified only by a detection leave the linear model unchanged.
        """
        return window_model

    def shaped(self, coordinate: Any) -> Cause:
        """The same cause with the fitted parameter of its shape at a standard normal coordinate."""
        return self

    @property
    def is_linear(self) -> bool:
        """Whether it is identified from the linear responses."""
        return type(self).extend is not Cause.extend and not self.time_varying

    @property
    def may_explain_unknown(self) -> bool:
        """Whether it may explain what the linear responses show as unknown."""
        return self.is_linear

    def allows(self, other: Cause) -> bool:
        """Whether the detection of another cause is valid where this one is detected or named."""
        return True

    def admits_size(self, size: float, size_error: float) -> bool:
        """Whether a detected size is physically possible for it."""
        return True

    def described(self, evidence: str) -> str:
        """Description as a clause for readers, given the evidence of a verdict."""
        return self.meaning
