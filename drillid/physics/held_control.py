"""Control that samples and holds: a computer reads the speed at intervals h and holds its command in between.

A command that is held for h is late by a uniformly distributed time: the drive is multiplied by
(1 − e^(−sh))/(sh) = e^(−sh/2) sinh(sh/2)/(sh/2), a delay by h/2, which counts as part of T_d, and a variance of h²/12
(Åström and Wittenmark 1997, Computer-Controlled Systems, chapters 2 and 3). The readings fold (alias) what the steps of
the command add at multiples of their rate. There the top drive's inertia J is the load, whose speed at the readings
follows exactly: where the drive itself is late by m + f intervals, m whole ones and a part f,

    z^(−m) (1 − f + f/z) h/(J (z − 1)) = e^(−sT_d)/(J s) (1 + s²h² (f(1 − f)/2 − 1/24) + …),   z = e^(sh),

so that altogether the variance is v = h² (f(1 − f) − 1/12): h²/12 in the mean over f, and between −h²/12 and h²/6. The
series is the response of a delay of 0 with probability 1 − f, else of h, about its mean, over that of a uniform one.
Further cumulants follow from these two: the third is κ = h³ f(1 − f)(1 − 2f), at most 0.1 h³; the fourth makes 1 % at
4 Hz where h is 45 ms.

What depends on f is folded from the multiples k of the rate: 1 + Σ s² e^(−νT) G(s + ν)/(G(s) (s + ν)²) over ν = 2πik/h,
k ≠ 0, with T = T_d − h/2 and the filters G between command and reading. Their ratio is taken at s = 0, for the first
multiple, which folds most, together with its slope; from the third multiple on, its modulus is the second's, and so is
its phase per multiple. A recorder that keeps the readings holds what they would be if the recorder's clock and
filter took the place of the control's: its time stamps have the difference in v, and in κ, between the two.
"""

from collections.abc import Callable
from functools import partial
from typing import Any, NamedTuple

import numpy as np
from scipy.special import erf

from drillid.arrays import Array
from drillid.physics.dual_numbers import composed, linear, primal

_USUAL = 0.025
"""s, scale of the half-normal prior of an interval that is not known."""
INTERVALS = (0.0, *np.geomspace(0.01, 0.05, 15).tolist())
"""s, intervals to try where it is not known: none, then up to one that hardly any speed control exceeds, so closely
spaced that none in between fits much better.
"""
_BETWEEN = np.sqrt(np.convolve(np.square(INTERVALS), [0.5, 0.5], "valid"))
"""s, limits between neighbouring intervals, halfway in their effect, which grows with the square of the interval."""
PRIOR = np.diff(erf(np.array([0.0, *_BETWEEN, np.inf]) / (np.sqrt(2) * _USUAL)))
"""Prior probability of the range of intervals about each of these."""
Cumulants = tuple[Any, Any, Any, Any]
"""Cumulants from the second (s²) to the fifth (s⁵)."""
_NONE = 1e-200
"""Used in place of a response that vanishes, whose phase does not matter."""
_STEP = 0.01
"""Step of the difference that gives a filter's slope, relative to the rate; the error grows with its square."""


class Filters(NamedTuple):
    """Effect of the filters between a held command and its reading on the folded multiples; may be Duals."""

    first: Any = 1.0
    """G at the first multiple of the rate."""
    slope: Any = 0.0
    """s, slope of ln G there less that at 0."""
    modulus: Any = 1.0
    """Modulus of G at the second multiple."""
    turned: Any = 0.0
    """rad, phase of G at the second multiple, per multiple."""


NO_FILTERS = Filters()


def filters_between(response: Callable[[Any], Any], interval: Any) -> Filters:
    """Effect of filters on the folded multiples.

    Parameters
    ----------
    response : G without delays, as a function of s in rad/s, which is its last axis; 1 at s = 0
    interval : h, s; with a last axis of length 1 where it is an array
    """
    rate = 2j * np.pi / interval
    aside = -1j * _STEP
    at = response(rate * np.array([1, 2, 1 + aside, 1 - aside, aside, -aside])) + _NONE
    first, second, *sides = (linear(partial(_place, number), at) for number in range(6))
    slope = np.log(sides[0] / sides[1] / (sides[2] / sides[3])) / (2 * aside * rate)
    twice = np.log(second)
    phase, nearest = linear(np.imag, twice), 2 * np.angle(primal(first))
    # phase at the second multiple, on the branch nearest to twice that at the first
    phase = phase - 2 * np.pi * np.round((primal(phase) - nearest) / (2 * np.pi))
    return Filters(first, slope, np.exp(linear(np.real, twice)), phase / 2)


def _place(number: int, values: Array) -> Array:
    return values[..., number : number + 1]


def read_and_kept(
    interval: Any, delay: Any, offset: Any, read: Filters = NO_FILTERS, kept: Filters = NO_FILTERS
) -> tuple[Cumulants, Cumulants]:
    """Cumulants that holding a command and reading its effect add to its delay, and those that the recorded readings
    have in addition; any argument may be a Dual.

    They are continuous where the whole delay is a multiple of h plus h/2; v has a kink there. Fourth and fifth are
    plain numbers, as their derivatives hardly matter.

    Parameters
    ----------
    interval, delay : h and T_d, which includes h/2; s
    offset : of the recorder's clock, s
    read, kept : all other filters from the command to the control's reading, and to the recorded one
    """
    of_read, of_kept = _added(interval, delay, read), _added(interval, delay + offset, kept)
    second, third, fourth, fifth = (after - before for before, after in zip(of_read, of_kept, strict=True))
    return of_read, (second, third, fourth, fifth)


def _added(interval: Any, late: Any, filters: Filters) -> Cumulants:
    """Cumulants added if all delays together are `late`, s."""
    h = primal(interval)
    second, third, *series = _on_all_multiples(interval, late, filters)
    if filters is not NO_FILTERS:
        beyond = _on_the_first(interval, late, filters)
        second, third = second + 2 * beyond[0], third - 6 * beyond[1]
        series = [all_ + primal(more) for all_, more in zip(series, beyond, strict=True)]
    a, b, fourth, fifth = series
    return second, third, 24 * fourth - 12 * a**2 - h**4 / 120, 120 * (a * b - fifth)


def _on_all_multiples(interval: Any, late: Any, filters: Filters) -> tuple[Any, ...]:
    """Second and third cumulant, then the coefficients of s² to s⁵ without derivatives, of the folded multiples, as if
    the filters acted on all multiples as on the second one.

    The coefficients are Bernoulli polynomials (Abramowitz and Stegun 1964, 23.1.16).
    """
    h, delay, w, turned = (primal(each) for each in (interval, late, filters.modulus, filters.turned))
    part = delay / h - 0.5 - turned / (2 * np.pi)
    part = part - np.floor(part)
    spread, skewed = part * (1 - part), 1 - 2 * part
    second, third = h**2 * (spread - 1 / 6) / 2, h**3 * spread * skewed / -6
    fourth, fifth = h**4 * (1 / 30 - spread**2) / 8, h**5 * spread * skewed * (1 / 3 + spread) / 60
    cumulants = []
    for order, factor, beside, value, slope in (
        (2, 2.0, h**2 / 12, second, h * skewed / 2),
        (3, -6.0, 0.0 * h, third, h**2 * (1 - 6 * spread) / -6),
    ):
        scaled = factor * w * slope
        # a longer interval also makes the same delay a smaller part of it
        of_interval = (order * (factor * w * value + beside) - scaled * delay) / h
        parts = [(of_interval, interval), (scaled, late)]
        if filters is not NO_FILTERS:
            parts += [(factor * value, filters.modulus), (scaled * h / (-2 * np.pi), filters.turned)]
        cumulants.append(composed(factor * (w * value) + beside, parts))
    return *cumulants, w * second, w * third, w * fourth, w * fifth


def _on_the_first(interval: Any, late: Any, filters: Filters) -> Cumulants:
    """Addition for the filters' actual effect on the first multiple."""
    rate = 2j * np.pi / interval
    turn = 2 * np.exp(rate * (interval / 2 - late)) / rate**2
    beyond = turn * (filters.first - filters.modulus * np.exp(1j * filters.turned))
    sloping = turn * filters.first * filters.slope
    third, fourth = sloping - 2 * beyond / rate, (3 * beyond / rate - 2 * sloping) / rate
    fifth = (3 * sloping - 4 * beyond / rate) / rate**2
    second, third, fourth, fifth = (linear(np.real, each) for each in (beyond, third, fourth, fifth))
    return second, third, primal(fourth), primal(fifth)


def held_logarithm(s: Any, third: Any, fourth: Any, fifth: Any) -> Any:
    """Addition of the third (s³) to fifth (s⁵) cumulants to the logarithm of a delay's response."""
    if all(isinstance(each, float) and each == 0 for each in (third, fourth, fifth)):
        return 0.0
    return s**3 * (third / -6) + s**4 * (fourth / 24) + s**5 * (fifth / -120)
