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

from drillid.arrays import Floats
from drillid.physics.dual_numbers import composed, linear, primal
from drillid.physics.kernel import compiled

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


def read_and_kept(
    interval: Any, delay: Any, offset: Any, read: Any = None, kept: Any = None
) -> tuple[Cumulants, Cumulants]:
    """Cumulants that a command adds to its delay which is held and then read, and what the readings as they are kept
    have beyond them; any argument may be a Dual.

    They are continuous where the whole delay is a multiple of h and a half; v has a kink there. Fourth and fifth are
    plain numbers, as their derivatives hardly matter.

    Parameters
    ----------
    interval, delay : h and T_d, which includes h/2; s
    offset : of the recorder's clock, s
    read, kept : response at s = 2πi/h of all other filters from the command to what is read, and to what is kept; None
        without any
    """
    variables = interval, delay, offset, *_polar(read), *_polar(kept)
    values = [primal(each) for each in variables]
    shape = np.broadcast_shapes(*(np.shape(each) for each in values))
    columns = np.empty((len(values), *shape))
    for row, value in enumerate(values):
        columns[row] = value
    of_read, beyond = _added(columns.reshape(len(values), -1)).reshape(2, 4, 1 + len(values), *shape)
    return _composed(of_read, variables), _composed(beyond, variables)


def _composed(table: Floats, variables: tuple[Any, ...]) -> Cumulants:
    """Cumulants from their values and derivatives, (4, 8, ...)."""
    second, third = (composed(order[0], list(zip(order[1:], variables, strict=True))) for order in table[:2])
    fourth, fifth = table[2:, 0]
    return second, third, fourth, fifth


@compiled
def _added(columns: Floats) -> Floats:
    """Cumulants with their derivatives, (2, 4, 8, places): what is read, and what is kept less that; from the second to
    the fifth; the value, and its derivative to each variable, of which fourth and fifth have none.

    Parameters
    ----------
    columns : (7, places) interval, delay, offset, and modulus and phase of the filters of what is read and kept
    """
    found = np.zeros((2, 4, 8, columns.shape[1]))
    for place in range(columns.shape[1]):
        h = columns[0, place]
        for reader in range(2):
            late = columns[1, place] + reader * columns[2, place]
            w, turned = columns[3 + 2 * reader, place], columns[4 + 2 * reader, place]
            part = late / h - 0.5 - turned / (2 * np.pi)
            part -= np.floor(part)
            spread, skewed, mixed = part * (1 - part), 1 - 2 * part, w * (1 - w)
            values = (
                h**2 * (w * (spread - 1 / 6) + 1 / 12),
                h**3 * w * spread * skewed,
                # from the logarithm of 1 + w (exp(…) − 1)
                h**4 * (w * (spread * (1 - 6 * spread) + 1 / 60) - 1 / 120 + 3 * mixed * (spread - 1 / 6) ** 2),
                h**5 * spread * skewed * (w * (1 - 12 * spread) + 10 * mixed * (spread - 1 / 6)),
            )
            by_delay = h * w * skewed, h**2 * w * (1 - 6 * spread)
            by_modulus = h**2 * (spread - 1 / 6), h**3 * spread * skewed
            # what is kept is told by what it has beyond what is read
            for row in range(reader, 2):
                sign = 1.0 if row == reader else -1.0
                for order in range(4):
                    found[row, order, 0, place] += sign * values[order]
                for order in range(2):
                    slope = sign * by_delay[order]
                    # a longer interval also makes less of one of the same delay
                    found[row, order, 1, place] += sign * (2 + order) * values[order] / h - slope * late / h
                    found[row, order, 2, place] += slope
                    found[row, order, 3, place] += reader * slope
                    found[row, order, 4 + 2 * reader, place] += sign * by_modulus[order]
                    found[row, order, 5 + 2 * reader, place] -= slope * h / (2 * np.pi)
    return found


def _polar(filters: Any) -> tuple[Any, Any]:
    """Modulus and phase of a response that may be a Dual; 1 and 0 where there is none."""
    if filters is None:
        return 1.0, 0.0
    logarithm = np.log(filters + _NONE)
    return np.exp(linear(np.real, logarithm)), linear(np.imag, logarithm)


def held_logarithm(s: Any, third: Any, fourth: Any, fifth: Any) -> Any:
    """What cumulants from the third (s³) to the fifth (s⁵) add to the logarithm of a delay's response."""
    return s**3 * (third / -6) + s**4 * (fourth / 24) + s**5 * (fifth / -120)
