"""Control that samples and holds: a computer reads the speed at an interval h and holds its command in between.

A command that is held for h is late by a uniformly distributed time: the drive is multiplied by
(1 − e^(−sh))/(sh) = e^(−sh/2) sinh(sh/2)/(sh/2), a delay by h/2, which counts as part of T_d, and a variance of h²/12
(Åström and Wittenmark 1997, Computer-Controlled Systems, chapters 2 and 3). The readings fold what the steps of the
command add at multiples of their rate. There the top drive's inertia J is the load, whose speed at the readings follows
exactly: where the drive itself is late by m + f intervals, m whole ones and a part f,

    z^(−m) (1 − f + f/z) h/(J (z − 1)) = e^(−sT_d)/(J s) (1 + s²h² (f(1 − f)/2 − 1/24) + …),   z = e^(sh),

so that altogether the variance is v = h² (f(1 − f) − 1/12): h²/12 in the mean over f, and between −h²/12 and h²/6. The
next term of the logarithm is −s³ κ/6 with the third cumulant κ = h³ f(1 − f)(1 − 2f), at most 0.1 h³.

A recorder whose clock is late by t₀ against the control's holds what the readings would be if the drive were later by
t₀: its time stamps have the difference of v, and of κ, at T_d + t₀ and at T_d.
"""

import numpy as np
from numpy.typing import ArrayLike
from scipy.special import ndtri

from drillid.arrays import Floats

LONGEST = 0.05
"""s, beyond which hardly any speed control has its interval."""
_USUAL = LONGEST / 2
"""s, scale of the half-normal prior of an interval that is not known."""
_QUANTILES = 64
_SHARES = (np.arange(_QUANTILES) + 0.5) / _QUANTILES


def hold_variance(interval: ArrayLike, delay: ArrayLike) -> Floats:
    """V of the drive, s², from the interval h and the whole delay T_d, which includes h/2; both in s, and broadcast."""
    interval = np.asarray(interval, dtype=float)
    return _spread(interval, np.asarray(delay, dtype=float) - interval / 2) - interval**2 / 12


def hold_skewness(interval: float, delay: ArrayLike) -> Floats:
    """κ of the drive, s³, from the interval h and the whole delays T_d, which include h/2, s; zero where h is NaN."""
    beyond = np.mod(np.asarray(delay, dtype=float) / interval - 0.5, 1.0)
    return np.asarray(np.nan_to_num(interval**3 * beyond * (1 - beyond) * (1 - 2 * beyond)), dtype=float)


def reading_skewness(interval: float, delay: ArrayLike, clock_offset: ArrayLike) -> Floats:
    """κ of a recorder's time stamps, s³, whose clock is late by some times, s; zero where h is NaN."""
    later = np.asarray(delay, dtype=float) + np.asarray(clock_offset, dtype=float)
    return hold_skewness(interval, later) - hold_skewness(interval, delay)


def hold_variance_prior(interval: float, delay: float, delay_error: float) -> tuple[float, float]:
    """Mean and standard deviation of v of the drive, s².

    Parameters
    ----------
    interval : s; NaN where it is not known, which is then half-normal
    delay, delay_error : s, T_d and its standard uncertainty, infinite where it is not known
    """
    intervals, delays = _intervals_and_delays(interval, delay, delay_error)
    return _moments(hold_variance(intervals, delays))


def reading_variance_prior(
    interval: float, delay: float, delay_error: float, clock_error: float
) -> tuple[float, float]:
    """Mean and standard deviation of v of a recorder's time stamps, s², whose clock is off by `clock_error` (s).

    Parameters
    ----------
    interval, delay, delay_error : as for the drive
    """
    intervals, delays = _intervals_and_delays(interval, delay, delay_error)
    later = delays[..., None] + clock_error * ndtri(_SHARES)
    return _moments(hold_variance(intervals[..., None], later) - hold_variance(intervals, delays)[..., None])


def _spread(interval: Floats, time: Floats) -> Floats:
    """h² g(1 − g), s², where a time is beyond whole intervals by a part g."""
    beyond = np.mod(time / interval, 1.0)
    return np.asarray(interval**2 * beyond * (1 - beyond), dtype=float)


def _intervals_and_delays(interval: float, delay: float, delay_error: float) -> tuple[Floats, Floats]:
    """The interval alone, or quantiles of its prior where it is not known; and quantiles of the delay, s."""
    intervals = np.array([interval]) if np.isfinite(interval) else -_USUAL * ndtri(_SHARES / 2)
    # of a delay that is not known, any part of an interval is as likely as another
    known = np.isfinite(delay_error)
    return intervals, delay + delay_error * ndtri(_SHARES)[:, None] if known else intervals * _SHARES[:, None]


def _moments(values: Floats) -> tuple[float, float]:
    return float(values.mean()), float(values.std())
