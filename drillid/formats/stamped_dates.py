"""Columns of dates that hold times of day as well, or lie beside a column of elapsed times."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from drillid.arrays import Integers
from drillid.errors import LogError
from drillid.formats.column_times import of_numbers, of_text
from drillid.formats.counted_times import unit_named
from drillid.formats.since import FAR_FROM_START_S, counts_from_day
from drillid.formats.stated_times import Naive, StatedTimes
from drillid.formats.time_columns import is_number
from drillid.formats.times_of_day import are_no_digits, numbers_in, time_of_day
from drillid.formats.written_times import DAY_NS

_S = 1_000_000_000
_MIN = 60 * _S


def of_stamped_dates(of: StatedTimes, dates: Naive, clock: Any) -> Naive:
    """Times of the rows of such a log.

    Times of day are placed on the day of the date, whose own time of day may be rounded or that of an export. Elapsed
    times count from the stated start, else from the date if that is the same in all rows; otherwise the dates are the
    times.

    Parameters
    ----------
    dates : with their times of day
    clock : Arrow column of times of day or elapsed times
    """
    of.check_complete(clock)
    times = _times_of_day(of, clock)
    if times is not None and _agree(times, dates):
        since = dates.since + _apart(times, dates)
        return Naive(since, dates.zoned or times.zoned, (*dates.notes, *times.notes))
    constant = bool(np.ptp(dates.since) == 0)
    if times is not None and not _are_elapsed(of, times, numbers_in(clock) is not None and not constant):
        return _on_days(of, dates, times, constant)
    if constant or of.described.start is not None:
        return from_start(of, dates, clock)
    what = f"column '{of.date}' holds times of day as well and is used alone; '{of.column}' counts from another time"
    note = (what, "State the time from which it counts as time.start in the rig description if that is wrong")
    return Naive(dates.since, dates.zoned, (*dates.notes, note))


def count_from_date(of: StatedTimes, dates: Naive, clock: Any) -> bool:
    """Whether numbers beside dates without times of day are elapsed times, so that nothing but a stated start says when
    they begin.

    Seconds that begin near zero are, unless their name says that they are those of the day; so are minutes or hours.
    """
    numbers = numbers_in(clock)
    of_day = counts_from_day(of.column)
    if numbers is None or of_day or (of.described.start is None and np.ptp(dates.since) > 0):
        return False
    unit = unit_named(of.places.header.units.get(of.column, ""))
    if unit is None and np.all(numbers < 1):
        # fractions of the day
        return False
    if of_day is False or unit not in (None, "s", "day"):
        return True
    return bool(numbers[0] < FAR_FROM_START_S) and (unit == "s" or are_no_digits(numbers))


def _times_of_day(of: StatedTimes, clock: Any) -> Naive | None:
    """The column as times of day; None for numbers that are too large."""
    try:
        return time_of_day(of, clock)
    except LogError:
        if numbers_in(clock) is None:
            raise
        return None


def _agree(times: Naive, dates: Naive) -> bool:
    """Whether times of day are those of the dates, which may leave out seconds or their decimals."""
    coarse = _MIN if not np.any(dates.since % _MIN) else _S
    return bool(np.all(np.abs(_apart(times, dates)) < coarse))


def _apart(times: Naive, dates: Naive) -> Integers:
    """From the dates' times of day to those of another column, at most half a day, ns."""
    return (times.since - dates.since + DAY_NS // 2) % DAY_NS - DAY_NS // 2


def _are_elapsed(of: StatedTimes, times: Naive, beside_stamps: bool) -> bool:
    """Whether times that may be those of a day count from the log's start instead.

    Parameters
    ----------
    beside_stamps : whether they are numbers beside dates that vary, whose own times of day are to be preferred
    """
    of_day = True if times.zoned else counts_from_day(of.column)
    if of_day is not None:
        return not of_day
    return beside_stamps or bool(times.since[0] < FAR_FROM_START_S * _S)


def _on_days(of: StatedTimes, dates: Naive, times: Naive, constant: bool) -> Naive:
    since = dates.since // DAY_NS * DAY_NS + times.since if constant else dates.since + _apart(times, dates)
    what = f"the times of day in column '{of.date}' are not those in column '{of.column}' and are not used"
    note = (what, f"State '{of.date}' as time.column in the rig description if it holds the times")
    return Naive(since, times.zoned, (*dates.notes, *times.notes, note))


def from_start(of: StatedTimes, dates: Naive, clock: Any) -> Naive:
    """Elapsed times from the stated start, else from the one date of all rows."""
    stated = of.start() if of.described.start is not None else None
    start, zoned = stated or (int(dates.since[0]), dates.zoned)
    written = str(np.datetime_as_string(np.datetime64(start, "ns"), "ns"))
    if numbers_in(clock) is None:
        since = start + time_of_day(of, clock).since
    else:
        counted = replace(of, described=replace(of.described, start=f"{written}Z" if zoned else written))
        since = (of_numbers if is_number(clock.type) else of_text)(counted, clock).since
    if stated is not None:
        by = f"{written[:-6]}, as stated; column '{of.date}' is not used"
    elif start % DAY_NS:
        by = f"{written[:-6]}, the time in column '{of.date}'"
    else:
        by = f"midnight of {written[:10]}, as column '{of.date}' holds no times of day"
    what = f"the times in column '{of.column}' count from {by}"
    return Naive(since, zoned, (*dates.notes, (what, "State time.start in the rig description if that is wrong")))
