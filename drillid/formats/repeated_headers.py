"""Headers among the rows of a table, as in concatenated logs: they must name the columns and units of its own."""

from __future__ import annotations

import itertools
from collections import Counter

from drillid.formats.description import Unusable
from drillid.formats.header_rows import Cells, HeaderRows, are_units
from drillid.formats.mnemonics import date_among, is_no_unit, key_of, split_unit, times_among
from drillid.formats.places import shortened
from drillid.units.expressions import meanings_of

_FEWEST_SHARED = 2
"""Names that a row must share with a header to be one itself."""
_FEWEST_OTHERS = 3
"""Cells of a header that shares no names; a remark may look like a shorter one."""
_REMEDY = "Split the file there, so that each part has its own header"


def check_header(header: HeaderRows, cells: Cells, place: str) -> None:
    """Refuse a row of text that is a header, but not that of its table.

    One that leaves out names or units, or writes them in another way, is still that of its table.

    Parameters
    ----------
    header : that of the table
    cells : of a row without numbers and times
    place : of the row, for the message

    Raises
    ------
    Unusable
        If a column has another name or another unit in it.
    """
    if are_units(cells, header.names):
        _check_units(header, header.names, [cell.strip().strip("[](){}").strip() for cell in cells], place)
        return
    for names in _rows_of_names(header):
        if _is_header(cells, names):
            if _differ(cells, names):
                text = shortened(", ".join(filter(None, map(str.strip, cells))))
                raise Unusable(f"{place} names other columns than the header: '{text}'", _REMEDY)
            _check_units(header, names, [split_unit(cell)[1] for cell in cells], place)


def is_header(header: HeaderRows, cells: Cells) -> bool:
    """Whether a row of text names columns, those of the table or others."""
    return any(_is_header(cells, names) for names in _rows_of_names(header))


def _rows_of_names(header: HeaderRows) -> tuple[Cells, ...]:
    return header.names_rows or (header.names,)


def _is_header(cells: Cells, names: Cells) -> bool:
    """Whether a row shares at least half of the names, or has as many others, among them that of a time."""
    found, known = _keys(cells), _keys(names)
    shared = (found & known).total()
    if shared >= _FEWEST_SHARED and 2 * shared >= known.total():
        return True
    of_time = bool(times_among(cells)) or date_among(cells) is not None
    return of_time and found.total() >= max(_FEWEST_OTHERS, known.total())


def _keys(names: Cells) -> Counter[str]:
    return Counter(_key(name) for name in names if name.strip())


def _key(name: str) -> str:
    return key_of(name) or name.strip()


def _differ(cells: Cells, names: Cells) -> bool:
    """Whether a row has another name than that of the column, or one beyond the last column."""
    return any(
        at >= len(names) or (names[at].strip() and _key(cell) != _key(names[at]))
        for at, cell in enumerate(cells)
        if cell.strip()
    )


def _check_units(header: HeaderRows, names: Cells, units: Cells, place: str) -> None:
    for name, whole, unit in itertools.zip_longest(names, header.names, units, fillvalue=""):
        bare, own = split_unit(name)
        own = own or header.units.get(whole, "")
        if own and not is_no_unit(unit) and not _is_same(unit, own):
            raise Unusable(f"{place} gives '{bare}' in '{unit}' and the header in '{own}'", _REMEDY)


def _is_same(unit: str, other: str) -> bool:
    """Whether two units are one, which may be written in several ways."""
    if unit.casefold() == other.casefold():
        return True
    try:
        return bool(set(meanings_of(unit)) & set(meanings_of(other)))
    except ValueError:
        return False
