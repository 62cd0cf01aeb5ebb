"""Nonlinear parts of a rig: friction, cutting, play, limits and sensors, in addition to the linear equipment.

Every part has parameters at which it has no effect; a `NonlinearRig` of defaults is its drilling system. Parameters
are floats in SI units, for the time-domain simulator.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from drillid.arrays import Floats
from drillid.errors import SettingsError
from drillid.physics.equipment import DrillingSystem, RegenerativeCutting, StribeckCutting

_RATE = 1e-3
"""m/s, assumed rate of penetration where only the torque of the blades is known."""
_LEAST_POINTS = 2
_STALL = 10.0
"""Greatest depth of cut of the blades per steady depth of cut, assumed likewise."""


@dataclass(frozen=True)
class Weakening:
    """How friction falls from its static to its dynamic level as the speed v rises.

    level(v) = dynamic + (static − dynamic) exp(−(|v|/threshold)^exponent), after Stribeck (1902) in the form of
    Armstrong-Hélouvry, Dupont and Canudas de Wit (1994), Automatica 30, 1083–1138. A large exponent
    approaches a jump at the threshold.
    """

    threshold: float = 1.0
    """rad/s."""
    exponent: float = 1.0

    def __post_init__(self) -> None:
        if not (self.threshold > 0 and self.exponent > 0):
            raise SettingsError(
                "weakening of friction",
                f"threshold {self.threshold} rad/s and exponent {self.exponent} must both be positive",
                "Set static and dynamic friction to the same level where there is no weakening",
            )

    def level(self, static: float, dynamic: float, speed: float) -> float:
        """Level at a speed in rad/s, in the unit of `static` and `dynamic`."""
        return float(dynamic + (static - dynamic) * np.exp(-((abs(speed) / self.threshold) ** self.exponent)))

    def slope(self, static: float, dynamic: float, speed: float) -> float:
        """Derivative of the level to a positive speed in rad/s; negative where friction weakens."""
        ratio = (speed / self.threshold) ** self.exponent
        return float(-(static - dynamic) * np.exp(-ratio) * ratio * self.exponent / speed)


@dataclass(frozen=True, eq=False)
class WallContact:
    """Coulomb friction between string and wall, as torque per length, constant within each piece of the string.

    For a string that starts from rest these levels are multiplied by 1 + rest exp(−φ/rest_angle), φ its slip since:
    the slip law of Ruina (1983), Journal of Geophysical Research 88, 10359–10370, without the slow healing.
    """

    edges: Floats
    """(pieces + 1,) m from the top of the string, rising."""
    static: Floats
    """(pieces,) N, static friction torque per length."""
    dynamic: Floats
    """(pieces,) N, friction torque per length far above the threshold speed."""
    weakening: Weakening = Weakening()
    rest: Floats | float = 0.0
    """(pieces,) or one for all, relative increase of friction after a long rest."""
    rest_angle: float = 10.0
    """rad of slip over which this increase falls to 1/e."""

    def __post_init__(self) -> None:
        pieces = self.edges.size - 1
        if np.any(np.asarray(self.rest) < 0) or np.shape(self.rest) not in ((), (pieces,)) or not self.rest_angle > 0:
            raise SettingsError(
                "wall contact",
                "`rest` must be one value ≥ 0 for each piece or for all, and `rest_angle` must be positive",
                "Correct them; rest = 0 is friction without memory",
            )
        fits = self.static.shape == self.dynamic.shape == (pieces,) and bool(np.all(np.diff(self.edges) > 0))
        if not (fits and np.all(self.dynamic >= 0) and np.all(self.static >= self.dynamic)):
            raise SettingsError(
                "wall contact",
                "it needs one static and one dynamic level for each piece, 0 ≤ dynamic ≤ static, and increasing edges",
                "Build it with drillid.physics.soft_string.wall_contact, or correct the levels",
            )

    def torque_between(self, edges: Floats) -> tuple[Floats, Floats]:
        """Static and dynamic torque (N m) between neighbouring edges (m), integrated exactly."""
        return self._integrals(edges, self.static), self._integrals(edges, self.dynamic)

    def rest_between(self, edges: Floats) -> Floats:
        """Mean of `rest` between neighbouring edges (m), weighted by static friction."""
        static = self._integrals(edges, self.static)
        return np.divide(
            self._integrals(edges, self.static * self.rest), static, np.zeros(static.size), where=static > 0
        )

    def _integrals(self, edges: Floats, level: Floats) -> Floats:
        cumulative = np.concatenate([[0.0], np.cumsum(level * np.diff(self.edges))])
        return np.asarray(np.diff(np.interp(edges, self.edges, cumulative)), dtype=float)


@dataclass(frozen=True)
class Cutting:
    """Cutting friction at the bit: torque proportional to the weight on bit, weakening with speed."""

    static: float
    """m, torque per weight on bit at standstill."""
    dynamic: float
    """m, torque per weight on bit far above the threshold speed."""
    weakening: Weakening = Weakening()

    def __post_init__(self) -> None:
        if not 0 <= self.dynamic <= self.static:
            raise SettingsError("cutting", "it needs 0 ≤ dynamic ≤ static", "Correct the torques per weight on bit")

    def torque(self, weight: float, speed: float) -> float:
        """Torque (N m) at a weight on bit (N) and a bit speed (rad/s)."""
        return weight * self.weakening.level(self.static, self.dynamic, speed)


@dataclass(frozen=True, eq=False)
class SpeedLaw:
    """A torque at the bit tabulated against its speed, added to all other torques; straight beyond either end.

    Linear between its points, which are equally spaced: a spline is given by many of them. With a memory τ the torque
    is that at a speed w that lags the bit's speed v, τ dw/dt = v − w: a law with one state.
    """

    speed: Floats
    """(points,) rad/s, rising in equal steps."""
    torque: Floats
    """(points,) N m, against the rotation."""
    memory: float = 0.0
    """s; none where it is 0."""

    def __post_init__(self) -> None:
        if not _is_table(self.speed, self.torque) or not self.memory >= 0:
            raise SettingsError(
                "law of the bit",
                "it needs one finite torque for each of at least two speeds in equal rising steps, and a memory ≥ 0",
                "Draw the spline at equally spaced speeds",
            )

    @property
    def steepest(self) -> float:
        """Largest slope of either sign, N m s/rad."""
        return float(np.abs(np.diff(self.torque)).max() / (self.speed[1] - self.speed[0]))


@dataclass(frozen=True, eq=False)
class TwistLaw:
    """A coupling in the string whose twist, added to the string's own, is tabulated against its torque.

    Beyond either end of the table it is straight. The twist never falls as the torque rises, so the coupling cannot
    supply energy.
    """

    depth: float
    """m from the string's upper end; in the simulator the nearest spring gives way."""
    torque: Floats
    """(points,) N m, rising in equal steps."""
    twist: Floats
    """(points,) rad."""

    def __post_init__(self) -> None:
        if not _is_table(self.torque, self.twist) or bool(np.any(np.diff(self.twist) < 0)):
            raise SettingsError(
                "law of a coupling",
                "it needs a twist for each of at least two torques in equal rising steps, and one that never falls",
                "Draw the spline at equally spaced torques, with a compliance by which its twist never falls",
            )


@dataclass(frozen=True, eq=False)
class ErrorLaw:
    """A torque that the speed control adds to its own, tabulated against the speed error: a gain that grows with it.

    Linear between its points, straight beyond either end. The error is the set point less the filtered reading;
    the torque passes through the control's filter.
    """

    error: Floats
    """(points,) rad/s, set point less reading, rising in equal steps."""
    torque: Floats
    """(points,) N m, in the direction of rotation."""

    def __post_init__(self) -> None:
        if not _is_table(self.error, self.torque):
            raise SettingsError(
                "law of the speed control",
                "it needs one finite torque for each of at least two speed errors in equal rising steps",
                "Draw the spline at equally spaced errors",
            )


def _is_table(places: Floats, values: Floats) -> bool:
    """Whether there is one finite value for each of at least two places in equal rising steps."""
    steps = np.diff(places)
    is_regular = places.size >= _LEAST_POINTS and bool(np.all(steps > 0)) and np.allclose(steps, steps[0])
    return is_regular and values.shape == places.shape and bool(np.all(np.isfinite(values)))


@dataclass(frozen=True)
class RegenerativeBit:
    """A bit each of whose blades cuts the rock left by the blade ahead.

    Torsional form of Richard, Germay and Detournay (2007), Journal of Sound and Vibration 305, 432–456: each of N
    blades cuts the depth d = V t_N, with t_N the time since the bit was 2π/N behind its present angle, and the
    torque is ½ ε a² N d. Axial motion is reduced to the rate of penetration V; the bit advances at this rate until
    the cut carries all the weight, N d = W/(ζ ε a), and no further. A bit at standstill is thus loaded up to a
    stalling torque. A bit that turns backward or carries no weight does not cut.
    """

    blades: int
    torque_per_depth: float
    """N, torque per depth of cut of all blades together, ½ ε a²."""
    rate: float
    """m/s, rate of penetration V."""
    depth_per_weight: float
    """m/N, greatest depth of cut of all blades together per weight on bit, 1/(ζ ε a)."""

    def __post_init__(self) -> None:
        if self.blades < 1 or min(self.torque_per_depth, self.rate, self.depth_per_weight) < 0:
            raise SettingsError(
                "regenerative bit", "blades must be at least 1, torque, rate and depth not negative", "Correct them"
            )

    def carried(self, speed: float, weight: float) -> bool:
        """Whether the weight (N) sustains the rate of penetration at a steady speed in rad/s."""
        return self.rate * 2 * np.pi / speed <= self.depth_per_weight * weight

    def torque(self, speed: float, weight: float) -> float:
        """Torque (N m) of steady cutting at a speed in rad/s under a weight in N."""
        depth = self.rate * 2 * np.pi / speed if self.carried(speed, weight) else self.depth_per_weight * weight
        return self.torque_per_depth * depth


@dataclass(frozen=True)
class Gear:
    """Gear between motor and output of the top drive, with backlash; rigid without it."""

    play: float = 0.0
    """rad, backlash: free angle between contact on either flank."""
    output_inertia: float = 0.0
    """kg m², the part of the top drive's inertia below the gear."""
    stiffness: float = 5e6
    """N m/rad, with teeth in contact."""
    damping: float = 2e3
    """N m s/rad, with teeth in contact."""


@dataclass(frozen=True)
class DriveLimits:
    """Limits of torque and of its rate, applied to the delayed command between the drive's gain and its lag."""

    torque: float = np.inf
    """N m, of either sign; at the limit the integral of the speed control is held (anti-windup)."""
    rate: float = np.inf
    """N m/s."""
    jitter_interval: float = 0.02
    """s, for which each random delay is held; a delay never falls below zero."""


@dataclass(frozen=True)
class SpeedSensor:
    """The top drive's speed as the speed control and the log read it."""

    scale: float = 1.0
    """Reading per true speed."""
    resolution: float = 0.0
    """rad/s, quantisation step of the reading."""
    ripple: float = 0.0
    """Relative amplitude of the once-per-revolution error of an eccentric sensor wheel."""


@dataclass(frozen=True)
class NonlinearRig:
    """A drilling system with its nonlinear parts."""

    system: DrillingSystem
    contact: WallContact | None = None
    cutting: Cutting | None = None
    regenerative: RegenerativeBit | None = None
    law: SpeedLaw | None = None
    coupling: TwistLaw | None = None
    control_law: ErrorLaw | None = None
    gear: Gear = Gear()
    limits: DriveLimits = DriveLimits()
    sensor: SpeedSensor = SpeedSensor()
    control_interval: float = 0.0
    """s, sampling interval of the control; 0 for continuous control."""

    @classmethod
    def from_linear(cls, system: DrillingSystem, weight_on_bit: float) -> "NonlinearRig":
        """The rig whose cutting laws, linearised at their speed, are those of the system; the inverse of `linearised`.

        A linear law of blades contains only their torque, number and speed. A rate of penetration of 1 mm/s is assumed,
        and a cut that carries all of the weight at ten times its steady depth.

        Parameters
        ----------
        weight_on_bit : N, at which the laws have their torques

        Raises
        ------
        SettingsError
            If the weight is not positive, or two laws are of the same kind.
        """
        laws = {type(law): law for law in system.bit.cutting}
        if weight_on_bit <= 0 or len(laws) < len(system.bit.cutting):
            raise SettingsError(
                "nonlinear rig",
                "cutting needs a weight on bit and one law of each kind",
                "Give it, merge the laws",
            )
        cutting = regenerative = None
        for law in laws.values():
            if isinstance(law, StribeckCutting):
                levels = float(law.static / weight_on_bit), float(law.dynamic / weight_on_bit)
                cutting = Cutting(*levels, Weakening(float(law.threshold), float(law.exponent)))
            else:
                depth = _RATE * 2 * np.pi / float(law.speed)
                per_depth, depth_per_weight = float(law.torque) / depth, _STALL * depth / weight_on_bit
                regenerative = RegenerativeBit(int(law.blades), per_depth, _RATE, depth_per_weight)
        free = replace(system, bit=replace(system.bit, cutting=()))
        return cls(free, cutting=cutting, regenerative=regenerative)

    def linearised(self, speed: float, weight_on_bit: float = 0.0) -> DrillingSystem:
        """The linear system of small vibrations about a steady speed (rad/s), with the cutting laws at that speed.

        Wall contact, tabulated laws, gear, limits, sensor and the control's sampling are left out.
        """
        laws: list[RegenerativeCutting | StribeckCutting] = []
        if self.cutting is not None:
            levels = (weight_on_bit * self.cutting.static, weight_on_bit * self.cutting.dynamic)
            weakening = self.cutting.weakening
            laws.append(StribeckCutting(*levels, weakening.threshold, speed, weakening.exponent))
        blades = self.regenerative
        if blades is not None and blades.carried(speed, weight_on_bit):
            laws.append(RegenerativeCutting(blades.torque(speed, weight_on_bit), speed, blades.blades))
        return replace(self.system, bit=replace(self.system.bit, cutting=tuple(laws)))


VaryingRig = Callable[[float], NonlinearRig]
"""The rig at a time in s since the first step; its parameters may change, but not which parts it has."""
