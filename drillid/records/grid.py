"""A log's regular grid: which samples are stored, the position of its rows among them, and faults of its clock."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from drillid.arrays import Array, Booleans, Integers
from drillid.datasets.codes import RecordFlag
from drillid.errors import LogError
from drillid.records.clock import Ticks
from drillid.records.shared_stamps import first_known, shared_note

Note = tuple[str, str]
"""What was repaired in a log, and the remedy."""
MOST_APART = 3
"""Largest number of notes of one kind on a log that get a row each; more share one row with their number."""

CHECK_RECORDER = "These samples are flagged; check the recorder if this recurs"
_LONGEST_STORED_GAP_S = 300.0
"""Gaps up to this length are stored as missing samples; longer ones appear in the times only."""
_NEAR_TICK = 0.3
"""A log continues the previous log's ticks where it is off them by less than this share of an interval."""
_LARGE_DRIFT = 2e-4
"""Larger relative deviations of a clock from its nominal rate are noted; 17 s a day."""
_SAMPLES_PER_ROW = 5
"""Largest number of stored samples per row of a log; one with more holes shows no dynamics."""
_LONGEST_SPAN_S = 2 * 365.25 * 86_400
"""Longest time from a log's first row to its last, s; a longer log holds stamps of other times."""
_SMALL_GRID = 500_000
"""Grids of up to this many samples are stored whatever the number of rows: 20 MB."""
_FAR_OFF_S = 10.0
"""Larger differences between a sample's time and its stamp are noted."""


@dataclass(frozen=True)
class Grid:
    """Stored samples of one log.

    size : number of samples
    position : sample of each row of `Ticks.rows`, shape (row,)
    first : whether a row is the first at its sample, shape (row,)
    tick : of each sample, shape (time,)
    time : shape (time,)
    flags : repeated rows and steps of the clock, `RecordFlag`, shape (time,)
    omitted_gaps : gaps too long to be stored: the last sample before each, and its length in s
    """

    size: int
    position: Integers
    first: Booleans
    tick: Integers
    time: NDArray[np.datetime64]
    flags: NDArray[np.uint8]
    omitted_gaps: tuple[tuple[int, float], ...]

    @classmethod
    def of(cls, ticks: Ticks, where: str = "log") -> Grid:
        """The grid that holds all ticks of a log.

        Raises
        ------
        LogError
            If its span, or its size for the number of rows, is absurd; nothing of that size is allocated before.
        """
        span = (int(ticks.tick[-1]) - int(ticks.tick[0])) / ticks.rate
        if span > _LONGEST_SPAN_S:
            what = f"its stamps span {span / _LONGEST_SPAN_S * 2:.1f} years"
            raise LogError(where, what, "Export the log again; its time column is damaged, or holds several logs")
        spacing = np.diff(ticks.tick)
        skipped = np.where(spacing > _LONGEST_STORED_GAP_S * ticks.rate, spacing - 1, 0)
        position = ticks.tick - np.concatenate([[0], np.cumsum(skipped)])
        size = int(position[-1]) + 1
        if size > max(_SAMPLES_PER_ROW * ticks.rows.size, _SMALL_GRID):
            raise LogError(
                where,
                f"its {ticks.rows.size} rows are spread over {size} samples at {ticks.rate:g} Hz, most of them missing",
                "State the unit or format of the time column, or export the log with all rows of its recorder",
            )
        first = np.concatenate([[True], spacing > 0])
        jump = np.zeros(size, dtype=np.int64)
        jump[position[1:][skipped > 0]] = skipped[skipped > 0]
        tick = np.arange(size) + np.cumsum(jump)
        flags = np.zeros(size, np.uint8)
        flags[position[~first]] |= np.uint8(RecordFlag.DUPLICATE)
        flags[position[ticks.repeated]] |= np.uint8(RecordFlag.DUPLICATE)
        flags[position[[step.row for step in ticks.steps]]] |= np.uint8(RecordFlag.CLOCK_STEP)
        gaps = tuple((int(position[row]), float(skipped[row] / ticks.rate)) for row in np.flatnonzero(skipped))
        return cls(size, position, first, tick, ticks.times(tick), flags, gaps)

    def first_values(self, rows: Array) -> Array:
        """The first value of a channel, shape (row,), at each sample; NaN where it has none, shape (time,)."""
        return first_known(rows, self.position, self.size)

    def at(self, sample: int) -> str:
        """Time of a sample for messages."""
        return str(self.time[sample].astype("datetime64[ms]"))


@dataclass(frozen=True)
class End:
    """End of a log that the next log of the well may join.

    rate : nominal samples per second
    time : its last sample, ns since 1970 UTC
    stamps : time of its last row by the stamps, without and with the steps of its clock, ns
    """

    rate: float
    time: int
    stamps: tuple[int, int]

    @classmethod
    def of(cls, ticks: Ticks) -> End:
        """The end of a log, from its ticks."""
        time = int(ticks.times(ticks.tick[-1:])[0].astype(np.int64))
        return cls(ticks.rate, time, (ticks.end, ticks.end + round(1e9 * sum(step.seconds for step in ticks.steps))))


def following(ticks: Ticks, before: End) -> Ticks:
    """A log's ticks after those of the previous log, at the distance between their stamps.

    The samples of both are at the nominal rate, from which the stamps drift; so the time from the
    last stamp of one log to the first of the other counts. After a longer pause a log is placed
    by its own stamps again.
    """
    interval = 1e9 / ticks.rate
    gap = min(((ticks.begin - stamp) * 1e-9 * ticks.actual for stamp in before.stamps), key=lambda gap: abs(gap - 1))
    longest = _LONGEST_STORED_GAP_S * ticks.rate
    if gap > longest:
        return replace(ticks, origin=max(ticks.origin, before.time + round(longest * interval)))
    near = round(gap)
    return replace(ticks, origin=before.time + round((near if abs(gap - near) < _NEAR_TICK else gap) * interval))


def clock_notes(ticks: Ticks, grid: Grid) -> list[Note]:
    """Notes on the clock: a large drift, rows out of order, repeated rows, steps."""
    notes = []
    if abs(ticks.actual / ticks.rate - 1) > _LARGE_DRIFT:
        off = 1e6 * (ticks.actual / ticks.rate - 1)
        what = f"its clock runs {off:+.0f} parts per million off the rate of {ticks.rate:g} Hz"
        notes.append((what, "Its samples are placed regularly at that rate; check the recorder's clock"))
    away = (End.of(ticks).time - ticks.end) * 1e-9
    if abs(away) > _FAR_OFF_S:
        what = f"its last sample is placed {away:+.1f} s off its stamp, so that no time is lost between samples"
        notes.append((what, "Compare the times with the driller's report; check the recorder's clock"))
    if ticks.shared:
        notes.append(shared_note(ticks.shared))
    if ticks.reordered:
        what = f"{ticks.reordered} rows were out of order and were sorted by time"
        notes.append((what, "Check the recorder if this recurs"))
    duplicates = int(ticks.repeated.size + np.sum(~grid.first))
    if duplicates:
        what = f"{duplicates} rows repeat the time of another row; the first value of each channel is used"
        notes.append((what, CHECK_RECORDER))
    return [*notes, *_step_notes(ticks, grid)]


def _step_notes(ticks: Ticks, grid: Grid) -> list[Note]:
    remedy = "Later times of this log follow the clock before that; compare them with the driller's report"
    if len(ticks.steps) > MOST_APART:
        seconds, places = [step.seconds for step in ticks.steps], [int(grid.position[step.row]) for step in ticks.steps]
        smooth = sum(step.continues for step in ticks.steps)
        what = f"the clock was set {len(seconds)} times, by {min(seconds):+.3f} to {max(seconds):+.3f} s"
        when = first_and_last(grid, places)
        return [(f"{what}, {when}; the signals are continuous at {smooth} of them", remedy)]
    notes = []
    for step in ticks.steps:
        signals = (
            "the signals are continuous there"
            if step.continues
            else "the signals are discontinuous there, so time is missing"
        )
        what = f"the clock was set by {step.seconds:+.3f} s at {grid.at(int(grid.position[step.row]))}; {signals}"
        notes.append((what, remedy))
    return notes


def first_and_last(grid: Grid, samples: Sequence[int]) -> str:
    """Times of the first and the last of some samples, in order of time, for messages."""
    return f"the first at {grid.at(samples[0])}, the last at {grid.at(samples[-1])}"


def seconds_text(seconds: float) -> str:
    """A duration, s, for messages; never rounded to nothing."""
    return f"{seconds:.1f}" if seconds >= 1 else f"{seconds:.2f}"
