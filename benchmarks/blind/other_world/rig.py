"""A rig of the second world in one window: string, ends, control, drive, friction and recording, in SI units."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from benchmarks.blind.hidden import altered
from drillid.arrays import Floats

DENSITY, SHEAR_MODULUS = 7850.0, 79.3e9
"""Of steel, kg/m³ and Pa."""


@dataclass(frozen=True)
class Piece:
    """A uniform length of the string with what is attached to its lower end; pieces go from top to bottom."""

    length: float
    """m."""
    moment: float
    """Polar moment of the cross section, m⁴."""
    wall_damping: float = 0.0
    """κ, N s/m⁴."""
    steel_damping: float = 0.0
    """δ, N s/m²."""
    density: float = DENSITY
    shear_modulus: float = SHEAR_MODULUS
    loss_factor: float = 0.0
    """Share of 2π times the elastic energy that is lost in a cycle."""
    root_drag: float = 0.0
    """N s^(3/2)/m⁴, drag that grows as the square root of frequency."""
    inertia_below: float = 0.0
    """kg m², lump at the lower end."""
    damping_below: float = 0.0
    """N m s/rad, at the lower end."""

    @property
    def admittance(self) -> float:
        """Characteristic admittance without damping, N m s/rad."""
        return self.moment * float(np.sqrt(self.density * self.shear_modulus))

    @property
    def inertia(self) -> float:
        """Inertia of the piece itself, kg m²."""
        return self.density * self.moment * self.length


def coupling(stiffness: float) -> Piece:
    """A spring of a stiffness (N m/rad) without inertia, as a piece of one metre."""
    moment = 1e-5
    return Piece(1.0, moment, density=1e-3, shear_modulus=stiffness / moment)


@dataclass(frozen=True)
class Control:
    """PI speed control that reads the speed, and renews its command, at intervals."""

    proportional: float
    """N m s/rad."""
    integral: float
    """N m/rad."""
    interval: float
    """s."""
    speed_filter: float = 0.0
    """s, time constant of an analogue low pass in front of the reading."""
    torque_filter: float = 0.0
    """s, time constant of a low pass on the controller's torque."""
    windup_gain: float = 0.0
    """1/s, rate at which the integral gives back what a limit withholds (back-calculation); 0 holds it at the limit."""
    notch: float = 0.0
    """Hz, centre of a notch in the controller's torque; 0 without it."""
    notch_depth: float = 0.9
    """Share that it takes away at its centre."""


@dataclass(frozen=True)
class Drive:
    """From the command to the torque on the top drive."""

    inertia: float
    """kg m²."""
    delay: float
    """s, apart from the hold of the command."""
    gain: float = 1.0
    lag: float = 0.0
    """s."""
    jitter: float = 0.0
    """s rms, of the delay of each command."""
    limit: float = np.inf
    """N m."""
    rate: float = np.inf
    """N m/s."""
    play: float = 0.0
    """rad, backlash of the gear; contact is rigid."""
    share_below_gear: float = 0.3
    """Share of the inertia below the gear, where it has play."""
    resonance: float = 0.0
    """Hz, of the torque loop, lightly damped; 0 without it."""


LAWS = ("karnopp", "dahl", "lugre")
"""Friction at low speed: Karnopp (1985), Dahl (1968), Canudas de Wit, Olsson, Åström and Lischinsky (1995)."""
FALLS = ("gaussian", "rational")
"""How friction falls with speed: exp(−(v/v_s)²), Bo and Pavelescu (1982); 1/(1 + v/v_s), Hess and Soom (1990)."""


@dataclass(frozen=True)
class Friction:
    """Dry friction of one contact."""

    law: str
    coulomb: float
    """N m, at high speed."""
    rise: float = 0.0
    """N m, additional friction at rest."""
    fall: str = "gaussian"
    threshold: float = 1.0
    """rad/s, speed scale of the fall."""

    def level(self, speed: float) -> float:
        """Friction of steady sliding, N m, at a speed in rad/s."""
        ratio = abs(speed) / self.threshold
        return self.coulomb + self.rise * float(np.exp(-(ratio**2)) if self.fall == "gaussian" else 1 / (1 + ratio))

    def steepness(self, speed: float) -> float:
        """Fall of friction per speed at a positive speed, N m s/rad."""
        ratio = speed / self.threshold
        shape = 2 * ratio * np.exp(-(ratio**2)) if self.fall == "gaussian" else 1 / (1 + ratio) ** 2
        return float(self.rise / self.threshold * shape)

    @classmethod
    def with_steepness(cls, law: str, fall: str, coulomb: float, steepness: float, speed: float) -> "Friction":
        """Friction that falls by `steepness` per speed at a speed, at a threshold of that speed."""
        unit = cls(law, coulomb, 1.0, fall, speed)
        return altered(unit, rise=steepness / unit.steepness(speed))


@dataclass(frozen=True)
class Contact:
    """Friction at a place along the string."""

    share: float
    """Of the string's length, from the top."""
    friction: Friction


@dataclass(frozen=True)
class Blades:
    """Cutting in which each blade cuts what the blade ahead has left, at a steady rate of penetration."""

    count: int
    torque: float
    """N m, at the mean speed."""


RECORDINGS = ("hold", "interpolate")
"""What a recorder makes of the controller's samples: the last one, or a line between two."""


@dataclass(frozen=True)
class Recording:
    """How the controller's samples become rows of a log, and the speed's own faults."""

    kind: str = "hold"
    phase: float = 0.0
    """s, of the recorder's clock against the controller's."""
    noise: float = 0.0
    """rad/s rms, of every reading of the speed."""
    scale: float = 1.0
    offset: float = 0.0
    """s; positive where the speed is recorded late."""
    drift: float = 0.0
    """s/s, growth of the offset."""
    filter_time: float = 0.0
    """s, one over the angular corner frequency of a low pass on the recorded speed."""
    filter_order: int = 1
    held: float = 0.0
    """s, interval at which a slower device renews the recorded speed; 0 without one."""
    resolution: float = 0.0
    """rad/s."""
    tone: float = 0.0
    """rad/s, amplitude of a disturbance of the recorded speed."""
    tone_frequency: float = 50.0
    """Hz."""
    ripple: float = 0.0
    """Relative amplitude of the sensor's error once per revolution, which the control sees as well."""


@dataclass(frozen=True)
class Rock:
    """Torque of the rock on the bit beside friction and blades: mean and disturbances."""

    mean: float
    """N m."""
    noise: float
    """N m rms."""
    bandwidth: float
    """Hz."""
    swing: float = 0.0
    """Standard deviation of the logarithm of a slowly varying level."""
    tail: float = np.inf
    """Degrees of freedom of the noise's distribution (Student's t)."""
    bursts: float = 0.0
    """1/s, rate of episodes of stronger noise."""
    lines: tuple[tuple[float, float], ...] = ()
    """Hz and N m rms of narrow bands: pump strokes, blades."""
    wander: float = 0.0
    """Relative slow variation of the mean with the weight on bit."""


@dataclass(frozen=True)
class Window:
    """Everything that the simulation of a window depends on, besides the seed."""

    string: tuple[Piece, ...]
    control: Control
    drive: Drive
    rock: Rock
    speed: float
    """rad/s, set point."""
    sweep: float
    """N m, amplitude of each of the three sweeps."""
    recording: Recording = Recording()
    contacts: tuple[Contact, ...] = ()
    bit_friction: Friction | None = None
    blades: Blades | None = None
    speed_wander: float = 0.0
    """Relative slow variation of the set point."""
    growth: float = 0.0
    """m, by which the uppermost piece grows while the window lasts, about its mean."""
    damping_course: tuple[float, ...] = ()
    """N m s/rad, damping added at the bit at equally spaced moments from begin to end of the window, linear between."""

    def added_damping(self, share: Floats) -> Floats:
        """Damping added at the bit at elapsed shares of the window, N m s/rad."""
        course = self.damping_course or (0.0,)
        return np.interp(share, np.linspace(0.0, 1.0, len(course)), course)

    def with_control(self, **parameters: Any) -> "Window":
        """The same with another control."""
        return altered(self, control=altered(self.control, **parameters))

    def with_drive(self, **parameters: Any) -> "Window":
        """The same with another drive."""
        return altered(self, drive=altered(self.drive, **parameters))

    def with_recording(self, **parameters: Any) -> "Window":
        """The same with another recording."""
        return altered(self, recording=altered(self.recording, **parameters))

    @property
    def length(self) -> float:
        """Of the string, m."""
        return sum(piece.length for piece in self.string)

    def grown(self, share: float) -> tuple[Piece, ...]:
        """The string at an elapsed share of the window."""
        first, *below = self.string
        return (altered(first, length=first.length + self.growth * (share - 0.5)), *below)
