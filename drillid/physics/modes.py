"""Modes of the drilling system: its poles in the complex plane, with frequency and damping.

The characteristic function F(s) is what the motion of the upper end is short of zero for a unit speed of the
bit: T₁ + Y_top ω₁, or ω₁ where the top is clamped. It is made of the sections' transfer matrices, so that it
has no poles above the real axis, with any of the damping laws, and its zeros there are the modes.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from drillid.errors import EstimationError, SettingsError
from drillid.physics.bottom_end import bit_load, chain_through_motor
from drillid.physics.dual import Dual, derivatives
from drillid.physics.equipment import DrillingSystem
from drillid.physics.line import Complex, chain_entries
from drillid.physics.top_drive import top_admittance

Poles = NDArray[np.complex128]

FASTEST_DECAY = 20.0
"""1/s; faster decaying motion is not looked for."""
FASTEST_GROWTH = 5.0
"""1/s; faster growing motion is not looked for."""

_LARGEST_TURN = 0.7
"""rad; largest turn of F between neighbouring points of a contour."""
_MOST_HALVINGS = 30
_NEWTON_STEPS = 60
_SMALLEST_RECTANGLE = 1e-7
"""1/s; zeros closer together count as one multiple zero."""


@dataclass(frozen=True)
class Modes:
    """Poles above the real axis, in order of frequency."""

    poles: Poles
    """Shape (mode,), 1/s."""

    @property
    def frequency(self) -> NDArray[np.float64]:
        """Frequency of the damped motion, Im s/2π, Hz."""
        return self.poles.imag / (2 * np.pi)

    @property
    def damping_ratio(self) -> NDArray[np.float64]:
        """−Re s/|s|, 1 at critical damping, negative where the motion grows."""
        return -self.poles.real / np.abs(self.poles)


def characteristic_function(system: DrillingSystem, s: Complex, *, stiff: bool = False) -> Any:
    """F(s), zero at the modes: T₁ + Y_top ω₁ (N m s/rad), or ω₁ with the top clamped, per speed of the bit."""
    speed, torque = 1.0, bit_load(system.bit, s)
    matrices = [chain_entries(section, s) for section in system.string]
    if system.motor is not None:
        matrices.append(chain_through_motor(system.motor, s))
    for a, b, c, d in reversed(matrices):
        speed, torque = a * speed + b * torque, c * speed + d * torque
    return speed if stiff else torque + top_admittance(system.top_drive, s) * speed


def modes(
    system: DrillingSystem,
    lowest: float = 0.02,
    highest: float = 5.0,
    *,
    stiff: bool = False,
    fastest_decay: float = FASTEST_DECAY,
    fastest_growth: float = FASTEST_GROWTH,
) -> Modes:
    """All modes of one system (plain figures) between two frequencies.

    The zeros of F are counted by its turns along rectangles (argument principle), which are halved until
    each holds one; Newton's method with exact derivatives ends the search. So none is missed.

    Parameters
    ----------
    lowest, highest : Hz
    stiff : clamp the top drive
    fastest_decay, fastest_growth : 1/s, bounds of the real part

    Raises
    ------
    EstimationError
        If a zero lies on the boundary of the band.
    SettingsError
        If the system stands for several windows.
    """
    corners = complex(-fastest_decay, 2 * np.pi * lowest), complex(fastest_growth, 2 * np.pi * highest)

    def function(s: Any) -> Any:
        return characteristic_function(system, s, stiff=stiff)

    travel_time = sum(section.length * np.sqrt(section.density / section.shear_modulus) for section in system.string)
    spacing = 0.5 / float(np.max(travel_time + system.top_drive.delay))
    if np.shape(function(np.array(corners))) != (2,):
        raise SettingsError("modes", "the system stands for several windows", "Ask for the modes of one by one")
    poles = np.array(_zeros(function, *corners, spacing), dtype=complex)
    return Modes(poles[np.argsort(poles.imag)])


def pole_derivatives(
    build: Callable[..., DrillingSystem], parameters: NDArray[np.float64], pole: complex, *, stiff: bool = False
) -> Complex:
    """Derivative of a pole to each parameter, −(∂F/∂p)/(∂F/∂s), exact.

    Parameters
    ----------
    build : drilling system of P figures
    parameters : shape (P,)
    pole : 1/s, of the system of these parameters

    Returns
    -------
    slopes : shape (P,), 1/s per unit of each parameter
    """
    _, slopes = derivatives(
        lambda s, *figures: characteristic_function(build(*figures), s, stiff=stiff),
        np.concatenate([[pole], parameters]),
    )
    return np.asarray(-slopes[1:, 0] / slopes[0, 0], dtype=complex)


def _zeros(function: Callable[[Any], Any], lower: complex, upper: complex, spacing: float) -> list[complex]:
    """Zeros in the rectangle between two corners; F turns by less than a radian over `spacing` (1/s) far from them."""
    turns, moment = _along_boundary(function, lower, upper, spacing)
    if turns == 0:
        return []
    size = upper - lower
    if turns == 1:
        zero = _newton(function, moment)
        if lower.real <= zero.real <= upper.real and lower.imag <= zero.imag <= upper.imag:
            return [zero]
    if max(size.real, size.imag) < _SMALLEST_RECTANGLE:
        return [(lower + upper) / 2] * turns
    # a cut off the middle seldom meets a zero, as symmetric systems have theirs on round places
    if size.imag >= size.real:
        middle = lower.imag + 0.4871 * size.imag
        parts = (lower, complex(upper.real, middle)), (complex(lower.real, middle), upper)
    else:
        middle = lower.real + 0.4871 * size.real
        parts = (lower, complex(middle, upper.imag)), (complex(middle, lower.imag), upper)
    return [zero for part in parts for zero in _zeros(function, *part, spacing)]


def _along_boundary(
    function: Callable[[Any], Any], lower: complex, upper: complex, spacing: float
) -> tuple[int, complex]:
    """Number of zeros inside, and their sum by the first moment of d log F; no poles are inside."""
    around = np.array(
        [lower, complex(upper.real, lower.imag), upper, complex(lower.real, upper.imag), lower], dtype=complex
    )
    counts = 8 + (np.abs(np.diff(around)) / spacing).astype(int)
    sides = zip(around[:-1], around[1:], counts, strict=True)
    edges = [np.linspace(start, end, count, endpoint=False) for start, end, count in sides]
    points = np.concatenate([*edges, around[:1]])
    values = np.asarray(function(points))
    for _ in range(_MOST_HALVINGS):
        steps = np.log(values[1:] / values[:-1])
        coarse = np.flatnonzero((np.abs(steps.imag) > _LARGEST_TURN) | (np.abs(steps.real) > 2.0))
        if coarse.size == 0:
            moment = np.sum((points[1:] + points[:-1]) / 2 * steps)
            return round(float(np.sum(steps.imag)) / (2 * np.pi)), complex(moment / (2j * np.pi))
        between = (points[coarse] + points[coarse + 1]) / 2
        points = np.insert(points, coarse + 1, between)
        values = np.insert(values, coarse + 1, function(between))
    raise EstimationError(
        f"modes between {lower:.3g} and {upper:.3g} 1/s",
        "a mode lies on the boundary of the search",
        "Choose another band of frequencies or another fastest decay",
    )


def _newton(function: Callable[[Any], Any], start: complex) -> complex:
    """Zero near the start, to rounding."""
    zero = start
    for _ in range(_NEWTON_STEPS):
        value = function(Dual(np.array([zero]), np.ones((1, 1))))
        step = complex(value.value[0] / value.tangents[0, 0])
        zero -= step
        if abs(step) <= 1e-14 * abs(zero):
            break
    return zero
