"""Times as year, month, day, hour, minute and second in a column each."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from drillid.arrays import Floats, Integers
from drillid.formats.stated_times import Naive, StatedTimes

_BOUNDS = ((0, 2200), (1, 12), (1, 31), (0, 23), (0, 59), (0, 60.999999))
"""Least and largest values of each part; a second of 60 is a leap second, or rounded."""
_CENTURY, _FIRST_OF_1900S = 100, 80
"""Years below the first belong to this century, those from the second on to the last one."""


def of_parts(of: StatedTimes, columns: Sequence[Any]) -> Naive:
    """Times of the six columns of `of.parts`; all but seconds are whole numbers.

    Raises
    ------
    LogError
        With the place of a cell that is not part of a date or a time of day.
    """
    year, month, day, hour, minute, second = (
        _part(replace(of, column=name, parts=()), column, *bounds, whole=name != of.parts[-1])
        for name, column, bounds in zip(of.parts, columns, _BOUNDS, strict=True)
    )
    short = year < _CENTURY
    year = np.where(short, year + np.where(year < _FIRST_OF_1900S, 2000, 1900), year)
    months = _whole((year - 1970) * 12 + month - 1).astype("datetime64[M]")
    days = months.astype("datetime64[D]") + (_whole(day) - 1)
    outside = np.flatnonzero(days.astype("datetime64[M]") != months)
    if outside.size:
        row = int(outside[0])
        raise replace(of, column=of.parts[2], parts=()).wrong(row, columns[2][row].as_py())
    seconds = _whole(hour * 3600 + minute * 60)
    fraction = np.rint(second * 1e6).astype(np.int64) * 1000
    return Naive(days.astype("datetime64[ns]").astype(np.int64) + seconds * 1_000_000_000 + fraction, False)


def _part(of: StatedTimes, column: Any, low: float, high: float, *, whole: bool) -> Floats:
    import pyarrow as pa
    import pyarrow.compute as pc

    of.check_complete(column)
    text = pc.replace_substring(pc.utf8_trim_whitespace(column.cast(pa.string())), ",", ".")
    is_number = pc.match_substring_regex(text, r"^\d+(?:\.\d*)?$").to_numpy()
    if not np.all(is_number):
        row = int(np.argmin(is_number))
        raise of.wrong(row, column[row].as_py())
    values = np.asarray(text.cast(pa.float64()).to_numpy())
    fits = (values >= low) & (values <= high) & ((values == np.floor(values)) | (not whole))
    if not np.all(fits):
        row = int(np.argmin(fits))
        raise of.wrong(row, column[row].as_py())
    return values


def _whole(values: Floats) -> Integers:
    return np.asarray(np.rint(values).astype(np.int64))
