"""Cumulants that held control adds to a delay, with their derivatives, compiled.

With the rate r = 2πi/h of the control and the sum L(s) of the filters' logarithms, the first multiple folds by exp L(r)
and slopes by L′(r) − L′(0); all others fold by the modulus of exp L(2r), and half its phase per multiple. The formulas
and their source are those of `drillid.physics.held_control`.
"""

import cmath
import math

import numpy as np

from drillid.arrays import Complex, Floats
from drillid.physics.kernel import compiled

QUANTITIES = 8
"""Number of quantities that the cumulants depend on: interval h, delay T_d and clock offset, s; time constants of the
drive's lag and of the control's speed filter, s; variances of jitter of the drive and of the recorder's clock, s²; one
over the angular corner frequency of the recorder's Butterworth filter, s."""
_INTERVAL, _DELAY, _LAG, _SECOND_LAG, _VARIANCE, _CORNER_TIME = range(6)
"""Places of the quantities on the way to one reading, whose delay and variance are sums."""
WAYS = 2
"""To the control's reading, and to the recorded one."""
_ON_ONE_WAY = 6
_TO_READ = np.array([0, 1, -1, 2, 3, 4, -1, -1])
_TO_KEPT = np.array([0, 1, 1, 2, -1, 4, 4, 5])
"""Place on the way to the control's reading, and to the recorded one, of each of the eight quantities; −1 off it."""


@compiled
def _butterworth(u: complex, order: int) -> tuple[complex, complex, complex]:
    """Logarithm of a Butterworth polynomial, continuous from u = 0 on, with its first and second derivative."""
    logarithm, first, second = complex(0.0, 0.0), complex(0.0, 0.0), complex(0.0, 0.0)
    for pair in range((order + 1) // 2):
        if pair < order // 2:
            across = 2 * math.sin(math.pi * (2 * pair + 1) / (2 * order))
            factor, slope, curvature = 1.0 + across * u + u * u, across + 2 * u, 2.0
        else:
            factor, slope, curvature = 1.0 + u, complex(1.0, 0.0), 0.0
        relative = slope / factor
        logarithm += cmath.log(factor)
        first += relative
        second += curvature / factor - relative * relative
    return logarithm, first, second


@compiled
def filters(own: Floats, order: int, s: complex, slopes: Complex) -> tuple[complex, complex, complex]:
    """L, L′ and L″ at s.

    Parameters
    ----------
    own : (6,) the quantities
    order : of the Butterworth filter
    slopes : (2, 6) filled with the derivatives of L and L′ to the filters' quantities
    """
    logarithm, first, second = 0.5 * own[_VARIANCE] * s * s, own[_VARIANCE] * s, complex(own[_VARIANCE], 0.0)
    slopes[0, _VARIANCE], slopes[1, _VARIANCE] = 0.5 * s * s, s
    for place in (_LAG, _SECOND_LAG):
        time = own[place]
        factor = 1.0 + time * s
        logarithm -= cmath.log(factor)
        first -= time / factor
        second += (time / factor) ** 2
        slopes[0, place], slopes[1, place] = -s / factor, -1.0 / factor**2
    time = own[_CORNER_TIME]
    polynomial, by_u, by_u_twice = _butterworth(time * s, order)
    slopes[0, _CORNER_TIME], slopes[1, _CORNER_TIME] = -s * by_u, -by_u - time * s * by_u_twice
    return logarithm - polynomial, first - time * by_u, second - time * time * by_u_twice


@compiled
def _on_all_multiples(h: float, part: float) -> tuple[float, float, float, float]:
    """Coefficients of s² to s⁵ of all folded multiples without filters, where the delay is whole intervals, a part and
    half of one: Bernoulli polynomials (Abramowitz and Stegun 1964, 23.1.16).
    """
    spread, skewed = part * (1 - part), 1 - 2 * part
    second, third = h**2 * (spread - 1 / 6) / 2, -(h**3) * spread * skewed / 6
    return second, third, h**4 * (1 / 30 - spread**2) / 8, h**5 * spread * skewed * (1 / 3 + spread) / 60


@compiled
def _one_way(own: Floats, order: int, by_filters: Complex, cumulants: Floats, slopes: Floats) -> None:
    """Cumulants (4,) that are added on the way to one reading, and derivatives (2, 6) of second and third.

    Parameters
    ----------
    by_filters : (3, 2, 6) derivatives of L and L′ at 0, r and 2r, filled
    """
    h, delay = own[_INTERVAL], own[_DELAY]
    rate = complex(0.0, 2 * math.pi / h)
    _, at_zero, _ = filters(own, order, complex(0.0, 0.0), by_filters[0])
    at_first, by_rate, curvature = filters(own, order, rate, by_filters[1])
    at_second, by_twice, _ = filters(own, order, 2 * rate, by_filters[2])

    modulus, phase = math.exp(at_second.real), 0.5 * at_second.imag
    part = delay / h - 0.5 - phase / (2 * math.pi)
    part -= math.floor(part)
    second, third, fourth, fifth = _on_all_multiples(h, part)
    turn, on_first = h * h / (2 * math.pi**2) * cmath.exp(-rate * delay), cmath.exp(at_first)
    on_second, slope = modulus * cmath.exp(complex(0.0, phase)), by_rate - at_zero
    beyond, sloping = turn * (on_first - on_second), turn * on_first * slope

    a = modulus * second + beyond.real
    b = modulus * third + (sloping - 2 * beyond / rate).real
    fourth = modulus * fourth + ((3 * beyond / rate - 2 * sloping) / rate).real
    fifth = modulus * fifth + ((3 * sloping - 4 * beyond / rate) / rate**2).real
    cumulants[0], cumulants[1] = 2 * a + h * h / 12, -6 * b
    cumulants[2], cumulants[3] = 24 * fourth - 12 * a**2 - h**4 / 120, 120 * (a * b - fifth)

    by_part = h**2 * (1 - 2 * part) / 2, -(h**3) * (1 - 6 * part * (1 - part)) / 6
    for place in range(_ON_ONE_WAY):
        of_h, of_delay = (1.0 if place == _INTERVAL else 0.0), (1.0 if place == _DELAY else 0.0)
        of_rate = -rate / h * of_h
        of_first = by_rate * of_rate + by_filters[1, 0, place]
        of_second = by_twice * 2 * of_rate + by_filters[2, 0, place]
        of_slope = curvature * of_rate + by_filters[1, 1, place] - by_filters[0, 1, place]
        of_modulus, of_phase = modulus * of_second.real, 0.5 * of_second.imag
        of_part = of_delay / h - delay / h**2 * of_h - of_phase / (2 * math.pi)
        of_turn = 2 / h * of_h - of_rate * delay - rate * of_delay
        of_folded = on_first * of_first - on_second * complex(of_second.real, of_phase)
        of_beyond = of_turn * beyond + turn * of_folded
        of_sloping = of_turn * sloping + turn * on_first * (of_first * slope + of_slope)
        of_third = of_sloping - 2 * of_beyond / rate + 2 * beyond / rate**2 * of_rate
        of_a = of_modulus * second + modulus * (2 * second / h * of_h + by_part[0] * of_part) + of_beyond.real
        of_b = of_modulus * third + modulus * (3 * third / h * of_h + by_part[1] * of_part) + of_third.real
        slopes[0, place], slopes[1, place] = 2 * of_a + h / 6 * of_h, -6 * of_b


@compiled
def on_way(quantities: Floats, way: int) -> Floats:
    """The six quantities on one of the ways, interval, delay, two lags, variance and time of the corner, of eight."""
    own = np.zeros(_ON_ONE_WAY)
    for quantity, place in enumerate(_TO_KEPT if way else _TO_READ):
        if place >= 0:
            own[place] += quantities[quantity]
    return own


@compiled
def folded(quantities: Floats, order: int, cumulants: Floats, slopes: Floats) -> None:
    """What holding adds to the cumulants of the drive's delay, and to those of the recorder's clock.

    Parameters
    ----------
    quantities : (W, 8)
    order : of the recorder's filter
    cumulants : (2, 4, W) second to fifth, filled
    slopes : (2, 2, 8, W) derivatives of second and third, filled
    """
    by_filters = np.zeros((3, 2, _ON_ONE_WAY), dtype=np.complex128)
    added, derivatives = np.empty((WAYS, 4)), np.empty((WAYS, 2, _ON_ONE_WAY))
    for window in range(quantities.shape[0]):
        for way in range(WAYS):
            own = on_way(quantities[window], way)
            _one_way(own, order, by_filters, added[way], derivatives[way])
        cumulants[0, :, window], cumulants[1, :, window] = added[0], added[1] - added[0]
        for quantity in range(QUANTITIES):
            read, kept = _TO_READ[quantity], _TO_KEPT[quantity]
            for which in range(2):
                of_read = derivatives[0, which, read] if read >= 0 else 0.0
                of_kept = derivatives[1, which, kept] if kept >= 0 else 0.0
                slopes[0, which, quantity, window] = of_read
                slopes[1, which, quantity, window] = of_kept - of_read
