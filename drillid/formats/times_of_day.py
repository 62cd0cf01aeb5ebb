"""Times of day, and times of libraries' own types."""

from __future__ import annotations

import re
from typing import Any

import numpy as np

from drillid.arrays import Integers
from drillid.errors import LogError
from drillid.formats.stated_times import EXAMPLE, Naive, StatedTimes
from drillid.formats.time_columns import is_number, padded, padded_clock
from drillid.formats.written_times import DAY_NS, parse

_PAST_MIDNIGHT_NS = DAY_NS // 2
"""A time of day that is earlier than the one before by more than this is of the next day."""


def of_times(of: StatedTimes, column: Any) -> Naive:
    """Time stamps and dates of Arrow."""
    import pyarrow as pa

    of.check_complete(column)
    zoned = pa.types.is_timestamp(column.type) and column.type.tz is not None
    try:
        whole = column.cast(pa.timestamp("ns", "UTC" if zoned else None)).cast(pa.int64())
    except pa.ArrowInvalid as error:
        raise LogError(of.places.column(of.column), "holds times that nanoseconds cannot hold", EXAMPLE) from error
    return Naive(np.asarray(whole.to_numpy()).copy(), zoned)


def time_of_day(of: StatedTimes, column: Any) -> Integers:
    """Time since midnight, ns."""
    import pyarrow as pa
    import pyarrow.compute as pc

    of.check_complete(column)
    if pa.types.is_timestamp(column.type):
        return of_times(of, column).since % DAY_NS
    if pa.types.is_time(column.type) or pa.types.is_duration(column.type):
        unit = {"s": 10**9, "ms": 10**6, "us": 10**3, "ns": 1}[column.type.unit]
        width = pa.int32() if pa.types.is_time32(column.type) else pa.int64()
        counts = column.cast(width).cast(pa.int64()).to_numpy()
        return np.asarray(counts) * unit
    if is_number(column.type):
        numbers = column.cast(pa.float64()).to_numpy()
        if np.all((numbers >= 0) & (numbers < 1)):
            return np.asarray(np.rint(numbers * (DAY_NS // 1000)).astype(np.int64) * 1000)
        column = padded_clock(column)
    text = column.cast(pa.string())
    first = next((cell.as_py().strip() for cell in text if cell.is_valid), "")
    if re.fullmatch(r"\d{1,6}(?:[.,]\d*)?", first):
        text = pc.replace_substring(padded(text), ",", ".")
        text = pc.replace_substring_regex(text, r"^(\d\d)(\d\d)(\d\d)", r"\1:\2:\3")
    found = parse(text)
    if found is None or not found.timed:
        raise of.wrong(0, first)
    if np.any(found.wrong):
        row = int(np.argmax(found.wrong))
        raise of.wrong(row, column[row].as_py())
    return found.since % DAY_NS


def from_midnight(of: StatedTimes, clock: Integers) -> Naive:
    """Times of day, which pass midnight where they fall by half a day, from a stated date on."""
    start = of.midnight()
    if start is None:
        raise LogError(
            of.places.column(of.column),
            "holds times of day without a date",
            "State the column of the dates as time.date, or the date of the first row as time.start, "
            "in the rig description",
        )
    steps = np.diff(clock, prepend=clock[:1])
    days = np.cumsum((steps < -_PAST_MIDNIGHT_NS).astype(np.int64) - (steps > _PAST_MIDNIGHT_NS))
    what = f"the times of day in column '{of.column}' are dated from the log's start on"
    note = (what, "Check the date; a log with gaps of a day needs a column of dates")
    return Naive(start[0] + days * DAY_NS + clock, start[1], (note,))
