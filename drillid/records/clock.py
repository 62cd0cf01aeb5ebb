"""Time stamps of a log → places of its rows on a regular grid.

A recorder samples by a regular clock; the jitter is mostly that of the stamp, written when the row
reaches the recorder. So a regular clock is fitted to the stamps and each row is assigned to its
tick. Missing rows leave ticks empty. Where the stamps jump but the signals are continuous, the
clock was set and no rows are missing.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import median_filter

from drillid.arrays import Booleans, Floats, Integers
from drillid.errors import LogError
from drillid.records.order import in_order, sorted_if_shuffled, without_repeats
from drillid.records.shared_stamps import evenly

_DAY_NS = 86_400_000_000_000
FEWEST_ROWS = 10
"""Least number of rows of a log, and of values of a column."""
LOWEST_RATE, HIGHEST_RATE = 0.2, 10_000.0
"""Sample rates of logs, Hz. The slowest torsional mode of a long string has a period of about 10 s, of which two
samples are the least that show it; a drive closes its current loop some thousand times a second, and nothing records
torque faster."""
_MOST_STEPS, _ROWS_PER_STEP = 20, 500
"""A log whose clock was set more often than this, and more than once in this many rows, has damaged stamps: clocks are
set a few times a day."""
_ROUND_TOLERANCE = 1e-3
"""Largest relative deviation of a clock from its nominal rate; a round rate further off is another rate."""
_LARGEST_TOLERANCE = 0.01
"""The same for logs too short for an accurate rate."""
_NO_DRIFT = 0.05
"""Drift over a log, in intervals, that is not significant."""
_NEAR_TICK = 0.3
"""A grid continues the previous one where their ticks differ by less than this share of an interval."""
_PHASE_ROWS = 100
"""Rows on either side over which the phase of the stamps between ticks is averaged."""
_PHASE_BREAK = 0.15
"""Change of that phase over a jump, in intervals, beyond which the clock is not continuous."""
_LASTING_ROWS = 5
"""Stamps off their neighbours' ticks for fewer rows than this are late stamps, not a jump."""
_BLOCK = 200_000
"""Number of rows processed at once, to limit memory."""
_EITHER_SIDE = 3
"""Samples on either side of a jump by which the continuity of a signal is judged."""
_SHORT_JUMP = 5
"""Longest jump, in intervals, over which a signal with missing rows is smooth too."""
_FAR_ROUGHER = 4.0
"""Ratio of a signal's roughness with missing rows to that without, above which the clock was set at a short jump."""


@dataclass(frozen=True)
class ClockStep:
    """The recorder's clock was set by `seconds` before `row`; `continues`: the signals are continuous there."""

    row: int
    seconds: float
    continues: bool


@dataclass(frozen=True)
class Ticks:
    """A log's rows on its regular grid.

    rate : nominal samples per second
    actual : samples per second by the stamps
    origin : time of tick 0, ns since 1970 UTC
    rows : rows in order of time, repeated rows left out, shape (row,)
    tick : tick of each of `rows`, not decreasing, shape (row,)
    begin, end : times of the first and the last of `rows` by the stamps, their jitter averaged and steps of
        the clock removed, ns since 1970 UTC
    jitter : stamp less tick of the regular clock at the rate `actual`, s, shape (row,)
    repeated : indices in `rows` of the rows that omitted rows repeat, shape (repeat,)
    steps : steps of the clock; `row` is an index in `rows`
    reordered : number of rows that were out of order
    shared : usual number of rows that share a stamp and are spaced evenly; 0 where stamps are fine enough
    """

    rate: float
    actual: float
    origin: int
    begin: int
    end: int
    rows: Integers
    tick: Integers
    jitter: Floats
    repeated: Integers
    steps: tuple[ClockStep, ...]
    reordered: int
    shared: int = 0

    def times(self, ticks: Integers) -> NDArray[np.datetime64]:
        """UTC times of ticks, ns."""
        since = np.rint(ticks * (1e9 / self.rate)).astype(np.int64)
        return np.asarray((self.origin + since).astype("datetime64[ns]"))


def place_rows(
    stamps: Integers,
    sweep: Floats,
    speed: Floats,
    rate: float | None = None,
    anchor: int | None = None,
    where: str = "log",
) -> Ticks:
    """Fit a regular clock to stamps and place each row on its tick.

    Parameters
    ----------
    stamps : time stamps, ns since 1970 UTC, shape (row,), in the file's order
    sweep, speed : the two signals that distinguish a set clock from missing rows, shape (row,)
    rate : nominal samples per second; the roundest that the stamps allow where None
    anchor : time of a tick of the previous grid, ns; midnight where None
    where : name of the log for messages

    Raises
    ------
    LogError
        If there are too few rows, their order cannot be found, the stamps are coarser than the samples, nothing is
        recorded at such a rate, or the clock jumps all the time.
    """
    if stamps.size < FEWEST_ROWS:
        raise too_few_rows(where, stamps.size)
    rows, repeats = without_repeats(stamps, sweep, speed)
    stamps, shared = evenly(stamps, sweep, speed, repeats)
    if shared:
        rows, repeats = np.arange(stamps.size), np.arange(0)
    rows, shuffled = sorted_if_shuffled(stamps, rows, where)
    interval = _interval(stamps[rows], where)
    rows, reordered = in_order(stamps, rows, interval)
    reordered = max(shuffled, reordered)
    seconds = (stamps[rows] - stamps[rows[0]]) * 1e-9
    spacing, shift = _tick_spacing(seconds, interval)
    spacing, moved, steps = _without_steps(spacing, shift, sweep[rows], speed[rows], interval)
    if len(steps) > max(_MOST_STEPS, rows.size // _ROWS_PER_STEP):
        what = f"its stamps jump {len(steps)} times within {rows.size} rows, more often than any clock is reset"
        raise LogError(
            where,
            what,
            "Export the log again; its time column is damaged, or its stamps scatter by a third of a sample",
        )
    seconds, tick = seconds - moved, np.concatenate([[0], np.cumsum(spacing)])
    centred = tick - np.mean(tick)
    along = float(np.dot(centred, seconds))
    if not along > 0:
        raise LogError(where, "its stamps do not advance with its rows", "Export the log again, in the order of time")
    actual = float(np.dot(centred, centred) / along)
    nominal = nominal_rate(actual, int(tick[-1])) if rate is None else rate
    actual = nominal if abs(actual / nominal - 1) * tick[-1] < _NO_DRIFT else actual
    first, jitter = int(stamps[rows[0]]), seconds - tick / actual
    begin, end = (first + round(float(np.median(part)) * 1e9) for part in (jitter[:_PHASE_ROWS], jitter[-_PHASE_ROWS:]))
    origin = _aligned(first + round(float(np.median(seconds - tick / nominal)) * 1e9), nominal, anchor)
    kept = stamps[rows]
    by_time = np.argsort(kept, kind="stable")
    repeated = by_time[np.searchsorted(kept[by_time], stamps[repeats])]
    end += round(tick[-1] * 1e9 / actual)
    jitter -= np.median(jitter)
    return Ticks(nominal, actual, origin, begin, end, rows, tick, jitter, repeated, steps, reordered, shared)


def too_few_rows(where: str, rows: int) -> LogError:
    """The error for a log too short to determine its clock."""
    return LogError(where, f"holds only {rows} rows of the {FEWEST_ROWS} needed", "Remove it from the logs sheet")


def _interval(stamps: Integers, where: str) -> float:
    """Mean interval between rows without gaps, s."""
    steps = np.diff(stamps) * 1e-9
    forward = steps[steps > 0]
    if forward.size < 0.5 * steps.size or forward.size == 0:
        raise LogError(
            where,
            "its time stamps are coarser than its samples: most rows share a stamp, and not always the same number",
            "Export stamps with fractions of a second",
        )
    usual = float(np.median(forward))
    if not 1 / HIGHEST_RATE <= usual <= 1 / LOWEST_RATE:
        raise LogError(
            where,
            f"its stamps are {usual:.3g} s apart, and torque is recorded at {LOWEST_RATE:g} to {HIGHEST_RATE:g} Hz",
            "State the unit or format of the time column, or export the log at the rate of its recorder",
        )
    near = steps[np.abs(steps / usual - 1) < 0.5]
    return float(np.mean(near)) if near.size else usual


def _tick_spacing(seconds: Floats, interval: float) -> tuple[Integers, Floats]:
    """Ticks from each row to the next, and the shift of the clock's phase between ticks there, shape (row − 1,).

    The phase of the stamps between ticks is averaged over many rows, as an angle, which missing
    rows do not change; a stamp then determines its tick as long as it is less than half an
    interval off. A stamp further off differs from its neighbours for a few rows only, whereas
    missing rows and set clocks shift all following rows: a median filter removes the former and
    leaves the latter.
    """
    rows = seconds.size
    place = seconds / interval - np.arange(rows)
    total = np.concatenate([[0], np.cumsum(np.exp(2j * np.pi * place))])
    jumps = 1 + np.flatnonzero(np.abs(np.diff(place)) > 1)
    behind = total[jumps] - total[np.maximum(jumps - 1 - _PHASE_ROWS, 0)]
    beyond = total[np.minimum(jumps + _PHASE_ROWS, rows - 1)] - total[jumps]
    phase_change = np.angle(beyond * np.conj(behind)) / (2 * np.pi)
    breaks = jumps[np.abs(phase_change) > _PHASE_BREAK]
    bounds = np.concatenate([[0], breaks, [rows]])
    phase = np.empty(rows)
    for first in range(0, rows, _BLOCK):
        row = np.arange(first, min(first + _BLOCK, rows))
        piece = np.searchsorted(breaks, row, side="right")
        high, low = np.minimum(row + _PHASE_ROWS + 1, bounds[piece + 1]), np.maximum(row - _PHASE_ROWS, bounds[piece])
        phase[row] = np.angle(total[high] - total[low])
    del total
    phase = np.unwrap(phase) / (2 * np.pi)
    ahead = median_filter(np.rint(place - phase), 2 * _LASTING_ROWS - 1, mode="nearest")
    return 1 + np.diff(ahead).astype(np.int64), np.diff(phase) * interval


def _without_steps(
    spacing: Integers, shift: Floats, sweep: Floats, speed: Floats, interval: float
) -> tuple[Integers, Floats, tuple[ClockStep, ...]]:
    """Ticks between rows without the steps of the clock, the sum of the steps up to each stamp (s), and the steps."""
    doubtful = np.flatnonzero((spacing > 1) | (spacing < 0))
    spacing, moved = spacing.copy(), np.zeros(spacing.size + 1)
    if doubtful.size == 0:
        return spacing, moved, ()
    sweep_continuity, speed_continuity = _Continuity(sweep, spacing), _Continuity(speed, spacing)
    jump = spacing[doubtful]
    continues = (
        sweep_continuity.moving(doubtful) & sweep_continuity.smooth(doubtful) & speed_continuity.smooth(doubtful)
    )
    short = continues & (jump > 1) & (jump <= _SHORT_JUMP)
    continues[short] = sweep_continuity.rougher_with_gap(doubtful[short], jump[short])
    stepped = continues | (jump < 1)
    before = doubtful[stepped]
    spacing[before] = np.where(continues[stepped], 1, round(1 / interval))
    moved[before + 1] = (jump[stepped] - spacing[before]) * interval + shift[before]
    steps = tuple(
        ClockStep(row + 1, seconds, smooth)
        for row, seconds, smooth in zip(
            before.tolist(), moved[before + 1].tolist(), continues[stepped].tolist(), strict=True
        )
    )
    return spacing, np.cumsum(moved), steps


class _Continuity:
    """Whether a signal is smooth over a jump of its stamps, compared with its usual smoothness."""

    def __init__(self, signal: Floats, spacing: Integers) -> None:
        self.signal = signal
        windows = np.lib.stride_tricks.sliding_window_view(signal, 2 * _EITHER_SIDE)
        blocks = range(0, len(windows), _BLOCK)
        usual = np.concatenate([self._misfit(windows[first : first + _BLOCK], 1) for first in blocks])
        broken = np.convolve(spacing != 1, np.ones(2 * _EITHER_SIDE - 1), "valid") > 0
        usual = usual[~broken & np.isfinite(usual)]
        self.limit = float(np.quantile(usual, 0.99)) if usual.size else 0.0

    @staticmethod
    def _misfit(samples: Floats, gap: int) -> Floats:
        """Root of the squared misfit of a cubic to samples (..., 6): three, `gap` intervals, three."""
        position = np.arange(2 * _EITHER_SIDE, dtype=float)
        position[_EITHER_SIDE:] += gap - 1
        basis = np.linalg.qr(np.vander(position / position[-1], 4))[0]
        residual = samples - (samples @ basis) @ basis.T
        return np.asarray(np.sqrt(np.sum(residual**2, axis=-1)))

    def _around(self, before: Integers) -> Floats:
        """Samples on either side of jumps behind the rows `before`, shape (jump, 6); NaN next to the ends."""
        place = before[:, None] + np.arange(1 - _EITHER_SIDE, 1 + _EITHER_SIDE)
        inside = (place[:, 0] >= 0) & (place[:, -1] < self.signal.size)
        return np.where(inside[:, None], self.signal[np.where(inside[:, None], place, 0)], np.nan)

    def moving(self, before: Integers) -> Booleans:
        """Whether the signal changes around each jump by more than its roughness."""
        return np.asarray(np.ptp(self._around(before), axis=1) > 3 * self.limit)

    def smooth(self, before: Integers) -> Booleans:
        """Whether the signal is as smooth as usual if no row is missing at each jump."""
        return np.asarray(self._misfit(self._around(before), 1) <= self.limit)

    def rougher_with_gap(self, before: Integers, gap: Integers) -> Booleans:
        """Whether the signal would be far rougher with the rows around each jump `gap` intervals apart than with 1."""
        around = self._around(before)
        rough = np.full(before.size, np.nan)
        for intervals in np.unique(gap).tolist():
            rough[gap == intervals] = self._misfit(around[gap == intervals], intervals)
        return np.asarray((rough > self.limit) & (rough > _FAR_ROUGHER * self._misfit(around, 1)))


def rate_tolerance(ticks: int, least: float) -> float:
    """Relative tolerance of the rate of a log with this many ticks: half an interval over a short log."""
    return max(least, min(0.5 / max(ticks, 1), _LARGEST_TOLERANCE))


def nominal_rate(actual: float, ticks: int) -> float:
    """The roundest rate that a clock may nominally have, in Hz or in ms from sample to sample.

    Parameters
    ----------
    actual : samples per second by the stamps, which drift against the samples
    ticks : length of the log in samples
    """
    tolerance = rate_tolerance(ticks, _ROUND_TOLERANCE)
    for decimals in range(4):
        for rate in (round(actual, decimals), 1e3 / (round(1e3 / actual, decimals) or np.inf)):
            if rate > 0 and abs(actual / rate - 1) < tolerance:
                return float(rate)
    return actual


def _aligned(origin: int, rate: float, anchor: int | None) -> int:
    """Origin (ns) moved to the nearest tick of an earlier grid, where it is close to it."""
    start = origin // _DAY_NS * _DAY_NS if anchor is None else anchor
    ticks = (origin - start) * 1e-9 * rate
    near = round(ticks)
    return start + round(near * 1e9 / rate) if abs(ticks - near) < _NEAR_TICK else origin


def share_of_real_jitter(signal: Floats, ticks: Ticks) -> float:
    """Share of the stamps' jitter that the samples really have.

    A sample taken j late on a signal of slope f′ differs from its tick's value by f′ j, which makes
    the signal rougher; the share is that whose subtraction leaves it smoothest (least squares on
    fourth differences): 0 where the clock is regular and only stamps jitter, 1 where stamps are exact.

    Parameters
    ----------
    signal : shape (row,), in the order of ticks.rows
    """
    if np.ptp(ticks.jitter) * ticks.rate < 1e-4:
        return 0.0
    slope = np.gradient(signal) * ticks.rate
    rough, expected = np.diff(signal, 4), np.diff(slope * ticks.jitter, 4)
    whole = (ticks.tick[4:] - ticks.tick[:-4] == 4) & np.isfinite(rough) & np.isfinite(expected)
    rough, expected = rough[whole], expected[whole]
    if rough.size == 0 or not np.any(expected):
        return 0.0
    usual = np.abs(rough) <= np.quantile(np.abs(rough), 0.999)
    power = float(np.sum((expected**2)[usual]))
    return float(np.sum((rough * expected)[usual]) / power) if power > 0 else 0.0
