"""Modes of the drilling system: its poles in the complex plane, with frequency and damping.

The characteristic function F(s) is the residual of the upper boundary condition for a unit speed of the bit:
T₁ + Y_top ω₁, or ω₁ where the top is clamped, times the denominators of further factors of drive and control and of the
feedback of the string's torque. As a product of the sections' transfer matrices it has no poles above the real axis,
with any of the damping laws but that of a mounted inertia, and its zeros there are the modes.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from drillid.arrays import Complex, Floats
from drillid.errors import EstimationError
from drillid.physics.attachments import MountedInertia
from drillid.physics.bottom_end import bit_load, chain_through_motor
from drillid.physics.dual_numbers import Dual, derivatives
from drillid.physics.equipment import DrillingSystem, of_window, window_shape
from drillid.physics.line import chain_entries
from drillid.physics.top_drive import matching_denominator, top_admittance

FASTEST_DECAY = 20.0
"""1/s; modes that decay faster are not searched for."""
FASTEST_GROWTH = 5.0
"""1/s; modes that grow faster are not searched for."""

_LARGEST_TURN = 0.7
"""rad; largest change of arg F between neighbouring points of a contour."""
_MOST_HALVINGS = 30
_NEWTON_STEPS = 60
_SMALLEST_RECTANGLE = 1e-7
"""1/s; zeros closer together count as one multiple zero."""


@dataclass(frozen=True)
class Modes:
    """Poles above the real axis, in order of frequency."""

    poles: Complex
    """Shape (..., mode), 1/s; padded with NaN for windows with fewer modes than others."""

    @property
    def frequency(self) -> Floats:
        """Frequency of the damped motion, Im s/2π, Hz."""
        return self.poles.imag / (2 * np.pi)

    @property
    def damping_ratio(self) -> Floats:
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
    if stiff:
        return speed
    residual = (torque + top_admittance(system.top_drive, s) * speed) * matching_denominator(system.top_drive, s)
    for shaping in (system.top_drive.shaping, system.top_drive.controller.shaping):
        residual = residual if shaping is None else residual * shaping.denominator(s)
    return residual


def modes(
    system: DrillingSystem,
    lowest: float = 0.02,
    highest: float = 5.0,
    *,
    stiff: bool = False,
    fastest_decay: float = FASTEST_DECAY,
    fastest_growth: float = FASTEST_GROWTH,
) -> Modes:
    """All modes between two frequencies, of every window that the system describes.

    The zeros of F are counted by its winding number along rectangles (argument principle), which are bisected
    until each holds one; Newton's method with exact derivatives refines it. So none is missed.

    Parameters
    ----------
    system : quantities are plain numbers, or of shape (..., 1)
    lowest, highest : Hz
    stiff : clamp the top drive
    fastest_decay, fastest_growth : 1/s, bounds of the real part

    Raises
    ------
    EstimationError
        If a zero lies on the boundary of the band, or an inertia is mounted along the string.
    """
    if any(isinstance(law, MountedInertia) for section in system.string for law in section.laws):
        raise EstimationError(
            "modes",
            "modes cannot be counted beside an inertia mounted along the string, which has a resonance of its own",
            "Leave it out, or put a lump in its place",
        )
    corners = complex(-fastest_decay, 2 * np.pi * lowest), complex(fastest_growth, 2 * np.pi * highest)
    shape = window_shape(system)
    per_window = [_poles(of_window(system, index, shape), corners, stiff) for index in np.ndindex(shape)]
    padded = np.full((len(per_window), max((poles.size for poles in per_window), default=0)), complex(np.nan, np.nan))
    for row, poles in zip(padded, per_window, strict=True):
        row[: poles.size] = poles
    return Modes(padded.reshape(*shape, -1) if shape else padded[0])


def _poles(system: DrillingSystem, corners: tuple[complex, complex], stiff: bool) -> Complex:
    """Poles of one window inside a rectangle, in order of frequency."""

    def function(s: Any) -> Any:
        return characteristic_function(system, s, stiff=stiff)

    travel_time = sum(section.length * np.sqrt(section.density / section.shear_modulus) for section in system.string)
    poles = np.array(_zeros(function, *corners, 0.5 / float(travel_time + system.top_drive.delay)), dtype=complex)
    return poles[np.argsort(poles.imag)]


def pole_derivatives(
    build: Callable[..., DrillingSystem],
    parameters: Floats,
    poles: Complex | complex,
    *,
    stiff: bool = False,
) -> Complex:
    """Derivative of poles to each parameter, −(∂F/∂p)/(∂F/∂s), exact.

    Parameters
    ----------
    build : drilling system of P parameters
    parameters : shape (..., P)
    poles : 1/s, of the systems of these parameters; shape (..., mode) as from `modes`, or a single pole

    Returns
    -------
    slopes : shape (..., mode, P), 1/s per unit of each parameter; NaN where the pole is; (P,) for a single pole
    """
    at = np.asarray(poles, dtype=complex)
    values = parameters[..., None, :] if at.ndim else parameters
    points = np.concatenate([at[..., None], np.broadcast_to(values, (*at.shape, values.shape[-1]))], axis=-1)
    with np.errstate(invalid="ignore"):
        # windows with fewer modes are padded with NaN
        _, slopes = derivatives(lambda s, *values: characteristic_function(build(*values), s, stiff=stiff), points)
        return np.asarray(-slopes[..., 1:, 0] / slopes[..., :1, 0], dtype=complex)


def _zeros(function: Callable[[Any], Any], lower: complex, upper: complex, spacing: float) -> list[complex]:
    """Zeros in a rectangle between corners; far from them arg F changes by less than 1 rad over `spacing` (1/s)."""
    zeros: list[complex] = []
    rectangles = [(lower, upper)]
    while rectangles:
        counted = [(*corners, *_along_boundary(function, *corners, spacing)) for corners in rectangles]
        single = [rectangle for rectangle in counted if rectangle[2] == 1]
        divided = [rectangle[:3] for rectangle in counted if rectangle[2] > 1]
        starts = [rectangle[3] for rectangle in single]
        for (low, high, count, _), zero in zip(single, _newton(function, starts), strict=True):
            if low.real <= zero.real <= high.real and low.imag <= zero.imag <= high.imag:
                zeros.append(complex(zero))
            else:
                divided.append((low, high, count))
        rectangles = []
        for low, high, count in divided:
            size = high - low
            if max(size.real, size.imag) < _SMALLEST_RECTANGLE:
                zeros += [(low + high) / 2] * count
            else:
                rectangles += _parts(low, high)
    return zeros


def _parts(lower: complex, upper: complex) -> list[tuple[complex, complex]]:
    """Rectangle cut in two across its longer side."""
    size = upper - lower
    # a cut off the middle seldom passes through a zero; those of symmetric systems lie at round fractions
    if size.imag >= size.real:
        middle = lower.imag + 0.4871 * size.imag
        return [(lower, complex(upper.real, middle)), (complex(lower.real, middle), upper)]
    middle = lower.real + 0.4871 * size.real
    return [(lower, complex(middle, upper.imag)), (complex(middle, lower.imag), upper)]


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


def _newton(function: Callable[[Any], Any], starts: list[complex]) -> Complex:
    """Zeros near the starting points, to rounding."""
    zeros = np.array(starts, dtype=complex)
    moving = np.arange(zeros.size)
    for _ in range(_NEWTON_STEPS):
        if moving.size == 0:
            break
        value = function(Dual(zeros[moving], np.ones((1, moving.size))))
        steps = value.value / value.tangents[0]
        zeros[moving] -= steps
        moving = moving[np.abs(steps) > 1e-14 * np.abs(zeros[moving])]
    return zeros
