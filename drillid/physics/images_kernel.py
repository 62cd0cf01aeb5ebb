"""What readings of a held command's effect fold, at any frequency, compiled.

At the multiples ν = 2πik/h of the control's rate, k ≠ 0, the top drive's inertia J and the pipe's characteristic
admittance Y₀ are the load. Relative to the command's own response in the band, without that load, the multiples add

    R(s) = Σ s/(s + ν) e^(−νT) G(s + ν)/G(s)/(J (s + ν) + Y₀),

with T = T_d − h/2 and the filters G between command and reading. Without filters the sum is the z transform of a held
step's response (Åström and Wittenmark 1997, Computer-Controlled Systems, chapter 2) less the term k = 0. With filters
the first multiples are summed one by one; on all others G has the modulus of the next one, and its phase per multiple.
"""

import cmath
import math

import numpy as np

from drillid.arrays import Complex, Floats
from drillid.physics.held_kernel import WAYS, filters, on_way
from drillid.physics.kernel import compiled, falling, inlined, inverse

_ONE_BY_ONE = 4
"""Multiples on either side that are summed where there are filters."""
_NODES = 16
"""Number of Chebyshev nodes between which R is interpolated."""
_COSINES = np.cos(np.pi * np.outer(np.arange(_NODES), np.arange(_NODES) + 0.5) / _NODES)
"""Chebyshev polynomials at the nodes, by degree and node; that of first degree is the nodes."""
_FAR = 2.9
"""Distance of the nearest pole from the middle of the frequencies, relative to half their range, from which the error
is below 1e-12 of R: it falls by 5.6 with each node (Trefethen 2013, Approximation Theory and Approximation Practice).
"""


@inlined
def _passed(own: Floats, pairs: Floats, order: int, s: complex) -> complex:
    """1/G(s).

    Parameters
    ----------
    own : (6,) quantities of one way
    pairs : (order // 2,) linear coefficients of the Butterworth filter's quadratic factors
    """
    u = own[5] * s
    product: complex = (1.0 + own[2] * s) * (1.0 + own[3] * s) * falling(0.5 * own[4] * s * s)
    if order % 2:
        product = product * (1.0 + u)
    for pair in pairs:
        product = product * (1.0 + pair * u + u * u)
    return product


@compiled
def _on_one_way(
    own: Floats, pairs: Floats, order: int, inertia: float, admittance: float, s: Complex, images: Complex
) -> None:
    """R (F,) of one way, filled."""
    h, start = own[0], own[1] - 0.5 * own[0]
    is_filtered, modulus, turned = own[2] > 0 or own[3] > 0 or own[4] > 0 or own[5] > 0, 1.0, 0.0
    if is_filtered:
        beyond = _ONE_BY_ONE + 1
        logarithm, _, _ = filters(
            own, order, complex(0.0, 2 * math.pi * beyond / h), np.zeros((2, own.size), np.complex128)
        )
        modulus, turned = math.exp(logarithm.real), logarithm.imag / beyond
    part = start / h - turned / (2 * math.pi)
    part -= math.floor(part)
    decay = admittance / inertia * h
    whole, at_end = math.exp(-decay), math.exp(-decay * (1 - part))
    first, second = -math.expm1(-decay * (1 - part)) / admittance, (at_end - whole) / admittance
    for j in range(s.size):
        later = falling(s[j] * h)
        pulses = (first + second * later) * later * inverse(1.0 - whole * later)
        held = s[j] * h * inverse(1.0 - later) * falling(-part * h * s[j])
        images[j] = modulus * (held * pulses - inverse(inertia * s[j] + admittance))
    if not is_filtered:
        return
    for multiple in range(-_ONE_BY_ONE, _ONE_BY_ONE + 1):
        if multiple != 0:
            around = complex(0.0, 2 * math.pi * multiple / h)
            own_phase, usual = cmath.exp(-around * start), modulus * cmath.exp(-around * part * h)
            for j in range(s.size):
                at = s[j] + around
                of_multiple = own_phase * inverse(_passed(own, pairs, order, at)) - usual
                images[j] += s[j] * inverse(at) * inverse(inertia * at + admittance) * of_multiple
    for j in range(s.size):
        images[j] *= _passed(own, pairs, order, s[j])


@compiled
def images(
    quantities: Floats, pairs: Floats, order: int, inertia: float, admittance: float, omega: Floats, folded: Complex
) -> None:
    """R of the control's reading and of the recorded one, rad/(N m s).

    Far below the control's rate R is smooth: it is interpolated between Chebyshev nodes.

    Parameters
    ----------
    quantities : (8,) of `drillid.physics.held_kernel`
    pairs : (order // 2,) linear coefficients of the quadratic factors of the recorder's filter
    order : of that filter; 0 without one
    inertia : of the top drive, kg m²
    admittance : characteristic one of the pipe, N m s/rad
    omega : (F,) 1/s
    folded : (2, F), filled
    """
    middle, half = 0.5 * (omega.max() + omega.min()), 0.5 * (omega.max() - omega.min())
    nearest = 2 * math.pi / quantities[0]
    is_smooth = half > 0 and omega.size > _NODES and nearest - middle > _FAR * half
    at = middle + half * _COSINES[1] if is_smooth else omega
    s, values = (at * 1j).astype(np.complex128), np.empty(at.size, dtype=np.complex128)
    for way in range(WAYS):
        _on_one_way(on_way(quantities, way), pairs, order, inertia, admittance, s, values)
        if is_smooth:
            _interpolate(values, (omega - middle) / half, folded[way])
        else:
            folded[way] = values


@compiled
def _interpolate(values: Complex, x: Floats, result: Complex) -> None:
    """Polynomial through values at the Chebyshev nodes, at places within ±1, filled (Trefethen 2013, chapter 3)."""
    coefficients = np.empty(_NODES, dtype=np.complex128)
    for degree in range(_NODES):
        coefficient = 0j
        for node in range(_NODES):
            coefficient += values[node] * _COSINES[degree, node]
        coefficients[degree] = coefficient * ((2.0 if degree else 1.0) / _NODES)
    for j in range(x.size):
        before, now, polynomial = 1.0, x[j], coefficients[0]
        for degree in range(1, _NODES):
            polynomial += coefficients[degree] * now
            before, now = now, 2.0 * x[j] * now - before
        result[j] = polynomial
