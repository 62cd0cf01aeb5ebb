"""Signs of what stays at zero for a while: a bit that stands, a gear between its flanks.

A quantity that passes zero spends as much time about it as its density beside zero foretells; one that dwells there
spends more.
"""

import numpy as np
from numpy.typing import NDArray
from scipy.special import stdtr

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
_LEAST_SHARE = 0.005
"""Share of the time about zero below which nothing can be told."""
_SIZE_ERROR = 1.0
"""Of the play, which is reckoned from the time between flanks in a rough way."""


def standing_score(remainder: Remainder, motion: Motion) -> Score | None:
    """A bit that dwells at standstill; None where it hardly gets there. The size is its swing per mean speed."""
    mean = float(remainder.speed.mean())
    speed = _inner(remainder, mean + motion.below(1.0)[0])
    found = _dwelling(remainder, speed, _STANDING * abs(mean))
    if found is None:
        return None
    swing = float(np.ptp(np.quantile(speed, [0.025, 0.975]))) / (2 * abs(mean))
    return Score(found[0], swing, 0.1 * swing, max(found[0], 0.0) ** 2 / 2)


def backlash_score(remainder: Remainder, motion: Motion) -> Score | None:
    """A string torque that dwells at zero; None where it hardly gets there or the command is not logged.

    Between the flanks the string, of characteristic admittance Y₀, is let go as fast as its torque T would have
    changed: a play p lasts t with p = dT/dt t²/(2 Y₀).
    """
    if not remainder.record.has_command:
        return None
    torque = _inner(remainder, motion.string_torque())
    width = _BETWEEN_FLANKS * float(torque.std())
    found = _dwelling(remainder, torque, width)
    if found is None:
        return None
    normal, excess = found
    side = np.sign(torque[np.abs(torque) > width])
    crossings = max(int(np.count_nonzero(np.diff(side))), 1)
    slope = np.abs(np.gradient(torque) * remainder.record.rate)
    beside = (np.abs(torque) > 2 * width) & (np.abs(torque) < 6 * width)
    lasting = max(excess, 0.0) * torque.size / remainder.record.rate / crossings
    admittance = float(np.ravel(remainder.system.string[0].characteristic_admittance)[0])
    play = float(np.mean(slope[beside])) * lasting**2 / (2 * admittance) if beside.any() else 0.0
    return Score(normal, play, _SIZE_ERROR * play, max(normal, 0.0) ** 2 / 2)


def _inner(remainder: Remainder, series: Floats) -> Floats:
    ends = round(_ENDS_S * remainder.record.rate)
    return series[ends:-ends]


def _dwelling(remainder: Remainder, series: Floats, width: float) -> tuple[float, float] | None:
    """Standard normal value of the time about zero, and the share of it that is too much.

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
    return normal_of_chance(float(stdtr(count - 1, -blocks.mean() / deviation))), float(blocks.mean())
