"""What the first cells of a column are: whole stamps, counts from a known time, or times of day."""

from __future__ import annotations

import datetime
import re
from typing import Any

import numpy as np

from drillid.formats.counted_times import size_of
from drillid.formats.written_times import UnclearDate, parse

_TIME_OF_DAY = re.compile(r"(?:\d{1,2}[:.]\d{2}([:.].*)?|\d{1,6}([.,]\d*)?)(?: ?[AaPp]\.?[Mm]\.?)?")


def holds_stamps(cells: Any) -> bool:
    """Whether Arrow cells are stamps of date and time, of their own type or as text."""
    import pyarrow as pa

    kind = cells.type.value_type if pa.types.is_dictionary(cells.type) else cells.type
    if pa.types.is_timestamp(kind):
        return True
    if not (pa.types.is_string(kind) or pa.types.is_large_string(kind)):
        return False
    first = _first(cells)
    try:
        found = parse(pa.chunked_array([[str(first)]], pa.string()))
    except UnclearDate:
        return True
    return found is not None and found.dated and found.timed and not found.wrong[0]


def counts_stamps(cells: Any) -> bool:
    """Whether Arrow cells are numbers, which may be text, that count from a known time such as 1970."""
    try:
        numbers = np.array([float(cell.as_py()) for cell in cells if cell.is_valid])
    except (TypeError, ValueError):
        return False
    return numbers.size > 0 and size_of(numbers) is not None


def is_time_of_day(cells: Any) -> bool:
    """Whether the first of some Arrow cells is a time of day without a date."""
    first = _first(cells)
    if isinstance(first, datetime.time | datetime.timedelta):
        return True
    if isinstance(first, datetime.datetime):
        return first.year <= 1900
    if isinstance(first, int | float):
        return 0 <= first < 240_000
    return first is not None and _TIME_OF_DAY.fullmatch(str(first).strip()) is not None


def _first(cells: Any) -> Any:
    return next((cell.as_py() for cell in cells if cell.is_valid), None)
