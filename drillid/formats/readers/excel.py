"""Workbooks: xlsx, xlsb, xls and ods."""

from __future__ import annotations

import contextlib
import datetime
import os
import re
import zipfile
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from drillid.formats.arrow_tables import with_notes
from drillid.formats.description import Dialect, Header, Note, Unusable
from drillid.formats.header_rows import HeaderRows, find_header, where_names_are
from drillid.formats.numbers_in_text import with_numbers
from drillid.formats.packing import check_archive, first_bytes
from drillid.formats.repeated_headers import check_header
from drillid.formats.rows_without_data import WithoutData, rows_without_data

SUFFIXES = (".xlsx", ".xls", ".xlsm", ".xlsb", ".ods")
LEAVES_ROWS_OUT = True
_SAMPLE_ROWS = 200
_WORKBOOK = "xl/workbook.xml"
_DAYS_TO_1904 = 1462
"""Days to 1904-01-01 in workbooks that count from 1900."""
_FIRST_DAY, _LAST_DAY = 31412, 53327
"""Days from 1904 to 1990 and to 2050."""
_LONGEST_STEP_DAYS = 0.005
_OF_THE_SYSTEM = re.compile(r"\(os error (\d+)\)")
_NO_REMEDY = "None needed if that is right; otherwise save the workbook with days from 1900"
_EPOCH = datetime.datetime(1970, 1, 1)


@dataclass(frozen=True)
class _Layout:
    """Where the data of a table are.

    sheet : its name
    top : first row with content, counted from 0
    header : names, units and the first row of data, counted from `top`
    above : cells of the rows above the data
    since_1904 : whether days count from 1904 and not from 1900
    """

    sheet: str
    top: int
    header: HeaderRows
    above: frozenset[tuple[str, ...]]
    since_1904: bool


def _workbook(path: Path) -> Any:
    import python_calamine

    if first_bytes(path, 2) == b"PK":
        check_archive(path)
    with _damage():
        return python_calamine.CalamineWorkbook.from_path(path)


@contextlib.contextmanager
def _damage() -> Iterator[None]:
    """Errors of the library, whose panics are not an `Exception`, become `ValueError`.

    Those of the system, whose numbers are in the library's messages alone, become `OSError` with the number.
    """
    import python_calamine

    try:
        yield
    except (python_calamine.CalamineError, OSError) as error:
        if number := _OF_THE_SYSTEM.search(str(error)):
            raise OSError(int(number[1]), os.strerror(int(number[1]))) from error
        raise ValueError(str(error)) from error
    except BaseException as error:
        if type(error).__name__ != "PanicException":
            raise
        raise ValueError(f"the library that reads it failed: {error}") from error


def headers(path: Path, dialect: Dialect) -> list[Header]:
    """A table for each sheet with rows of data.

    Raises
    ------
    ValueError
        If it is not a workbook, or no sheet has a header.
    """
    workbook = _workbook(path)
    since_1904 = _is_since_1904(path)
    found, nameless = [], []
    for sheet in workbook.sheet_names:
        if dialect.table not in (None, sheet):
            continue
        rows, top = _rows(workbook, sheet, _SAMPLE_ROWS)
        if not rows:
            continue
        cells = [[_as_text(cell) for cell in row] for row in rows]
        header = find_header(
            cells,
            _row_of(dialect.header_line, top, len(rows), "header_line"),
            _row_of(dialect.units_line, top, len(rows), "units_line"),
        )
        if header is None or len(header.names) < 2:
            nameless.append(sheet)
            continue
        notes = tuple(where_names_are(header, lambda row, top=top: top + row + 1, dialect))  # type: ignore[misc]
        layout = _Layout(sheet, top, header, frozenset(map(tuple, cells[: header.first])), since_1904)
        found.append(Header(header.names, header.units, table=sheet, layout=layout, notes=notes))
    if not found and nameless:
        raise Unusable(
            f"has no row with the names of the columns in its sheet '{nameless[0]}'",
            "State the number of that row in the rig description as file.header_line",
        )
    return found


def _is_since_1904(path: Path) -> bool:
    """Whether a workbook of Office Open XML counts days from 1904, as those begun on old Macintoshes do."""
    from defusedxml import ElementTree

    if first_bytes(path, 2) != b"PK":
        return False
    with zipfile.ZipFile(path) as archive:
        if _WORKBOOK not in archive.namelist():
            return False
        with archive.open(_WORKBOOK) as content:
            properties = ElementTree.parse(content).getroot().find("{*}workbookPr")
    return properties is not None and properties.get("date1904", "0") in ("1", "true", "on")


def _row_of(line: int | None, top: int, count: int, key: str) -> int | None:
    """Index of a stated row among those with content."""
    if line is not None and not 0 <= line - 1 - top < count:
        what = f"has nothing in row {line}, which the rig description states as file.{key}"
        raise Unusable(what, f"Correct file.{key}")
    return None if line is None else line - 1 - top


def read_columns(
    path: Path, header: Header, columns: Sequence[str], text: Sequence[str], rows: int | None = None
) -> Any:
    """The columns as an Arrow table; a numeric column with a cell that is not a number stays text."""
    import pyarrow as pa

    layout: _Layout = header.layout
    limit = None if rows is None else layout.header.first + rows
    rows_of = _held(_rows(_workbook(path), layout.sheet, limit)[0], layout)
    found = _without_data(rows_of, layout, [header.columns.index(name) for name in text])
    left_out = set(found.rows if found.credible else [])
    data = [row for at, row in rows_of if at not in left_out]
    places = [header.columns.index(name) for name in columns]
    arrays, notes = {}, list[Note]()
    for name, at in zip(columns, places, strict=True):
        cells = [row[at] if at < len(row) else "" for row in data]
        if name in text and layout.since_1904 and _are_days(cells):
            cells = ["" if cell == "" else float(cell) + _DAYS_TO_1904 for cell in cells]
            notes.append((f"the days in column '{name}' count from 1904, as the workbook states", _NO_REMEDY))
        arrays[name] = _times(cells) if name in text else _numbers(cells)
    numeric = [name for name in columns if name not in text and pa.types.is_string(arrays[name].type)]
    table = with_numbers(pa.table(arrays), numeric, None, None, ";") if numeric else pa.table(arrays)
    notes += found.notes(lambda at: f"row {layout.top + at + 1}") if left_out else []
    return with_notes(table, notes)


def line_of(path: Path, header: Header, row: int) -> int:
    """Number of the sheet's row, counted from 1, that holds a row of data."""
    layout: _Layout = header.layout
    held = _held(_rows(_workbook(path), layout.sheet, None)[0], layout)
    found = _without_data(held, layout, [])
    left_out = set(found.rows if found.credible else [])
    kept = [at for at, _ in held if at not in left_out]
    return layout.top + kept[row] + 1 if row < len(kept) else 0


def _held(rows: list[list[Any]], layout: _Layout) -> list[tuple[int, list[Any]]]:
    """Non-empty rows behind the header, and their places."""
    return [
        (at, cells) for at, cells in enumerate(rows) if at >= layout.header.first and any(cell != "" for cell in cells)
    ]


def _without_data(rows: list[tuple[int, list[Any]]], layout: _Layout, times: Sequence[int]) -> WithoutData:
    if times and all(at < len(cells) and not isinstance(cells[at], str) for _, cells in rows for at in times):
        return WithoutData((), (), len(rows))
    as_text = ((at, [_as_text(cell) for cell in cells], True) for at, cells in rows)

    def check(row: int, cells: Sequence[str]) -> None:
        check_header(layout.header, cells, f"row {layout.top + row + 1} of sheet '{layout.sheet}'")

    return rows_without_data(as_text, layout.above, times, check)


def _rows(workbook: Any, sheet: str, limit: int | None) -> tuple[list[list[Any]], int]:
    """Cells of a sheet from its first row with content on, and the number of empty rows before that."""
    with _damage():
        found = workbook.get_sheet_by_name(sheet)
        top = found.start[0] if found.start else 0
        rows: list[list[Any]] = found.to_python(skip_empty_area=True, nrows=limit)
    return rows, int(top)


def _as_text(cell: Any) -> str:
    return str(cell).strip()


def _numbers(cells: list[Any]) -> Any:
    """Cells as float64, or as text where one is not a number."""
    import pyarrow as pa

    if all(isinstance(cell, int | float) or cell == "" for cell in cells):
        return pa.array([None if cell == "" else float(cell) for cell in cells], pa.float64())
    return pa.array([None if cell == "" else str(cell) for cell in cells], pa.string())


def _times(cells: list[Any]) -> Any:
    """Cells of a column of times: times, times of day, numbers or text."""
    import pyarrow as pa

    held = [cell for cell in cells if cell != ""]
    if held and all(isinstance(cell, datetime.datetime | datetime.date) for cell in held):
        return pa.array([_microseconds(cell) for cell in cells], pa.int64()).cast(pa.timestamp("us"))
    if held and all(isinstance(cell, datetime.time) for cell in held):
        return pa.array([None if cell == "" else cell for cell in cells], pa.time64("us"))
    if held and all(isinstance(cell, datetime.timedelta) for cell in held):
        return pa.array([None if cell == "" else cell for cell in cells], pa.duration("us"))
    if held and all(isinstance(cell, int | float) for cell in held):
        return pa.array([None if cell == "" else float(cell) for cell in cells], pa.float64())
    return pa.array([None if cell == "" else str(cell) for cell in cells], pa.string())


def _are_days(cells: list[Any]) -> bool:
    """Whether cells of a workbook that counts from 1904 are days in the years 1990 to 2050, not seconds or the like."""
    if not all(isinstance(cell, int | float) or cell == "" for cell in cells):
        return False
    days = np.array([cell for cell in cells if cell != ""], dtype=float)
    if not np.all((days > _FIRST_DAY) & (days < _LAST_DAY)):
        return False
    return days.size < 2 or float(np.median(np.abs(np.diff(days)))) < _LONGEST_STEP_DAYS


def _microseconds(cell: Any) -> int | None:
    if cell == "":
        return None
    whole = cell if isinstance(cell, datetime.datetime) else datetime.datetime.combine(cell, datetime.time())
    return (whole - _EPOCH) // datetime.timedelta(microseconds=1)
