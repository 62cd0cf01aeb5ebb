"""Control that samples and holds: a computer reads the speed at an interval h and holds its command in between.

A command that is held for h is late by a uniformly distributed time: the drive is multiplied by
(1 − e^(−sh))/(sh) = e^(−sh/2) sinh(sh/2)/(sh/2), a delay by h/2, which counts as part of T_d, and a variance of h²/12
(Åström and Wittenmark 1997, Computer-Controlled Systems, chapters 2 and 3). The readings fold what the steps of the
command add at multiples of their rate. There the top drive's inertia J is the load, whose speed at the readings follows
exactly: where the drive itself is late by m + f intervals, m whole ones and a part f,

    z^(−m) (1 − f + f/z) h/(J (z − 1)) = e^(−sT_d)/(J s) (1 + s²h² (f(1 − f)/2 − 1/24) + …),   z = e^(sh),

so that altogether the variance is v = h² (f(1 − f) − 1/12): h²/12 in the mean over f, and between −h²/12 and h²/6. The
series is the response of a delay of 0 with probability 1 − f, else of h, about its mean, over that of a uniform one. It
has their further cumulants: the third is κ = h³ f(1 − f)(1 − 2f), at most 0.1 h³; the fourth makes 1 % at 4 Hz where h
is 45 ms.

What depends on f is folded, nearly all of it from the first multiple of the rate. A filter G between command and
reading shifts f by the phase of G there, and weakens what depends on f by |G|. A recorder that keeps the readings holds
what they would be if the drive were followed by the recorder's clock and filter in place of the control's: its time
stamps have the difference of v, and of κ, with the one and with the other.
"""

from typing import Any

import numpy as np
from scipy.special import erf

from drillid.physics.dual_numbers import composed, linear, primal

_USUAL = 0.025
"""s, scale of the half-normal prior of an interval that is not known."""
INTERVALS = (0.0, *np.geomspace(0.01, 0.05, 15).tolist())
"""s, intervals that are tried where it is not known: none, and up to where hardly any speed control has its
interval, so close that none between them fits much better.
"""
_BETWEEN = np.sqrt(np.convolve(np.square(INTERVALS), [0.5, 0.5], "valid"))
"""s, intervals that are nearer to the next one, by what they do, which grows with their square."""
PRIOR = np.diff(erf(np.array([0.0, *_BETWEEN, np.inf]) / (np.sqrt(2) * _USUAL)))
"""Prior probability of the intervals nearest each of these."""
Cumulants = tuple[Any, Any, Any, Any]
"""From the second (s²) to the fifth (s⁵)."""
_NONE = 1e-200
"""In place of a response that vanishes, whose phase does not matter."""


def cumulants(interval: Any, delay: Any, filters: Any = None) -> Cumulants:
    """Cumulants that a command adds to its delay which is held and then read; any argument may be a Dual.

    They are continuous where the whole delay is a multiple of h and a half; v has a kink there. Fourth and fifth are
    plain numbers, as their derivatives hardly matter.

    Parameters
    ----------
    interval, delay : h and T_d, which includes h/2; s
    filters : response of all other filters from the command to the reading at s = 2πi/h; None without any
    """
    beyond, weakened = delay / interval - 0.5, 1.0
    if filters is not None:
        logarithm = np.log(filters + _NONE)
        weakened, beyond = np.exp(linear(np.real, logarithm)), beyond - linear(np.imag, logarithm) / (2 * np.pi)
    h, w, part = (np.asarray(primal(each)) for each in (interval, weakened, beyond))
    part = part - np.floor(part)
    spread, skewed = part * (1 - part), 1 - 2 * part
    second, third = w * (spread - 1 / 6) + 1 / 12, w * spread * skewed
    of_second = [(2 * h * second, interval), (h**2 * w * skewed, beyond), (h**2 * (spread - 1 / 6), weakened)]
    of_third = [(3 * h**2 * third, interval), (h**3 * w * (1 - 6 * spread), beyond), (h**3 * spread * skewed, weakened)]
    fourth, fifth = _higher(part, w)
    return composed(h**2 * second, of_second), composed(h**3 * third, of_third), h**4 * fourth, h**5 * fifth


def held_logarithm(s: Any, third: Any, fourth: Any, fifth: Any) -> Any:
    """What cumulants from the third (s³) to the fifth (s⁵) add to the logarithm of a delay's response."""
    return s**3 * (third / -6) + s**4 * (fourth / 24) + s**5 * (fifth / -120)


def _higher(part: Any, weakened: Any) -> tuple[Any, Any]:
    """Fourth and fifth cumulant at an interval of one, from the logarithm of 1 + weakened (exp(…) − 1)."""
    spread, mixed = part * (1 - part), weakened * (1 - weakened)
    fourth = weakened * (spread * (1 - 6 * spread) + 1 / 60) - 1 / 120 + 3 * mixed * (spread - 1 / 6) ** 2
    fifth = spread * (1 - 2 * part) * (weakened * (1 - 12 * spread) + 10 * mixed * (spread - 1 / 6))
    return fourth, fifth
