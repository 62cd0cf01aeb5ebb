"""Text with a delimiter, of any encoding, decimals and header; plain or packed."""

from __future__ import annotations

import contextlib
import io
import itertools
from collections.abc import Collection, Iterator, Sequence
from dataclasses import replace
from pathlib import Path
from typing import IO, Any

from drillid.formats.arrow_tables import with_notes
from drillid.formats.description import Dialect, Header, Unusable
from drillid.formats.numbers_in_text import with_numbers
from drillid.formats.packing import opened
from drillid.formats.places import shortened
from drillid.formats.repeated_headers import check_header, is_header
from drillid.formats.rows_without_data import WithoutData, may_be_times, rows_without_data
from drillid.formats.streams import WithoutLines, in_utf_8, lines_of, parsable
from drillid.formats.text_layout import TextLayout, cells_of, layout_of

_BLOCK = 2**18
SUFFIXES = (".csv", ".txt", ".tsv", ".tab", ".asc", ".dat", ".prn")
STREAMS = True
LEAVES_ROWS_OUT = True


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
    """The columns as an Arrow table; a numeric column with a cell that is not a number stays text.

    Lines without data, which spoil the types of columns, are searched for where a type is not the expected one.
    """
    import pyarrow as pa

    layout, thousands = header.layout
    as_text = dict.fromkeys(columns, pa.string())
    numeric = {name: pa.float64() for name in columns if name not in text}
    types = as_text | (numeric if thousands is None else {})
    with contextlib.suppress(pa.ArrowInvalid):
        table = _read(path, layout, header.columns, types, rows)
        if all(may_be_times(table.column(name)) and not _has_comment(table.column(name), layout) for name in text):
            return table if thousands is None else _with_numbers(table, header, numeric)
    places = [header.columns.index(name) for name in text]
    found, skipped = _lines_without_data(path, layout, len(header.columns), places, rows)
    left_out = frozenset([*skipped, *(found.rows if found.credible else ())])
    notes = found.notes(lambda line: f"line {line + 1}") if found.credible else []
    try:
        if thousands is None:
            with contextlib.suppress(pa.ArrowInvalid):
                return with_notes(_read(path, layout, header.columns, types, rows, left_out), notes)
        table = _read(path, layout, header.columns, as_text, rows, left_out)
    except pa.ArrowInvalid:
        _check_widths(path, layout, len(header.columns), left_out)
        raise
    return with_notes(_with_numbers(table, header, numeric), notes)


def line_of(path: Path, header: Header, row: int) -> int:
    """Number of the line, counted from 1, that holds a row of data."""
    layout: TextLayout = header.layout[0]
    found, _ = _lines_without_data(path, layout, len(header.columns), [], None)
    left_out = set(found.rows if found.credible else [])
    lines = (line for line, _, _ in _rows(path, layout, len(header.columns), []) if line not in left_out)
    return next(itertools.islice(lines, row, None), -1) + 1


def _with_numbers(table: Any, header: Header, numeric: Collection[str]) -> Any:
    layout, thousands = header.layout
    return with_numbers(table, list(numeric), layout.decimal, thousands, layout.delimiter)


def _lines_without_data(
    path: Path, layout: TextLayout, width: int, times: Sequence[int], rows: int | None
) -> tuple[WithoutData, list[int]]:
    """Lines among the first rows that hold no data, and those that are comments or spaces; counted from 0."""
    skipped = list[int]()
    lines = itertools.islice(_rows(path, layout, width, skipped), rows)

    def check(line: int, cells: Sequence[str]) -> None:
        check_header(layout.header, cells, f"line {line + 1}")

    return rows_without_data(lines, layout.above, times, check), skipped


def _rows(path: Path, layout: TextLayout, width: int, skipped: list[int]) -> Iterator[tuple[int, list[str], bool]]:
    """Lines behind the header, their cells, and whether they are complete, not cut by the file's end.

    Comments and lines of spaces are left out; their numbers are added to `skipped`.

    Raises
    ------
    Unusable
        If a comment is a header with other columns or units.
    """
    with opened(path) as content:
        for at, raw in enumerate(lines_of(in_utf_8(content, layout.encoding))):
            if at < layout.first_line or not raw.strip(b"\r\n"):
                continue
            if not raw.strip():
                skipped.append(at)
                continue
            line = raw.decode(errors="replace").rstrip("\r\n")
            if line.startswith(layout.comment):
                check_header(layout.header, _in_comment(line, layout), f"line {at + 1}")
                skipped.append(at)
                continue
            cells = cells_of(line, layout.delimiter)
            yield at, cells, len(cells) >= width or raw.endswith((b"\n", b"\r"))


def _in_comment(line: str, layout: TextLayout) -> list[str]:
    """The cells of a comment, without the characters that begin it."""
    return cells_of(line.lstrip("".join(layout.comment)).strip(), layout.delimiter)


def _read(
    path: Path,
    layout: TextLayout,
    names: Sequence[str],
    types: dict[str, Any],
    rows: int | None,
    left_out: frozenset[int] = frozenset(),
) -> Any:
    """The columns of the given types, without the lines in `left_out`, which are counted from 0."""
    import pyarrow as pa
    from pyarrow import csv as arrow_csv

    with opened(path) as content:
        plain: Any = in_utf_8(content, layout.encoding)
        plain = WithoutLines(plain, left_out) if left_out else plain
        source = plain if rows is None else io.BytesIO(_first_lines(plain, layout.first_line + rows))
        lines, delimiter = parsable(source, layout.delimiter, len(names))
        return arrow_csv.read_csv(
            pa.PythonFile(lines, mode="r"),
            read_options=arrow_csv.ReadOptions(column_names=list(names), skip_rows=layout.first_line),
            parse_options=arrow_csv.ParseOptions(
                delimiter=delimiter,
                invalid_row_handler=lambda row: "skip" if _is_no_row(row.text, layout) else "error",
            ),
            convert_options=arrow_csv.ConvertOptions(
                include_columns=list(types),
                column_types=types,
                strings_can_be_null=True,
                timestamp_parsers=[],
                decimal_point="," if layout.decimal == "," else ".",
            ),
        )


def _check_widths(path: Path, layout: TextLayout, width: int, left_out: Collection[int]) -> None:
    """Refuse the first line with another number of cells than there are columns."""
    for line, cells, _ in _rows(path, layout, width, []):
        if len(cells) != width and line not in left_out:
            raise Unusable(
                f"line {line + 1} has {len(cells)} cell{'s' if len(cells) != 1 else ''} and the header names {width} "
                f"columns: '{shortened(', '.join(cells))}'",
                "Correct the line or delete it; a cell that holds the delimiter needs quotes",
            )


def _has_comment(column: Any, layout: TextLayout) -> bool:
    """Whether any cell begins as a comment does, which may have as many cells as a row."""
    import pyarrow.compute as pc

    return any(pc.any(pc.starts_with(column, sign)).as_py() for sign in layout.comment)


def _is_no_row(line: str, layout: TextLayout) -> bool:
    """Whether a line is blank, or a comment; but not one that names columns, which must be those of the table."""
    if not line.strip():
        return True
    return line.startswith(layout.comment) and not is_header(layout.header, _in_comment(line, layout))


def _first_lines(content: IO[bytes], count: int) -> bytes:
    """The first lines of a text, unparsed."""
    found = b""
    while len(found.splitlines()) <= count:
        block = content.read(_BLOCK)
        if not block:
            return found
        found += block
    return b"".join(found.splitlines(keepends=True)[:count])
