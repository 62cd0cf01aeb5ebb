"""Noise of a window: its spectrum, and bursts in time."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.fft import irfft, rfft

from drillid.arrays import Booleans, Complex, Floats

_CORNERS = (0.0, 1.0, 4.0)
"""Candidate corners of the high pass, as multiples of the lowest frequency of interest."""
ORDER = 40
"""Order of the autoregressive model: at a sample rate of 2.5 times the highest frequency, a few cycles of each mode."""
_BAND_RATIO = 4.0
"""Upper over lower edge of the bands in which bursts are sought: two octaves, as of one sweep."""
_LEAST_S = 5.0
"""Shortest time over which power is averaged, s."""
_CYCLES = 4.0
"""Least product of time and bandwidth over which power is averaged: eight degrees of freedom."""
_ERROR_RATE = 0.01
"""Probability, for each band, of a burst being detected in a window of stationary Gaussian noise."""


def autoregressive_level(power: Floats) -> Floats:
    """Smooth spectrum in the shape of a periodogram (lines,), up to a factor, by an autoregressive model.

    Noise divided by it is nearly white, so that averages over neighbouring lines are not biased by
    the resonances between them (prewhitening: Blackman and Tukey 1958).
    """
    from scipy.linalg import solve_toeplitz

    last = power.size - 1
    order = _order(last)
    covariance = irfft(power, 2 * last)[: order + 1]
    if not covariance[0] > 0:
        return np.ones(power.size)
    covariance[0] *= 1 + 1e-9
    prediction = solve_toeplitz(covariance[:-1], covariance[1:])
    return np.asarray(1 / np.abs(rfft(np.concatenate([[1.0], -prediction]), 2 * last)) ** 2, dtype=float)


def level_variance(last: int, unexcited: int, reach: int) -> float:
    """Relative variance of that smooth spectrum at a line over its mean within `reach` lines on both sides.

    A model of order p from n lines has p/n (Berk 1974, Annals of Statistics 2). What the mean has in common with the
    line cancels: lines farther apart than last/p have independent errors.
    """
    order = _order(last)
    independent = 2 * reach * order / last
    return order / unexcited * independent / (1 + independent)


def _order(last: int) -> int:
    return min(ORDER, last // 4)


def high_pass(power: Floats, unexcited: Booleans, lowest: int) -> Floats:
    """Fall of the noise towards zero frequency (lines,): the most likely high pass of first order.

    Speed control with integral action suppresses slow noise, which an autoregressive model with a memory much
    shorter than such an oscillation cannot represent. The corner is the most likely of a few by Whittle's likelihood
    (1953) of the unexcited lines, where the autoregressive model describes the rest.

    Parameters
    ----------
    power : (lines,) squares of the lines, 0 where they contain more than noise
    unexcited : (lines,) those that contain noise alone
    lowest : lowest line of interest
    """
    squares = np.arange(power.size) ** 2.0
    squares[0] = squares[1]
    best, chosen = np.inf, np.ones(power.size)
    for corner in _CORNERS:
        fall = squares / (squares + (corner * lowest) ** 2)
        level = (fall * autoregressive_level(power / fall))[unexcited]
        misfit = float(np.log(np.mean(power[unexcited] / level)) + np.mean(np.log(level)))
        if misfit < best:
            best, chosen = misfit, fall
    return chosen


@dataclass(frozen=True)
class Weights:
    """Weight and relative noise power of each sample of each period, (period, sample)."""

    weight: Floats
    power: Floats

    @property
    def averages(self) -> float:
        """Number of periods of usual noise whose plain mean has the variance of the weighted mean."""
        share = self.weight / self.weight.sum(axis=0)
        return float(1 / np.mean(np.sum(share**2 * self.power, axis=0)))

    @property
    def weighted_power(self) -> Floats:
        """Expected power of the weighted deviations from the weighted mean, per usual noise."""
        share = self.weight / self.weight.sum(axis=0)
        of_mean = np.sum(share**2 * self.power, axis=0)
        return np.asarray(self.weight**2 * (self.power * (1 - 2 * share) + of_mean), dtype=float)

    @property
    def residual(self) -> float:
        """Power of the deviations; one less than the number of periods where all weights are equal."""
        return float(np.mean(self.weighted_power.sum(axis=0)))

    @property
    def efficiency(self) -> float:
        """Share of the degrees of freedom that remains where the deviations' power is uneven."""
        power = self.weighted_power
        return float(np.mean(power) ** 2 / np.mean(power**2))

    def applied(self, channel: Floats) -> Floats:
        """Periods (period, sample) whose mean is the weighted mean, and whose deviations from it are weighted."""
        mean = np.sum(self.weight * channel, axis=0) / self.weight.sum(axis=0)
        return np.asarray(mean + self.weight * (channel - mean), dtype=float)


def bands(first: int, last: int) -> list[tuple[int, int]]:
    """Bands of equal ratio, of two octaves at least, as first and last-plus-one line."""
    count = max(1, int(np.log(last / first) / np.log(_BAND_RATIO) + 1e-9))
    edges = np.rint(np.geomspace(first, last + 1, count + 1)).astype(int)
    return list(zip(edges[:-1].tolist(), edges[1:].tolist(), strict=True))


def burst_weights(deviation: Complex, level: Floats, band: tuple[int, int], periods: int, seconds: float) -> Weights:
    """Weights that bound the influence of bursts in one band.

    The deviations from the mean period are whitened, and their power over a few seconds is compared
    with its median over the window. Where it exceeds the quantile of Gaussian noise at the error rate,
    the weight is inversely proportional to the power (Huber's bounded influence, over time); elsewhere
    it is one, so that a window without bursts loses nothing.

    Parameters
    ----------
    deviation : (lines,) spectrum of the whole record less its mean period
    level : (lines,) spectrum of the noise, up to a factor
    band : first and last-plus-one line
    periods, seconds : number of periods, and length of the record in s
    """
    from scipy.ndimage import uniform_filter1d
    from scipy.special import chdtri

    samples = 2 * (deviation.size - 1)
    white = np.zeros(deviation.size, dtype=complex)
    white[slice(*band)] = deviation[slice(*band)] / np.sqrt(level[slice(*band)])
    bandwidth = (band[1] - band[0]) / seconds
    span = min(max(_LEAST_S, _CYCLES / bandwidth), seconds / periods / 2)
    squares = irfft(white, samples).reshape(periods, -1) ** 2
    # the jump from the record's end to its beginning, which the mean period spreads to all, is not a burst
    edge = min(ORDER, squares.shape[1] // 4)
    squares[:, np.arange(-edge // 2, edge)] = np.median(squares) / chdtri(1, 0.5)
    power = uniform_filter1d(squares.ravel(), max(1, round(span / seconds * samples)), mode="wrap")
    freedom = 2 * bandwidth * span
    usual = np.median(power) * freedom / chdtri(freedom, 0.5)
    limit = chdtri(freedom, _ERROR_RATE * span / (2 * seconds)) / freedom
    ratio = power.reshape(periods, -1) / max(usual, np.finfo(float).tiny)
    loud = ratio > limit
    return Weights(np.where(loud, limit / np.maximum(ratio, limit), 1.0), np.where(loud, ratio, 1.0))
