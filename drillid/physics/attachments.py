"""Bodies attached to the string at a place: a lump, or an inertia on a spring and a damper.

An attachment is spread over a short section, a tenth of the shortest wavelength or less, so that every response of a
string holds with it. All of them are positive real for non-negative parameters: they cannot supply energy.
"""

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from drillid.physics.damping import DampingLaw, Steel
from drillid.physics.dual_numbers import primal
from drillid.physics.equipment import Quantity, Section
from drillid.physics.strings import String

SPREAD = 20.0
"""m, over which an attachment is spread: longer than the elements of the time-domain simulator, and a fiftieth of the
wavelength at 4 Hz."""

_SHORTEST = 1e-9
"""m, below which a piece is left out."""


@dataclass(frozen=True)
class MountedInertia(DampingLaw):
    """An inertia J on a spring and a damper in parallel, ω = √(k/J), ζ = c/(2 √(k J)).

    Seen from the string, Y = J s (2ζω s + ω²)/(s² + 2ζω s + ω²) (Den Hartog 1956, Mechanical Vibrations, section 3.2):
    an inertia far below its own frequency, a damping at it, and almost nothing far above.
    """

    inertia: Quantity
    """J, kg m²."""
    frequency: Quantity
    """ω/2π, Hz."""
    loss: Quantity
    """2ζ."""
    spread: float = SPREAD
    """m, length of the section that it is spread over."""

    def admittance(self, s: Any) -> Any:
        """Torque per speed of the string, N m s/rad."""
        own = 2 * np.pi * self.frequency
        mount = own * (self.loss * s + own)
        return self.inertia * s * mount / (np.square(s) + mount)

    @property
    def stiffness(self) -> Quantity:
        """Spring k, N m/rad."""
        return self.inertia * np.square(2 * np.pi * self.frequency)

    @property
    def damping(self) -> Quantity:
        """Damper c, N m s/rad."""
        return self.inertia * (2 * np.pi * self.frequency) * self.loss

    def shunt(self, section: Steel, s: Any) -> Any:
        """Admittance per length, N s/rad."""
        return self.admittance(s) / self.spread


@dataclass(frozen=True)
class Relaxation(DampingLaw):
    """Drag along the string through an elastic layer, b IP s/(s + p): none when slow, viscous when fast.

    Sums of it stand for any law with memory (Montseny 1998, ESAIM Proceedings 5, 159–175).
    """

    coefficient: Quantity
    """b, N s/m⁴."""
    rate: Quantity
    """p, rad/s."""

    def shunt(self, section: Steel, s: Any) -> Any:
        """Drag b IP s/(s + p), N s/rad."""
        return self.coefficient * section.polar_moment * s / (s + self.rate)


def with_lump(string: String, depth: Quantity, inertia: Quantity = 0.0, damping: Quantity = 0.0) -> String:
    """The string with an inertia (kg m²) and a damping (N m s/rad) to ground about a depth (m from its top)."""
    above, middle, below = _opened(string, depth)
    volume = SPREAD * middle.polar_moment
    heavier = replace(middle, density=middle.density + inertia / volume, kappa=middle.kappa + damping / volume)
    return (*above, heavier, *below)


def with_joint(string: String, depth: Quantity, compliance: Quantity) -> String:
    """The string with a soft joint (rad/(N m)) about a depth (m); it loses the same share of energy as the steel."""
    above, middle, below = _opened(string, depth)
    softer = 1 / (1 + compliance * middle.shear_modulus * middle.polar_moment / SPREAD)
    joint = replace(middle, shear_modulus=middle.shear_modulus * softer, delta=middle.delta * softer)
    return (*above, joint, *below)


def with_law(string: String, depth: Quantity, law: DampingLaw) -> String:
    """The string with a law of damping over a length SPREAD about a depth (m)."""
    above, middle, below = _opened(string, depth)
    return (*above, replace(middle, laws=(*middle.laws, law)), *below)


def _opened(string: String, depth: Quantity) -> tuple[String, Section, String]:
    """The string with a piece of length SPREAD about a depth split off: sections above, the piece, sections below.

    The piece lies within the section at that depth in the mean over the windows or, if that is too short, within the
    nearest that is long enough.
    """
    lengths = np.array([float(np.mean(primal(section.length))) for section in string])
    starts = np.concatenate([[0.0], np.cumsum(lengths)[:-1]])
    begin = float(np.mean(primal(depth))) - SPREAD / 2
    outside = np.maximum(np.maximum(starts - begin, begin - starts - lengths + SPREAD), 0.0)
    chosen = int(np.argmin(np.where(lengths > SPREAD, outside, np.inf)))
    section, start = string[chosen], sum((each.length for each in string[:chosen]), start=0.0)
    above = np.minimum(np.maximum(depth - SPREAD / 2 - start, 0.0), section.length - SPREAD)
    parts = [replace(section, length=length) for length in (above, SPREAD, section.length - SPREAD - above)]
    upper, middle, lower = parts
    before = (*string[:chosen], *(part for part in (upper,) if _has_length(part)))
    after = (*(part for part in (lower,) if _has_length(part)), *string[chosen + 1 :])
    return before, middle, after


def _has_length(section: Section) -> bool:
    return bool(np.any(np.asarray(primal(section.length)) > _SHORTEST))
