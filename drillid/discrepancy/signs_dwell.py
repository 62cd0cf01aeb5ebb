"""Signs of what stays at zero for a while: a bit that stands, a gear between its flanks.

A quantity that passes zero spends as much time about it as its density beside zero foretells; one that dwells there
spends more.
"""

import numpy as np
from numpy.typing import NDArray
from scipy.special import ndtr, stdtr

from drillid.discrepancy.signs_record import Remainder
from drillid.discrepancy.signs_score import Score, normal_of_chance
from drillid.discrepancy.signs_string import Motion

Floats = NDArray[np.float64]

_BLOCK_S = 20.0
_ENDS_S = 20.0
"""s at either end where the reckoned motion lacks data from outside of the window."""
_LEAST_BLOCKS = 4
_STANDING = 0.15
"""Share of the mean speed within which the bit counts as standing."""
_BETWEEN_FLANKS = 0.15
"""Share of the torque's standard deviation within which a gear may be between its flanks."""
_ABOVE_GEAR = (0.5, 0.6, 0.7, 0.8, 0.9, 1.0)
"""Shares of the top drive's inertia that may turn above the play, as the motor and its gear do."""
_LEAST_SHARE = 0.005
"""Share of the time about zero below which nothing can be told."""


def standing_score(remainder: Remainder, motion: Motion) -> Score | None:
    """A bit that dwells at standstill; None where it hardly gets there. The size is its swing per mean speed."""
    mean = float(remainder.speed.mean())
    speed = _inner(remainder, mean + motion.below(1.0)[0])
    found = _dwelling(remainder, speed, _STANDING * abs(mean))
    if found is None:
        return None
    swing = float(np.ptp(np.quantile(speed, [0.025, 0.975]))) / (2 * abs(mean))
    return Score(found, swing, 0.1 * swing, max(found, 0.0) ** 2 / 2)


def backlash_score(remainder: Remainder, motion: Motion) -> Score | None:
    """A torque at the gear that dwells at zero; None where it hardly gets there or the command is not logged.

    How much of the top drive turns above the play is not known: shares are tried, and the chance counts them. Nor is
    the play: how far the string turns meanwhile is not recorded.
    """
    if not remainder.record.has_command:
        return None
    torques = [_inner(remainder, motion.top_torque(above)) for above in _ABOVE_GEAR]
    found = [_dwelling(remainder, torque, _BETWEEN_FLANKS * float(torque.std())) for torque in torques]
    told = [normal for normal in found if normal is not None]
    if not told:
        return None
    normal = normal_of_chance(min(len(told) * float(ndtr(-max(told))), 1.0))
    return Score(normal, np.nan, np.inf, max(normal, 0.0) ** 2 / 2)


def _inner(remainder: Remainder, series: Floats) -> Floats:
    ends = round(_ENDS_S * remainder.record.rate)
    return series[ends:-ends]


def _dwelling(remainder: Remainder, series: Floats, width: float) -> float | None:
    """Standard normal value of the time about zero.

    What is foretold is extrapolated from the shares of two pairs of bands beside zero, as a parabola would.
    """
    off = np.abs(series) / width
    about, beside, beyond = off < 1, (off >= 1) & (off < 3), (off >= 3) & (off < 5)
    count = int(series.size / remainder.record.rate / _BLOCK_S)
    if count < _LEAST_BLOCKS or about.mean() < _LEAST_SHARE:
        return None
    # the bands lie at 2 and 4 widths and are twice as wide together
    excess = about - (4 * beside - beyond) / 6
    blocks = np.array([block.mean() for block in np.array_split(excess, count)])
    deviation = float(blocks.std(ddof=1)) / np.sqrt(count)
    if deviation == 0:
        return None
    return normal_of_chance(float(stdtr(count - 1, -blocks.mean() / deviation)))
