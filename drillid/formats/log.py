"""Reading rig logs of any format: checks that are the same for all of them."""

from __future__ import annotations

import errno
import glob
import os
import traceback
from collections import OrderedDict
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from drillid.arrays import Floats
from drillid.errors import DrillidError, LogError, is_of_machine
from drillid.formats.arrow_tables import notes_of
from drillid.formats.cells import numbers
from drillid.formats.choice_of_times import choose_times
from drillid.formats.column_names import column_named, listed
from drillid.formats.continued import Continuing, as_one, names_of, overlap
from drillid.formats.description import Dialect, Header, LogFormat, Note, TimeColumn, Unusable
from drillid.formats.detection import reader_of, suffix_of
from drillid.formats.long_form import noted
from drillid.formats.mnemonics import split_unit, time_among
from drillid.formats.packing import unpacked_file
from drillid.formats.places import Places, first_line
from drillid.formats.remote import local_file, url_of
from drillid.formats.repeated_names import check_repeated_times, first_of_repeated
from drillid.formats.stamps import utc_stamps
from drillid.formats.stated_times import StatedTimes
from drillid.formats.time_columns import Stamps
from drillid.formats.times_of_day import may_count_otherwise

if TYPE_CHECKING:
    from numpy.typing import NDArray

_ROWS_OF_START = 1000
"""Rows among which a log's earliest time stamp is sought."""
_SHORT_OF_MEMORY = (os.strerror(errno.ENOMEM), os.strerror(errno.EAGAIN))
"""Messages of libraries that cannot get memory, or a thread with its stack, in errors of their own."""
PLAIN = Dialect()


@dataclass
class Log:
    """A rig log in memory; its columns are popped one by one, so that none is held twice.

    stamps : UTC without zone, ns, shape (row,), in the file's order
    units : units by the columns' names, where the file states them
    notes : decisions that were taken while reading; those on a column's cells are added as it is popped
    times : columns that state the times
    """

    path: Path
    stamps: NDArray[np.datetime64]
    units: dict[str, str]
    notes: list[Note]
    times: tuple[str, ...]
    _table: Any
    _places: Places
    _nulls: tuple[float, ...]

    def pop(self, name: str) -> Floats:
        """Remove a column from the log and return it in the file's units, NaN for missing values, shape (row,).

        Raises
        ------
        LogError
            If a cell is not a number; the message names file, column and row.
        """
        column = column_named(name, self._places.header, self.path)
        nulls = (*self._places.header.nulls.get(column, ()), *self._nulls)
        values, notes = numbers(self._places, column, self._table.column(column), nulls)
        self.notes += notes
        self._table = self._table.drop_columns([column])
        _release_memory()
        return values


def read_log(
    path: Path, time: str | TimeColumn | None, columns: Sequence[str], zone: str = "UTC", dialect: Dialect = PLAIN
) -> Log:
    """Read the time column and some numeric columns of a rig log.

    Parameters
    ----------
    path : the log, or its URL
    time : its time column, or the name of that column
    columns : names of the numeric columns
    zone : time zone of stamps without one, where `time` is a name
    dialect : how the file is laid out

    Raises
    ------
    LogError
        If the file cannot be read, lacks a column, holds no rows, or holds an invalid time
        stamp; the message names file, column and row.
    """
    described = time if isinstance(time, TimeColumn) else TimeColumn(time, zone=zone)
    with _reading(path) as (reader, file, notes):
        header = _table_of(path, _headers(path, file, reader, dialect), columns)
        places = Places(path, header, _line_of)
        times, decided = choose_times(reader, file, described, places)
        wanted = [column_named(name, header, path) for name in columns]
        table = _columns(path, file, reader, header, times, wanted, None)
        stamps, read = utc_stamps(times, table)
        check_repeated_times(times, wanted, lambda names: reader.read_columns(file, header, names, names))
        if overlap(table, stamps):
            raise _several(path, names_of(header), columns)
        left_out = notes_of(table) if reader.LEAVES_ROWS_OUT else []
    table = table.drop_columns([name for name in times.columns if name not in wanted])
    _release_memory()
    units = {name: header.units[column] for name, column in zip(columns, wanted, strict=True) if column in header.units}
    said = [*notes, *header.notes, *first_of_repeated(columns, header), *decided, *read, *left_out]
    return Log(path, stamps, units, said, times.columns, table, places, dialect.null_values)


def first_stamp(
    path: Path,
    time: str | TimeColumn | None,
    zone: str = "UTC",
    dialect: Dialect = PLAIN,
    columns: Sequence[str] = (),
) -> np.datetime64:
    """Earliest of a log's first time stamps, by which logs are sorted; more of the log is read only where needed.

    Parameters
    ----------
    columns : names by which the table is chosen; the others as of `read_log`

    Raises
    ------
    LogError
        As `read_log`.
    """
    described = time if isinstance(time, TimeColumn) else TimeColumn(time, zone=zone)
    with _reading(path) as (reader, file, _):
        header = _table_of(path, _headers(path, file, reader, dialect), columns)
        times, _ = choose_times(reader, file, described, Places(path, header, _line_of))
        try:
            found = _earliest_of_some(times, _columns(path, file, reader, header, times, [], _ROWS_OF_START))
        except LogError:
            found = None
        if found is None:
            # what the first rows leave open, such as the order of day and month, later rows may show
            found = _earliest(times, _columns(path, file, reader, header, times, [], None))
        return found


def headers(path: Path, dialect: Dialect = PLAIN) -> list[Header]:
    """Columns of each table of a log file, with their units; no row is read.

    Raises
    ------
    LogError
        If the file cannot be read or holds no table.
    """
    with _reading(path) as (reader, file, _):
        return _headers(path, file, reader, dialect)


def table_with(path: Path, columns: Sequence[str], dialect: Dialect = PLAIN) -> Header:
    """The table of a log file that holds most of some columns.

    Raises
    ------
    LogError
        As `headers`.
    """
    return _table_of(path, headers(path, dialect), columns)


def _line_of(path: Path, header: Header, row: int) -> int:
    """Line of a row in the file as it is now, packed or remote; 0 for formats without lines."""
    with _reading(path) as (reader, file, _):
        return reader.line_of(file, header, row)


@contextmanager
def _reading(path: Path) -> Iterator[tuple[Continuing, Path, tuple[Note, ...]]]:
    """The reader of a log and a file that it can read; whatever goes wrong in it becomes a `LogError`."""
    where = url_of(path) or str(path)
    try:
        with local_file(path) as local:
            reader, notes = reader_of(local)
            with unpacked_file(local, suffix_of(local), getattr(reader, "STREAMS", False)) as file:
                yield Continuing(reader), file, notes
    except (DrillidError, MemoryError, ConnectionError):
        raise
    except Unusable as error:
        raise LogError(where, error.what, error.remedy) from error
    except FileNotFoundError as error:
        if glob.has_magic(where) and url_of(path) is None:
            raise LogError(where, "matches no file", "Correct the pattern, or wait for the first log") from error
        raise LogError(where, "does not exist", "Correct its path") from error
    except IsADirectoryError as error:
        raise LogError(where, "is a folder, not a log file", "Name the files in it") from error
    except PermissionError as error:
        raise LogError(where, "is not readable", "Ask for permission to read it; the next run tries again") from error
    except Exception as error:
        if not isinstance(error, OSError | ValueError | EOFError) and not _of_a_library(error):
            raise
        if any(words in str(error) for words in _SHORT_OF_MEMORY):
            raise MemoryError(str(error)) from error
        if getattr(error, "errno", None) == errno.ENAMETOOLONG:
            raise LogError(where, "is longer than the name of a file may be", "Correct its path") from error
        remedy = "Export the log again; the file may be cut short or damaged"
        if is_of_machine(error):
            remedy = "Check the disk or share that it lies on; the next run tries again"
        raise LogError(where, f"cannot be read ({first_line(error)})", remedy) from error


_KNOWN: OrderedDict[tuple[Any, ...], list[Header]] = OrderedDict()
_MOST_KNOWN = 64
"""Number of headers kept while logs are sorted, checked and read, as finding them may take a pass over the file."""


def _of_a_library(error: Exception) -> bool:
    """Whether an error was raised outside this package: libraries raise whatever they meet in damaged files."""
    frames = traceback.extract_tb(error.__traceback__)
    return not Path(frames[-1].filename).is_relative_to(Path(__file__).parent)


def _headers(path: Path, file: Path, reader: LogFormat, dialect: Dialect) -> list[Header]:
    """The tables of a log, or the stated one of them."""
    key = (path, dialect, *_version(path))
    if key not in _KNOWN or path.is_dir():
        _KNOWN[key] = _read_headers(path, file, reader, dialect)
        while len(_KNOWN) > _MOST_KNOWN:
            _KNOWN.popitem(last=False)
    return _KNOWN[key]


def _version(path: Path) -> tuple[int, int]:
    """What changes when a file does; for a remote file, its local copy is examined instead."""
    with local_file(path) as local:
        status = local.stat()
    return status.st_size, status.st_mtime_ns


def _read_headers(path: Path, file: Path, reader: LogFormat, dialect: Dialect) -> list[Header]:
    if file.is_file() and not file.stat().st_size:
        raise LogError(str(path), "is empty", "Export the log again, or take it out of the logs sheet")
    found = [noted(header) for header in reader.headers(file, dialect)]
    if not found:
        raise LogError(str(path), "is empty", "Export the log again, or take it out of the logs sheet")
    if dialect.table is None:
        return found
    chosen = [header for header in found if header.table == dialect.table]
    if not chosen:
        what = f"has no table '{dialect.table}'; its tables are {listed([header.table for header in found])}"
        raise LogError(str(path), what, "Correct file.table in the rig description")
    return chosen


def _table_of(path: Path, found: list[Header], columns: Sequence[str]) -> Header:
    """The table that holds all wanted columns, several of the same columns as one, else that with most of them.

    Raises
    ------
    LogError
        If several hold all of them and differ in more than their rows.
    """
    if len(found) == 1:
        return found[0]

    def held(header: Header) -> int:
        names = {split_unit(name)[0].casefold() for name in header.columns} | set(header.columns)
        return sum(name in names or split_unit(name)[0].casefold() in names for name in columns)

    ranked = sorted(found, key=lambda header: (-held(header), -_likely_log(header)))
    alike = [each for each in found if held(each) == len(columns) and _has_times(each) == _has_times(ranked[0])]
    if len(alike) <= 1 or not columns:
        return ranked[0]
    one = as_one(alike)
    if one is None:
        raise _several(path, [each.table for each in alike], columns)
    return one


def _several(path: Path, tables: Sequence[str], columns: Sequence[str]) -> LogError:
    what = f"its tables {listed(tables)} all hold the columns {listed(columns)}"
    return LogError(str(path), what, "State the one to read as file.table in the rig description")


def _likely_log(header: Header) -> int:
    """How much a table looks like a log: it has times, and many columns."""
    return 1000 * _has_times(header) + len(header.columns)


def _has_times(header: Header) -> bool:
    return header.time is not None or time_among(header.columns) is not None


def _columns(
    path: Path, file: Path, reader: LogFormat, header: Header, times: StatedTimes, columns: list[str], rows: int | None
) -> Any:
    wanted = list(dict.fromkeys([*times.columns, *columns]))
    table = None if header.rows == 0 else reader.read_columns(file, header, wanted, times.columns, rows)
    if table is None or table.num_rows == 0:
        raise LogError(str(path), "holds no rows", "Export the log again, or take it out of the logs sheet")
    return table


def _earliest_of_some(times: StatedTimes, table: Any) -> np.datetime64 | None:
    """Earliest stamp of some rows; None where the log's other rows may show that all are to be read otherwise."""
    return None if may_count_otherwise(times, table.column(times.column)) else _earliest(times, table)


def _earliest(times: StatedTimes, table: Any) -> np.datetime64:
    stamps: Stamps = utc_stamps(times, table, ambiguous=True)[0]
    return np.datetime64(np.min(stamps))


def _release_memory() -> None:
    """Release the memory that Arrow keeps for later use; numpy needs it."""
    import pyarrow as pa

    pa.default_memory_pool().release_unused()
