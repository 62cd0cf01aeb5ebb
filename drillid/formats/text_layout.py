"""Layout of a text file: encoding, delimiter, decimals, lines of the header; stated or found from its first lines."""

from __future__ import annotations

import codecs
import csv
import re
from collections import Counter
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from pathlib import Path

from drillid.formats.description import Dialect, Note, Unusable
from drillid.formats.header_rows import HeaderRows, find_header, is_data, is_number, where_names_are
from drillid.formats.packing import lines_at_start
from drillid.formats.places import shortened
from drillid.formats.zones import states_zone

_SAMPLE_LINES = 400
_SAMPLE_BYTES = 2**17
_CONTROL = re.compile(rb"[\x00-\x08\x0e-\x19\x1b-\x1f\x7f]")
"""Bytes that no text holds; 1A may mark its end."""
_BOMS = (
    (codecs.BOM_UTF8, "utf-8-sig"),
    (codecs.BOM_UTF16_LE, "utf-16"),
    (codecs.BOM_UTF16_BE, "utf-16"),
)
_COMMENTS = ("#", "//", "%", "!")
_BETWEEN = ("\t", ";", "|", ",")
"""Delimiters, those that occur in no number first."""
_SPACES = " "
_GROUPED = re.compile(r"[+-]?\d{1,3}([., '’\u00a0\u202f])\d{3}(?!\d)")
_ONLY_THOUSANDS = re.compile(r"[+-]?[1-9]\d{0,2}\.\d{3}")
_OPEN_QUOTE = re.compile(r'(?:^|[\t;|,])\s*"(?:[^"]|"")*$')
"""A quote that opens a cell and does not close in its line."""
_MOST_QUOTED = 100
"""Lines that the names of columns may take; a quote that runs on longer is an inch mark."""
_SHARE = 0.9
"""Share of the lines of data that a delimiter must cut into the same number of cells."""


@dataclass(frozen=True)
class TextLayout:
    """How the lines of a text file are read.

    encoding : of its characters
    delimiter : between its cells; ' ' for any number of spaces
    decimal : decimal mark, None where no cell of the sample shows it
    comment : characters that begin lines without data, as a tuple
    header : names, units
    first_line : index of the first line of data
    above : cells of the lines above it
    has_rows : whether there are any lines of data
    notes : decisions that were taken
    """

    encoding: str
    delimiter: str
    decimal: str | None
    comment: tuple[str, ...]
    header: HeaderRows
    first_line: int
    above: frozenset[tuple[str, ...]]
    has_rows: bool
    notes: tuple[Note, ...] = ()


def layout_of(path: Path, dialect: Dialect) -> TextLayout | None:
    """The layout of a text file; None of an empty one.

    Raises
    ------
    ValueError
        If it is not text, or has no header.
    """
    sample = lines_at_start(path, _SAMPLE_BYTES)
    if not sample:
        return None
    if not is_text(sample):
        raise ValueError("its content is not text")
    text, encoding = decoded(sample, dialect.encoding)
    lines = _with_whole_quotes(re.split(r"\r\n|\n|\r", text)[:_SAMPLE_LINES])
    if len(lines) > 2 and (len(lines) == _SAMPLE_LINES or len(sample) == _SAMPLE_BYTES):
        lines = lines[:-1]
    comment = _COMMENTS if dialect.comment is None else (dialect.comment,)
    delimiter = dialect.delimiter or find_delimiter([line for line in lines if not line.startswith(comment)])
    return _laid_out(lines, delimiter, encoding, comment, dialect)


def _with_whole_quotes(lines: list[str]) -> list[str]:
    """Lines, with those that a quote spans joined in the first, spaces for line breaks; the others are left empty."""
    found, at = list(lines), 0
    while at < len(found):
        last, line = at, found[at]
        while _OPEN_QUOTE.search(line) and last + 1 < min(len(found), at + _MOST_QUOTED):
            last += 1
            line = f"{line} {found[last]}"
        if last > at and not _OPEN_QUOTE.search(line):
            found[at : last + 1] = [line, *[""] * (last - at)]
            at = last
        at += 1
    return found


def is_text(content: bytes) -> bool:
    """Whether bytes may be text in any usual encoding."""
    if content.startswith((codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE)) or _utf_16(content):
        return True
    return _CONTROL.search(content[:8192]) is None


def decoded(content: bytes, encoding: str | None = None) -> tuple[str, str]:
    """Text and its encoding: as stated, by its byte-order mark, UTF-8 where that is valid, else that of Windows.

    Raises
    ------
    ValueError
        If the stated encoding is unknown or does not fit.
    """
    if encoding is not None:
        try:
            return content.decode(encoding, "ignore"), encoding
        except LookupError as error:
            raise ValueError(f"the encoding '{encoding}' of the rig description is unknown") from error
    marked = next((name for mark, name in _BOMS if content.startswith(mark)), None) or _utf_16(content)
    if marked is not None:
        return content.decode(marked, "ignore"), marked
    try:
        return codecs.getincrementaldecoder("utf-8")().decode(content), "utf-8"
    except UnicodeDecodeError:
        return content.decode("cp1252", "replace"), "cp1252"


def _utf_16(content: bytes) -> str | None:
    """UTF-16 without a byte-order mark, by the zeros in every other byte of plain letters."""
    start = content[:2000]
    if len(start) < 20:
        return None
    even, odd = start[0::2].count(0), start[1::2].count(0)
    if odd > 0.8 * len(start) / 2 and even == 0:
        return "utf-16-le"
    return "utf-16-be" if even > 0.8 * len(start) / 2 and odd == 0 else None


def find_delimiter(lines: list[str]) -> str:
    """The character that cuts the lines of data into the same number of cells.

    Tabs and semicolons come before commas, which may stand in numbers; spaces are used where nothing else cuts.
    """
    for delimiter in _BETWEEN:
        widths = Counter(len(cells) for line in lines if is_data(cells := cells_of(line, delimiter)))
        if not widths:
            continue
        width, count = widths.most_common(1)[0]
        if width > 1 and count >= _SHARE * widths.total() and _covers(lines, delimiter, widths.total()):
            return delimiter
    spaced = [line.split() for line in lines if is_data(line.split())]
    if spaced and Counter(map(len, spaced)).most_common(1)[0][0] > 1:
        return _SPACES
    named = [delimiter for delimiter in _BETWEEN if any(delimiter in line for line in lines)]
    return named[0] if named else ","


def _covers(lines: list[str], delimiter: str, cut: int) -> bool:
    """Whether a delimiter cuts most of the lines that hold numbers."""
    numeric = sum(any(character.isdigit() for character in line) for line in lines)
    return 2 * cut >= numeric


def cells_of(line: str, delimiter: str) -> list[str]:
    """Cells of a line, quotes and outer spaces removed."""
    if delimiter == _SPACES:
        return line.split()
    try:
        return [cell.strip() for cell in next(csv.reader([line], delimiter=delimiter), [])]
    except csv.Error:
        return [line]


def _laid_out(
    lines: list[str], delimiter: str, encoding: str, comment: tuple[str, ...], dialect: Dialect
) -> TextLayout:
    used = [
        at
        for at, line in enumerate(lines)
        if line.strip() and (not line.startswith(comment) or dialect.header_line == at + 1)
    ]
    rows = [cells_of(lines[at], delimiter) for at in used]
    if dialect.columns:
        first = next((at for at, row in enumerate(rows) if is_data(row)), 0)
        header: HeaderRows | None = HeaderRows(dialect.columns, {}, first)
    else:
        lines_of = {at: row for row, at in enumerate(used)}
        header = find_header(
            rows,
            _row_of(dialect.header_line, lines_of, "header_line"),
            _row_of(dialect.units_line, lines_of, "units_line"),
        ) or _in_comments(lines, used, rows, delimiter, comment)
    if header is None:
        raise Unusable(
            "has no line with the names of its columns",
            "State them in the rig description as file.columns, or the number of their line as file.header_line",
        )
    given = header
    header = _with_date_apart(given, rows, delimiter)
    if header is given:
        _check_names(header, rows, lambda row: used[row] + 1)
    first_line = used[header.first] if header.first < len(used) else len(lines)
    cells = {cell for row in rows[header.first :] for cell in row if is_number(cell)}
    decimal = dialect.decimal or ("." if delimiter == "," else decimal_of(cells))
    if delimiter != "," and dialect.decimal is None and dialect.thousands is None:
        _check_points(rows[header.first :], header.names)
    notes = (
        *where_names_are(header, lambda row: used[row] + 1, dialect),
        *_written_numbers(decimal, cells, dialect),
        *_zones_nearby(lines[:first_line]),
    )
    has_rows = header.first < len(used)
    above = frozenset(map(tuple, rows[: header.first]))
    return TextLayout(encoding, delimiter, decimal, comment, header, first_line, above, has_rows, notes)


def _row_of(line: int | None, rows: dict[int, int], key: str) -> int | None:
    if line is None:
        return None
    if line - 1 not in rows:
        what = f"has nothing in line {line}, which the rig description states as file.{key}"
        raise Unusable(what, f"Correct file.{key}")
    return rows[line - 1]


def _in_comments(
    lines: list[str], used: list[int], rows: list[list[str]], delimiter: str, comment: tuple[str, ...]
) -> HeaderRows | None:
    """Names in the last comment before the data, where it has as many cells as these."""
    first = next((at for at, row in enumerate(rows) if is_data(row)), None)
    if first is None:
        return None
    above = [line for line in lines[: used[first]] if line.startswith(comment)]
    bare = [cells_of(line.lstrip("".join(comment)).strip(), delimiter) for line in above]
    whole = [row for row in bare if len(row) == len(rows[first]) and not is_data(row)]
    found = find_header([*whole, *rows[first:]]) if whole else None
    return None if found is None else HeaderRows(found.names, found.units, first, names_rows=found.names_rows)


def _with_date_apart(header: HeaderRows, rows: list[list[str]], delimiter: str) -> HeaderRows:
    """The header with 'Time' as two columns, where spaces delimit and a date and a time of day stand below it."""
    if delimiter != _SPACES or header.first >= len(rows):
        return header
    data = rows[header.first]
    given = [name for name in header.names if not re.fullmatch(r"column \d+(?::\d+)?", name)]
    if len(data) != len(given) + 1:
        return header
    for at in range(len(given)):
        if re.fullmatch(r"\d{1,4}[-/.]\d{1,2}[-/.]\d{1,4}", data[at]) and re.match(r"\d{1,2}:\d{2}", data[at + 1]):
            names = (*given[:at], f"{given[at]} (date)", *given[at:])
            units = {name: unit for name, unit in header.units.items() if name in names[: at + 2]}
            return replace(header, names=names, units=units)
    return header


def _check_names(header: HeaderRows, rows: list[list[str]], line_of: Callable[[int], int]) -> None:
    """Refuse a header with fewer names than columns that hold something: which of them it names is not known."""
    if header.names_row is None:
        return
    named, width = max(map(len, header.names_rows)), len(header.names)
    for at, row in enumerate(rows[header.first :], header.first):
        if len(row) == width and any(row[named:]):
            raise Unusable(
                f"names {named} columns in line {line_of(header.names_row)}, and line {line_of(at)} has {width} cells: "
                f"'{shortened(', '.join(row))}'",
                "Name every column there, or state all names as file.columns in the rig description; if a delimiter "
                "stands within cells, as before the decimals of a second, export the log with another",
            )


def _check_points(rows: list[list[str]], names: tuple[str, ...]) -> None:
    """Refuse points where nothing shows whether they are decimal points or separate thousands.

    They may separate thousands where a column has integers of up to three digits beside numbers such as 1.234, and no
    cell of the table has another number of decimals.
    """
    columns = [[row[at] for row in rows if at < len(row) and is_number(row[at])] for at in range(len(names))]
    with_point = [[cell for cell in cells if cell.count(".") == 1] for cells in columns]
    if any("," in cell for cells in columns for cell in cells):
        return
    if not all(_ONLY_THOUSANDS.fullmatch(cell) for cells in with_point for cell in cells):
        return
    for name, cells, pointed in zip(names, columns, with_point, strict=True):
        integers = [cell.lstrip("+-") for cell in cells if "." not in cell]
        if pointed and integers and max(map(len, integers)) <= 3:
            cells_shown = f"'{pointed[0]}' and '{integers[0]}' in column '{name}'"
            raise Unusable(
                f"has cells such as {cells_shown}: is the point for decimals or thousands?",
                "State file.decimal in the rig description: '.', or ',' where points separate thousands",
            )


def _zones_nearby(lines: list[str]) -> Iterator[Note]:
    """Notes on lines above the data that state a time zone."""
    for at, line in enumerate(lines, 1):
        if states_zone(line):
            what = f"line {at} states a time zone, which is not used: '{shortened(line.strip())}'"
            yield what, "State that zone as time.zone in the rig description, unless the stamps have zones themselves"


def _written_numbers(decimal: str | None, cells: set[str], dialect: Dialect) -> Iterator[Note]:
    """Notes on decimal marks and thousands separators that are not a matter of course."""
    if decimal == "," and dialect.decimal is None:
        example = next((cell for cell in sorted(cells) if "," in cell), "")
        what = f"numbers such as '{example}' are read with a decimal comma"
        yield what, "State file.decimal in the rig description if that is wrong"
    grouped = [(cell, match[1]) for cell in sorted(cells) if (match := _GROUPED.match(cell)) is not None]
    cell, sign = next(((cell, sign) for cell, sign in grouped if sign != decimal), ("", ""))
    if decimal is not None and cell and dialect.thousands is None:
        what = f"'{sign}' in numbers such as '{cell}' is taken as a thousands separator"
        yield what, "State file.thousands in the rig description if that is wrong"


def decimal_of(cells: set[str]) -> str | None:
    """The decimal mark that numbers show beyond doubt; None where they do not.

    A comma before three digits may mark decimals or thousands; a comma before any other number of digits, or behind a
    zero, marks decimals, and one that occurs twice or before a point marks thousands.
    """
    point = any(re.search(r"\.\d*$", cell) and cell.count(".") == 1 for cell in cells)
    for cell in cells:
        bare = cell.lstrip("+-")
        if bare.count(",") == 1 and ("." not in bare or bare.index(".") < bare.index(",")):
            whole, decimals = bare.split(",")
            if not re.fullmatch(r"\d{3}", decimals) or whole in ("", "0") or len(whole) > 3 or "." in whole:
                return ","
        elif bare.count(",") > 1 or ("," in bare and "." in bare):
            return "."
    return "." if point and not any("," in cell for cell in cells) else None
