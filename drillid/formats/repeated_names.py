"""Columns of the same name in one table: which is read, and whether each channel has times of its own."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from drillid.errors import LogError
from drillid.formats.description import Header, Note
from drillid.formats.stamps import utc_stamps
from drillid.formats.stated_times import StatedTimes

_REMEDY = (
    "Write each column of times and the columns after it into a file of its own; logs of a well are joined by time"
)


def first_of_repeated(columns: Sequence[str], header: Header) -> Iterator[Note]:
    """Notes on the names that several columns of the header have."""
    for name in columns:
        if f"{name}:2" in header.columns:
            what = f"has several columns '{name}'; the first is read"
            yield what, f"Name '{name}:2' in the rig description if the second is meant"


def check_repeated_times(times: StatedTimes, wanted: Sequence[str], read: Callable[[list[str]], Any]) -> None:
    """Refuse a table in which columns of numbers follow times of their own that are not those of the table.

    Trends are often exported with a column of times before every channel. Such a table is read by one of them
    only where all are alike.

    Parameters
    ----------
    times : columns of the times by which the table is read
    wanted : columns of numbers
    read : reads some columns unchanged into an Arrow table

    Raises
    ------
    LogError
        If the times before one of the columns differ; the message names both columns and a row.
    """
    for own, followed in _other_times(times, wanted).items():
        names = [name for name in (times.column, times.date, *own) if name is not None]
        table = read(list(dict.fromkeys(names)))
        differing = _first_difference(times, replace(times, column=own[0], date=own[1]), table)
        if differing is not None:
            row, expected, other = differing
            raise LogError(
                times.places.cell(own[0], row),
                f"the times before column '{followed}' are not those in '{times.column}': {other} and {expected}",
                _REMEDY,
            )


def _other_times(times: StatedTimes, wanted: Sequence[str]) -> dict[tuple[str, str | None], str]:
    """Repeats of the columns of times and dates before wanted columns, each with the first column that follows it.

    Where no column follows the times themselves, those beside them are the same in another form, and none are returned.
    """
    used = times.column, times.date
    column, date = used
    found, followed = dict[tuple[str, str | None], str](), set[tuple[str, str | None]]()
    for name in times.places.header.columns:
        if _repeats(name, times.column):
            column = name
        elif times.date is not None and _repeats(name, times.date):
            date = name
        else:
            followed.add((column, date))
            if name in wanted and (column, date) != used:
                found.setdefault((column, date), name)
    return found if used in followed else {}


def _repeats(name: str, of: str) -> bool:
    """Whether two columns have the same name in the file, or are the same."""
    return _in_file(name) == _in_file(of)


def _in_file(name: str) -> str:
    own, _, number = name.rpartition(":")
    return own if own and number.isdigit() else name


def _first_difference(times: StatedTimes, others: StatedTimes, table: Any) -> tuple[int, str, str] | None:
    """The first row whose times differ, and both, UTC; rows without the other times have no values in their columns."""
    import pyarrow.compute as pc

    pairs = [(times.column, others.column)] + ([(times.date, others.date)] if times.date else [])
    if all(table.column(one).equals(table.column(other)) for one, other in pairs):
        return None
    rows = np.flatnonzero(pc.is_valid(table.column(others.column)).to_numpy())
    held = table.take(rows)
    first, second = (utc_stamps(each, held, ambiguous=True)[0] for each in (times, others))
    different = np.flatnonzero(first != second)
    if not different.size:
        return None
    at = different[0]
    one, other = (str(np.datetime_as_string(each[at], "ms")) for each in (first, second))
    return int(rows[at]), one, other
