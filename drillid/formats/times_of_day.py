"""Times of day, and times of libraries' own types."""

from __future__ import annotations

import re
from dataclasses import replace
from typing import Any

import numpy as np

from drillid.arrays import Floats
from drillid.errors import LogError
from drillid.formats.counted_times import unit_named
from drillid.formats.places import shortened
from drillid.formats.stated_times import EXAMPLE, Naive, StatedTimes
from drillid.formats.time_columns import is_number, padded, padded_clock
from drillid.formats.written_times import DAY_NS, parse

_DIGITS = re.compile(r"\d{1,6}(?:[.,]\d*)?")
_DAY_S = 86_400
_PAST_MIDNIGHT_NS = DAY_NS // 2
"""A time of day that is earlier than the one before by more than this belongs to the next day."""


def of_times(of: StatedTimes, column: Any) -> Naive:
    """Times from Arrow's time stamps and dates."""
    import pyarrow as pa

    of.check_complete(column)
    zoned = pa.types.is_timestamp(column.type) and column.type.tz is not None
    try:
        whole = column.cast(pa.timestamp("ns", "UTC" if zoned else None)).cast(pa.int64())
    except pa.ArrowInvalid as error:
        raise LogError(of.places.column(of.column), "holds times that nanoseconds cannot represent", EXAMPLE) from error
    return Naive(np.asarray(whole.to_numpy()).copy(), zoned)


def time_of_day(of: StatedTimes, column: Any) -> Naive:
    """Times since midnight of the date that belongs to them; those with a zone may be of the day before or after."""
    import pyarrow as pa
    import pyarrow.compute as pc

    of.check_complete(column)
    if pa.types.is_timestamp(column.type):
        stamps = of_times(of, column)
        return Naive(stamps.since % DAY_NS, stamps.zoned)
    if pa.types.is_time(column.type) or pa.types.is_duration(column.type):
        unit = {"s": 10**9, "ms": 10**6, "us": 10**3, "ns": 1}[column.type.unit]
        width = pa.int32() if pa.types.is_time32(column.type) else pa.int64()
        counts = column.cast(width).cast(pa.int64()).to_numpy()
        return Naive(np.asarray(counts) * unit, False)
    numbers = numbers_in(column)
    if numbers is not None:
        counted = _counted(of, numbers)
        if counted is not None:
            return counted
        column = padded_clock(column) if is_number(column.type) else column
    text = column.cast(pa.string())
    first = next((cell.as_py().strip() for cell in text if cell.is_valid), "")
    if _DIGITS.fullmatch(first):
        text = pc.replace_substring(padded(text), ",", ".")
        text = pc.replace_substring_regex(text, r"^(\d\d)(\d\d)(\d\d)", r"\1:\2:\3")
    found = parse(text)
    if found is None or not found.timed:
        raise of.wrong(0, first)
    if np.any(found.wrong):
        row = int(np.argmax(found.wrong))
        raise of.wrong(row, column[row].as_py())
    return Naive(found.since % DAY_NS if found.dated else found.since, found.zoned)


def numbers_in(column: Any) -> Floats | None:
    """Times of day that are numbers, such as 60001.5, 0.25 or '0,25', shape (row,); None for any others."""
    import pyarrow as pa
    import pyarrow.compute as pc

    if is_number(column.type):
        return np.asarray(column.cast(pa.float64()).to_numpy())
    text = pc.utf8_trim_whitespace(column.cast(pa.string()))
    first = text[0].as_py() or ""
    if not _DIGITS.fullmatch(first) or re.match(r"0\d", first):
        return None
    try:
        return np.asarray(pc.replace_substring(text, ",", ".").cast(pa.float64()).to_numpy())
    except pa.ArrowInvalid:
        return None


def _counted(of: StatedTimes, numbers: Floats) -> Naive | None:
    """Fractions of a day, or seconds of the day; None for digits of hours, minutes and seconds such as 60001.

    If all are below 1, they are fractions. They are seconds where the column's unit says so, or where the digits of
    some, such as 21661, are not valid minutes and seconds.
    """
    if _all_below(1, numbers):
        return Naive(np.asarray(np.rint(numbers * (DAY_NS // 1000)).astype(np.int64) * 1000), False)
    stated = _in_seconds(of)
    if not (stated or are_no_digits(numbers)) or not _all_below(_DAY_S, numbers):
        return None
    what = f"the times in column '{of.column}' are read as seconds of the day"
    notes = () if stated else ((what, "Write times of day such as 06:00:00.020 if that is wrong"),)
    return Naive(np.rint(numbers * 1e6).astype(np.int64) * 1000, False, notes)


def may_count_otherwise(of: StatedTimes, column: Any) -> bool:
    """Whether rows behind these may show that times of day count something else, as 10261 does behind 10200."""
    import pyarrow as pa

    if of.date is None or not (is_number(column.type) or pa.types.is_string(column.type)):
        return False
    numbers = numbers_in(column)
    if numbers is None or not _all_below(_DAY_S, numbers):
        return False
    return _all_below(1, numbers) or not (_in_seconds(of) or are_no_digits(numbers))


def _all_below(limit: int, numbers: Floats) -> bool:
    return bool(np.all((numbers >= 0) & (numbers < limit)))


def _in_seconds(of: StatedTimes) -> bool:
    """Whether the file states that the times count seconds."""
    return unit_named(of.places.header.units.get(of.column, "")) == "s"


def are_no_digits(numbers: Floats) -> bool:
    """Whether the last four digits of some numbers are not valid minutes and seconds."""
    return bool(np.any((numbers % 100 >= 61) | (numbers % 10_000 >= 6000)))


def with_milliseconds(of: StatedTimes, naive: Naive, column: Any) -> Naive:
    """Times of whole seconds with the milliseconds of a column beside them, where it holds whole numbers below 1000."""
    import pyarrow as pa
    import pyarrow.compute as pc

    assert of.milliseconds is not None
    text = pc.utf8_trim_whitespace(column.cast(pa.string()))
    if np.any(naive.since % 1_000_000_000):
        return naive
    whole = pc.fill_null(pc.match_substring_regex(text, r"^\d{1,3}(?:\.0*)?$"), False).to_numpy()
    if not np.all(whole):
        row = int(np.argmin(whole))
        cell = f"its row {row + 1} is '{shortened(column[row].as_py())}'"
        what = f"column '{of.milliseconds}' is not added to the times as their milliseconds, as {cell}"
        return replace(naive, notes=(*naive.notes, (what, f"Correct that{of.places.in_line(row)} if it is wrong")))
    added = text.cast(pa.float64()).to_numpy().astype(np.int64) * 1_000_000
    what = f"the milliseconds in column '{of.milliseconds}' are added to the times in column '{of.column}'"
    note = (what, "Rename the column if that is wrong")
    return replace(naive, since=naive.since + added, notes=(*naive.notes, note))


def from_midnight(of: StatedTimes, times: Naive) -> Naive:
    """Times from a stated date on, from times of day, which pass midnight where they fall by half a day."""
    start = of.midnight(in_utc=times.zoned)
    if start is None:
        raise LogError(
            of.places.column(of.column),
            "holds times of day without a date",
            "State the column of the dates as time.date, or the date of the first row as time.start, "
            "in the rig description",
        )
    clock = times.since
    steps = np.diff(clock, prepend=clock[:1])
    days = np.cumsum((steps < -_PAST_MIDNIGHT_NS).astype(np.int64) - (steps > _PAST_MIDNIGHT_NS))
    what = f"the times of day in column '{of.column}' are dated from the start of the log"
    note = (what, "Check the date; a log with gaps of a day needs a column of dates")
    since = start[0] + days * DAY_NS + clock
    return Naive(since, start[1] or times.zoned, (*times.notes, note))
