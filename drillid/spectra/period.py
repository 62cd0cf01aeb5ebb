"""The period of a sweep, to a fraction of a sample where recorder and drive have clocks of their own."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.fft import irfft, next_fast_len, rfft, rfftfreq
from scipy.signal.windows import hann

from drillid.arrays import Floats, Integers

_NOT_REPEATING = 0.01
"""Share of the sweep's power that may differ from one period to the next."""
_SHORTEST_PERIOD = 1.0
"""Periods of the lowest frequency that the sweep's own period must hold at least."""
_WHOLE = 0.05
"""Samples by which whole numbers of samples a period may differ from the sweep over a window."""


def sweep_period(sweep: Floats, rate: float, lowest_frequency: float) -> float:
    """Period (s) of a sweep; 0 where it does not repeat within half of the window.

    The shortest lag at which the sweep, less its mean, differs from itself by less than 1 % of its power. It is a whole
    number of samples unless the difference would be seen over a window.

    Parameters
    ----------
    sweep : (samples,) N m
    rate, lowest_frequency : Hz; a period holds at least one of that frequency's
    """
    correlation = _Correlation(sweep - sweep.mean())
    if not correlation.record.any():
        return 0.0
    shortest = int(_SHORTEST_PERIOD * rate / lowest_frequency)
    lags = correlation.lowest_lags(_NOT_REPEATING)
    for lag in lags[lags >= shortest].tolist():
        period = correlation.nearest(lag)
        if correlation.difference(period) < _NOT_REPEATING:
            return _refined(lag, period, correlation) / rate
    return 0.0


def _refined(lag: int, period: float, correlation: "_Correlation") -> float:
    """Period in samples, from the whole lag nearest to it and what that tells of it.

    A multiple of the period tells it the more precisely, and one multiple tells where its double is.
    """
    multiple = 2
    while multiple * period < correlation.record.size / 2:
        period = correlation.nearest(round(multiple * period)) / multiple
        multiple *= 2
    return float(lag) if abs(period - lag) * correlation.record.size < _WHOLE * lag else period


@dataclass(frozen=True)
class _Correlation:
    """Correlation of a record (samples,) without mean with itself, at lags between its samples too."""

    record: Floats

    @cached_property
    def points(self) -> int:
        """Samples with as many zeros."""
        return int(next_fast_len(2 * self.record.size, real=True))

    @cached_property
    def power(self) -> Floats:
        """(lines,) of the record with its zeros."""
        return np.asarray(np.abs(rfft(self.record, self.points)) ** 2)

    @cached_property
    def energy(self) -> Floats:
        """(samples + 1,) sum of squares before each sample."""
        return np.concatenate([[0.0], np.cumsum(self.record**2)])

    def lowest_lags(self, limit: float) -> Integers:
        """Lags up to half of the record at which it differs least, and by so little that between samples it may be less
        than a share of its power.
        """
        # a lag of half of the record has a neighbour on either side too
        lags = np.arange(self.record.size // 2 + 2)
        difference = 1 - 2 * irfft(self.power, self.points)[: lags.size] / self._of_both(lags)
        inner = difference[1:-1]
        lowest = (inner <= difference[:-2]) & (inner <= difference[2:]) & (inner < limit + self._half_a_sample())
        return np.flatnonzero(lowest) + 1

    def _half_a_sample(self) -> float:
        """Difference of a record from itself half a sample later, per power."""
        return float(1 - self.power @ np.cos(np.pi * rfftfreq(self.points)) / self.power.sum())

    def _of_both(self, lag: Integers) -> Floats:
        """Sums of squares of the record's two parts that a lag compares."""
        both = self.energy[-1 - lag] + self.energy[-1] - self.energy[lag]
        return np.asarray(np.maximum(both, np.finfo(float).tiny))

    def difference(self, lag: float) -> float:
        """Difference of the record from itself at a lag in samples, per power."""
        product = self.power @ np.cos(2 * np.pi * rfftfreq(self.points) * lag) * 2 / self.points
        return float(1 - 2 * product / self._of_both(np.asarray(round(lag))))

    def nearest(self, lag: int) -> float:
        """The lag nearest to a whole one at which the record is most like itself, in samples.

        Its two parts, tapered alike, differ in phase by the frequency times the fraction of a sample.
        """
        taper = hann(self.record.size - lag)
        first, second = rfft(taper * self.record[: taper.size]), rfft(taper * self.record[lag:])
        product, turn = second * np.conj(first), 2 * np.pi * rfftfreq(taper.size)
        weight = np.abs(product) * turn
        return float(lag - (weight @ np.angle(product)) / (weight @ turn))
