"""The time of every row of a log, in UTC, from however its file states it."""

from __future__ import annotations

import re
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from drillid.arrays import Integers
from drillid.errors import LogError
from drillid.formats.counted_times import NoStart, from_numbers, unit_named
from drillid.formats.description import Note, TimeColumn
from drillid.formats.places import Places, shortened
from drillid.formats.since import unit_since
from drillid.formats.time_columns import (
    Stamps,
    all_aware,
    is_aware,
    is_number,
    nanoseconds,
    padded,
    padded_clock,
    zoned_stamps,
)
from drillid.formats.written_times import DAY_NS, ORDERS, UnclearDate, format_in, has_short_year, order_in, parse

if TYPE_CHECKING:
    pass

_ISO = re.compile(r"^\d{4}(?:-\d{1,2}-\d{1,2}|\d{4})(?:[T ]|$)")
_EXAMPLE = "Write time stamps such as 2025-03-03T06:00:00.020Z"
_LONGEST_MESSAGE = 500
_OTHER_FORMAT = "or state their format as time.format in the rig description"
_NUMBER = re.compile(r"^[+-]?\d+(?:[.,]\d*)?(?:[eE][+-]?\d+)?$")
_PAST_MIDNIGHT_NS = DAY_NS // 2
"""A time of day that is earlier than the one before by more than this is of the next day."""


@dataclass(frozen=True)
class Naive:
    """Times before their zone is known.

    since : ns since 1970, shape (row,)
    zoned : whether they are UTC already
    notes : decisions that were taken
    """

    since: Integers
    zoned: bool
    notes: tuple[Note, ...] = ()


@dataclass(frozen=True)
class Times:
    """The columns of a log that state its times.

    column, date : their names; `date` is None where one column holds both
    described : what the user states about them
    places : names of places for messages
    """

    column: str
    date: str | None
    described: TimeColumn
    places: Places

    def stamps(self, table: Any, ambiguous: bool | None = None) -> tuple[Stamps, list[Note]]:
        """Stamps as UTC without zone, ns, shape (row,), and the decisions taken.

        Parameters
        ----------
        table : Arrow table with the columns
        ambiguous : whether stamps of an hour that comes twice are the first; inferred from the rows' order where None

        Raises
        ------
        LogError
            With the place of a cell that is no time, or a question that the rig description must answer.
        """
        column = table.column(self.column)
        if self.date is not None:
            return self._placed(self._joined(table.column(self.date), column), ambiguous)
        zoned = zoned_stamps(column) if self.described.format is None else None
        if zoned is not None:
            return zoned, []
        return self._placed(self._naive(column), ambiguous)

    def _placed(self, naive: Naive, ambiguous: bool | None) -> tuple[Stamps, list[Note]]:
        if naive.zoned:
            return naive.since.view("datetime64[ns]"), list(naive.notes)
        return self._localised(naive.since, ambiguous), list(naive.notes)

    def _naive(self, column: Any) -> Naive:
        import pyarrow as pa

        if pa.types.is_dictionary(column.type):
            column = column.cast(column.type.value_type)
        if pa.types.is_timestamp(column.type) or pa.types.is_date(column.type):
            return self._of_times(column)
        if pa.types.is_time(column.type) or pa.types.is_duration(column.type):
            return self._from_midnight(self._time_of_day(column))
        if is_number(column.type):
            return self._of_numbers(column)
        if not (pa.types.is_string(column.type) or pa.types.is_large_string(column.type)):
            raise self._wrong(0, column[0].as_py())
        return self._of_text(column.cast(pa.string()))

    def _of_times(self, column: Any) -> Naive:
        import pyarrow as pa

        self._check_complete(column)
        zoned = pa.types.is_timestamp(column.type) and column.type.tz is not None
        try:
            whole = column.cast(pa.timestamp("ns", "UTC" if zoned else None)).cast(pa.int64())
        except pa.ArrowInvalid as error:
            raise LogError(
                self.places.column(self.column), "holds times that nanoseconds cannot hold", _EXAMPLE
            ) from error
        return Naive(np.asarray(whole.to_numpy()).copy(), zoned)

    def _of_numbers(self, column: Any) -> Naive:
        """Counts, whose unit and start are stated or follow from their size."""
        import pyarrow as pa

        self._check_complete(column)
        header = self.places.header
        values = column.to_numpy() if pa.types.is_integer(column.type) else column.cast(pa.float64()).to_numpy()
        finite = np.isfinite(values)
        if not np.all(finite):
            row = int(np.argmin(finite))
            raise self._wrong(row, values[row])
        header_unit = unit_named(unit_since(header.units.get(self.column, "")))
        try:
            found = from_numbers(values, self.described.unit, self._start(), header_unit)
        except NoStart as error:
            raise self._wrong(
                0,
                column[0].as_py(),
                "If it counts seconds, state their start as time.start and another unit as time.unit "
                f"in the rig description; else {_EXAMPLE[0].lower()}{_EXAMPLE[1:]}",
            ) from error
        except ValueError as error:
            row = int(np.argmax(np.abs(values.astype(float))))
            raise self._wrong(row, values[row], str(error).capitalize()) from error
        if not found.decided:
            counts = self.described.start is None and header.start is not None
            return Naive(found.since, found.zoned, (self._from_header(),) if counts else ())
        zone = f"in the zone {self.described.zone}" if found.decided.startswith("days") else "UTC"
        what = f"the times in column '{self.column}' are read as {found.decided}, {zone}, by their size"
        return Naive(found.since, found.zoned, ((what, "State time.unit in the rig description where that is wrong"),))

    def _from_header(self) -> Note:
        start = "" if self.places.header.start is None else np.datetime_as_string(self.places.header.start, "ms")
        what = f"the times in column '{self.column}' are counted from the start in the file's header, {start}"
        return what, "State time.start in the rig description where that is wrong"

    def _start(self) -> tuple[int, bool] | None:
        """The time that the column counts from, stated by the user or else by the file."""
        import pandas as pd

        if self.described.start is not None:
            start = pd.Timestamp(self.described.start)
            return (start.tz_convert("UTC") if start.tzinfo else start).as_unit("ns").value, start.tzinfo is not None
        header = self.places.header
        if header.start is None:
            return None
        return int(header.start.astype("datetime64[ns]").astype(np.int64)), header.start_is_utc

    def _of_text(self, column: Any) -> Naive:
        import pyarrow.compute as pc

        cell = next((found for found in (each.as_py() for each in column) if found and found.strip()), "")
        if not cell:
            raise self._wrong(0, cell)
        stated = self._format()
        if stated is not None and stated not in ORDERS:
            return self._formatted(column, stated)
        if _NUMBER.match(cell.strip()) and not re.match(r"^(?:19|20)\d{12}(?:[.,]\d*)?$", cell.strip()):
            return self._of_numbers(self._as_numbers(column))
        if _ISO.match(cell):
            found = self._iso(column)
            if not isinstance(found, int):
                return found
            wrong: int | None = found
        else:
            wrong = None
        return self._parsed(column, wrong, has_short_year(cell), pc)

    def _parsed(self, column: Any, wrong: int | None, short: bool, pc: Any) -> Naive:
        """Times in a form other than ISO."""
        try:
            found = parse(column, self._format())
        except UnclearDate as error:
            raise LogError(
                self.places.cell(self.column, 0),
                f"'{shortened(column[0].as_py())}' may have day or month first, and no row of the log shows which",
                "State time.format in the rig description as 'day first' or 'month first'",
            ) from error
        if found is None or (wrong is not None and np.any(found.wrong)):
            row = wrong or 0
            cell = column[row].as_py()
            if short:
                raise LogError(
                    self.places.cell(self.column, row),
                    f"'{shortened(cell)}' is not a time: its year has two digits",
                    "State the format in the rig description, such as time.format: '%d.%m.%y %H:%M:%S'",
                )
            raise self._wrong(row, cell)
        if np.any(found.wrong):
            row = int(np.argmax(found.wrong))
            raise self._wrong(row, column[row].as_py())
        notes = tuple([self._decided(found.decided)] if found.decided else [])
        if found.dated:
            return Naive(found.since, found.zoned, notes)
        return self._from_midnight(found.since)

    def _format(self) -> str | None:
        """Format or order of dates that the user states, else the file, whose unit may be 'DD/MM/YY'."""
        if self.described.format is not None:
            return self.described.format
        form = format_in(self.places.header.units.get(self.column, ""))
        if form is None or "%y" in form:
            return form
        return order_in(form)

    def _decided(self, decided: str) -> Note:
        what = f"the dates in column '{self.date or self.column}' are read as {decided}"
        return what, "State time.format in the rig description where that is wrong"

    def _iso(self, column: Any) -> Naive | int:
        """ISO stamps, or the first row that is none."""
        import pandas as pd

        cells = column.to_pandas()
        aware = pd.to_datetime(cells, errors="coerce", format="ISO8601", utc=all_aware(cells))
        wrong = np.flatnonzero(aware.isna())
        if wrong.size:
            return int(wrong[0])
        if not pd.api.types.is_datetime64_any_dtype(aware.dtype):
            return int(np.argmin(cells.map(is_aware)))
        zoned = aware.dt.tz is not None
        return Naive(nanoseconds(aware), zoned)

    def _formatted(self, column: Any, stated: str) -> Naive:
        import pandas as pd

        cells = column.to_pandas().str.strip()
        try:
            found = pd.to_datetime(cells, errors="coerce", format=stated, utc="%z" in stated)
        except ValueError as error:
            raise LogError(
                self.places.column(self.column),
                f"the format '{stated}' of the rig description cannot be used ({error})",
                "Write time.format as strptime has it, such as '%d.%m.%Y %H:%M:%S.%f'",
            ) from error
        wrong = np.flatnonzero(found.isna())
        if wrong.size:
            row = int(wrong[0])
            raise self._wrong(row, cells.iloc[row], f"It is not of the format '{stated}' that time.format states")
        if "%d" not in stated and "%j" not in stated and not re.search(r"%[cDxF]", stated):
            return self._from_midnight(nanoseconds(found) % DAY_NS)
        return Naive(nanoseconds(found), found.dt.tz is not None)

    def _as_numbers(self, column: Any) -> Any:
        import pyarrow as pa
        import pyarrow.compute as pc

        trimmed = pc.utf8_trim_whitespace(column)
        try:
            return trimmed.cast(pa.int64())
        except pa.ArrowInvalid:
            pass
        plain = pc.replace_substring(trimmed, ",", ".")
        try:
            return plain.cast(pa.float64())
        except pa.ArrowInvalid as error:
            matches = pc.fill_null(pc.match_substring_regex(plain, _NUMBER.pattern), False)
            row = int(np.argmin(matches.to_numpy()))
            raise self._wrong(row, column[row].as_py()) from error

    def _from_midnight(self, clock: Integers) -> Naive:
        """Times of day, which pass midnight where they fall by half a day, from a stated date on."""
        start = self._start()
        if start is None:
            raise LogError(
                self.places.column(self.column),
                "holds times of day without a date",
                "State the column of the dates as time.date, or the date of the first row as time.start, "
                "in the rig description",
            )
        steps = np.diff(clock, prepend=clock[:1])
        days = np.cumsum((steps < -_PAST_MIDNIGHT_NS).astype(np.int64) - (steps > _PAST_MIDNIGHT_NS))
        what = f"the times of day in column '{self.column}' are dated from the log's start on"
        note = (what, "Check the date; a log with gaps of a day needs a column of dates")
        return Naive(start[0] // DAY_NS * DAY_NS + days * DAY_NS + clock, start[1], (note,))

    def _joined(self, dates: Any, clock: Any) -> Naive:
        """A column of dates and one of times of day."""
        import pyarrow as pa
        import pyarrow.compute as pc

        assert self.date is not None
        stated = self.described.format
        both_text = pa.types.is_string(dates.type) and pa.types.is_string(clock.type)
        if stated is not None and stated not in ORDERS and both_text:
            return self._formatted(pc.binary_join_element_wise(dates, clock, " "), stated)
        days = replace(self, column=self.date, date=None)._days(dates)
        since = self._time_of_day(clock)
        return Naive(days.since // DAY_NS * DAY_NS + since, False, days.notes)

    def _days(self, dates: Any) -> Naive:
        """Midnight of each date."""
        import pyarrow as pa
        import pyarrow.compute as pc

        form = format_in(self.places.header.units.get(self.column, ""))
        if form is not None and "%y" in form and (is_number(dates.type) or pa.types.is_string(dates.type)):
            self._check_complete(dates)
            whole = dates.cast(pa.int64()) if is_number(dates.type) else dates
            return self._formatted(pc.utf8_lpad(pc.cast(whole, pa.string()), 6, "0"), form)
        if is_number(dates.type):
            self._check_complete(dates)
            numbers = dates.cast(pa.float64()).to_numpy()
            if np.all((numbers > 1.9e7) & (numbers < 2.1e7)):
                dates = pc.cast(dates.cast(pa.int64()), pa.string())
            elif np.all((numbers > 30_000) & (numbers < 60_000)):
                return Naive(from_numbers(np.floor(numbers), "excel", None, None).since, False)
            else:
                dates = pc.cast(dates.cast(pa.int64()), pa.string())
        if pa.types.is_string(dates.type):
            first = next((cell.as_py().strip() for cell in dates if cell.is_valid), "")
            if has_short_year(first) or re.fullmatch(r"\d{6}", first):
                raise LogError(
                    self.places.cell(self.column, 0),
                    f"'{first}' is not a date: its year has two digits",
                    "State the format of date and time in the rig description, such as "
                    "time.format: '%y%m%d %H%M%S' or '%d.%m.%y %H:%M:%S'",
                )
            if re.fullmatch(r"\d{8}", first):
                return self._parsed(dates, None, False, pc)
            return self._of_text(dates)
        if pa.types.is_timestamp(dates.type) or pa.types.is_date(dates.type):
            return self._of_times(dates)
        raise self._wrong(0, dates[0].as_py())

    def _time_of_day(self, column: Any) -> Integers:
        """Time since midnight, ns."""
        import pyarrow as pa
        import pyarrow.compute as pc

        self._check_complete(column)
        if pa.types.is_timestamp(column.type):
            return self._of_times(column).since % DAY_NS
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
            raise self._wrong(0, first)
        if np.any(found.wrong):
            row = int(np.argmax(found.wrong))
            raise self._wrong(row, column[row].as_py())
        return found.since % DAY_NS

    def _check_complete(self, column: Any) -> None:
        if column.null_count:
            import pyarrow.compute as pc

            raise self._wrong(int(np.argmax(pc.is_null(column).to_numpy())), "")

    def _wrong(self, row: int, cell: object, remedy: str = "") -> LogError:
        shown = "" if cell is None else shortened(cell)
        example = f"Write time stamps such as 2025-03-03T06:00:00.020Z{self.places.in_line(row)}"
        return LogError(
            self.places.cell(self.column, row), f"'{shown}' is not a time", remedy or f"{example}, {_OTHER_FORMAT}"
        )

    def _localised(self, since: Integers, ambiguous: bool | None) -> Stamps:
        import pandas as pd

        zone = self.described.zone
        naive = pd.Series(since.view("datetime64[ns]"))
        if zone == "UTC":
            return since.view("datetime64[ns]")
        rule: Any = "infer" if ambiguous is None else np.full(len(naive), ambiguous)
        try:
            aware = naive.dt.tz_localize(zone, ambiguous=rule)
        except (ValueError, KeyError) as error:
            raise LogError(
                self.places.column(self.column),
                f"the stamps cannot be placed in the time zone '{zone}' ({first_line(error)})",
                "Correct the zone in the rig description, or log in UTC",
            ) from error
        return np.asarray(aware.dt.tz_convert("UTC").dt.tz_localize(None).to_numpy(), dtype="datetime64[ns]")


def first_line(error: BaseException) -> str:
    """The first line of an error's message."""
    lines = str(error).splitlines() or [type(error).__name__]
    return shortened(lines[0].rstrip("."), _LONGEST_MESSAGE)
