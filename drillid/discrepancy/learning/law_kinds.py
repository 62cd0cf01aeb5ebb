"""What a law may be of: the bit's torque against its speed, with or without a memory, a coupling's twist against its
torque, or the speed control's torque against its error; and what each adds to the record to first order in its
spline.

About the base model a law without a tangent answers the swing that the sweep makes at its place by a torque, or a
twist, of second order, whose way to the record is linear (the second-order Volterra kernel; Schetzen 1980, The Volterra
and Wiener Theories of Nonlinear Systems, chapter 3). By reciprocity it is the way from the top drive to that place.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
from scipy.special import chdtrc

from drillid.arrays import Complex, Floats
from drillid.discrepancy.learning.fingerprint import CONTROL_LAW
from drillid.discrepancy.learning.law_spline import LawSpline
from drillid.discrepancy.learning.law_window import LawWindow
from drillid.discrepancy.rules import NEIGHBOURS_SHARE_VARIANCE
from drillid.physics.bottom_end import above_motor, bit_load
from drillid.physics.equipment import DrillingSystem
from drillid.physics.line import input_admittance, speed_ratio
from drillid.physics.nonlinear import ErrorLaw, NonlinearRig, SpeedLaw, TwistLaw
from drillid.physics.responses import command_mobility
from drillid.physics.strings import String, cut
from drillid.physics.top_drive import after_gains, torque_transfers
from drillid.units import RPM

_MARGIN = 1.25
"""Compliance with which a coupling is simulated, relative to the least that keeps its twist from falling."""
_STAND = 30.0
"""m of pipe as compliant as a usual coupling."""
POWERS = (2, 3)
"""Powers of the swing in the curves of a law that are screened."""


@dataclass(frozen=True)
class LawKind(ABC):
    """One kind of law; `place` and `value` are what it acts on and what it answers, in SI units."""

    variables: ClassVar[tuple[str, str, str]]
    """Dataset variables of the places at which it is drawn, of its values and of their standard errors."""
    words_scale: ClassVar[float] = 1.0
    """Factor on changes of its slope where they are put in words."""
    has_slope: ClassVar[bool] = False
    """Whether its slope at the mean is fitted as well as its curvature."""

    @property
    def place(self) -> float | None:
        """Share of the string above it, where that is sought."""
        return None

    @property
    @abstractmethod
    def element(self) -> str:
        """Its name in fingerprints."""

    @property
    @abstractmethod
    def family(self) -> str:
        """The port at which it acts."""

    @abstractmethod
    def words(self, change: str, spline: LawSpline) -> str:
        """The law in words, by the change of its slope with its interval."""

    @abstractmethod
    def mean(self, window: LawWindow) -> float:
        """What it acts on in the mean over a window."""

    @abstractmethod
    def swing(self, window: LawWindow) -> Floats:
        """What it acts on less its mean, over one period of the sweep by the base model, (samples,)."""

    @abstractmethod
    def recorded(self, window: LawWindow, answer: Floats) -> Complex:
        """Harmonics (lines,) of the record by what it answers over one period of the sweep, (samples,)."""

    @abstractmethod
    def added(self, window: LawWindow, place: Floats, value: Floats) -> Complex:
        """Harmonics (lines,) that a law, less what the base model has of it, adds to the record, simulated.

        Parameters
        ----------
        place, value : (points,)
        """

    def scale(self, window: LawWindow) -> float:
        """Usual slope: the pipe's characteristic admittance, N m s/rad."""
        return float(window.window_model.system.string[0].characteristic_admittance)

    def slope_in_model(self, window: LawWindow) -> float:
        """Its slope at the mean, where the base model determines it, or 0."""
        return 0.0

    def change(self, spline: LawSpline) -> Floats:
        """Factors (K,) of the spline's second derivatives in the change of the slope over the range."""
        return spline.rise

    def per_change(self, spline: LawSpline) -> float:
        """Factor from that change to a quantity that does not depend on the range."""
        return 1 / spline.span


@dataclass(frozen=True)
class BitLaw(LawKind):
    """The bit's torque (N m) against its speed (rad/s), or against a speed that follows it."""

    variables = ("law_speed", "law_torque", "law_error")
    memory: float = 0.0
    """s."""

    @property
    def element(self) -> str:
        """Its name in fingerprints."""
        return "law of the bit" if self.memory == 0 else f"law of the bit with a memory of {self.memory:g} s"

    @property
    def family(self) -> str:
        """The port at which it acts."""
        return "bit"

    def words(self, change: str, spline: LawSpline) -> str:
        """The change of the bit's damping."""
        memory = "" if self.memory == 0 else f", which it follows with a memory of {self.memory:g} s"
        ends = f"from {spline.low / RPM:.0f} to {spline.high / RPM:.0f} rpm"
        return f"the bit's damping changes by {change} N m s/rad {ends}, a cubic spline of its speed{memory}"

    def mean(self, window: LawWindow) -> float:
        """Mean speed."""
        return window.mean_speed

    def swing(self, window: LawWindow) -> Floats:
        """The bit's speed less its mean, or what follows it."""
        system, (s, sweep) = window.window_model.system, window.whole_sweep
        return window.series(command_mobility(system, s) * sweep * _at(system, 1.0, s)[0] / (1 + self.memory * s))

    def recorded(self, window: LawWindow, answer: Floats) -> Complex:
        """By a torque against the bit's rotation."""
        return np.asarray(-_to_top(window, 1.0)[0] * window.harmonics(answer), dtype=complex)

    def added(self, window: LawWindow, place: Floats, value: Floats) -> Complex:
        """By torques (N m) at speeds (rad/s)."""
        rig = NonlinearRig(window.window_model.system, law=SpeedLaw(place, value, self.memory))
        return window.simulated(rig, window.mean_speed) - window.still

    def slope_in_model(self, window: LawWindow) -> float:
        """The bit's damping."""
        return float(window.window_model.system.bit.damping)


@dataclass(frozen=True)
class CouplingLaw(LawKind):
    """A coupling's twist (rad) against its torque (N m)."""

    variables = ("coupling_torque", "coupling_twist", "coupling_error")
    words_scale = 1e3
    at: float = 0.0
    """Share of the string above it."""

    @property
    def place(self) -> float:
        """Share of the string above it."""
        return self.at

    @property
    def element(self) -> str:
        """Its name in fingerprints."""
        return "law of a coupling"

    @property
    def family(self) -> str:
        """The port at which it acts."""
        if self.at in (0, 1):
            return "bit" if self.at else "top"
        return "upper string" if self.at < 1 / 2 else "lower string"

    def words(self, change: str, spline: LawSpline) -> str:
        """The change of its compliance."""
        ends = f"from {spline.low / 1e3:.1f} to {spline.high / 1e3:.1f} kN m"
        # without a logged command the mean torque counts as zero
        ends += " about its mean" if spline.low == -spline.high else ""
        at = f"a coupling at {self.at:.0%} of the string"
        return f"{at}, whose compliance changes by {change} rad/(kN m) {ends}, a cubic spline of its torque"

    def mean(self, window: LawWindow) -> float:
        """Mean torque."""
        return window.mean_torque

    def swing(self, window: LawWindow) -> Floats:
        """Its torque less its mean."""
        system, (s, sweep) = window.window_model.system, window.whole_sweep
        ratio, admittance = _at(system, self.at, s)
        return window.series(command_mobility(system, s) * sweep * ratio * admittance)

    def scale(self, window: LawWindow) -> float:
        """Compliance of a stand, rad/(N m)."""
        pipe = window.window_model.system.string[0]
        return _STAND / float(pipe.shear_modulus * pipe.polar_moment)

    def recorded(self, window: LawWindow, answer: Floats) -> Complex:
        """By a twist."""
        to_top, admittance = _to_top(window, self.at)
        return np.asarray(window.s * to_top * admittance * window.harmonics(answer), dtype=complex)

    def added(self, window: LawWindow, place: Floats, value: Floats) -> Complex:
        """By twists (rad) at torques (N m)."""
        system = window.window_model.system
        depth = self.at * float(sum(section.length for section in system.string))
        # a compliance that both have keeps the twist from falling; at rest the torque is that about the mean
        least = _MARGIN * max(0.0, -float(np.diff(value).min()) / float(place[1] - place[0]))
        torque = place - window.mean_torque
        rigs = [
            NonlinearRig(system, coupling=TwistLaw(depth, torque, least * torque + twist))
            for twist in (value, 0.0 * value)
        ]
        bent, straight = (window.simulated(rig, 0.0) for rig in rigs)
        return bent - straight


@dataclass(frozen=True)
class ControlLaw(LawKind):
    """The speed control's torque (N m) against its speed error (rad/s), which is zero in the mean."""

    variables = ("control_speed_error", "control_torque", "control_torque_error")
    has_slope = True

    @property
    def element(self) -> str:
        """Its name in fingerprints."""
        return CONTROL_LAW

    @property
    def family(self) -> str:
        """The port at which it acts."""
        return "control"

    def words(self, change: str, spline: LawSpline) -> str:
        """The change of the proportional gain."""
        end = f"{spline.span / 2 / RPM:.1f} rpm"
        return (
            f"the speed control's gain changes by {change} N m s/rad from no speed error to one of {end}, a cubic "
            "spline of that"
        )

    def mean(self, window: LawWindow) -> float:
        """Zero."""
        return 0.0

    def swing(self, window: LawWindow) -> Floats:
        """The speed error."""
        system, (s, sweep) = window.window_model.system, window.whole_sweep
        return window.series(-command_mobility(system, s) * sweep / (1 + s * system.top_drive.controller.speed_filter))

    def recorded(self, window: LawWindow, answer: Floats) -> Complex:
        """By a torque that is added to that of the control before its filter."""
        way = window.window_model.mobility(window.s) * after_gains(
            window.window_model.system.top_drive.controller, window.s
        )
        return np.asarray(way * window.harmonics(answer), dtype=complex)

    def added(self, window: LawWindow, place: Floats, value: Floats) -> Complex:
        """By torques (N m) at speed errors (rad/s)."""
        rig = NonlinearRig(window.window_model.system, control_law=ErrorLaw(place, value))
        return window.simulated(rig, window.mean_speed) - window.still

    def change(self, spline: LawSpline) -> Floats:
        """Change of the gain from no error to a large one of either sign."""
        return spline.growth

    def per_change(self, spline: LawSpline) -> float:
        """Per squared error."""
        return 4 / spline.span**2


PLACES_APART = 0.25
"""Distance between the places at which a coupling is tried, as a share of the string's length."""
KINDS: tuple[LawKind, ...] = (
    BitLaw(),
    *(BitLaw(memory) for memory in (0.3, 1.0, 3.0)),
    *(CouplingLaw(float(place)) for place in np.arange(5) * PLACES_APART),
    ControlLaw(),
)
"""Kinds that are tried."""


def _to_top(window: LawWindow, place: float) -> tuple[Complex, Complex]:
    """Speed that is recorded per torque at a place of the string, by reciprocity, and the admittance below it."""
    system = window.window_model.system
    ratio, admittance = _at(system, place, window.s)
    drive = torque_transfers(system.top_drive, window.s)[0]
    return window.window_model.mobility(window.s) / drive * ratio, admittance


def _at(system: DrillingSystem, place: float, s: Complex) -> tuple[Complex, Complex]:
    """Speed at a place per that of the top drive, and the admittance below it, N m s/rad."""
    upper: String = system.string
    lower: String = ()
    if place < 1:
        upper, lower = cut(system.string, place * float(sum(section.length for section in system.string)))
    load = above_motor(system.motor, bit_load(system.bit, s), s)
    for section in reversed(lower):
        load = input_admittance(section, load, s)
    ratio, below = np.ones_like(s), load
    for section in reversed(upper):
        ratio, load = ratio * speed_ratio(section, load, s), input_admittance(section, load, s)
    return ratio, below


@dataclass(frozen=True, eq=False)
class Screened:
    """Misfit that a kind of law explains, to first order in its curves."""

    kind: LawKind
    statistic: float
    """χ² of as many degrees of freedom as POWERS."""
    p_value: float


def screened(windows: Sequence[LawWindow], kept: Sequence[Any] | None = None) -> list[Screened]:
    """Score tests of every kind of law, in the lines (W, lines) that are kept.

    What neither the base model nor the law explains counts as noise.
    """
    lines = [np.ones(window.s.size, dtype=bool) for window in windows] if kept is None else kept
    rest = [window.residual[used] for window, used in zip(windows, lines, strict=True)]
    squares, count = sum(float(np.sum(np.abs(each) ** 2)) for each in rest), 2 * sum(each.size for each in rest)
    excess = NEIGHBOURS_SHARE_VARIANCE * max(squares / max(count, 1), 1.0)
    return [_screened(kind, windows, lines, rest, excess) for kind in KINDS]


def _screened(
    kind: LawKind, windows: Sequence[LawWindow], kept: Sequence[Any], rest: Sequence[Complex], excess: float
) -> Screened:
    swings = [kind.swing(window) for window in windows]
    largest = max(float(np.abs(swing).max()) for swing in swings)
    matrix, vector = np.zeros((len(POWERS), len(POWERS))), np.zeros(len(POWERS))
    for window, used, swing, residual in zip(windows, kept, swings, rest, strict=True):
        curves = [kind.recorded(window, (swing / largest) ** power) / window.error for power in POWERS]
        columns = np.stack([curve[used] for curve in curves])
        matrix += (columns.conj() @ columns.T).real
        vector += (columns.conj() @ residual).real
    statistic = float(vector @ np.linalg.lstsq(matrix, vector)[0]) / excess
    return Screened(kind, statistic, float(chdtrc(len(POWERS), statistic)))


def law_p_value(windows: Sequence[LawWindow]) -> float:
    """p-value of the base model against a law of any kind (Bonferroni)."""
    return min(len(KINDS) * min(each.p_value for each in screened(windows)), 1.0)
