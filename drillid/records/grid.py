"""A log's regular grid: which samples are stored, where its rows lie among them, and what its clock did."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from drillid.arrays import Booleans, Integers
from drillid.datasets.codes import RecordFlag
from drillid.records.clock import Ticks

Note = tuple[str, str]
"""What was done to a log, and what its owner can do about the cause."""

LOOK = "These samples are flagged; look at the recorder if this recurs"
_LONGEST_STORED_GAP_S = 300.0
"""Gaps up to this length are stored as missing samples; longer ones only show in the times."""
_NEAR_TICK = 0.3
"""A log joins the ticks of the log before it where it is off them by less than this share of an interval."""
_LARGE_DRIFT = 2e-4
"""Clocks further off their nominal rate are noted; 17 s a day."""
_FAR_OFF_S = 10.0
"""Samples further off their stamps are noted."""


@dataclass(frozen=True)
class Grid:
    """Stored samples of one log.

    size : number of samples
    position : sample of each row of `Ticks.rows`, shape (row,)
    first : the rows that are the first on their sample, shape (row,)
    time : shape (time,)
    flags : what the clock did, `RecordFlag`, shape (time,)
    left_out : gaps too long to be stored: the last sample before each, and its length in s
    """

    size: int
    position: Integers
    first: Booleans
    time: NDArray[np.datetime64]
    flags: NDArray[np.uint8]
    left_out: tuple[tuple[int, float], ...]

    @classmethod
    def of(cls, ticks: Ticks) -> Grid:
        """The samples that a log's ticks need."""
        apart = np.diff(ticks.tick)
        skipped = np.where(apart > _LONGEST_STORED_GAP_S * ticks.rate, apart - 1, 0)
        position = ticks.tick - np.concatenate([[0], np.cumsum(skipped)])
        size = int(position[-1]) + 1
        first = np.concatenate([[True], apart > 0])
        jump = np.zeros(size, dtype=np.int64)
        jump[position[1:][skipped > 0]] = skipped[skipped > 0]
        tick = np.arange(size) + np.cumsum(jump)
        flags = np.zeros(size, np.uint8)
        flags[position[~first]] |= np.uint8(RecordFlag.DUPLICATE)
        flags[position[ticks.repeated]] |= np.uint8(RecordFlag.DUPLICATE)
        flags[position[[step.row for step in ticks.steps]]] |= np.uint8(RecordFlag.CLOCK_STEP)
        gaps = tuple((int(position[row]), float(skipped[row] / ticks.rate)) for row in np.flatnonzero(skipped))
        return cls(size, position, first, ticks.times(tick), flags, gaps)

    def at(self, sample: int) -> str:
        """Time of a sample for messages."""
        return str(self.time[sample].astype("datetime64[ms]"))


@dataclass(frozen=True)
class End:
    """End of a log that the next log of the well may join.

    rate : nominal samples per second
    time : its last sample, ns since 1970 UTC
    stamps : time of its last row by the stamps, with settings of its clock taken out and as they were, ns
    """

    rate: float
    time: int
    stamps: tuple[int, int]

    @classmethod
    def of(cls, ticks: Ticks) -> End:
        """The end of a log by its ticks."""
        time = int(ticks.times(ticks.tick[-1:])[0].astype(np.int64))
        return cls(ticks.rate, time, (ticks.end, ticks.end + round(1e9 * sum(step.seconds for step in ticks.steps))))


def following(ticks: Ticks, before: End) -> Ticks:
    """A log's ticks behind the log before it, as many intervals later as the stamps tell.

    The samples of both are at the nominal rate, from which the stamps drift away; so it is the time
    from the one log's last stamp to the other's first that counts. A log after a longer pause
    goes by its stamps again.
    """
    interval = 1e9 / ticks.rate
    apart = min(((ticks.begin - stamp) * 1e-9 * ticks.found for stamp in before.stamps), key=lambda gap: abs(gap - 1))
    longest = _LONGEST_STORED_GAP_S * ticks.rate
    if apart > longest:
        return replace(ticks, origin=max(ticks.origin, before.time + round(longest * interval)))
    near = round(apart)
    return replace(ticks, origin=before.time + round((near if abs(apart - near) < _NEAR_TICK else apart) * interval))


def clock_notes(ticks: Ticks, grid: Grid) -> list[Note]:
    """What the clock did: a large drift, rows out of order, repeated rows, settings of the clock."""
    notes = []
    if abs(ticks.found / ticks.rate - 1) > _LARGE_DRIFT:
        off = 1e6 * (ticks.found / ticks.rate - 1)
        what = f"its clock runs {off:+.0f} parts in a million off the rate of {ticks.rate:g} Hz"
        notes.append((what, "Its samples are taken to be regular at that rate; look at the recorder's clock"))
    away = (End.of(ticks).time - ticks.end) * 1e-9
    if abs(away) > _FAR_OFF_S:
        what = f"its last sample is placed {away:+.1f} s off its stamp, so that no time is lost between samples"
        notes.append((what, "Compare the times with the driller's report; look at the recorder's clock"))
    if ticks.reordered:
        what = f"{ticks.reordered} rows stood out of order and were sorted by time"
        notes.append((what, "Look at the recorder if this recurs"))
    duplicates = int(ticks.repeated.size + np.sum(~grid.first))
    if duplicates:
        notes.append((f"{duplicates} rows repeat the time of another row; the first of each is used", LOOK))
    for step in ticks.steps:
        run_on = "the signals run on through it" if step.continues else "the signals break there, so time is missing"
        what = f"the clock was set by {step.seconds:+.3f} s at {grid.at(int(grid.position[step.row]))}; {run_on}"
        notes.append((what, "Later times of this log keep the clock before; compare them with the driller's report"))
    return notes
