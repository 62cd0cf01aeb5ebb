"""Sign of a delay that jitters, in how the noise grows with the command."""

import numpy as np
from numpy.typing import NDArray
from scipy.special import stdtr

from drillid.discrepancy.signs_record import Remainder
from drillid.discrepancy.signs_score import Score, normal_of_chance

Floats = NDArray[np.float64]

_JITTER_BAND = (1.0, 0.4)
"""Lowest frequency, Hz, and highest, as a share of the rate."""
_HOLD_S = 0.02
"""s, for which each delay of a jittering drive is taken to hold."""
_BLOCK_S = 4.0
_NEIGHBOURS = 6
"""Blocks over which the noise's level stays much the same."""


def jitter_score(remainder: Remainder, left: Floats) -> Score | None:
    """Noise that grows with the square of the command's slope; None where the sweep does not repeat.

    A delay off by ξ leaves out the torque ξ times the command's slope. The noise's power, weighted by where jitter
    shows best, is regressed on the square of the slope that repeats with the sweep, in which noise has no part.

    Parameters
    ----------
    left : (samples,) rad/s, what neither the sweep nor other causes account for
    """
    if not remainder.periods:
        return None
    rate, samples = remainder.record.rate, remainder.samples
    low, high = _JITTER_BAND[0], _JITTER_BAND[1] * rate
    inside = (remainder.frequency > low) & (remainder.frequency < high)
    shown = np.where(inside, np.abs(remainder.mobility) ** 2 * samples / remainder.noise, 0.0)
    weight = np.sqrt(shown / shown.max())
    power = remainder.filtered(weight * np.sqrt(samples / remainder.noise) * inside, left * remainder.taper) ** 2
    slope = remainder.filtered(remainder.s, remainder.command - remainder.command.mean())
    repeated = slope - remainder.without_sweep(slope)
    size_block = round(_BLOCK_S * rate)
    count = samples // size_block
    blocks = [
        values[: count * size_block].reshape(count, -1).mean(axis=1)
        for values in (power, repeated**2 * remainder.taper**2, remainder.taper**2)
    ]
    whole = blocks[2] > 1 - 1e-6
    response, driver = blocks[0][whole], blocks[1][whole]
    gain = 2 / samples * float(np.sum(weight**2 * shown)) * _HOLD_S * rate / remainder.inflation
    slope_found, error = _regression(driver - driver.mean(), response)
    ratio = slope_found / error
    normal = normal_of_chance(float(stdtr(response.size - 2, -ratio)))
    return Score(normal, slope_found / gain, error / gain, max(normal, 0.0) ** 2 / 2)


def _regression(driver: Floats, response: Floats) -> tuple[float, float]:
    """Slope on a centred driver and its standard error, whatever the variances are and if neighbours go together.

    Covariances of neighbours are weighted after Newey and West (1987, Econometrica 55, 703–708).
    """
    energy = float(driver @ driver)
    slope = float(driver @ response) / energy
    residual = response - response.mean() - slope * driver
    leverage = 1 / driver.size + driver**2 / energy
    products = driver * residual / (1 - leverage)
    total = float(products @ products)
    for lag in range(1, _NEIGHBOURS + 1):
        total += 2 * (1 - lag / (_NEIGHBOURS + 1)) * float(products[lag:] @ products[:-lag])
    return slope, float(np.sqrt(max(total, 0.1 * float(products @ products)))) / energy
