"""Which columns of a log state its times."""

from __future__ import annotations

from pathlib import Path

from drillid.errors import LogError
from drillid.formats.column_names import column_named, listed
from drillid.formats.description import Header, LogFormat, Note, TimeColumn
from drillid.formats.kinds_of_times import counts_stamps, holds_stamps, is_time_of_day
from drillid.formats.mnemonics import date_among, key_of, milliseconds_among, parts_among, times_among
from drillid.formats.places import Places
from drillid.formats.stated_times import StatedTimes

_DEFAULT_TIME = "TIME"
"""Name of a time column that needs no note."""


def choose_times(
    reader: LogFormat, file: Path, described: TimeColumn, places: Places
) -> tuple[StatedTimes, list[Note]]:
    """The columns that state the times, by the rig description, else the format, else their names; and notes on those
    that were not stated.

    Raises
    ------
    LogError
        If a stated column is missing, or none can be identified.
    """
    header, notes = places.header, list[Note]()
    parts = () if described.column is not None or described.date is not None else _parts(header)
    if parts:
        beside = milliseconds_among(name for name in header.columns if name not in parts)
        return StatedTimes(parts[-1], None, described, places, beside, parts), [_of_parts(parts)]
    if described.column is not None:
        column = column_named(described.column, header, places.path)
    else:
        column = header.time or _time_column(reader, file, places)
        if header.time is None and key_of(column) != _DEFAULT_TIME:
            notes.append(_taken("times", column, "column"))
    date = None if described.date is None else column_named(described.date, header, places.path)
    if date is None:
        of_format = header.date if column == header.time else None
        date = of_format or _date_beside(reader, file, header, column)
        if date is not None and date != header.date:
            notes.append(_taken("dates", date, "date"))
    beside = milliseconds_among(name for name in header.columns if name not in (column, date))
    return StatedTimes(column, date, described, places, beside), notes


def _parts(header: Header) -> tuple[str, ...]:
    """Columns of the parts of times, where no other column is named like a time."""
    parts = parts_among(header.columns)
    others = [name for name in times_among(header.columns) if name not in parts]
    return () if others or (header.time is not None and header.time not in parts) else parts


def _of_parts(parts: tuple[str, ...]) -> Note:
    what = f"the times are combined from the columns {listed(parts)}"
    return what, "State time.column in the rig description if that is wrong"


def _time_column(reader: LogFormat, file: Path, places: Places) -> str:
    """The column of times by its name, one with dates before others, else the only one that holds stamps."""
    header = places.header
    named, dated = times_among(header.columns), date_among(header.columns)
    if len(named) == 1:
        return named[0]
    among = named or list(header.columns)
    cells = None if header.rows == 0 else reader.read_columns(file, header, among, among, 5)
    stamped = [] if cells is None else [name for name in among if holds_stamps(cells.column(name))]
    if named:
        counts = cells is not None and counts_stamps(cells.column(named[0]))
        return named[0] if counts or not stamped else stamped[0]
    if dated is not None and (dated in stamped or len(stamped) != 1):
        return dated
    if len(stamped) != 1:
        raise LogError(
            places.whole,
            f"has no column that is named like a time; its columns are {listed(header.columns)}",
            "State the one with the times as time.column in the rig description",
        )
    return stamped[0]


def _taken(what: str, column: str, key: str) -> Note:
    return (
        f"the {what} are taken from column '{column}'",
        f"State time.{key} in the rig description if that is wrong",
    )


def _date_beside(reader: LogFormat, file: Path, header: Header, column: str) -> str | None:
    """A column named like a date, where the column of times holds times of day only."""
    date = date_among(name for name in header.columns if name != column)
    if date is None or header.rows == 0:
        return None
    cells = reader.read_columns(file, header, [column], [column], 5).column(column)
    return date if is_time_of_day(cells) else None
