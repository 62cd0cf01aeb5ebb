"""What the linear model leaves out: friction, cutting, play, limits and sensors, described once beside the equipment.

Every part has sizes at which it does nothing; a `NonlinearRig` of defaults is its drilling system. Figures are plain
numbers in SI units, for the time-domain simulator.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from drillid.arrays import Floats
from drillid.errors import SettingsError
from drillid.physics.equipment import DrillingSystem, RegenerativeCutting, StribeckCutting

_RATE = 1e-3
"""m/s, rate of penetration of blades of which only the torque is known."""
_STALL = 10.0
"""Greatest depth of their cut per steady depth."""


@dataclass(frozen=True)
class Weakening:
    """How friction falls from its static to its dynamic level as the speed v rises.

    level(v) = dynamic + (static − dynamic) exp(−(|v|/threshold)^exponent), after Stribeck (1902) in the form of
    Armstrong-Hélouvry, Dupont and Canudas de Wit (1994), Automatica 30, 1083–1138. A large exponent comes close to
    a jump at the threshold.
    """

    threshold: float = 1.0
    """rad/s."""
    exponent: float = 1.0

    def __post_init__(self) -> None:
        if not (self.threshold > 0 and self.exponent > 0):
            raise SettingsError(
                "weakening of friction",
                f"threshold {self.threshold} rad/s and exponent {self.exponent} must both be positive",
                "Give static and dynamic friction the same level where there is no weakening",
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

    A string that starts from rest is held by (1 + rest exp(−φ/rest_angle)) times these levels, φ its own slip since:
    the slip law of Ruina (1983), Journal of Geophysical Research 88, 10359–10370, without the slow healing.
    """

    edges: Floats
    """(pieces + 1,) m from the top of the string, rising."""
    static: Floats
    """(pieces,) N, torque per length that a standing string can take."""
    dynamic: Floats
    """(pieces,) N, torque per length far above the threshold speed."""
    weakening: Weakening = Weakening()
    rest: Floats | float = 0.0
    """(pieces,) or one for all, share by which a string that has rested long is held more than one that has turned."""
    rest_angle: float = 10.0
    """rad of slip, over which that share falls to 1/e."""

    def __post_init__(self) -> None:
        pieces = self.edges.size - 1
        if np.any(np.asarray(self.rest) < 0) or np.shape(self.rest) not in ((), (pieces,)) or not self.rest_angle > 0:
            raise SettingsError(
                "wall contact",
                "shares of rest must not be negative, one for each piece or one for all, over an angle above 0",
                "Correct them; a share of 0 is friction without memory",
            )
        fits = self.static.shape == self.dynamic.shape == (pieces,) and bool(np.all(np.diff(self.edges) > 0))
        if not (fits and np.all(self.dynamic >= 0) and np.all(self.static >= self.dynamic)):
            raise SettingsError(
                "wall contact",
                "it needs one static and one dynamic level for each piece, 0 ≤ dynamic ≤ static, and rising edges",
                "Build it with drillid.physics.soft_string.wall_contact, or correct the levels",
            )

    def within(self, edges: Floats) -> tuple[Floats, Floats]:
        """Static and dynamic torque (N m) between each pair of neighbouring edges (m), as exact integrals."""
        return self._integrals(edges, self.static), self._integrals(edges, self.dynamic)

    def rest_within(self, edges: Floats) -> Floats:
        """Share of rest between each pair of neighbouring edges (m), weighted with static friction."""
        held = self._integrals(edges, self.static)
        return np.divide(self._integrals(edges, self.static * self.rest), held, np.zeros(held.size), where=held > 0)

    def _integrals(self, edges: Floats, level: Floats) -> Floats:
        gathered = np.concatenate([[0.0], np.cumsum(level * np.diff(self.edges))])
        return np.asarray(np.diff(np.interp(edges, self.edges, gathered)), dtype=float)


@dataclass(frozen=True)
class Cutting:
    """Friction of cutting at the bit: torque proportional to the weight on it, weakening with speed."""

    static: float
    """m, torque per weight on bit at standstill."""
    dynamic: float
    """m, torque per weight on bit far above the threshold speed."""
    weakening: Weakening = Weakening()

    def __post_init__(self) -> None:
        if not 0 <= self.dynamic <= self.static:
            raise SettingsError("cutting", "it needs 0 ≤ dynamic ≤ static", "Correct the torques per weight on bit")

    def torque(self, weight: float, speed: float) -> float:
        """Torque (N m) at a weight (N) and a speed (rad/s) of the turning bit."""
        return weight * self.weakening.level(self.static, self.dynamic, speed)


@dataclass(frozen=True)
class RegenerativeBit:
    """A bit whose blades cut what the blade ahead of each has left.

    Torsional form of Richard, Germay and Detournay (2007), Journal of Sound and Vibration 305, 432–456: each of N
    blades cuts the depth d = V t_N, with t_N the time since the bit was 2π/N behind its present angle, and the
    torque is ½ ε a² N d. Axial motion is reduced to the rate V of penetration; the bit goes down at it until the
    cut takes all the weight, N d = W/(ζ ε a), and no further. So a bit that stands is loaded up to a stalling
    torque. One that turns backward or carries no weight cuts nothing.
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
        """Whether the weight (N) suffices for the rate of penetration at a steady speed in rad/s."""
        return self.rate * 2 * np.pi / speed <= self.depth_per_weight * weight

    def torque(self, speed: float, weight: float) -> float:
        """Torque (N m) of steady cutting at a speed in rad/s under a weight in N."""
        depth = self.rate * 2 * np.pi / speed if self.carried(speed, weight) else self.depth_per_weight * weight
        return self.torque_per_depth * depth


@dataclass(frozen=True)
class Gear:
    """Gear between motor and output of the top drive, with play; without play it is rigid."""

    play: float = 0.0
    """rad, free angle between contact on either flank."""
    output_inertia: float = 0.0
    """kg m², the part of the top drive's inertia below the gear."""
    stiffness: float = 5e6
    """N m/rad, of teeth in contact."""
    damping: float = 2e3
    """N m s/rad, of teeth in contact."""


@dataclass(frozen=True)
class DriveLimits:
    """What the drive does to the delayed command between its gain and its lag: limits of torque and of its rate."""

    torque: float = np.inf
    """N m, of either sign; the integral of the speed control is held meanwhile."""
    rate: float = np.inf
    """N m/s."""
    jitter_interval: float = 0.02
    """s, for which each delay of a jittering drive holds; none falls below zero."""


@dataclass(frozen=True)
class SpeedSensor:
    """What speed control and log see of the top drive's speed."""

    scale: float = 1.0
    """Reading per true speed."""
    resolution: float = 0.0
    """rad/s, step of the reading."""
    ripple: float = 0.0
    """Share of the speed by which an eccentric wheel falsifies it, once per revolution."""


@dataclass(frozen=True)
class NonlinearRig:
    """A drilling system with all that is not linear in it."""

    system: DrillingSystem
    contact: WallContact | None = None
    cutting: Cutting | None = None
    regenerative: RegenerativeBit | None = None
    gear: Gear = Gear()
    limits: DriveLimits = DriveLimits()
    sensor: SpeedSensor = SpeedSensor()
    control_interval: float = 0.0
    """s, at which the control reads the speed and renews its command; 0 for continuous control."""

    @classmethod
    def of(cls, system: DrillingSystem, weight_on_bit: float) -> "NonlinearRig":
        """The rig whose cutting has the system's linear laws as its own about their speed; the inverse of `about`.

        Of blades only torque and number are known. They penetrate at a millimetre a second, and their cut takes all
        of the weight at ten times its steady depth.

        Parameters
        ----------
        weight_on_bit : N, to which the laws' torques belong

        Raises
        ------
        SettingsError
            If the weight is not positive, or two laws are of one kind.
        """
        laws = {type(law): law for law in system.bit.cutting}
        if weight_on_bit <= 0 or len(laws) < len(system.bit.cutting):
            raise SettingsError(
                "non-linear rig", "cutting needs a weight on bit and one law of each kind", "Give the weight, join laws"
            )
        cutting = regenerative = None
        for law in laws.values():
            if isinstance(law, StribeckCutting):
                levels = float(law.static / weight_on_bit), float(law.dynamic / weight_on_bit)
                cutting = Cutting(*levels, Weakening(float(law.threshold), float(law.exponent)))
            else:
                depth = _RATE * 2 * np.pi / float(law.speed)
                figures = int(law.blades), float(law.torque) / depth, _RATE, _STALL * depth / weight_on_bit
                regenerative = RegenerativeBit(*figures)
        free = replace(system, bit=replace(system.bit, cutting=()))
        return cls(free, cutting=cutting, regenerative=regenerative)

    def about(self, speed: float, weight_on_bit: float = 0.0) -> DrillingSystem:
        """The linear system of small vibrations about a steady speed (rad/s): the bit's cutting laws at that speed.

        Wall contact, gear, limits, sensor and the control's sampling have no part in it.
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


Course = Callable[[float], NonlinearRig]
"""NonlinearRig at a time in s since the first step; only sizes may change, not which parts there are."""
