"""Times that are numbers: counts from 1970, days of workbooks and MATLAB, seconds from a stated start."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from drillid.arrays import Floats, Integers

_S, _DAY = 1_000_000_000, 86_400_000_000_000
COUNTED: dict[str, tuple[float, int]] = {
    "ns": (1.0, 0),
    "us": (1e3, 0),
    "ms": (1e6, 0),
    "s": (_S, 0),
    "min": (60 * _S, 0),
    "h": (3600 * _S, 0),
    "day": (_DAY, 0),
    "excel": (_DAY, -25569 * _DAY),
    "matlab": (_DAY, 0),
    "labview": (_S, -2_082_844_800 * _S),
    "ticks": (100, 0),
    "filetime": (100, 0),
}
"""Units of times that are numbers: ns of each, and ns from 1970 to its zero where ns can hold that."""
LOCAL = ("excel", "matlab", "ticks")
"""Units whose times are local clock times."""
_AT_1970 = {"matlab": 719529, "ticks": 621_355_968_000_000_000, "filetime": 116_444_736_000_000_000}
"""Values at the start of 1970 of counts whose zero ns cannot hold."""
_SPELLINGS = {
    **dict.fromkeys(("s", "sec", "secs", "second", "seconds"), "s"),
    **dict.fromkeys(("ms", "msec", "millisecond", "milliseconds"), "ms"),
    **dict.fromkeys(("us", "µs", "μs", "usec", "microsecond", "microseconds"), "us"),
    **dict.fromkeys(("ns", "nsec", "nanosecond", "nanoseconds"), "ns"),
    **dict.fromkeys(("min", "mins", "minute", "minutes"), "min"),
    **dict.fromkeys(("h", "hr", "hrs", "hour", "hours"), "h"),
    **dict.fromkeys(("d", "day", "days"), "day"),
}
_SIZES = (
    ("s", 6.3e8, 2.53e9),
    ("ms", 6.3e11, 2.53e12),
    ("us", 6.3e14, 2.53e15),
    ("ns", 7.5e17, 2.53e18),
    ("ticks", 6.277e17, 6.466e17),
    ("filetime", 1.2275e17, 1.4174e17),
    ("labview", 3.02e9, 4.7e9),
    ("excel", 32874, 54789),
    ("matlab", 726834, 748750),
)
"""Sizes of times between 1990 and 2050; LabVIEW's from 2000, ns from October 1993, as ticks of .NET are smaller."""
_LAST = 2.53e18
"""Ns from 1970 to 2050."""
_LONGEST_STEP_DAYS = 6e-5
"""Largest usual step of times in days, 5 s; as a number, the smallest step of times in seconds is larger."""

_DECIDED = {
    "excel": "days of a workbook",
    "matlab": "days of MATLAB",
    "labview": "s since 1904",
    "ticks": "ticks of .NET, 100 ns since the year 1",
    "filetime": "file times of Windows, 100 ns since 1601",
}
"""How a note describes numbers that do not count from 1970."""


@dataclass(frozen=True)
class Counted:
    """Times from numbers.

    since : ns since 1970, shape (row,)
    zoned : whether they are UTC; else local clock times
    decided : what was inferred from the numbers' size, else empty
    """

    since: Integers
    zoned: bool
    decided: str = ""


class NoStart(ValueError):
    """Numbers that count from an unstated time."""


def unit_named(text: str) -> str | None:
    """The unit of `COUNTED` that a file's header names."""
    return _SPELLINGS.get(text.strip().lower())


def from_numbers(
    values: Floats | Integers, unit: str | None, start: tuple[int, bool] | None, header_unit: str | None
) -> Counted:
    """Times from numbers.

    Parameters
    ----------
    values : shape (row,), all finite
    unit : one of `COUNTED`, as the user states it
    start : time of zero, ns since 1970, and whether that is UTC
    header_unit : unit in the file's header

    Raises
    ------
    NoStart
        If the numbers count from an unknown time.
    ValueError
        If a time is outside the years that nanoseconds can hold.
    """
    if start is not None:
        used = unit or header_unit or "s"
        size, _ = COUNTED[used]
        return Counted(_scaled(values, size) + start[0], start[1])
    if unit is not None and unit not in ("min", "h", "day"):
        return Counted(_absolute(values, unit), unit not in LOCAL)
    found = size_of(values)
    if found is None or (header_unit is not None and found in COUNTED and not _agrees(found, header_unit)):
        raise NoStart
    return Counted(_absolute(values, found), found not in LOCAL, _DECIDED.get(found, f"{found} since 1970"))


def are_dates(values: Floats | Integers, unit: str | None, start: int) -> bool:
    """Whether numbers are, by their size, times from 1990 to 2050 although a start is stated beside them.

    Those that may equally be s or the like from the start count only where they would then lie after 2050.

    Parameters
    ----------
    values : shape (row,), all finite
    unit : one of `COUNTED`, from the file's header; s where None
    start : ns since 1970
    """
    found = size_of(values)
    last = start + float(np.median(values)) * COUNTED[unit or "s"][0]
    return found in LOCAL or (found is not None and last > _LAST)


def size_of(values: Floats | Integers) -> str | None:
    """The unit in which the numbers are times between 1990 and 2050; None where there is none."""
    middle = float(np.median(values))
    steps = np.abs(np.diff(values[:1000]))
    usual = float(np.median(steps)) if steps.size else 0.0
    for unit, low, high in _SIZES:
        if low <= middle <= high and (COUNTED[unit][0] != _DAY or usual < _LONGEST_STEP_DAYS):
            return unit
    return None


def _agrees(found: str, header_unit: str) -> bool:
    """Whether the header's unit does not contradict the numbers' size."""
    return COUNTED[found][0] == COUNTED[header_unit][0]


def _absolute(values: Floats | Integers, unit: str) -> Integers:
    size, zero = COUNTED[unit]
    return _scaled(values - _AT_1970.get(unit, 0), size, values) + zero


def _scaled(values: Floats | Integers, size: float, as_written: Floats | Integers | None = None) -> Integers:
    """Numbers in units of `size` ns as whole ns, rounded to what floats of their size resolve."""
    if np.any(np.abs(np.asarray(values, dtype=float)) * size > 2.0**62):
        raise ValueError("the time is outside the range of years that can be stored")
    if values.dtype.kind in "iu":
        return np.asarray(values.astype(np.int64) * round(size))
    largest = float(np.max(np.abs(values if as_written is None else as_written), initial=0.0))
    resolved = 10 ** max(0, int(np.ceil(np.log10(max(np.spacing(largest) * size, 1.0)))))
    whole = np.floor(values)
    rest = np.rint((values - whole) * (size / resolved)).astype(np.int64) * resolved
    return np.asarray(whole.astype(np.int64) * round(size) + rest)
