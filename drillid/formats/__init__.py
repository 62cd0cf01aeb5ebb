"""Rig logs of any file format behind one function.

A format is one module of this package with three members: `SUFFIXES`, the file name endings that it
reads; `header(path)`, the names of the file's columns; and `read_columns(path, columns, text, rows)`,
which returns those columns as an Arrow table, the ones in `text` unchanged and the others as float64
where possible, limited to the first `rows` rows where that is given. They raise `FileNotFoundError` or
any other `OSError`, or `ValueError` with the reason. Everything else (a missing column, text among the
numbers, invalid time stamps) is checked here, once for all formats.
"""

from __future__ import annotations

import difflib
import importlib
import pkgutil
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np
import pandas as pd

from drillid.arrays import Floats
from drillid.errors import LogError

if TYPE_CHECKING:
    from numpy.typing import NDArray

_NULL_VALUES = (-999.25, -9999.0)
"""Numbers that drilling recorders write for missing values."""
_ROWS_OF_START = 1000
"""Rows among which a log's earliest time stamp is sought."""
_FIRST_ROW = 1
"""Rows are counted from 1, without the header."""


class LogFormat(Protocol):
    """Interface of a module of this package."""

    SUFFIXES: tuple[str, ...]

    def header(self, path: Path) -> list[str]:
        """Names of the file's columns."""
        ...

    def read_columns(self, path: Path, columns: Sequence[str], text: Sequence[str], rows: int | None = None) -> Any:
        """The columns as an Arrow table, those in `text` unchanged and the others as float64 where possible."""
        ...


@dataclass
class Log:
    """A rig log in memory; its columns are popped one by one, so that none is held twice.

    stamps : UTC without zone, ns, shape (row,), in the file's order
    """

    path: Path
    stamps: NDArray[np.datetime64]
    _table: Any

    def pop(self, name: str) -> Floats:
        """Remove a column from the log and return it in the file's units, NaN for missing values, shape (row,).

        Raises
        ------
        LogError
            If a cell is not a number; the message names file, column and row.
        """
        values = _numbers(self.path, name, self._table.column(name))
        self._table = self._table.drop_columns([name])
        _release_memory()
        return values


def formats() -> dict[str, LogFormat]:
    """Every format of this package by the file name endings that it reads."""
    by_suffix: dict[str, LogFormat] = {}
    for module in pkgutil.iter_modules(__path__):
        reader: Any = importlib.import_module(f"{__name__}.{module.name}")
        by_suffix |= dict.fromkeys(reader.SUFFIXES, reader)
    return by_suffix


def format_of(path: Path) -> LogFormat:
    """The format that reads a file of this name; of several matching endings the longest wins."""
    by_suffix = formats()
    matching = [suffix for suffix in by_suffix if path.name.lower().endswith(suffix)]
    if not matching:
        raise LogError(str(path), "is of no known format", f"Known endings are {', '.join(sorted(by_suffix))}")
    return by_suffix[max(matching, key=len)]


def read_log(path: Path, time: str, columns: Sequence[str], zone: str = "UTC") -> Log:
    """Read the time column and some numeric columns of a rig log.

    Parameters
    ----------
    path : the log
    time : name of its time column
    columns : names of the numeric columns
    zone : time zone of stamps without one

    Raises
    ------
    LogError
        If the file cannot be read, lacks a column, holds no rows, or holds an invalid time
        stamp; the message names file, column and row.
    """
    table = _read(path, time, columns, None)
    stamps = _stamps(path, time, table.column(time), zone)
    table = table.drop_columns([time])
    _release_memory()
    return Log(path, stamps, table)


def _release_memory() -> None:
    """Release the memory that Arrow keeps for later use; numpy needs it."""
    import pyarrow as pa

    pa.default_memory_pool().release_unused()


def first_stamp(path: Path, time: str, zone: str = "UTC") -> np.datetime64:
    """Earliest of a log's first time stamps, by which logs are sorted; the rest of the log is not read.

    Raises
    ------
    LogError
        As `read_log`.
    """
    table = _read(path, time, [], _ROWS_OF_START)
    return np.datetime64(np.min(_stamps(path, time, table.column(time), zone, ambiguous=True)))


def _read(path: Path, time: str, columns: Sequence[str], rows: int | None) -> Any:
    reader, wanted = format_of(path), list(dict.fromkeys([time, *columns]))
    try:
        header = reader.header(path) if path.stat().st_size else []
        if not header:
            raise LogError(str(path), "is empty", "Export the log again, or take it out of the logs sheet")
        _check_columns(path, wanted, header)
        table = reader.read_columns(path, wanted, [time], rows)
    except FileNotFoundError as error:
        raise LogError(str(path), "does not exist", "Check the path in the logs sheet") from error
    except (OSError, EOFError, ValueError) as error:
        raise LogError(
            str(path),
            f"cannot be read ({_first_line(error)})",
            "Export the log again; the file may be cut short or damaged",
        ) from error
    if table.num_rows == 0:
        raise LogError(str(path), "holds no rows", "Export the log again, or take it out of the logs sheet")
    return table


def _check_columns(path: Path, wanted: list[str], header: list[str]) -> None:
    for name in wanted:
        if name not in header:
            close = difflib.get_close_matches(name, header, n=1)
            hint = f"Did you mean '{close[0]}'?" if close else "Name one of them in the rig description"
            existing = ", ".join(f"'{column}'" for column in header) or "none"
            raise LogError(str(path), f"has no column '{name}'; its columns are {existing}", hint)


def _numbers(path: Path, name: str, column: Any) -> Floats:
    """Cells as floats, the recorders' null values as NaN."""
    import pyarrow as pa

    if column.type == pa.float64():
        values = np.require(column.to_numpy(), dtype=np.float64, requirements=["W"])
    else:
        cells = column.to_pandas()
        numbers = pd.to_numeric(cells, errors="coerce")
        wrong = np.flatnonzero(numbers.isna() & cells.notna() & (cells.astype(str).str.strip() != ""))
        if wrong.size:
            row = int(wrong[0])
            raise LogError(
                f"{path}, column '{name}', row {row + _FIRST_ROW}",
                f"'{cells.iloc[row]}' is not a number",
                "Correct the cell, or leave it empty where there is no value",
            )
        values = numbers.to_numpy(dtype=np.float64, copy=True)
    for null in (*_NULL_VALUES, np.inf, -np.inf):
        values[values == null] = np.nan
    return values


def _stamps(path: Path, name: str, column: Any, zone: str, ambiguous: bool | None = None) -> NDArray[np.datetime64]:
    """Stamps as UTC without zone, ns; of a repeated hour as `ambiguous` gives it, or inferred from the order."""
    zoned = _zoned_stamps(column)
    if zoned is not None:
        return zoned
    cells = column.to_pandas()
    if pd.api.types.is_numeric_dtype(cells.dtype):
        raise _invalid_time(path, name, 0, cells.iloc[0])
    aware = pd.to_datetime(
        cells, errors="coerce", format=None if _is_time(cells) else "ISO8601", utc=_mixed_or_aware(cells)
    )
    wrong = np.flatnonzero(aware.isna())
    if wrong.size:
        raise _invalid_time(path, name, int(wrong[0]), cells.iloc[int(wrong[0])])
    if aware.dt.tz is None:
        aware = _localised(path, name, aware, zone, ambiguous)
    return np.asarray(aware.dt.tz_convert("UTC").dt.tz_localize(None).to_numpy(), dtype="datetime64[ns]")


def _zoned_stamps(column: Any) -> NDArray[np.datetime64] | None:
    """The same for a column whose stamps all have a zone, in a fraction of the memory; None for any other."""
    import pyarrow as pa

    zoned_text = pa.types.is_string(column.type) and str(column[0]).endswith("Z")
    if column.null_count or not (zoned_text or (pa.types.is_timestamp(column.type) and column.type.tz)):
        return None
    try:
        whole = column.cast(pa.timestamp("ns", "UTC")).cast(pa.int64())
    except pa.ArrowInvalid:
        return None
    return np.asarray(whole.to_numpy()).view("datetime64[ns]")


def _is_time(cells: pd.Series[Any]) -> bool:
    return pd.api.types.is_datetime64_any_dtype(cells.dtype)


def _mixed_or_aware(cells: pd.Series[Any]) -> bool:
    """Whether stamps given as text have a zone: a Z, or an offset such as +01:00, at their end."""
    return not _is_time(cells) and bool(cells.astype(str).str.contains(r"(?:Z|[+-]\d\d:?\d\d)$", regex=True).all())


def _localised(path: Path, name: str, naive: pd.Series[Any], zone: str, ambiguous: bool | None) -> pd.Series[Any]:
    rule = "infer" if ambiguous is None else np.full(len(naive), ambiguous)
    try:
        localised: pd.Series[Any] = naive.dt.tz_localize(zone, ambiguous=rule)
    except (ValueError, KeyError) as error:
        raise LogError(
            f"{path}, column '{name}'",
            f"the stamps cannot be placed in the time zone '{zone}' ({_first_line(error)})",
            "Correct the zone in the rig description, or log in UTC",
        ) from error
    return localised


def _invalid_time(path: Path, name: str, row: int, cell: object) -> LogError:
    return LogError(
        f"{path}, column '{name}', row {row + _FIRST_ROW}",
        f"'{cell}' is not a time",
        "Write time stamps such as 2025-03-03T06:00:00.020Z",
    )


def _first_line(error: Exception) -> str:
    return (str(error) or type(error).__name__).splitlines()[0].rstrip(".")
