"""LAS 1.2 to 3.0 logs over time; the header is read by lasio, the data by Arrow."""

from __future__ import annotations

import contextlib
import io
import itertools
import mmap
import re
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import IO, Any

import numpy as np

from drillid.formats.arrow_tables import with_notes
from drillid.formats.description import Dialect, Header, Note, Unusable
from drillid.formats.header_rows import is_number
from drillid.formats.las_header import LasHeader, moment_in, read_header
from drillid.formats.las_sections import Section, data_among, describing, sections_of
from drillid.formats.numbers_in_text import with_numbers
from drillid.formats.rows_without_data import may_be_times, rows_without_data
from drillid.formats.streams import WithoutLines, in_utf_8, lines_of, parsable
from drillid.formats.text_layout import cells_of, decimal_of, decoded, is_text

SUFFIXES = (".las",)
LEAVES_ROWS_OUT = True

_SAMPLE = 2**16
_ENDS = re.compile(rb"\r\n|\n|\r")
_DELIMITERS = {"COMMA": ",", "TAB": "\t", "SPACE": " "}
_COMMENT = ("#",)
_WIDTHS = re.compile(r"Expected (?P<curves>\d+) columns, got (?P<found>\d+)")
"""Arrow's message about a row with another number of cells."""
_SAME: dict[str, Callable[[Header], Any]] = {
    "the curves": lambda header: header.columns,
    "the units": lambda header: header.units,
    "the start of the times": lambda header: (header.start, header.start_is_utc),
    "the null values": lambda header: header.nulls,
    "the delimiters": lambda header: (header.layout.delimiter, header.layout.width),
}
"""What sections of data must have in common for their rows to be read as one table."""


@dataclass(frozen=True)
class _Layout:
    """How the data section is read.

    encoding : of the file
    parts : begin and end of the rows of each section of data, in bytes
    delimiter : between cells; ' ' for any number of spaces
    width : number of cells of a row, where a row takes several lines, else 0
    decimal : decimal mark, None where no cell shows it
    """

    encoding: str
    parts: tuple[tuple[int, int], ...]
    delimiter: str
    width: int
    decimal: str | None


def headers(path: Path, dialect: Dialect) -> list[Header]:
    """The one table of the file; the rows of several sections with the same header are concatenated.

    Raises
    ------
    ValueError
        If it is not a LAS file, is a log over depth, or holds several logs with different headers.
    """
    with _mapped(path) as content:
        encoding = _encoding(content, dialect)
        sections = sections_of(content, encoding)
        data, others = data_among(sections)
        if not data:
            raise ValueError("it has no section ~A, which holds the data")
        read: dict[str, Header] = {}
        for section in data:
            text = "".join(
                content[part.begin : part.end].decode(encoding, "replace") for part in describing(section, sections)
            )
            if text not in read:
                read[text] = _header(content, encoding, dialect, read_header(text, section.title), section)
            _check_same(next(iter(read.values())), read[text], section)
        header = next(iter(read.values()))
        parts = tuple((_rows_begin(content, section), section.end) for section in data)
    notes = [_not_read(others)] if others else []
    return [replace(header, layout=replace(header.layout, parts=parts), notes=tuple(notes))]


def _header(content: mmap.mmap, encoding: str, dialect: Dialect, found: LasHeader, section: Section) -> Header:
    """The table of one section of data, by its header and its first rows."""
    begin = _rows_begin(content, section)
    sample = content[begin : min(section.end, begin + _SAMPLE)].decode(encoding, "replace")
    lines = [line for line in re.split(r"\r\n|\n|\r", sample) if line.strip() and not line.startswith("#")]
    delimiter = dialect.delimiter or _delimiter(found, lines[:-1] or lines)
    rows = [cells_of(line, delimiter) for line in lines[:-1] or lines]
    names, date = _with_date_apart(found, rows)
    decimal = dialect.decimal or decimal_of({cell for row in rows for cell in row if is_number(cell)})
    at = None if found.time is None else names.index(found.time)
    first = [row[at] for row in rows[:2] if at < len(row)] if at is not None else []
    # cells with a date need no start
    dated = date is not None or (bool(first) and moment_in(first[0]) is not None)
    start = None if dated else found.start(_values(first, decimal))
    return Header(
        names,
        found.units,
        time=found.time,
        date=date,
        start=None if start is None else np.datetime64(start.since, "ns"),
        start_is_utc=start is not None and start.is_utc,
        start_offset=0 if start is None else start.offset,
        nulls=dict.fromkeys(names, found.nulls),
        layout=_Layout(encoding, (), delimiter, len(names) if found.wrapped else 0, decimal),
        rows=None if rows else 0,
    )


def _values(cells: Sequence[str], decimal: str | None) -> list[float]:
    """Cells as numbers; empty where one is not a number."""
    try:
        return [float(cell.strip().replace(decimal or ".", ".")) for cell in cells]
    except ValueError:
        return []


def _check_same(first: Header, other: Header, section: Section) -> None:
    """Refuse sections of data whose rows cannot be read as one table."""
    for what, of in _SAME.items():
        if of(first) != of(other):
            raise Unusable(
                f"has several sections of data, and {what} of '{section.title.strip()}' are not those of the first",
                "Export each log to a file of its own",
            )


def _not_read(others: Sequence[Section]) -> Note:
    titles = ", ".join(f"'{section.title.strip()}'" for section in others)
    return f"only the sections of log data are read, and not {titles}", "None needed unless these hold the log"


def read_columns(
    path: Path, header: Header, columns: Sequence[str], text: Sequence[str], rows: int | None = None
) -> Any:
    """The columns as an Arrow table; a numeric column with a cell that is not a number stays text.

    Lines without data, which spoil the types of columns, are searched for where a type is not the expected one.
    """
    import pyarrow as pa

    numeric = {name: pa.float64() for name in columns if name not in text}
    types = dict.fromkeys(columns, pa.string()) | numeric
    with contextlib.suppress(pa.ArrowInvalid):
        table = _read(path, header, types, rows)
        if all(may_be_times(table.column(name)) for name in text):
            return table
    left_out, notes = _without_data(path, header, text, rows)
    try:
        return with_notes(_read(path, header, types, rows, left_out), notes)
    except pa.ArrowInvalid as error:
        width = _WIDTHS.search(str(error))
        if width is not None:
            raise Unusable(
                f"has a row of {width['found']} cells, and its section ~C names {width['curves']} curves",
                "Write a line for each curve in ~C, such as 'TQA.kN.m : torque', and as many cells in each row",
            ) from error
        if not numeric:
            raise
    table = _read(path, header, dict.fromkeys(columns, pa.string()), rows, left_out)
    return with_notes(with_numbers(table, list(numeric), header.layout.decimal, None, header.layout.delimiter), notes)


def line_of(path: Path, header: Header, row: int) -> int:
    """Number of the line, counted from 1, that holds a row of data; 0 where rows take several lines."""
    layout: _Layout = header.layout
    if layout.width:
        return 0
    left_out, _ = _without_data(path, header, [], None)
    with _mapped(path) as content:
        lines = (at for at, line in enumerate(_lines(content, layout)) if _is_row(line) and at not in left_out)
        found = next(itertools.islice(lines, row, None), None)
        return 0 if found is None else _line_in_file(content, layout, found)


def _without_data(
    path: Path, header: Header, times: Sequence[str], rows: int | None
) -> tuple[frozenset[int], list[Note]]:
    """Lines of data, counted from 0, that are comments or hold no data, and notes on the latter."""
    layout: _Layout = header.layout
    if layout.width:
        return frozenset(), []
    with _mapped(path) as content:
        comments = [at for at, line in enumerate(_lines(content, layout)) if line.startswith(b"#")]
        lines = itertools.islice(_rows(content, layout, len(header.columns)), rows)
        found = rows_without_data(lines, [], [header.columns.index(name) for name in times])
        if not found.credible:
            return frozenset(comments), []
        notes = found.notes(lambda line: f"line {_line_in_file(content, layout, line)}")
        return frozenset([*found.rows, *comments]), notes


def _rows(content: mmap.mmap, layout: _Layout, width: int) -> Iterator[tuple[int, list[str], bool]]:
    """Lines of data, their cells, and whether they are complete, not cut by the file's end."""
    for at, line in enumerate(_lines(content, layout)):
        if _is_row(line):
            cells = cells_of(line.decode(layout.encoding, "replace").rstrip("\r\n"), layout.delimiter)
            yield at, cells, len(cells) >= width or line.endswith((b"\n", b"\r"))


def _is_row(line: bytes) -> bool:
    return bool(line.strip()) and not line.startswith(b"#")


def _lines(content: mmap.mmap, layout: _Layout) -> Iterator[bytes]:
    """All lines of the sections of data."""
    return lines_of(_Rows(content, layout))  # type: ignore[arg-type]


def _line_in_file(content: mmap.mmap, layout: _Layout, line: int) -> int:
    """Number in the file, counted from 1, of one of the lines of data, counted from 0."""
    for begin, end in layout.parts:
        count = len(_ENDS.findall(content, begin, end))
        if line < count or (begin, end) == layout.parts[-1]:
            return len(_ENDS.findall(content, 0, begin)) + line + 1
        line -= count
    return 0


@contextlib.contextmanager
def _mapped(path: Path) -> Iterator[mmap.mmap]:
    with path.open("rb") as file, mmap.mmap(file.fileno(), 0, access=mmap.ACCESS_READ) as content:
        yield content


def _encoding(content: mmap.mmap, dialect: Dialect) -> str:
    """Encoding of the file."""
    start = content[:_SAMPLE]
    if not is_text(start):
        raise ValueError("its content is not text")
    encoding = decoded(start, dialect.encoding)[1]
    if encoding.startswith("utf-16"):
        raise Unusable("is in UTF-16, and LAS files are plain text", "Save it in UTF-8")
    return encoding


def _rows_begin(content: mmap.mmap, section: Section) -> int:
    """Position where the rows of a section begin, behind its title."""
    found = (content.find(end, section.begin, section.end) for end in (b"\n", b"\r"))
    return next((at + 1 for at in found if at >= 0), section.end)


def _delimiter(header: LasHeader, lines: list[str]) -> str:
    """The delimiter that the header states, else the one that gives as many cells as there are curves."""
    if header.delimiter in _DELIMITERS:
        return _DELIMITERS[header.delimiter]
    first, curves = [line.strip() for line in lines[:5]], len(header.names)
    # a comma between spaces may be that of a decimal number
    if any(re.search(r"[,;]\s|[,;]$", line) for line in first) or not all(
        len(line.split()) in (curves, curves + 1) for line in first
    ):
        for delimiter in ("\t", ",", ";"):
            if first and all(len(cells_of(line.strip(delimiter), delimiter)) > 1 for line in first):
                return delimiter
    return " "


def _with_date_apart(header: LasHeader, rows: list[list[str]]) -> tuple[tuple[str, ...], str | None]:
    """Names of the cells, where a time stamp with a space in it takes two, and the column of dates."""
    names = header.names
    if header.wrapped or not rows or len(rows[0]) != len(names) + 1:
        return names, None
    for at, (date, clock) in enumerate(zip(rows[0], rows[0][1:], strict=False)):
        if re.fullmatch(r"\d{1,4}[-/.]\w{1,3}[-/.]\d{2,4}", date) and re.match(r"\d{1,2}:\d{2}", clock):
            column = names[at]
            return (*names[:at], f"{column} (date)", *names[at:]), f"{column} (date)" if column == header.time else None
    return names, None


class _Rows(io.RawIOBase):
    """The sections of data of a file as one stream."""

    def __init__(self, content: mmap.mmap, layout: _Layout) -> None:
        self.content, self.parts = content, list(layout.parts)

    def readable(self) -> bool:
        """Streams of bytes to read."""
        return True

    def read(self, size: int | None = -1) -> bytes:
        """Next bytes, of one section at most; all that are left if no size is given."""
        if size is None or size < 0:
            return b"".join(iter(lambda: self.read(_SAMPLE), b""))
        while self.parts:
            begin, end = self.parts[0]
            stop = min(end, begin + size)
            self.parts[:1] = [(stop, end)] if stop < end else []
            if stop > begin:
                return self.content[begin:stop]
        return b""


def _read(
    path: Path, header: Header, types: dict[str, Any], rows: int | None, left_out: frozenset[int] = frozenset()
) -> Any:
    """The columns of the given types, without the lines of data in `left_out`, which are counted from 0."""
    import pyarrow as pa
    from pyarrow import csv as arrow_csv

    layout: _Layout = header.layout
    with _mapped(path) as content:
        plain: Any = _Rows(content, layout)
        source: Any = in_utf_8(WithoutLines(plain, left_out) if left_out else plain, layout.encoding)  # type: ignore[arg-type]
        if layout.width:
            source = _unwrapped(source, layout, rows)
        elif rows is not None:
            source = io.BytesIO(_first_lines(source, rows))
        lines, delimiter = parsable(source, " " if layout.width else layout.delimiter, len(header.columns))
        return arrow_csv.read_csv(
            pa.PythonFile(lines, mode="r"),
            read_options=arrow_csv.ReadOptions(column_names=list(header.columns)),
            parse_options=arrow_csv.ParseOptions(
                delimiter=delimiter,
                invalid_row_handler=lambda row: "skip" if row.text.startswith(_COMMENT) else "error",
            ),
            convert_options=arrow_csv.ConvertOptions(
                include_columns=list(types),
                column_types=types,
                strings_can_be_null=True,
                timestamp_parsers=[],
                decimal_point="," if layout.decimal == "," else ".",
            ),
        )


def _first_lines(source: IO[bytes], rows: int) -> bytes:
    found = b""
    while found.count(b"\n") <= rows:
        block = source.read(_SAMPLE)
        if not block:
            break
        found += block
    return b"\n".join(found.splitlines()[:rows])


def _unwrapped(source: IO[bytes], layout: _Layout, rows: int | None) -> IO[bytes]:
    """Rows that take several lines, each joined into one line.

    Raises
    ------
    ValueError
        If the cells do not make whole rows.
    """
    lines = (line for line in source.read().splitlines() if not line.startswith(b"#"))
    if layout.delimiter == ",":
        lines = (line.replace(b",", b" ") for line in lines)
    cells = [cell for line in lines for cell in line.split()]
    if len(cells) % layout.width:
        raise ValueError(f"its {len(cells)} cells do not make whole rows of {layout.width} curves")
    starts = range(0, len(cells) if rows is None else min(len(cells), rows * layout.width), layout.width)
    return io.BytesIO(b"\n".join(b" ".join(cells[at : at + layout.width]) for at in starts))
