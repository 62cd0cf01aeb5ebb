"""Rows of a log in order of time: impossible stamps, stray stamps, repeated rows, shuffled rows."""

from __future__ import annotations

import numpy as np
from scipy.ndimage import median_filter

from drillid.arrays import Booleans, Floats, Integers
from drillid.errors import LogError

_NS_PER_S = 1_000_000_000
FIRST_YEAR, LAST_YEAR = 1980, 2100
"""No digital recorder stamped earlier; zeroed bytes read as 1970, counts in a wrong unit as 1970 or the far future."""
_STRAY_ROWS = 20
"""Runs of up to this many stamps that are far off those on either side are damaged."""
_STRAY_S = 60.0
"""Deviation from the surrounding stamps beyond which a stamp is stray, s; clocks that are merely late are kept."""
_SHUFFLED = 0.05
"""Share of rows that are followed by an earlier one, above which their order is not that of time."""
_DEEP = 1.5
"""Step back in time from a row to a later one, in intervals, that no jitter of stamps explains."""
_SORTABLE = 0.2
"""Largest share of rows within half an interval of another once sorted; beyond it stamps do not give an order."""


def outside_years(stamps: Integers) -> Booleans:
    """Stamps (ns since 1970 UTC) that no recorder can have written, shape (row,)."""
    first, last = (np.datetime64(f"{year}-01-01", "ns").astype(np.int64).item() for year in (FIRST_YEAR, LAST_YEAR))
    return np.asarray((stamps < first) | (stamps >= last))


def stray(stamps: Integers) -> Booleans:
    """Stamps (ns) of a few rows that are far off those of the rows around them, shape (row,).

    Stamps that only increase, and those of a clock that was set once, are their own running median up to a few rows.
    """
    steps = np.diff(stamps)
    backwards = steps < -_STRAY_S * _NS_PER_S
    if not np.any(backwards) or np.mean(backwards) > _SHUFFLED:
        return np.zeros(stamps.size, dtype=bool)
    forward = steps[steps > 0]
    usual = float(np.median(forward)) if forward.size else 0.0
    around = median_filter(stamps, 2 * _STRAY_ROWS + 1, mode="nearest")
    return np.asarray(np.abs(stamps - around) > max(_STRAY_S * _NS_PER_S, 2 * _STRAY_ROWS * usual))


def without_repeats(stamps: Integers, sweep: Floats, speed: Floats) -> tuple[Integers, Integers]:
    """Rows to keep and rows that repeat an earlier row's stamp and signals."""
    import pandas as pd

    repeats = np.zeros(stamps.size, dtype=bool)
    if np.any(np.diff(stamps) <= 0):
        order = np.argsort(stamps, kind="stable")
        same = np.diff(stamps[order]) == 0
        alike = np.sort(order[np.concatenate([[False], same]) | np.concatenate([same, [False]])])
        rows = {"stamp": stamps[alike], "sweep": sweep[alike], "speed": speed[alike]}
        repeats[alike] = pd.DataFrame(rows).duplicated().to_numpy()
    return np.flatnonzero(~repeats), np.flatnonzero(repeats)


def sorted_if_shuffled(stamps: Integers, rows: Integers, where: str) -> tuple[Integers, int]:
    """Rows sorted by stamp where the file's order is not that of time, and the number of rows that moved.

    A descending log and one in random order are sorted; rows that lie apart here and there are left to `in_order`,
    which distinguishes them from a clock that was set.

    Raises
    ------
    LogError
        If the rows are in no order and their stamps are too coarse or too rough to give one.
    """
    steps = np.diff(stamps[rows])
    if not np.any(steps < 0):
        return rows, 0
    ordered = rows[np.argsort(stamps[rows], kind="stable")]
    after = np.diff(stamps[ordered])
    usual = float(np.median(after[after > 0]))
    if np.mean(steps < 0) <= 0.5 and np.mean(steps < -_DEEP * usual) <= _SHUFFLED:
        return rows, 0
    shared = float(np.mean(after < 0.5 * usual))
    if shared > _SORTABLE:
        raise LogError(
            where,
            f"its rows are not in order of time, and {100 * shared:.0f} % of its stamps are too close together to sort",
            "Export the log in the order of time, with stamps in fractions of a second",
        )
    return ordered, int(np.sum(ordered != rows))


def in_order(stamps: Integers, rows: Integers, interval: float) -> tuple[Integers, int]:
    """Rows sorted by stamp, where that opens no gap and no two rows then share a tick; else the clock was set."""
    steps = np.diff(stamps[rows]) * 1e-9
    if not np.any(steps < -0.5 * interval):
        return rows, 0
    ordered = rows[np.argsort(stamps[rows], kind="stable")]
    after = np.diff(stamps[ordered]) * 1e-9
    shared = np.sum(after < 0.5 * interval) > np.sum(np.abs(steps) < 0.5 * interval)
    # a clock that was set leaves rows that share a tick, or one gap more
    torn = np.sum(after > 1.5 * interval) > np.sum(steps > 1.5 * interval)
    if shared or torn:
        return rows, 0
    return ordered, int(np.sum(ordered != rows))
