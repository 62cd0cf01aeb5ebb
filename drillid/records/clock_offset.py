"""Offset between the clocks of two recorders, from a channel that both recorded."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from drillid.arrays import Array, Floats, Integers

FARTHEST_S = 3700.0
"""Largest clock offset that is searched for, s: an hour of daylight saving and a little more."""
_FEWEST = 60
"""Least number of slow samples that determine an offset."""
_ALIKE = 0.7
"""Least correlation of the channel between the two records."""
_CLEAR = 0.05
"""Margin of that correlation over its peaks at all other offsets, as sweeps repeat themselves."""
_OVERLAP = 0.5
"""Least share of the shorter record that the other covers at an offset."""
_LARGEST = 10_000_000
"""Largest number of slow samples of a record."""
_BLOCKS = 20
"""Number of parts of the record whose disagreement gives the error of the offset."""
_NEAR, _FINER = 2, 20
"""Slow samples about the best whole lag within which the offset is searched for, and steps per sample."""
_STEPS = 3
"""Gauss-Newton steps from there."""


@dataclass(frozen=True)
class ClockOffset:
    """How far one clock is ahead of another, s, and its standard error, s, at least half a fast sample."""

    seconds: float
    error: float


@dataclass(frozen=True)
class _Series:
    """A record of a channel: times (s), increasing, and values, each shape (row,)."""

    at: Floats
    values: Floats

    @classmethod
    def of(cls, stamps: Integers, values: Array, start: int) -> _Series:
        good = np.flatnonzero(np.isfinite(values))
        times, first = np.unique(stamps[good], return_index=True)
        return cls(np.asarray((times - start) * 1e-9, dtype=np.float64), values[good][first].astype(float))

    @property
    def interval(self) -> float:
        return float(np.median(np.diff(self.at)))

    def means(self, edges: Floats) -> Floats:
        """Means between successive times, NaN where there is no sample, shape (edge - 1,)."""
        sums = np.concatenate([[0.0], np.cumsum(self.values)])
        places = np.searchsorted(self.at, edges)
        count = np.diff(places)
        return np.asarray(np.where(count > 0, np.diff(sums[places]) / np.maximum(count, 1), np.nan))

    def smoothed(self, interval: float) -> _Series:
        """Means over an interval about each sample."""
        sums = np.concatenate([[0.0], np.cumsum(self.values)])
        begin = np.searchsorted(self.at, self.at - interval / 2, side="left")
        end = np.searchsorted(self.at, self.at + interval / 2, side="right")
        return _Series(self.at, (sums[end] - sums[begin]) / np.maximum(end - begin, 1))


def clock_offset(fast_stamps: Integers, fast: Array, slow_stamps: Integers, slow: Array) -> ClockOffset | None:
    """How far the clock of a slow record of a channel is ahead of that of a fast one; None where they do not show it.

    The slow record holds samples of the channel, or its means over an interval of its own, stamped at their middle;
    whichever explains it better is assumed.

    Parameters
    ----------
    fast_stamps, slow_stamps : ns, each shape (row,)
    fast, slow : the channel in both, each shape (row,)
    """
    if min(np.sum(np.isfinite(fast)), np.sum(np.isfinite(slow))) < _FEWEST:
        return None
    start = int(fast_stamps.min())
    quick, coarse = _Series.of(fast_stamps, fast, start), _Series.of(slow_stamps, slow, start)
    if min(quick.at.size, coarse.at.size) < _FEWEST:
        return None
    step = max(coarse.interval, quick.interval)
    if (quick.at[-1] + 2 * FARTHEST_S) / step > _LARGEST:
        return None
    lag = _best_lag(quick, coarse, step)
    if lag is None:
        return None
    refined = (_refined(series, coarse, lag) for series in (quick, quick.smoothed(coarse.interval)))
    found = min((each for each in refined if each is not None), key=lambda each: each[1], default=None)
    return None if found is None else found[0]


def _best_lag(quick: _Series, coarse: _Series, step: float) -> float | None:
    """The offset, in whole steps, at which the records agree best, s; None where it is not clear."""
    from scipy.signal import find_peaks

    lags = int(FARTHEST_S / step)
    size = max(int(quick.at[-1] / step), 1)
    series = quick.means(step * np.arange(size + 1, dtype=np.float64))
    around = coarse.means(step * np.arange(-lags, size + lags + 1, dtype=np.float64))
    correlation = _correlation(series, around)
    if correlation is None or (best := int(np.argmax(correlation))) in (0, correlation.size - 1):
        return None
    peaks, _ = find_peaks(correlation, prominence=_CLEAR / 2)
    others = correlation[peaks[peaks != best]]
    if correlation[best] < _ALIKE or correlation[best] - np.max(others, initial=-1.0) < _CLEAR:
        return None
    return (best - lags) * step


def _correlation(series: Floats, around: Floats) -> Floats | None:
    """Correlation of a series with every part of a longer one, over the samples that both hold, shape (lag,)."""
    from scipy.signal import correlate

    def prepared(values: Floats) -> tuple[Floats, Floats]:
        known = np.isfinite(values)
        centred = np.where(known, values, np.mean(values[known]) if np.any(known) else 0.0)
        return centred - np.mean(centred[known]) if np.any(known) else centred, known.astype(float)

    def product(first: Floats, second: Floats) -> Floats:
        return np.asarray(correlate(first, second, "valid", "fft"))

    (x, has_x), (y, has_y) = prepared(series), prepared(around)
    x, y = x * has_x, y * has_y
    count = np.maximum(product(has_y, has_x), 1e-9)
    sum_x, sum_y = product(has_y, x), product(y, has_x)
    square_x = product(has_y, x**2) - sum_x**2 / count
    square_y = product(y**2, has_x) - sum_y**2 / count
    least = max(_FEWEST, _OVERLAP * min(np.sum(has_x), np.sum(has_y)))
    floor = 1e-9 * max(float(np.sum(x**2)), float(np.sum(y**2)))
    usable = (count > least - 0.5) & (square_x > floor) & (square_y > floor)
    if not np.any(usable):
        return None
    scale = np.sqrt(np.where(usable, square_x * square_y, 1.0))
    return np.asarray(np.where(usable, (product(y, x) - sum_x * sum_y / count) / scale, -1.0))


def _refined(quick: _Series, coarse: _Series, offset: float) -> tuple[ClockOffset, float] | None:
    """The offset by least squares with its error by a jackknife over parts of the record, and the residuals' rms."""
    near = offset + coarse.interval * np.linspace(-_NEAR, _NEAR, 2 * _NEAR * _FINER + 1)
    offset = float(min(near, key=lambda each: _residual(quick, coarse, float(each))))
    slope = _Series(quick.at, np.gradient(quick.values, quick.at))
    shifts = np.empty(0)
    for _ in range(_STEPS):
        fit = _Linear.of(quick, slope, coarse, offset)
        shift = None if fit is None else fit.shift()
        if fit is None or shift is None:
            return None
        shifts = fit.shifts_without_parts()
        offset += float(np.clip(shift, -coarse.interval / _FINER, coarse.interval / _FINER))
    error = float(np.sqrt((_BLOCKS - 1) / _BLOCKS * np.sum((shifts - shifts.mean()) ** 2)))
    return ClockOffset(offset, float(np.hypot(error, quick.interval / 2))), _residual(quick, coarse, offset)


def _residual(quick: _Series, coarse: _Series, offset: float) -> float:
    """Rms residual of the slow record at an offset, with gain and zero free; infinite without overlap."""
    at = coarse.at - offset
    inside = (at > quick.at[0]) & (at < quick.at[-1])
    signal, values = np.interp(at[inside], quick.at, quick.values), coarse.values[inside]
    if signal.size < _FEWEST or not np.std(signal) > 0:
        return np.inf
    slope, zero = np.polyfit(signal, values, 1)
    return float(np.sqrt(np.mean((values - slope * signal - zero) ** 2)))


@dataclass(frozen=True)
class _Linear:
    """Normal equations for zero, gain and gain times shift about an offset, for each part of the record.

    normal : shape (part, 3, 3)
    moment : shape (part, 3)
    """

    normal: Floats
    moment: Floats

    @classmethod
    def of(cls, quick: _Series, slope: _Series, coarse: _Series, offset: float) -> _Linear | None:
        at = coarse.at - offset
        inside = (at > quick.at[0]) & (at < quick.at[-1])
        if np.sum(inside) < _FEWEST:
            return None
        signal, change = (np.interp(at[inside], quick.at, each.values) for each in (quick, slope))
        design = np.stack([np.ones(signal.size), signal, -change], axis=1)
        values, parts = coarse.values[inside], np.array_split(np.arange(signal.size), _BLOCKS)
        return cls(
            np.array([design[part].T @ design[part] for part in parts]),
            np.array([design[part].T @ values[part] for part in parts]),
        )

    def shift(self) -> float | None:
        """Further delay of the slow record, s; None where the records have nothing in common."""
        solution = np.linalg.lstsq(self.normal.sum(axis=0), self.moment.sum(axis=0))[0]
        return float(solution[2] / solution[1]) if abs(solution[1]) > 0 else None

    def shifts_without_parts(self) -> Floats:
        """The same without each part of the record, shape (part,)."""
        normal, moment = self.normal.sum(axis=0) - self.normal, self.moment.sum(axis=0) - self.moment
        solutions = [np.linalg.lstsq(each, own)[0] for each, own in zip(normal, moment, strict=True)]
        return np.array([solution[2] / solution[1] for solution in solutions])
