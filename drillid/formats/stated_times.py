"""What the columns, the user and the file state about a log's times."""

from __future__ import annotations

import datetime
from dataclasses import dataclass
from typing import Any

import numpy as np

from drillid.arrays import Integers
from drillid.errors import LogError
from drillid.formats.description import Note, TimeColumn
from drillid.formats.mnemonics import offset_among, split_unit
from drillid.formats.places import Places, shortened
from drillid.formats.written_times import DAY_NS, format_in, order_in
from drillid.formats.zones import abbreviation_of_zone, zone_of_column

EXAMPLE = "Write time stamps such as 2025-03-03T06:00:00.020Z"
_OTHER_FORMAT = "or state their format as time.format in the rig description"


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
class StatedTimes:
    """The columns of a log that state its times.

    column, date : their names; `date` is None where one column holds both
    milliseconds : name of the column with the milliseconds that whole seconds lack, None without one
    parts : columns of year, month, day, hour, minute and second, the last of which is `column`; empty where there are
        none
    described : what the user states about them
    places : names of places for messages
    """

    column: str
    date: str | None
    described: TimeColumn
    places: Places
    milliseconds: str | None = None
    parts: tuple[str, ...] = ()

    @property
    def columns(self) -> tuple[str, ...]:
        """The columns that are read for the times."""
        whole = (self.column, self.date, self.milliseconds, *self.parts[:-1])
        return tuple(name for name in whole if name is not None)

    def start(self) -> tuple[int, bool] | None:
        """The time that the column counts from, stated by the user or else by the file."""
        import pandas as pd

        if self.described.start is not None:
            start = pd.Timestamp(self.described.start)
            return (start.tz_convert("UTC") if start.tzinfo else start).as_unit("ns").value, start.tzinfo is not None
        header = self.places.header
        if header.start is None:
            return None
        return int(header.start.astype("datetime64[ns]").astype(np.int64)), header.start_is_utc

    def midnight(self, *, in_utc: bool) -> tuple[int, bool] | None:
        """Start of the day of the start, in UTC or in the zone in which the start is written; and whether it is UTC."""
        import pandas as pd

        start = self.start()
        if start is None:
            return None
        if in_utc:
            offset = 0
        elif self.described.start is None:
            offset = self.places.header.start_offset
        else:
            stated = pd.Timestamp(self.described.start).utcoffset()
            offset = 0 if stated is None else round(stated.total_seconds()) * 1_000_000_000
        return (start[0] + offset) // DAY_NS * DAY_NS - offset, start[1]

    def zone(self) -> str | datetime.tzinfo:
        """The zone of times without one: that in the columns' names or units, else that of the rig's clock."""
        header = self.places.header
        if self.described.start is not None:
            return self.described.zone
        columns = [name for name in (self.column, self.date) if name is not None]
        found = (zone_of_column(name, header.units.get(name, "")) for name in columns)
        return next((zone for zone in found if zone is not None), self.described.zone)

    def zone_notes(self) -> tuple[Note, ...]:
        """For times without a zone: that their column states it, or that one beside them does, which is not used."""
        zone = self.zone()
        if str(zone) != self.described.zone:
            what = f"the times in column '{self.column}' are in the zone {zone}, as its name or unit states"
            return ((what, f"Correct the name or unit if the rig's zone, {self.described.zone}, is right"),)
        abbreviation = abbreviation_of_zone(self.column, self.places.header.units.get(self.column, ""))
        if abbreviation is not None:
            what = f"{abbreviation} at column '{self.column}' stands for several zones; {zone} is assumed"
            return ((what, "State time.zone in the rig description if that is wrong"),)
        beside = offset_among(self.places.header.columns)
        if beside is None or beside in (self.column, self.date):
            return ()
        what = f"the zone in column '{beside}' is not used; those in column '{self.column}' are assumed to be in {zone}"
        return ((what, "State time.zone in the rig description if that is wrong"),)

    def form(self) -> str | None:
        """Format or order of dates that the user states, else the file, whose unit may be 'DD/MM/YY'."""
        if self.described.format is not None:
            return self.described.format
        form = self.written_form()
        if form is None or "%y" in form:
            return form
        return order_in(form)

    def written_form(self) -> str | None:
        """Format of dates by the unit of their column, else by its name, such as 'YYMMDD'."""
        return format_in(self.places.header.units.get(self.column, "")) or format_in(split_unit(self.column)[0])

    def by_rows(self, decided: str) -> Note:
        """A note that the rows showed how dates are written."""
        what = f"the dates in column '{self.date or self.column}' are read as {decided}"
        return what, "State time.format in the rig description if that is wrong"

    def from_header(self, first: int, *, in_utc: bool) -> Note:
        """A note that times count from a start in the file's header, and what the first one is, ns since 1970."""
        header = self.places.header
        start = "" if header.start is None else np.datetime_as_string(header.start, "ms")
        zone = "UTC" if in_utc else self.described.zone
        row = np.datetime_as_string(np.datetime64(first, "ns"), "ms")
        what = (
            f"the times in column '{self.column}' count from {start}, as the file's header says: "
            f"the first is {row} {zone}"
        )
        return what, "State time.start in the rig description if that is wrong"

    def check_complete(self, column: Any) -> None:
        """Refuse a column that lacks a time."""
        if column.null_count:
            import pyarrow.compute as pc

            raise self.wrong(int(np.argmax(pc.is_null(column).to_numpy())), "")

    def wrong(self, row: int, cell: object, remedy: str = "", *, fault: str = "") -> LogError:
        """The error for a cell that is not a time, and why it is not where that is known."""
        what = f"'{'' if cell is None else shortened(cell)}' is not a time{fault and f': {fault}'}"
        example = f"{EXAMPLE}{self.places.in_line(row)}"
        return LogError(self.places.cell(self.column, row), what, remedy or f"{example}, {_OTHER_FORMAT}")
