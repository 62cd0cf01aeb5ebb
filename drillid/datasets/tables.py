"""Tables for people as CSV files, safe to open in a spreadsheet.

A spreadsheet runs a cell that begins with =, +, - or @ as a formula. Such a text gets an apostrophe in front of it, by
which spreadsheets know a text; it is taken away again when the table is read here. Numbers stay numbers.
"""

from __future__ import annotations

import os
import re
from pathlib import Path
from typing import Any, TextIO

import pandas as pd

_FORMULA = re.compile(r"'*[=+\-@\t\n\uff1d\uff0b\uff0d\uff20]")
_HARMLESS = re.compile(r"[+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?|-+|\+")
"""Plain numbers, and dashes that stand for nothing."""


def write_table(table: pd.DataFrame, path: str | Path) -> None:
    """Write a table whole or not at all, its texts escaped."""
    path = Path(path)
    escaped = table.assign(**{str(name): column.map(_escaped) for name, column in table.items() if _holds_text(column)})
    path.parent.mkdir(parents=True, exist_ok=True)
    temporary = path.with_name(f"{path.name}.part")
    escaped.to_csv(temporary, index=False)
    os.replace(temporary, path)


def read_table(path: str | Path | TextIO, **options: Any) -> pd.DataFrame:
    """Read a table that `write_table` has written; `options` are those of `pandas.read_csv`.

    Raises
    ------
    FileNotFoundError
        If there is none.
    ValueError
        If the file is no table.
    """
    # a row whose only cell is a space is no blank line
    given: dict[str, Any] = {"skip_blank_lines": False} | options
    table: pd.DataFrame = pd.read_csv(path, **given)
    return table.assign(**{str(name): column.map(_plain) for name, column in table.items() if _holds_text(column)})


def _holds_text(column: pd.Series[Any]) -> bool:
    return not pd.api.types.is_numeric_dtype(column.dtype) and not pd.api.types.is_datetime64_any_dtype(column.dtype)


def _escaped(cell: Any) -> Any:
    """The cell with an apostrophe where a spreadsheet would take it for a formula; carriage returns become spaces."""
    if not isinstance(cell, str):
        return cell
    text = cell.replace("\r", " ")
    return f"'{text}" if _FORMULA.match(text) and not _HARMLESS.fullmatch(text) else text


def _plain(cell: Any) -> Any:
    """The cell as it was before it was escaped."""
    return cell[1:] if isinstance(cell, str) and cell.startswith("'") and _FORMULA.match(cell) else cell
