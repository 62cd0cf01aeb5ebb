"""Rows that share a stamp: the recorder's stamps are coarser than its samples, or it writes a channel a row."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from drillid.arrays import Array, Booleans, Floats, Indices, Integers

_SHARED = 0.45
"""Share of rows with the stamp of the row before above which stamps are coarser than the samples."""
_FEWEST_STAMPS = 10
"""Least number of different stamps that show a regular number of rows each."""
_LONGEST_NS = 60_000_000_000
"""Longest time from one stamp to the next over which rows are taken to be evenly spaced."""
_REGULAR, _OFF = 0.9, 0.02
"""Share of the stamps that must have the usual number of rows, to within one row or this part of it."""
_WHOLE = 0.5
"""Least share of rows that hold both signals, and largest of rows that repeat a row of the same stamp."""
_FINER = "Export stamps with fractions of a second if the recorder has them"


def evenly(stamps: Integers, sweep: Floats, speed: Floats, repeats: Integers) -> tuple[Integers, int]:
    """Stamps with the rows of each spaced evenly up to the next one, and the usual number of rows per stamp.

    The stamps are unchanged, with 0, where they are fine enough, no number of rows is usual, or the rows of one stamp
    are a single sample: copies, or its channels one by one.

    Parameters
    ----------
    stamps : ns, shape (row,), in the file's order
    sweep, speed : NaN where a row has none, shape (row,)
    repeats : rows that repeat a row of the same stamp
    """
    steps = np.diff(stamps)
    if steps.size == 0 or np.any(steps < 0) or np.mean(steps == 0) <= _SHARED:
        return stamps, 0
    begins = np.flatnonzero(np.concatenate([[True], steps > 0]))
    counts = np.diff(np.append(begins, stamps.size))
    if counts.size < _FEWEST_STAMPS or not _are_samples(sweep, speed, repeats, stamps.size - counts.size):
        return stamps, 0
    unit, usual = int(np.median(np.diff(stamps[begins]))), int(np.median(counts[1:-1]))
    alike = np.abs(counts - usual) <= max(1.0, _OFF * usual)
    on_units = np.all(np.diff(stamps[begins]) % unit == 0)
    if usual < 2 or unit > _LONGEST_NS or not on_units or np.mean(alike[1:-1]) < _REGULAR:
        return stamps, 0
    whole = alike.copy()
    whole[[0, -1]] = False
    alike[[0, -1]] = counts[[0, -1]] > usual
    slots = np.where(alike, counts, np.maximum(counts, usual))
    before = np.zeros_like(counts)
    before[0] = slots[0] - counts[0]
    place = np.arange(stamps.size) - np.repeat(begins - before, counts)
    since = place * (unit / np.repeat(slots, counts))
    _draw_lines(since, stamps, begins, counts, whole, unit / usual)
    return stamps + np.rint(since).astype(np.int64), usual


def one_by_one(stamps: Integers, signals: Sequence[Array]) -> bool:
    """Whether rows share stamps and no stamp has two values of a signal, so that its rows are one sample.

    Parameters
    ----------
    stamps : ns, shape (row,), in the file's order
    signals : NaN where a row has none, each of shape (row,)
    """
    steps = np.diff(stamps)
    if np.any(steps < 0) or not np.any(steps == 0):
        return False
    begins = np.flatnonzero(np.concatenate([[True], steps > 0]))
    return all(int(np.add.reduceat(np.isfinite(signal).astype(int), begins).max()) <= 1 for signal in signals)


def shared_note(usual: int) -> tuple[str, str]:
    """A note that rows are spaced evenly, with its remedy."""
    what = f"{usual} rows share each stamp, and are spaced evenly up to the next one"
    return what, _FINER


def first_values(stamps: Integers, channels: dict[str, Array]) -> tuple[Integers, dict[str, Array], dict[str, Indices]]:
    """The distinct stamps, the first value of each channel at each, and the rows where a later value differs from it.

    Rows that share a stamp may hold a channel each.

    Parameters
    ----------
    stamps : ns, shape (row,)
    channels : NaN for missing values, shape (row,); popped one by one, so that none is held twice

    Returns
    -------
    Increasing stamps, shape (stamp,); channels, shape (stamp,); the rows, in order, of each channel that has any.
    """
    if np.all(np.diff(stamps) > 0):
        return stamps, channels, {}
    distinct, place = np.unique(stamps, return_inverse=True)
    first, differing = dict[str, Array](), dict[str, Indices]()
    for name in list(channels):
        values = channels.pop(name)
        first[name] = first_known(values, place, distinct.size)
        others = np.flatnonzero(np.isfinite(values) & (values != first[name][place]))
        if others.size:
            differing[name] = others
    return distinct, first, differing


def first_known(values: Array, place: Indices, size: int) -> Array:
    """The first value at each of so many places, shape (size,); NaN where there is none.

    Parameters
    ----------
    values : NaN for missing ones, shape (row,)
    place : of each row, shape (row,)
    """
    first, known = np.full(size, np.nan, values.dtype), np.flatnonzero(np.isfinite(values))[::-1]
    first[place[known]] = values[known]  # from the last row to the first, which stays
    return first


def differing_note(log: str, stamps: Integers, differing: dict[str, Indices]) -> tuple[str, str]:
    """A note on the rows of `first_values` whose values are not used, with its remedy.

    Parameters
    ----------
    log : name of the log
    stamps : ns, shape (row,)
    """
    rows = np.unique(np.concatenate(list(differing.values())))
    first = np.datetime_as_string(stamps[rows[0]].astype("datetime64[ns]"), unit="ms")
    what = (
        f"{rows.size} rows of {log} repeat the stamp of an earlier row with another {' or '.join(differing)}, the "
        f"first at {first} UTC; only the first value of a channel at a stamp is used"
    )
    return what, _FINER


def _draw_lines(
    since: Floats, stamps: Integers, begins: Integers, counts: Integers, whole: Booleans, interval: float
) -> None:
    """Give rows of successive stamps with a usual number of rows each the times of a regular clock, where these fit.

    This keeps a clock regular whose rate is not a whole number of rows per stamp.

    Parameters
    ----------
    since : times after the stamps, ns, which are changed, shape (row,)
    begins, counts, whole : first row of each stamp, number of its rows, and whether that is usual, shape (stamp,)
    interval : usual time between rows, ns
    """
    unit = np.median(np.diff(stamps[begins]))
    goes_on = (np.diff(stamps[begins]) == unit) & whole[1:] & whole[:-1]
    bounds = np.flatnonzero(np.concatenate([[True], ~goes_on, [True]]))
    for first, end in zip(bounds[:-1].tolist(), bounds[1:].tolist(), strict=True):
        if end - first < _FEWEST_STAMPS:
            continue
        begin, stop = int(begins[first]), int(begins[end - 1] + counts[end - 1])
        zero = stamps[begin]
        centre = begins[first:end] + (counts[first:end] - 1) / 2
        slope, offset = np.polyfit(centre, stamps[begins[first:end]] - zero + (unit - interval) / 2, 1)
        line = slope * np.arange(begin, stop) + offset - (stamps[begin:stop] - zero)
        if np.all((line > -interval) & (line < unit + interval)):
            since[begin:stop] = line


def _are_samples(sweep: Floats, speed: Floats, repeats: Integers, later: int) -> bool:
    """Whether the rows of one stamp are samples of their own.

    Parameters
    ----------
    later : number of rows behind the first one of each stamp, all of which repeat it if rows were written twice
    """
    whole = float(np.mean(np.isfinite(sweep) & np.isfinite(speed)))
    return whole >= _WHOLE and repeats.size <= _WHOLE * later
