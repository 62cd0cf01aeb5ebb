"""Where in a file a cell is, as its user counts: lines of a text, rows of a sheet or a table."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from drillid.formats.description import Header

_LONGEST_QUOTE, _LONGEST_MESSAGE = 60, 500
_FIRST_ROW = 1
"""Rows are counted from 1, without the header."""


@dataclass(frozen=True)
class Places:
    """Names of places in one table of a file, for messages; `line_of` gives a row's line, 0 without lines."""

    path: Path
    header: Header
    line_of: Callable[[Path, Header, int], int]

    def cell(self, column: str, row: int) -> str:
        """The place of a cell by its column and its row, counted from 0."""
        line = self.line_of(self.path, self.header, row) if self.header.table else 0
        return f"{self.whole}, column '{column}', row {line or row + _FIRST_ROW}"

    def in_line(self, row: int) -> str:
        """The line of a text file that holds a row, as part of a remedy; empty for other files."""
        line = 0 if self.header.table else self.line_of(self.path, self.header, row)
        return f" in line {line} of the file" if line else ""

    def column(self, name: str) -> str:
        """The place of a column."""
        return f"{self.whole}, column '{name}'"

    @property
    def whole(self) -> str:
        """The file, or the table in it."""
        return f"{self.path}, '{self.header.table}'" if self.header.table else str(self.path)


def shortened(text: object, longest: int = _LONGEST_QUOTE) -> str:
    """A cell or name as a message quotes it: the beginning of a very long one."""
    whole = str(text)
    return whole if len(whole) <= longest else whole[:longest] + "…"


def first_line(error: BaseException) -> str:
    """The first line of an error's message."""
    lines = str(error).splitlines() or [type(error).__name__]
    return shortened(lines[0].rstrip("."), _LONGEST_MESSAGE)
