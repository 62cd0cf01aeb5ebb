"""Numbers as offices write them: decimal commas, separated thousands."""

from __future__ import annotations

import re
from collections.abc import Sequence
from typing import Any

from drillid.formats.description import Unusable
from drillid.formats.text_layout import decimal_of

_SPACES = "\u00a0\u202f\u2009 '’"
"""Characters that separate thousands and are never decimal marks."""
_UNCLEAR = r"^[+-]?[1-9]\d{0,2},\d{3}$"


def with_numbers(table: Any, columns: Sequence[str], decimal: str | None, thousands: str | None, delimiter: str) -> Any:
    """A table of text in which those of the columns that hold nothing but numbers are float64.

    Parameters
    ----------
    columns : columns of numbers
    decimal, thousands : decimal mark and thousands separator, where they are known
    delimiter : between the cells; numbers of a file with commas between its cells have decimal points

    Raises
    ------
    Unusable
        If commas may be decimal marks or thousands separators, and nothing in the file shows which.
    """
    decimal = decimal or _decimal(table, columns, delimiter, thousands)
    for name in columns:
        position = table.column_names.index(name)
        numbers = _as_numbers(table.column(name), decimal, thousands)
        if numbers is not None:
            table = table.set_column(position, name, numbers)
    return table


def _decimal(table: Any, columns: Sequence[str], delimiter: str, thousands: str | None) -> str:
    """The decimal mark, from all cells of all columns."""
    import pyarrow.compute as pc

    if thousands is not None:
        return "," if thousands == "." else "."
    unclear = None
    for name in columns:
        column = pc.utf8_trim_whitespace(table.column(name))
        with_comma = column.filter(pc.fill_null(pc.match_substring_regex(column, r"^[+-]?[\d.,'’\s\xa0]*,\d*$"), False))
        if not len(with_comma):
            continue
        found = decimal_of(set(pc.unique(with_comma).to_pylist()))
        if found is not None:
            return found
        unclear = unclear or (name, with_comma[0].as_py())
    if unclear is not None and delimiter != ",":
        raise Unusable(
            f"has cells such as '{unclear[1]}' in column '{unclear[0]}': is the comma for decimals or thousands?",
            "State file.decimal in the rig description",
        )
    return "."


def _as_numbers(column: Any, decimal: str, thousands: str | None) -> Any:
    """The column as float64; None where a cell is not a number."""
    import pyarrow as pa
    import pyarrow.compute as pc

    between = thousands if thousands is not None else ("." if decimal == "," else ",")
    spaces = re.escape(_SPACES)
    point = re.escape(decimal)
    grouped = rf"^[+-]?\d{{1,3}}(?:[{spaces}{re.escape(between)}]\d{{3}})+(?:{point}\d*)?$"
    cells = pc.utf8_trim_whitespace(column)
    separated = pc.fill_null(pc.match_substring_regex(cells, grouped), False)
    joined = pc.replace_substring_regex(cells, rf"[{spaces}{re.escape(between)}]", "")
    cells = pc.if_else(separated, joined, cells)
    if decimal == ",":
        # a cell with a point that does not separate thousands is not a number here
        cells = pc.if_else(pc.match_substring(cells, "."), "not a number", pc.replace_substring(cells, ",", "."))
    cells = pc.if_else(pc.equal(cells, ""), pa.scalar(None, pa.string()), cells)
    try:
        return cells.cast(pa.float64())
    except pa.ArrowInvalid:
        return None
