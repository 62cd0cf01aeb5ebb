"""The time of every row of a log, in UTC, from however its file states it."""

from __future__ import annotations

import re
from dataclasses import replace
from typing import Any

import numpy as np

from drillid.arrays import Integers
from drillid.errors import LogError
from drillid.formats.clock_changes import in_utc, in_utc_by_order
from drillid.formats.column_times import formatted, of_numbers, of_text, parsed
from drillid.formats.counted_times import from_numbers
from drillid.formats.description import Note
from drillid.formats.parts_of_times import of_parts
from drillid.formats.places import first_line, shortened
from drillid.formats.short_years import of_short_years, with_long_years
from drillid.formats.stamped_dates import count_from_date, from_start, of_stamped_dates
from drillid.formats.stated_times import Naive, StatedTimes
from drillid.formats.time_columns import Stamps, is_number, zoned_stamps
from drillid.formats.times_of_day import from_midnight, of_times, time_of_day, with_milliseconds
from drillid.formats.written_times import DAY_NS, ORDERS, has_short_year, with_whole_milliseconds


def utc_stamps(of: StatedTimes, table: Any, ambiguous: bool | None = None) -> tuple[Stamps, list[Note]]:
    """Stamps as UTC without zone, ns, shape (row,), and the decisions taken.

    Parameters
    ----------
    table : Arrow table with the columns
    ambiguous : whether stamps of a repeated hour are of its first pass; inferred from the rows' order where None

    Raises
    ------
    LogError
        With the place of a cell that is not a time, or a question that the rig description must answer.
    """
    if of.parts:
        naive = of_parts(of, [table.column(name) for name in of.parts])
        stamps, noted = _placed(of, _with_milliseconds(of, naive, table), ambiguous)
        return stamps, noted
    column, in_milliseconds = with_whole_milliseconds(table.column(of.column))
    notes = [_in_milliseconds(of)] if in_milliseconds else []
    if of.date is not None:
        naive = _joined(of, table.column(of.date), column)
    else:
        zoned = zoned_stamps(column) if of.described.format is None and of.milliseconds is None else None
        if zoned is not None:
            return zoned, notes
        naive = _naive(of, column)
        _check_timed(of, naive.since, column)
    stamps, noted = _placed(of, _with_milliseconds(of, naive, table), ambiguous)
    return stamps, [*notes, *noted]


def _with_milliseconds(of: StatedTimes, naive: Naive, table: Any) -> Naive:
    return naive if of.milliseconds is None else with_milliseconds(of, naive, table.column(of.milliseconds))


def _placed(of: StatedTimes, naive: Naive, ambiguous: bool | None) -> tuple[Stamps, list[Note]]:
    if naive.zoned:
        return naive.since.view("datetime64[ns]"), list(naive.notes)
    return _localised(of, naive.since, ambiguous), [*naive.notes, *of.zone_notes()]


def _in_milliseconds(of: StatedTimes) -> Note:
    reason = "as they then advance within a second, whereas as decimals they would jump back and forth"
    what = f"the digits after the seconds in column '{of.column}' are read as whole milliseconds, {reason}"
    return what, "Write the same number of digits in every row if that is wrong"


def _check_timed(of: StatedTimes, since: Integers, column: Any) -> None:
    """Refuse a column of dates alone, which would put all rows at midnight."""
    if is_number(column.type) or since.size < 2 or np.any(since % DAY_NS):
        return
    raise LogError(
        of.places.column(of.column),
        f"holds dates without times of day, such as '{shortened(column[0].as_py())}'",
        "State the column with the times of day as time.column, and this one as time.date, in the rig description",
    )


def _naive(of: StatedTimes, column: Any) -> Naive:
    import pyarrow as pa

    if pa.types.is_dictionary(column.type):
        column = column.cast(column.type.value_type)
    if pa.types.is_timestamp(column.type) or pa.types.is_date(column.type):
        return of_times(of, column)
    if pa.types.is_time(column.type) or pa.types.is_duration(column.type):
        return from_midnight(of, time_of_day(of, column))
    if is_number(column.type):
        return of_numbers(of, column)
    if not (pa.types.is_string(column.type) or pa.types.is_large_string(column.type)):
        raise of.wrong(0, column[0].as_py())
    text = column.cast(pa.string())
    return _of_short_years(of, text) or of_text(of, text)


def _of_short_years(of: StatedTimes, text: Any) -> Naive | None:
    """Times with named months and two-digit years, where no other format is stated; None for any others."""
    if of.form() is not None and of.form() not in ORDERS:
        return None
    long, were_short = with_long_years(text)
    if not were_short:
        return None
    found = of_text(of, long)
    return replace(found, notes=(*found.notes, of_short_years(of.column)))


def _joined(of: StatedTimes, dates: Any, clock: Any) -> Naive:
    """Times from a column of dates and one of times of day."""
    import pyarrow as pa
    import pyarrow.compute as pc

    assert of.date is not None
    stated = of.described.format
    both_text = pa.types.is_string(dates.type) and pa.types.is_string(clock.type)
    if stated is not None and stated not in ORDERS and both_text:
        return formatted(of, pc.binary_join_element_wise(dates, clock, " "), stated)
    days = _days(replace(of, column=of.date, date=None), dates)
    if np.any(days.since % DAY_NS):
        return of_stamped_dates(of, days, clock)
    of.check_complete(clock)
    if count_from_date(of, days, clock):
        return from_start(of, days, clock)
    since = time_of_day(of, clock)
    return Naive(days.since + since.since, since.zoned, (*days.notes, *since.notes))


def _days(of: StatedTimes, dates: Any) -> Naive:
    """Each date, at midnight unless its cell holds a time of day as well."""
    import pyarrow as pa
    import pyarrow.compute as pc

    form = of.written_form()
    if form is not None and "%y" in form and (is_number(dates.type) or pa.types.is_string(dates.type)):
        of.check_complete(dates)
        whole = dates.cast(pa.int64()) if is_number(dates.type) else dates
        return formatted(of, pc.utf8_lpad(pc.cast(whole, pa.string()), 6, "0"), form)
    if is_number(dates.type):
        of.check_complete(dates)
        numbers = dates.cast(pa.float64()).to_numpy()
        if np.all((numbers > 1.9e7) & (numbers < 2.1e7)):
            dates = pc.cast(dates.cast(pa.int64()), pa.string())
        elif np.all((numbers > 30_000) & (numbers < 60_000)):
            return Naive(from_numbers(numbers, "excel", None, None).since, False)
        else:
            dates = pc.cast(dates.cast(pa.int64()), pa.string())
    if pa.types.is_string(dates.type):
        named = _of_short_years(of, dates)
        if named is not None:
            return named
        first = next((cell.as_py().strip() for cell in dates if cell.is_valid), "")
        if has_short_year(first) or re.fullmatch(r"\d{6}", first):
            raise LogError(
                of.places.cell(of.column, 0),
                f"'{first}' is not a date: its year has two digits",
                "State the format of date and time in the rig description, such as "
                "time.format: '%y%m%d %H%M%S' or '%d.%m.%y %H:%M:%S'",
            )
        if re.fullmatch(r"\d{8}", first):
            return parsed(of, dates, None, False, pc)
        return of_text(of, dates)
    if pa.types.is_timestamp(dates.type) or pa.types.is_date(dates.type):
        return of_times(of, dates)
    raise of.wrong(0, dates[0].as_py())


def _localised(of: StatedTimes, since: Integers, ambiguous: bool | None) -> Stamps:
    import pandas as pd

    zone = of.zone()
    naive = pd.Series(since.view("datetime64[ns]"))
    if str(zone) == "UTC":
        return since.view("datetime64[ns]")
    try:
        placed = in_utc_by_order(naive, zone) if ambiguous is None else in_utc(naive, zone, ambiguous)
    except KeyError as error:
        raise LogError(
            of.places.column(of.column),
            f"'{zone}' is not a time zone",
            "Correct time.zone in the rig description to one such as Europe/Oslo or UTC",
        ) from error
    except ValueError as error:
        raise _not_on_the_clock(of, naive, zone, first_line(error)) from error
    if placed is None:
        raise _not_on_the_clock(of, naive, zone, "")
    return placed.view("datetime64[ns]")


def _not_on_the_clock(of: StatedTimes, naive: Any, zone: Any, reason: str) -> LogError:
    """The error for stamps within the hour that a clock skips in spring, or the one that it repeats in autumn."""
    left_out = naive.dt.tz_localize(zone, ambiguous=np.ones(len(naive), bool), nonexistent="NaT").isna().to_numpy()
    repeated = naive.dt.tz_localize(zone, ambiguous="NaT", nonexistent="shift_forward").isna().to_numpy()
    if left_out.any():
        row = int(np.argmax(left_out))
        fault = "does not exist there, as clocks are set forward past it"
    elif repeated.any():
        row = int(np.argmax(repeated))
        fault = "occurs twice there, as clocks are set back, and the rows do not show which of the two it is"
    else:
        what = f"the stamps cannot be placed in the time zone '{zone}' ({reason})"
        return LogError(of.places.column(of.column), what, "Correct time.zone in the rig description")
    time = str(naive[row].floor("s"))
    return LogError(
        of.places.cell(of.column, row),
        f"the stamps cannot be placed in the time zone '{zone}': {time} {fault}",
        "Export the log in UTC, or with the offset from UTC in every stamp; if the recorder's clock is not changed for "
        "daylight saving, state its zone as time.zone in the rig description, such as Etc/GMT-1 for UTC+1",
    )
