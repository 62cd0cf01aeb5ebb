"""What a user may state about log files, and what a reader finds in one of them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Protocol

import numpy as np

Note = tuple[str, str]
"""A decision that was taken while reading a log, and what to do where it is wrong."""


@dataclass(frozen=True)
class TimeColumn:
    """How a log states the time of its rows; where None, it is taken from the file if that is unambiguous.

    column : name of the column of times
    date : name of the column of dates, where they stand apart from the times of day
    zone : time zone of stamps without one
    format : strptime format of written times, or 'day first' or 'month first'
    unit : unit of times that are numbers, one of `COUNTED`
    start : ISO time that seconds, minutes and the like are counted from, or the date of times of day; in `zone` where
        it names no zone itself
    """

    column: str | None = None
    date: str | None = None
    zone: str = "UTC"
    format: str | None = None
    unit: str | None = None
    start: str | None = None


@dataclass(frozen=True)
class Dialect:
    """How a file is laid out; where None, it is found from the file.

    delimiter : character between the columns of a text file; ' ' for any number of spaces
    decimal : character before the decimals
    thousands : character between thousands
    encoding : of a text file
    comment : characters that begin lines without data
    header_line, units_line : lines of the names and of the units, counted from 1, of a text file or sheet
    columns : names of the columns of a file without a header
    table : sheet, group, data set or log of a file that holds several
    null_values : further numbers that stand for missing values
    """

    delimiter: str | None = None
    decimal: str | None = None
    thousands: str | None = None
    encoding: str | None = None
    comment: str | None = None
    header_line: int | None = None
    units_line: int | None = None
    columns: tuple[str, ...] = ()
    table: str | None = None
    null_values: tuple[float, ...] = ()


@dataclass(frozen=True)
class Header:
    """Columns of one table of a log file.

    columns : names, in the file's order, each once
    units : units by the columns' names, where the file states them
    table : name of the table where the file has several, else empty
    time : column of times, where the format itself says which that is
    date : column of dates that belongs to `time`, where the format itself says so
    start : time from which the column `time` counts, where the file states it
    start_is_utc : whether that is UTC; else it is in the zone of the rig's clock
    start_offset : offset from UTC of the zone in which the file writes the start, ns
    nulls : numbers that the file itself states as missing values, by column
    layout : what the reader keeps for `read_columns`
    notes : decisions that were taken
    rows : number of rows, where it is known without reading them
    aliases : columns by the other names that the file states for them
    """

    columns: tuple[str, ...]
    units: dict[str, str] = field(default_factory=dict)
    table: str = ""
    time: str | None = None
    date: str | None = None
    start: np.datetime64 | None = None
    start_is_utc: bool = False
    start_offset: int = 0
    nulls: Mapping[str, tuple[float, ...]] = field(default_factory=dict)
    layout: Any = None
    notes: tuple[Note, ...] = ()
    rows: int | None = None
    aliases: dict[str, str] = field(default_factory=dict)


class Unusable(ValueError):
    """A sound file that cannot be used as a log, or not yet: what is wrong, and the remedy."""

    def __init__(self, what: str, remedy: str) -> None:
        self.what, self.remedy = what, remedy
        super().__init__(what, remedy)


class LogFormat(Protocol):
    """Interface of a module of `drillid.formats.readers`."""

    SUFFIXES: tuple[str, ...]
    """Endings of the names of its files."""

    def headers(self, path: Path, dialect: Dialect) -> list[Header]:
        """Header of each table of the file."""
        ...

    def read_columns(
        self, path: Path, header: Header, columns: Sequence[str], text: Sequence[str], rows: int | None = None
    ) -> Any:
        """Columns as an Arrow table, those in `text` unchanged, the others as float64 where possible."""
        ...
