"""Segments of one rig state, cut and joined, each with the reason why it holds no window."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import astuple, dataclass, replace
from typing import Any, Self

import numpy as np
import pandas as pd
import xarray as xr
from numpy.typing import NDArray

from drillid.arrays import Floats
from drillid.datasets.codes import RecordFlag, RigState
from drillid.records.grid import seconds_text

SEGMENT_COLUMNS = ("well", "state", "start", "end", "from_m", "to_m", "duration_s", "windows", "reason")
"""Columns of segments.csv: one row for every segment of the recorded time."""

_REGULAR = 1.1
"""Spacing of samples, in intervals, above which time is missing."""
_REASONS = {
    RigState.CONNECTION: "connection",
    RigState.OFF_BOTTOM: "off bottom",
    RigState.REAMING: "reaming",
    RigState.SWEEP_OFF: "sweep off",
}


@dataclass(frozen=True)
class Segment:
    """Samples `first` to `stop` (exclusive) of the records: one state, no missing time.

    start, end : times of the first sample and of one interval after the last, ns since 1970 UTC
    from_m, to_m : hole depth at the first and the last sample, m
    """

    state: RigState
    stuck: bool
    gap: bool
    first: int
    stop: int
    start: int
    end: int
    from_m: float
    to_m: float
    windows: int = 0
    reason: str = ""

    @classmethod
    def of(cls, content: Sequence[Any], offset: int) -> Self:
        """The segment from its JSON content, its samples counted from `offset`."""
        state, stuck, gap, first, stop, *rest = content
        return cls(RigState(state), stuck, gap, first + offset, stop + offset, *rest)

    def content(self, offset: int) -> list[Any]:
        """The segment's content for JSON, its samples counted from `offset`."""
        state, stuck, gap, first, stop, *rest = astuple(self)
        return [int(state), stuck, gap, first - offset, stop - offset, *rest]

    @property
    def duration(self) -> float:
        """Duration, s."""
        return (self.end - self.start) * 1e-9


def segments(part: xr.Dataset, states: NDArray[np.int8], rate: float, offset: int) -> list[Segment]:
    """Cut one log where the state, the time or the flag of a stuck sensor changes.

    Parameters
    ----------
    part : records of the log
    states : state of each sample, shape (time,)
    rate : samples per second
    offset : number of the log's first sample in the records
    """
    time = part["time"].values.astype("datetime64[ns]").astype(np.int64)
    flags, depth = part["flags"].values, part["hole_depth"].values
    stuck, gap = ((flags & np.uint8(flag)) > 0 for flag in (RecordFlag.STUCK, RecordFlag.GAP))
    kind = states.astype(np.int64) * 4 + 2 * stuck + (gap & (states == RigState.UNKNOWN))
    breaks = np.flatnonzero((np.diff(kind) != 0) | (np.diff(time) * 1e-9 * rate > _REGULAR)) + 1
    edges = [0, *breaks.tolist(), time.size]
    interval = round(1e9 / rate)
    return [
        Segment(
            RigState(int(states[first])),
            bool(stuck[first]),
            bool(gap[first]),
            offset + first,
            offset + stop,
            int(time[first]),
            int(time[stop - 1]) + interval,
            float(depth[first]),
            float(depth[stop - 1]),
        )
        for first, stop in itertools.pairwise(edges)
    ]


def joined(parts: list[Segment], rate: float) -> list[Segment]:
    """Segments of one kind joined where no time is missing between them, as where a log continues in the next."""
    result: list[Segment] = []
    for segment in parts:
        last = result[-1] if result else None
        same = last is not None and (last.state, last.stuck, last.gap) == (segment.state, segment.stuck, segment.gap)
        if last is not None and same and abs(segment.start - last.end) * 1e-9 * rate < _REGULAR - 1:
            result[-1] = replace(last, stop=segment.stop, end=segment.end, to_m=segment.to_m)
        else:
            result.append(segment)
    return result


def steady_parts(set_point: Floats, largest: float) -> list[tuple[int, int]]:
    """Bounds of the parts of a segment in each of which the set point varies by no more than `largest`."""
    parts, first = [], 0
    while first < set_point.size:
        rest = set_point[first:]
        over = np.maximum.accumulate(rest) - np.minimum.accumulate(rest) > largest
        stop = first + int(np.argmax(over)) if over[-1] else set_point.size
        parts.append((first, stop))
        first = stop
    return parts


def window_places(samples: int, length: int, shortest: int, overlap: float) -> list[tuple[int, int]]:
    """First sample and length of as many windows as fit, and of a shorter one where the remainder is long enough.

    The last window ends with the segment; the remainder lies at its start, where the rotation settles.
    """
    hop = max(1, round(length * (1 - overlap)))
    count = (samples - length) // hop + 1 if samples >= length else 0
    starts = [samples - length - hop * number for number in range(count - 1, -1, -1)]
    remainder = starts[0] if starts else samples
    return [*([(0, remainder)] if remainder >= shortest else []), *((start, length) for start in starts)]


def cut(segment: Segment, part: xr.Dataset, first: int, stop: int, rate: float, windows: int, reason: str) -> Segment:
    """Samples `first` to `stop` of a segment, whose records are `part`, as a segment of their own."""
    time, depth = part["time"].values.astype("datetime64[ns]").astype(np.int64), part["hole_depth"].values
    return replace(
        segment,
        first=segment.first + first,
        stop=segment.first + stop,
        start=int(time[first]),
        end=int(time[stop - 1]) + round(1e9 / rate),
        from_m=float(depth[first]),
        to_m=float(depth[stop - 1]),
        windows=windows,
        reason=reason,
    )


def reason_of(segment: Segment, missing: Sequence[str]) -> str:
    """Why a segment without windows has none.

    Parameters
    ----------
    missing : needed channels that it lacks
    """
    if segment.state is RigState.DRILLING:
        return "a sensor is stuck"
    if segment.state is RigState.UNKNOWN:
        return (
            f"gap of {seconds_text(segment.duration)} s"
            if segment.gap
            else f"no {', '.join(missing)} for {seconds_text(segment.duration)} s"
        )
    return _REASONS[segment.state]


def segments_table(well: str, rows: list[Segment]) -> pd.DataFrame:
    """Segments in order of time, in the columns of segments.csv."""
    table = [
        (
            well,
            row.state.name.lower(),
            *(pd.Timestamp(moment).isoformat(timespec="milliseconds") for moment in (row.start, row.end)),
            round(row.from_m, 3),
            round(row.to_m, 3),
            round(row.duration, 3),
            row.windows,
            row.reason,
        )
        for row in sorted(rows, key=lambda row: row.first)
    ]
    return pd.DataFrame(table, columns=list(SEGMENT_COLUMNS))
