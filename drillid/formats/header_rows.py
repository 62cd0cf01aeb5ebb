"""Rows of cells, from text or a workbook → the rows of names and units, and where the data begin."""

from __future__ import annotations

import itertools
import re
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass

from drillid.formats.description import Dialect, Note
from drillid.formats.mnemonics import is_no_unit, is_unit, split_unit, units_at_ends

Cells = Sequence[str]

_NUMBER = re.compile(r"[+-]?(?:\d[\d.,'  \u202f]*|[.,]\d+)(?:[eE][+-]?\d+)?%?")
_TIME = re.compile(
    r"\d{1,4}[-/.]\d{1,2}[-/.]\d{1,4}(?:[T_].*|\b.*)|\d{1,2}:\d{2}(?::\d{2})?\b.*|\d{8}T?\d{0,6}\b.*"
    r"|\d{1,2}[- ][A-Za-z]{3,9}[- ,]+\d{2,4}.*"
)
_MISSING = {"", "nan", "null", "none", "n/a", "na", "#n/a", "-nan", "inf", "-inf", "---", "--", "-"}
_RULE = re.compile(r"[-=+_|*\s]*[-=_]{2,}[-=+_|*\s]*")
_PREAMBLE = 30
"""Rows above the names of columns in which a file may describe itself."""


@dataclass(frozen=True)
class HeaderRows:
    """Where the header of a table is.

    names : names of the columns, unique; generated where a cell is empty
    units : units by name
    first : index of the first row of data
    names_row, units_row : indices of the rows that they are taken from
    upper_row : index of the row that holds the first part of the names, where two rows hold them
    units_at_ends : names whose units are their last words
    names_rows : cells of the rows that hold names, from the upper one
    """

    names: tuple[str, ...]
    units: dict[str, str]
    first: int
    names_row: int | None = None
    units_row: int | None = None
    upper_row: int | None = None
    units_at_ends: tuple[str, ...] = ()
    names_rows: tuple[tuple[str, ...], ...] = ()


def is_number(cell: str) -> bool:
    """Whether a cell is a number in any country's notation."""
    return _NUMBER.fullmatch(cell.strip()) is not None


def is_datum(cell: str) -> bool:
    """Whether a cell holds a number or a time."""
    stripped = cell.strip()
    return _NUMBER.fullmatch(stripped) is not None or _TIME.fullmatch(stripped) is not None


def is_data(cells: Cells) -> bool:
    """Whether a row holds data: it begins with a time, or half of its cells that hold anything are numbers or times."""
    held = [cell for cell in cells if cell.strip().lower() not in _MISSING]
    found = sum(is_datum(cell) for cell in held)
    begins = len(held) > 1 and _TIME.fullmatch(held[0].strip()) is not None
    return found > 0 and (begins or 2 * found >= len(held))


def are_units(row: Cells, names: Cells) -> bool:
    """Whether a row holds units, nearly all of them known, for the names above it."""
    held = [cell.strip() for cell in row if cell.strip()]
    bracketed = [cell for cell in held if re.fullmatch(r"\[.*\]|\(.*\)|\{.*\}", cell)]
    known = sum(is_unit(cell.strip("[](){}")) for cell in held)
    if _held(names) < len(held) or not held:
        return False
    names_are_units = sum(is_unit(name) for name in names if name.strip())
    return len(bracketed) == len(held) or (5 * known >= 4 * len(held) and names_are_units < known)


def usual_width(rows: Sequence[Cells]) -> int:
    """The most frequent number of cells in rows that hold data, else the largest in any row."""
    widths = Counter(len(row) for row in rows if is_data(row))
    return widths.most_common(1)[0][0] if widths else max((len(row) for row in rows), default=0)


def find_header(rows: Sequence[Cells], names_row: int | None = None, units_row: int | None = None) -> HeaderRows | None:
    """The header of a table among its first rows; None where data begin without one.

    Parameters
    ----------
    rows : cells of the first rows, junk before the header included
    names_row, units_row : their indices, where they are known
    """
    width = usual_width(rows)
    first = next((at for at, row in enumerate(rows) if _fits(row, width) and is_data(row) and _goes_on(rows, at)), None)
    if names_row is not None:
        after = max(names_row, names_row if units_row is None else units_row) + 1
        first = next((at for at in range(after, len(rows)) if is_data(rows[at])), after)
        units = units_row if units_row is not None else _units_below(rows, names_row, first)
        return _header(rows, names_row, units, width, first)
    if first is None:
        names = next((at for at, row in enumerate(rows) if len(row) == width and any(map(str.strip, row))), None)
        if names is None:
            return None
        units = _units_below(rows, names, len(rows))
        return _header(rows, names, units, width, (names if units is None else units) + 1)
    above = [at for at in range(first) if _fits(rows[at], width) and _held(rows[at]) and not _is_rule(rows[at])]
    if units_row is None and len(above) > 1 and are_units(rows[above[-1]], rows[above[-2]]):
        units_row = above[-1]
    above = [at for at in above if at != units_row]
    if not above or 2 * _held(rows[above[-1]]) < min(width, 4) or _mostly_numbers(rows[above[-1]]):
        return None
    in_two = len(above) > 1 and above[-2] == above[-1] - 1 and _completes(rows[above[-2]], rows[above[-1]])
    return _header(rows, above[-1], units_row, width, first, above[-2] if in_two else None)


def where_names_are(header: HeaderRows, line_of: Callable[[int], int], dialect: Dialect) -> Iterator[Note]:
    """A note on the lines that hold names and units, unless these are in the first line alone, or stated.

    Parameters
    ----------
    line_of : line of a row, both counted as their users do: lines from 1, rows from 0
    """
    if header.names_row is None:
        return
    names = line_of(header.names_row)
    units = None if header.units_row is None else line_of(header.units_row)
    found = [] if names == 1 or dialect.header_line == names else [f"names of the columns are taken from line {names}"]
    if header.upper_row is not None:
        found = [f"names of the columns are taken from the lines {line_of(header.upper_row)} and {names}"]
    if units is not None and units != dialect.units_line:
        found.append(f"units are taken from line {units}")
    if found:
        remedy = "State file.header_line and file.units_line in the rig description if that is wrong"
        yield f"the {' and the '.join(found)}", remedy
    if header.units_at_ends:
        example = header.units_at_ends[-1]
        what = f"the last words of names such as '{example}' are read as units, '{header.units[example]}' in this one"
        yield what, "State the units with the channels in the rig description if that is wrong"


def unique(names: Sequence[str]) -> tuple[str, ...]:
    """Names without repeats: the second 'TQA' is 'TQA:2'."""
    seen: Counter[str] = Counter()
    found = []
    for name in names:
        seen[name] += 1
        found.append(name if seen[name] == 1 else f"{name}:{seen[name]}")
    return tuple(found)


def _completes(upper: Cells, lower: Cells) -> bool:
    """Whether a row holds the first part of names: text wherever the row below is empty or repeats itself."""
    names = [cell.strip() for cell in lower]
    unclear = [at for at, name in enumerate(names) if not name or names.count(name) > 1]
    held = [at < len(upper) and bool(upper[at].strip()) for at in unclear]
    return bool(held) and all(held) and _held(upper) > 1 and not any(map(is_datum, upper))


def _header(
    rows: Sequence[Cells], names_row: int, units_row: int | None, width: int, first: int, upper_row: int | None = None
) -> HeaderRows:
    names = rows[names_row]
    if upper_row is not None:
        parts = itertools.zip_longest(rows[upper_row], names, fillvalue="")
        names = [f"{upper.strip()} {lower.strip()}".strip() for upper, lower in parts]
    last = max((at for at, name in enumerate(names, 1) if name.strip()), default=0)
    padded = [*names[: max(last, width)], *[""] * (width - len(names))]
    called = unique([name.strip() or f"column {at}" for at, name in enumerate(padded, 1)])
    at_ends = units_at_ends(called)
    stated = at_ends | {name: unit for name in called if (unit := split_unit(name)[1])}
    if units_row is not None:
        cells = zip(called, rows[units_row], strict=False)
        below = {name: unit.strip().strip("[](){}").strip() for name, unit in cells}
        stated |= {name: unit for name, unit in below.items() if unit and not is_no_unit(unit)}
    names_rows = tuple(tuple(rows[at]) for at in (upper_row, names_row) if at is not None)
    return HeaderRows(called, stated, first, names_row, units_row, upper_row, tuple(at_ends), names_rows)


def _fits(row: Cells, width: int) -> bool:
    """Whether a row has the table's number of cells; separators at the ends of lines add empty ones."""
    if len(row) > width and not any(cell.strip() for cell in row[width:]):
        return True
    return abs(len(row) - width) <= (1 if width > 2 else 0)


def _goes_on(rows: Sequence[Cells], at: int) -> bool:
    """Whether data follow, if anything does: a single row of numbers among junk does not begin a table, nor do such
    rows above names of more columns.
    """
    if _names_below(rows, at):
        return False
    behind = [row for row in rows[at + 1 : at + 3] if any(map(str.strip, row))]
    return not behind or any(is_data(row) or not _is_text(row) for row in behind)


def _names_below(rows: Sequence[Cells], at: int) -> bool:
    """Whether names of columns come within the next rows, more of them than any row holds until then."""
    most = _held(rows[at])
    for row in rows[at + 1 : at + _PREAMBLE]:
        if _is_text(row) and _held(row) > most and row not in rows[:at]:
            return True
        most = max(most, _held(row))
    return False


def _is_text(row: Cells) -> bool:
    held = [cell for cell in row if cell.strip().lower() not in _MISSING]
    return bool(held) and not any(map(is_datum, held))


def _held(row: Cells) -> int:
    return sum(bool(cell.strip()) for cell in row)


def _is_rule(row: Cells) -> bool:
    return all(not cell.strip() or _RULE.fullmatch(cell) for cell in row)


def _mostly_numbers(row: Cells) -> bool:
    held = [cell for cell in row if cell.strip()]
    return 2 * sum(map(is_number, held)) > len(held)


def _units_below(rows: Sequence[Cells], names_row: int, stop: int) -> int | None:
    below = [at for at in range(names_row + 1, min(stop, len(rows))) if not _is_rule(rows[at]) and _held(rows[at])]
    return below[0] if below and are_units(rows[below[0]], rows[names_row]) else None
