"""LAS 2.0 logs over time; the header is read by lasio, the data section by Arrow."""

from __future__ import annotations

import contextlib
import io
import mmap
import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import IO, Any

from drillid.formats.description import Dialect, Header
from drillid.formats.header_rows import is_number
from drillid.formats.las_header import LasHeader, read_header
from drillid.formats.numbers_in_text import with_numbers
from drillid.formats.streams import DELIMITER, Squeezed, in_utf_8
from drillid.formats.text_layout import cells_of, decimal_of, decoded, is_text

SUFFIXES = (".las",)

_LARGEST_HEADER = 2**22
"""Bytes of a section before the data."""
_SAMPLE = 2**16
_DATA = re.compile(r"~\s*(?:A|LOG_DATA)", re.IGNORECASE)
_OTHER = re.compile(r"~\s*O", re.IGNORECASE)
_DELIMITERS = {"COMMA": ",", "TAB": "\t", "SPACE": " "}
_COMMENT = ("#",)


@dataclass(frozen=True)
class _Layout:
    """How the data section is read.

    encoding : of the file
    begin, end : the data section, in bytes
    first_line : lines before it
    delimiter : between cells; ' ' for any number of spaces
    width : number of cells of a row, where a row takes several lines, else 0
    decimal : before the decimals, None where no cell shows it
    """

    encoding: str
    begin: int
    end: int
    first_line: int
    delimiter: str
    width: int
    decimal: str | None


def headers(path: Path, dialect: Dialect) -> list[Header]:
    """The one table of the file.

    Raises
    ------
    ValueError
        If it is no LAS file, or a log over depth.
    """
    with _mapped(path) as content:
        encoding, sections = _sections(content, dialect)
        text = "".join(
            content[begin:end].decode(encoding, "replace") for title, begin, end in sections if not _DATA.match(title)
        )
        data = [(title, begin, end) for title, begin, end in sections if _DATA.match(title)]
        if not data:
            raise ValueError("it has no section ~A, which holds the data")
        title, section, end = data[0]
        begin = content.find(b"\n", section, end) + 1 or _after_return(content, section, end)
        sample = content[begin : min(end, begin + _SAMPLE)].decode(encoding, "replace")
        found = read_header(text, title)
        lines = [line for line in re.split(r"\r\n|\n|\r", sample) if line.strip() and not line.startswith("#")]
        delimiter = dialect.delimiter or _delimiter(found, lines[:-1] or lines)
        rows = [cells_of(line, delimiter) for line in lines[:-1] or lines]
        names, date = _with_date_apart(found, rows)
        decimal = dialect.decimal or decimal_of({cell for row in rows for cell in row if is_number(cell)})
        first_line = len(re.findall(rb"\r\n|\n|\r", content[:begin])) if begin < _LARGEST_HEADER else 0
    width = len(names) if found.wrapped else 0
    layout = _Layout(encoding, begin, end, first_line, delimiter, width, decimal)
    count = None if rows else 0
    nulls = dict.fromkeys(names, found.nulls)
    return [Header(names, found.units, "", found.time, date, found.start, False, nulls, layout, (), count)]


def read_columns(
    path: Path, header: Header, columns: Sequence[str], text: Sequence[str], rows: int | None = None
) -> Any:
    """The columns as an Arrow table; a numeric column with a cell that is not a number stays text."""
    import pyarrow as pa

    as_text = dict.fromkeys(columns, pa.string())
    numeric = {name: pa.float64() for name in columns if name not in text}
    try:
        return _read(path, header, columns, as_text | numeric, rows)
    except pa.ArrowInvalid:
        if not numeric:
            raise
    table = _read(path, header, columns, as_text, rows)
    return with_numbers(table, list(numeric), header.layout.decimal, None, header.layout.delimiter)


def line_of(path: Path, header: Header, row: int) -> int:
    """Number of the line, counted from 1, that holds a row of data; 0 where rows take several lines."""
    layout: _Layout = header.layout
    if layout.width:
        return 0
    with _mapped(path) as content:
        for number, line in enumerate(_lines(content, layout), 1):
            if line.strip() and not line.startswith(b"#"):
                row -= 1
                if row < 0:
                    return layout.first_line + number
    return 0


@contextlib.contextmanager
def _mapped(path: Path) -> Iterator[mmap.mmap]:
    with path.open("rb") as file, mmap.mmap(file.fileno(), 0, access=mmap.ACCESS_READ) as content:
        yield content


def _sections(content: mmap.mmap, dialect: Dialect) -> tuple[str, list[tuple[str, int, int]]]:
    """Encoding of the file, and title, begin and end of each section, in whatever order they are."""
    start = content[:_SAMPLE]
    if not is_text(start):
        raise ValueError("its content is not text")
    encoding = decoded(start, dialect.encoding)[1]
    if encoding.startswith("utf-16"):
        raise ValueError("it is in UTF-16; LAS files are plain text")
    begins = list[int]()
    at = content.find(b"~")
    while at >= 0 and len(begins) < 100:
        line = max(content.rfind(b"\n", 0, at), content.rfind(b"\r", 0, at)) + 1
        if not content[line:at].strip(b" \t\xef\xbb\xbf"):
            begins.append(at)
        at = content.find(b"~", at + 1)
    ends = [*begins[1:], len(content)]
    found = []
    for begin, end in zip(begins, ends, strict=False):
        title = re.split(r"[\r\n]", content[begin : begin + 400].decode(encoding, "replace"), maxsplit=1)[0]
        if not _DATA.match(title) and end - begin > _LARGEST_HEADER:
            raise ValueError(f"its section {title.strip()[:20]} is larger than that of any log")
        if not _OTHER.match(title):
            found.append((title, begin, end))
    return encoding, found


def _after_return(content: mmap.mmap, begin: int, end: int) -> int:
    return content.find(b"\r", begin, end) + 1 or end


def _delimiter(header: LasHeader, lines: list[str]) -> str:
    """As the header has it, else the one that gives as many cells as there are curves."""
    if header.delimiter in _DELIMITERS:
        return _DELIMITERS[header.delimiter]
    for delimiter in ("\t", ",", ";"):
        if lines and all(len(cells_of(line.strip().strip(delimiter), delimiter)) > 1 for line in lines[:5]):
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


def _lines(content: mmap.mmap, layout: _Layout) -> Iterator[bytes]:
    section = io.BytesIO(content[layout.begin : layout.end])
    return iter(section)


class _Section(io.RawIOBase):
    """The data section of a file as a stream."""

    def __init__(self, content: mmap.mmap, layout: _Layout) -> None:
        self.content, self.at, self.end = content, layout.begin, layout.end

    def readable(self) -> bool:
        """Streams of bytes to read."""
        return True

    def read(self, size: int = -1) -> bytes:
        """Next bytes."""
        stop = self.end if size is None or size < 0 else min(self.end, self.at + size)
        piece = self.content[self.at : stop]
        self.at = stop
        return piece


def _read(path: Path, header: Header, columns: Sequence[str], types: dict[str, Any], rows: int | None) -> Any:
    import pyarrow as pa
    from pyarrow import csv as arrow_csv

    layout: _Layout = header.layout
    with _mapped(path) as content:
        source: Any = in_utf_8(_Section(content, layout), layout.encoding)  # type: ignore[arg-type]
        if layout.width:
            source = _unwrapped(source, layout, rows)
        elif rows is not None:
            source = io.BytesIO(_first_lines(source, rows))
        spaced = layout.delimiter == " " or layout.width > 0
        return arrow_csv.read_csv(
            pa.PythonFile(Squeezed(source) if spaced else source, mode="r"),
            read_options=arrow_csv.ReadOptions(column_names=list(header.columns)),
            parse_options=arrow_csv.ParseOptions(
                delimiter=DELIMITER if spaced else layout.delimiter,
                invalid_row_handler=lambda row: "skip" if row.text.startswith(_COMMENT) else "error",
            ),
            convert_options=arrow_csv.ConvertOptions(
                include_columns=list(columns),
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
    """Rows that take several lines, each in one line.

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
