"""Text with a delimiter, of any encoding, decimals and header; plain or packed."""

from __future__ import annotations

import io
import itertools
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import IO, Any

from drillid.formats.description import Dialect, Header
from drillid.formats.numbers_in_text import with_numbers
from drillid.formats.packing import opened
from drillid.formats.streams import DELIMITER, Squeezed, in_utf_8
from drillid.formats.text_layout import TextLayout, layout_of

_BLOCK = 2**18
SUFFIXES = (".csv", ".txt", ".tsv", ".tab", ".asc", ".dat", ".prn")
STREAMS = True


def headers(path: Path, dialect: Dialect) -> list[Header]:
    """The one table of the file."""
    layout = layout_of(path, dialect)
    if layout is None:
        return []
    found = layout.header
    date = time = None
    apart = next((name for name in found.names if name.endswith(" (date)")), None)
    if apart is not None:
        date, time = apart, apart.removesuffix(" (date)")
    kept = replace(layout, decimal=dialect.decimal or layout.decimal)
    rows = None if layout.has_rows else 0
    own = (kept, dialect.thousands)
    return [Header(found.names, found.units, time=time, date=date, layout=own, notes=layout.notes, rows=rows)]


def read_columns(
    path: Path, header: Header, columns: Sequence[str], text: Sequence[str], rows: int | None = None
) -> Any:
    """The columns as an Arrow table; a numeric column with a cell that is not a number stays text."""
    import pyarrow as pa

    layout, thousands = header.layout
    as_text = dict.fromkeys(columns, pa.string())
    numeric = {name: pa.float64() for name in columns if name not in text}
    if thousands is None:
        try:
            return _read(path, layout, header.columns, columns, as_text | numeric, rows)
        except pa.ArrowInvalid:
            if not numeric:
                raise
    table = _read(path, layout, header.columns, columns, as_text, rows)
    return with_numbers(table, list(numeric), layout.decimal, thousands, layout.delimiter)


def line_of(path: Path, header: Header, row: int) -> int:
    """Number of the line, counted from 1, that holds a row of data."""
    layout: TextLayout = header.layout[0]
    with opened(path) as content:
        lines = io.TextIOWrapper(content, encoding=layout.encoding, errors="replace")
        behind = (
            number
            for number, line in enumerate(lines, 1)
            if number > layout.first_line and line.strip() and not line.startswith(layout.comment)
        )
        return next(itertools.islice(behind, row, None), 0)


def _read(
    path: Path,
    layout: TextLayout,
    names: Sequence[str],
    columns: Sequence[str],
    types: dict[str, Any],
    rows: int | None,
) -> Any:
    import pyarrow as pa
    from pyarrow import csv as arrow_csv

    spaced = layout.delimiter == " "
    with opened(path) as content:
        plain: Any = in_utf_8(content, layout.encoding)
        source = plain if rows is None else io.BytesIO(_first_lines(plain, layout.first_line + rows))
        return arrow_csv.read_csv(
            pa.PythonFile(Squeezed(source) if spaced else source, mode="r"),
            read_options=arrow_csv.ReadOptions(column_names=list(names), skip_rows=layout.first_line),
            parse_options=arrow_csv.ParseOptions(
                delimiter=DELIMITER if spaced else layout.delimiter,
                invalid_row_handler=lambda row: "skip" if row.text.startswith(layout.comment) else "error",
            ),
            convert_options=arrow_csv.ConvertOptions(
                include_columns=list(columns),
                column_types=types,
                strings_can_be_null=True,
                timestamp_parsers=[],
                decimal_point="," if layout.decimal == "," else ".",
            ),
        )


def _first_lines(content: IO[bytes], count: int) -> bytes:
    """The first lines of a text, unparsed."""
    found = b""
    while len(found.splitlines()) <= count:
        block = content.read(_BLOCK)
        if not block:
            return found
        found += block
    return b"".join(found.splitlines(keepends=True)[:count])
