"""Dates with named months and years of two digits, such as '24-Aug-16'."""

from __future__ import annotations

from typing import Any

from drillid.formats.description import Note
from drillid.formats.written_times import MONTHS

_MONTH = rf"(?i:{'|'.join(MONTHS)})[a-z]{{0,6}}"
_DATE = rf"^(?P<before>(?:[^/]*[/ ])?)(?P<day>\d{{1,2}})(?P<month>[- ]?{_MONTH}\.?[- ]?)"
_ANY, _LAST_CENTURY, _THIS_CENTURY = (
    rf"{_DATE}(?P<year>{year})(?P<rest>(?:\D.*)?)$" for year in (r"\d\d", r"[89]\d", r"[0-7]\d")
)


def with_long_years(cells: Any) -> tuple[Any, bool]:
    """Cells with four-digit years, from 1980 to 2079, where all are such dates, alone or with a time of day.

    And whether the years were changed. Any other cells stay as they are, and so do those whose last number varies and
    whose first does not, as the first may be the year.

    Parameters
    ----------
    cells : Arrow column of text, shape (row,)
    """
    import pyarrow.compute as pc

    text = pc.utf8_trim_whitespace(cells)
    found = pc.extract_regex(text, _ANY).combine_chunks()
    if not len(found) or found.null_count:
        return cells, False
    days, years = (len(pc.unique(pc.struct_field(found, name))) for name in ("day", "year"))
    if years > 1 and days == 1:
        return cells, False
    for pattern, century in ((_LAST_CENTURY, "19"), (_THIS_CENTURY, "20")):
        text = pc.replace_substring_regex(text, pattern, rf"\1\2\3{century}\4\5")
    return text, True


def of_short_years(column: str) -> Note:
    """A note that dates with two-digit years are read."""
    what = f"the dates in column '{column}' are read as day, month and year of two digits, from 1980 to 2079"
    return what, "State time.format in the rig description if that is wrong"
