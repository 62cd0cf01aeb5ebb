"""Times as people and recorders write them: any order of day, month and year, AM and PM, times of day."""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from drillid.arrays import Booleans, Integers

DAY_FIRST, MONTH_FIRST = "day first", "month first"
ORDERS = (DAY_FIRST, MONTH_FIRST)
"""Orders of day and month that users may state as the format."""
DAY_NS = 86_400_000_000_000

_MOSTLY_MIXED, _SELDOM_MIXED = 0.5, 0.05
"""Least share of the seconds in which fractions jump as decimals, and largest in which they do as milliseconds, where
these lack zeros: a few rows may be out of order.
"""
_MONTHS = ("jan", "feb", "mar", "apr", "may", "jun", "jul", "aug", "sep", "oct", "nov", "dec")
_OTHER_MONTHS = {"mai": 5, "okt": 10, "dez": 12, "des": 12, "mär": 3, "mrz": 3, "ene": 1, "abr": 4, "ago": 8, "dic": 12}
MONTHS = (*_MONTHS, *_OTHER_MONTHS)
"""Beginnings of the names of months, in the languages that are known."""
_WEEKDAY = r"(?:[A-Za-z]{3,9},? +)?"
_YEAR_FIRST = r"(?P<year>\d{4})[-/.](?P<month>\d{1,2})[-/.](?P<day>\d{1,2})"
_NUMBERS = r"(?P<first>\d{1,2})(?P<sign>[-/. ])(?P<second>\d{1,2})[-/. ](?P<year>\d{4})"
_DAY_NAME = r"(?P<day>\d{1,2})(?:st|nd|rd|th)?[-/. ]*(?P<name>[^\W\d_]{3,9})[-/., ]*(?P<year>\d{4})"
_NAME_DAY = r"(?P<name>[^\W\d_]{3,9})\.?[- ]*(?P<day>\d{1,2})(?:st|nd|rd|th)?[-, ]+(?P<year>\d{4})"
_COMPACT = r"(?P<year>\d{4})(?P<month>\d{2})(?P<day>\d{2})"
_CLOCK = (
    r"(?P<hour>\d{1,2})[:hH.](?P<minute>\d{2})(?:[:mM.](?P<sec>\d{2})(?:[.,:](?P<fraction>\d{1,9})\d*)?[sS]?)?"
    r" ?(?P<half>[AaPp]\.?[Mm]\.?)?"
)
_COMPACT_CLOCK = r"(?P<hour>\d{2})(?P<minute>\d{2})(?P<sec>\d{2})(?:[.,](?P<fraction>\d{1,9})\d*)?(?P<half>)"
_ZONE = r" ?(?P<zone>[zZ]|UTC|GMT|[+-]\d{2}(?::?\d{2})?)?"
_BETWEEN = r"(?:[T_, ]+(?:- )?|/)"
_DATES = (_YEAR_FIRST, _NUMBERS, _DAY_NAME, _NAME_DAY, _COMPACT)
_PATTERNS = (
    *(f"^{_WEEKDAY}{date}{_BETWEEN}{_CLOCK}{_ZONE}$" for date in _DATES),
    f"^{_COMPACT}[T_ -]?{_COMPACT_CLOCK}{_ZONE}$",
    *(f"^{_WEEKDAY}{date}$" for date in _DATES),
    *(f"^{_CLOCK}{_BETWEEN}{_WEEKDAY}{date}$" for date in _DATES[:-1]),
    f"^{_CLOCK}{_ZONE}$",
)
_WITH_FRACTION = (
    r"^(?P<second>(?:.*[ T_,])?\d{1,2}[:hH.]\d{2}[:mM.]\d{2})(?:(?P<sign>[.,:])(?P<fraction>\d{1,3}))?(?P<rest>\D.*)?$"
)
_TOKENS = {"YYYY": "%Y", "YY": "%y", "MMM": "%b", "MM": "%m", "DD": "%d", "HH": "%H", "SSS": "%f", "SS": "%S"}
_SHORT_YEAR = re.compile(r"^(?:\d{1,2}([-/.])\d{1,2}\1\d{2}|\d{1,2}[- ]?[A-Za-z]{3}[- ]?\d{2}|\d{6})(?!\d)(?![-/.:]\d)")


@dataclass(frozen=True)
class Written:
    """A column of written times.

    since : ns since 1970, or since midnight where there is no date, shape (row,); meaningless in `wrong` rows
    wrong : cells that are not times, shape (row,)
    zoned : whether the times are UTC already; else they are local clock times
    dated, timed : whether the cells hold dates and times of day
    decided : why this order of day and month is assumed, empty where there was nothing to decide
    offset : of the first cell's zone from UTC, ns; 0 without one
    """

    since: Integers
    wrong: Booleans
    zoned: bool
    dated: bool
    timed: bool
    decided: str = ""
    offset: int = 0


class UnclearDate(ValueError):
    """Dates that do not show whether the day or the month comes first."""


def has_short_year(cell: str) -> bool:
    """Whether a date has a two-digit year."""
    return _SHORT_YEAR.match(cell.strip()) is not None


def format_in(unit: str) -> str | None:
    """The strptime format of a unit such as 'DD/MM/YY' or 'YYYY-MM-DD hh:mm:ss'; None for one without a date."""
    text, found, clock = unit.strip().strip("{}[]()").upper(), "", False
    while text:
        token = next((token for token in _TOKENS if text.startswith(token)), text[0])
        clock = clock or token == "HH"
        if token not in _TOKENS and token not in " -/.:,T_":
            return None
        found += "%M" if clock and token == "MM" else _TOKENS.get(token, token)
        text = text[len(token) :]
    return found if "%d" in found and re.search("%[mb]", found) and re.search("%[yY]", found) else None


def order_in(form: str) -> str | None:
    """The order of day and month in a strptime format; None where it leaves no doubt by itself."""
    if form.startswith("%Y") or "%b" in form:
        return None
    return DAY_FIRST if form.index("%d") < form.index("%m") else MONTH_FIRST


def with_whole_milliseconds(cells: Any) -> tuple[Any, bool]:
    """Times whose milliseconds lack leading zeros, such as '06:00:00.50' and '06:00:00.100' in turn, with these zeros.

    Zeros are missing where the fractions differ in length and, within nearly every second, only rise or only fall as
    whole milliseconds, but not as decimals. Other times stay as they are.

    Parameters
    ----------
    cells : Arrow column, shape (row,); unchanged if it is not text

    Returns
    -------
    The cells, and whether zeros were added.
    """
    import pyarrow as pa
    import pyarrow.compute as pc

    if not pa.types.is_string(cells.type) or cells.null_count or len(cells) < 2:
        return cells, False
    lengths = pc.min_max(pc.utf8_length(cells)).as_py()
    if lengths["min"] == lengths["max"]:
        return cells, False
    found = pc.extract_regex(pc.utf8_trim_whitespace(cells), _WITH_FRACTION).combine_chunks()
    if found.null_count:
        return cells, False
    second, sign, fraction, rest = (pc.struct_field(found, name) for name in ("second", "sign", "fraction", "rest"))
    padded = pc.if_else(pc.equal(fraction, ""), "", pc.utf8_lpad(fraction, 3, "0"))
    whole, decimals = (
        np.asarray(pc.cast(each(fraction, 3, "0"), pa.int64()).to_numpy(zero_copy_only=False))
        for each in (pc.utf8_lpad, pc.utf8_rpad)
    )
    within = np.asarray(pc.equal(second[1:], second[:-1]).to_numpy(zero_copy_only=False))
    widths = set(pc.unique(pc.utf8_length(fraction)).to_pylist()) - {0}
    zero_first = pc.any(pc.match_substring_regex(fraction, r"^0\d")).as_py()
    if len(widths) < 2 or 3 not in widths or zero_first:
        return cells, False
    if _mixed(decimals, within) < _MOSTLY_MIXED or _mixed(whole, within) > _SELDOM_MIXED:
        return cells, False
    return pa.chunked_array([pc.binary_join_element_wise(second, sign, padded, rest, "")]), True


def _mixed(values: Integers, within: Booleans) -> float:
    """Share of the seconds in which values both rise and fall, of those in which they change at all.

    Parameters
    ----------
    within : whether a row and the next one are within a second, shape (row - 1,)
    """
    steps, second = np.diff(values), np.cumsum(~within)
    rises, falls = (np.bincount(second[within & way], minlength=second[-1] + 1) > 0 for way in (steps > 0, steps < 0))
    return float(np.sum(rises & falls)) / max(float(np.sum(rises | falls)), 1.0)


def parse(cells: Any, order: str | None = None) -> Written | None:
    """Times from text, all in the form of the first cell; None where that form is not known.

    Parameters
    ----------
    cells : Arrow text
    order : one of `ORDERS`, where the user states it

    Raises
    ------
    UnclearDate
        If days and months cannot be distinguished.
    """
    import pyarrow.compute as pc

    trimmed = pc.utf8_trim_whitespace(cells)
    first = next((cell.as_py() for cell in trimmed if cell.is_valid and cell.as_py()), "")
    patterns = [pattern for pattern in _PATTERNS if re.match(pattern, first)]
    if not patterns:
        return None
    parts = pc.extract_regex(trimmed, patterns[0]).combine_chunks()
    return _from_parts(_Parts(parts, _filled(pc.is_null(parts), True)), order)


def parse_one(text: str) -> Written | None:
    """A single text as a column of one row; None where it is not a time, or unclear about day and month."""
    import pyarrow as pa

    if not text:
        return None
    try:
        found = parse(pa.chunked_array([[text]]))
    except UnclearDate:
        return None
    return None if found is None or found.wrong[0] else found


@dataclass(frozen=True)
class _Parts:
    """Parts of all cells, as text; `missing` marks cells of another form."""

    struct: Any
    missing: Booleans

    def has(self, name: str) -> bool:
        return bool(self.struct.type.get_field_index(name) >= 0)

    def text(self, name: str) -> Any:
        import pyarrow as pa
        import pyarrow.compute as pc

        if not self.has(name):
            return pa.array([""] * len(self.missing))
        return pc.fill_null(pc.struct_field(self.struct, name), "")

    def number(self, name: str) -> Integers:
        """A part as whole numbers, 0 where it is empty."""
        import pyarrow as pa
        import pyarrow.compute as pc

        if not self.has(name):
            return np.zeros(len(self.missing), dtype=np.int64)
        text = self.text(name)
        digits = pc.if_else(pc.equal(text, ""), "0", text)
        return np.asarray(digits.cast(pa.int64()).to_numpy(zero_copy_only=False))


def _from_parts(parts: _Parts, order: str | None) -> Written:
    wrong, decided = parts.missing.copy(), ""
    dated, timed = parts.has("year"), parts.has("hour")
    since = np.zeros(wrong.size, dtype=np.int64)
    if timed:
        clock, bad = _time_of_day(parts)
        since, wrong = since + clock, wrong | bad
    if dated:
        if parts.has("first"):
            day, month, decided = _ordered(parts, since, order)
        else:
            day, month = parts.number("day"), _month(parts)
        days, bad = _days(parts.number("year"), month, day)
        since, wrong = since + days * DAY_NS, wrong | bad
    offset, zoned, bad = _offsets(parts)
    first = int(offset[0]) if offset.size else 0
    return Written(since - offset, wrong | bad, zoned, dated, timed, decided, first)


def _time_of_day(parts: _Parts) -> tuple[Integers, Booleans]:
    """Time since midnight, ns."""
    hour, minute, second = (parts.number(name) for name in ("hour", "minute", "sec"))
    wrong = (hour > 23) | (minute > 59) | (second > 60)
    halves = _Values(parts, "half")
    if any(halves.values()):
        after = halves.of(lambda half: half.lower().startswith("p"))
        either = halves.of(bool)
        wrong |= either & ((hour > 12) | (hour == 0))
        hour = np.where(either, hour % 12 + 12 * after, hour)
    fractions = _Values(parts, "fraction")
    nanoseconds = fractions.numbers(lambda digits: int(digits.ljust(9, "0")) if digits else 0)
    return ((hour * 60 + minute) * 60 + second) * 1_000_000_000 + nanoseconds, wrong


class _Values:
    """One part of all cells, by its few different values."""

    def __init__(self, parts: _Parts, name: str) -> None:
        encoded = parts.text(name).dictionary_encode()
        self.different: list[str] = encoded.dictionary.to_pylist()
        self.index = np.asarray(encoded.indices.to_numpy(zero_copy_only=False))

    def values(self) -> list[str]:
        """The different values."""
        return self.different

    def of(self, test: Any) -> Booleans:
        """A property of the value in each row."""
        return np.asarray(np.array([bool(test(value)) for value in self.different], dtype=bool)[self.index])

    def numbers(self, convert: Any) -> Integers:
        """A number for the value in each row."""
        return np.asarray(np.array([convert(value) for value in self.different], dtype=np.int64)[self.index])


def _month(parts: _Parts) -> Integers:
    return _Values(parts, "name").numbers(_named_month) if parts.has("name") else parts.number("month")


def _named_month(name: str) -> int:
    start = name[:3].lower()
    return _MONTHS.index(start) + 1 if start in _MONTHS else _OTHER_MONTHS.get(start, 0)


def _days(year: Integers, month: Integers, day: Integers) -> tuple[Integers, Booleans]:
    """Days since 1970 and whether there is such a day."""
    wrong = (month < 1) | (month > 12) | (day < 1) | (day > 31) | (year < 1678) | (year > 2261)
    months = ((np.where(wrong, 1970, year) - 1970) * 12 + np.where(wrong, 1, month) - 1).astype("datetime64[M]")
    first = months.astype("datetime64[D]").astype(np.int64)
    length = (months + 1).astype("datetime64[D]").astype(np.int64) - first
    return first + day - 1, wrong | (day > length)


def _ordered(parts: _Parts, clock: Integers, order: str | None) -> tuple[Integers, Integers, str]:
    """Day, month and the reason for their order."""
    first, second, year = parts.number("first"), parts.number("second"), parts.number("year")
    good = ~parts.missing
    if order is None:
        order, why = _order(first[good], second[good], year[good], clock[good], _Values(parts, "sign").values())
    else:
        why = ""
    return (first, second, why) if order == DAY_FIRST else (second, first, why)


def _order(first: Integers, second: Integers, year: Integers, clock: Integers, signs: list[str]) -> tuple[str, str]:
    """The order of day and month that the data show, and how they show it."""
    if np.any(first > 12):
        return DAY_FIRST, f"{DAY_FIRST}, as one of them is {_date(first, second, year, int(np.argmax(first > 12)))}"
    if np.any(second > 12):
        return (
            MONTH_FIRST,
            f"{MONTH_FIRST}, as one of them is {_date(first, second, year, int(np.argmax(second > 12)))}",
        )
    if np.all(first == second):
        return DAY_FIRST, ""
    if signs == ["."]:
        return DAY_FIRST, f"{DAY_FIRST}, as dates with points are"
    changes = np.flatnonzero((np.diff(first) != 0) | (np.diff(second) != 0))
    steps = []
    for day, month in ((first, second), (second, first)):
        stamps = _days(year, month, day)[0] * DAY_NS + clock
        steps.append(np.abs(np.diff(stamps))[changes].max() if changes.size else 0)
    near, far = min(steps), max(steps)
    if changes.size and near <= DAY_NS and far >= 20 * DAY_NS:
        order = DAY_FIRST if steps[0] == near else MONTH_FIRST
        return order, f"{order}, as {_date(first, second, year, int(changes[0]) + 1)} follows within a day"
    raise UnclearDate


def _date(first: Integers, second: Integers, year: Integers, row: int) -> str:
    return f"'{first[row]:02d}/{second[row]:02d}/{year[row]}'"


def _offsets(parts: _Parts) -> tuple[Integers, bool, Booleans]:
    """Offset from UTC in ns, whether the cells have one, and the cells that differ in that from most others."""
    size = parts.missing.size
    if not parts.has("zone"):
        return np.zeros(size, dtype=np.int64), False, np.zeros(size, dtype=bool)
    zones = _Values(parts, "zone")
    has = zones.of(bool)
    zoned = bool(np.mean(has) > 0.5)
    return zones.numbers(_offset), zoned, has != zoned


def _offset(zone: str) -> int:
    if not zone.startswith(("+", "-")):
        return 0
    digits = zone[1:].replace(":", "").ljust(4, "0")
    minutes = int(digits[:2]) * 60 + int(digits[2:])
    return (-1 if zone[0] == "-" else 1) * minutes * 60_000_000_000


def _filled(column: Any, value: bool) -> NDArray[np.bool_]:
    import pyarrow.compute as pc

    return np.asarray(pc.fill_null(column, value).to_numpy(zero_copy_only=False)).copy()
