"""Rows of a sheet as people write it: text with tabs, comments and the quotes of Excel."""

import difflib
import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Generic, TypeVar

from drillid.config.files import read_text
from drillid.config.validation import Strict
from drillid.errors import SettingsError

Content = TypeVar("Content", bound=Strict)
_OPTIONAL = {"section", "tool", "folder", "fitted"}
"""Columns that a sheet need not have, beside the description."""
_LARGEST_BYTES = 100_000_000
"""Of a sheet; one of 10,000 wells with a log a day for a year has as many, and more are no sheet."""
_SEPARATORS = {",": "commas", ";": "semicolons"}


@dataclass(frozen=True)
class SheetRow(Generic[Content]):
    """One row of a sheet, of which either `content` or `fault` is there.

    where : sheet and row, for messages
    cells : by column, as they are written
    content : the row where it validates
    fault : why it does not
    """

    where: str
    cells: Mapping[str, str]
    content: Content | None = None
    fault: SettingsError | None = None


def sheet_rows(path: Path, model: type[Content]) -> Iterator[SheetRow[Content]]:
    """The sheet's rows; blank lines and lines that begin with '#' are skipped.

    Raises
    ------
    SettingsError
        If the sheet as a whole cannot be used: it cannot be read, has no header, other columns or other separators.
    """
    # other separators, as of a text processor, belong to their cells
    lines = re.split(r"\r\n|\n|\r", read_text(path, _LARGEST_BYTES))
    used = [number for number, line in enumerate(lines, 1) if line.strip() and not line.startswith("#")]
    if not used:
        header = "\t".join(name for name in model.model_fields if name not in _OPTIONAL)
        raise SettingsError(str(path), "has no header", f"Begin the sheet with the line '{header}', separated by tabs")
    _check_separator(path, lines[used[0] - 1])
    columns = _cells(lines[used[0] - 1])
    _check_columns(path, columns, model)
    for number in used[1:]:
        yield _row(f"{path}, row {number}", columns, lines[number - 1], model)


def _row(where: str, columns: Sequence[str], line: str, model: type[Content]) -> SheetRow[Content]:
    cells = _cells(line)
    named = dict.fromkeys(columns, "") | dict(zip(columns, cells, strict=False))
    if _is_broken(line.split("\t")[-1].strip()):
        fault = SettingsError(where, "holds a cell with a line break", "Remove it, so that the row is one line")
        return SheetRow(where, named, fault=fault)
    if len(cells) > len(columns):
        what = f"has {len(cells)} cells below {len(columns)} columns"
        return SheetRow(where, named, fault=SettingsError(where, what, "Remove superfluous tabs from the row"))
    try:
        return SheetRow(where, named, content=model.checked(named, where))
    except SettingsError as fault:
        return SheetRow(where, named, fault=fault)


def _check_separator(path: Path, header: str) -> None:
    for separator, plural in _SEPARATORS.items():
        if separator in header and "\t" not in header:
            remedy = "Save the sheet as text with tabs between its columns"
            raise SettingsError(str(path), f"has {plural} between its columns '{header}'", remedy)


def _check_columns(path: Path, columns: Sequence[str], model: type[Strict]) -> None:
    known = list(model.model_fields)
    for name in columns:
        if name not in known:
            close = difflib.get_close_matches(name, known, n=1)
            remedy = f"Did you mean '{close[0]}'?" if close else f"Known columns are {', '.join(known)}"
            raise SettingsError(str(path), f"has an unknown column '{name}'", remedy)
        if columns.count(name) > 1:
            raise SettingsError(str(path), f"has the column '{name}' twice", "Remove one of them")
    for name, field in model.model_fields.items():
        if field.is_required() and name not in columns:
            raise SettingsError(str(path), f"has no column '{name}'", "Add it to the header and to every row")


def _cells(line: str) -> list[str]:
    """The cells of a line without those that are empty at its end, as Excel saves them."""
    cells = list(map(_plain, line.split("\t")))
    while cells and not cells[-1]:
        cells.pop()
    return cells


def _is_broken(cell: str) -> bool:
    """Whether the last cell of a line opens a quote and does not close it, as Excel saves a cell of several lines."""
    return cell.startswith('"') and cell.count('"') % 2 == 1


def _plain(cell: str) -> str:
    """A cell without spaces around it, and without the quotes in which Excel saves one with a comma or a quote."""
    text = cell.strip()
    is_quoted = len(text) > 1 and text[0] == text[-1] == '"'
    return text[1:-1].replace('""', '"').strip() if is_quoted else text
