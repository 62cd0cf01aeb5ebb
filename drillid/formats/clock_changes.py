"""Clock times of a zone in UTC, also in the hour that its clocks repeat in autumn."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from drillid.arrays import Booleans, Integers
from drillid.formats.time_columns import nanoseconds
from drillid.formats.written_times import DAY_NS

if TYPE_CHECKING:
    import pandas as pd

_AROUND = 5
"""Rows whose median shows which of them have damaged or swapped stamps."""


def in_utc(times: pd.Series[Any], zone: Any, first_pass: bool) -> Integers:
    """Ns since 1970 UTC, shape (row,); those of a repeated hour as of its first or of its second pass.

    Raises
    ------
    ValueError
        If a time does not exist in the zone.
    """
    return nanoseconds(times.dt.tz_localize(zone, ambiguous=np.full(len(times), first_pass)))


def in_utc_by_order(times: pd.Series[Any], zone: Any) -> Integers | None:
    """As `in_utc`, but each of a repeated hour as of that pass which the rows' order shows; None where it does not."""
    placed = times.dt.tz_localize(zone, ambiguous="NaT")
    repeated = placed.isna().to_numpy()
    found = nanoseconds(placed)
    if not repeated.any():
        return found
    clock = times[repeated]
    first, second = (in_utc(clock, zone, first_pass) for first_pass in (True, False))
    in_second = _in_second_pass(nanoseconds(clock), int(np.median(second - first)))
    if in_second is None:
        return None
    found[repeated] = np.where(in_second, second, first)
    return found


def _in_second_pass(clock: Integers, put_back: int) -> Booleans | None:
    """Whether rows of repeated hours are of their second pass; None where their order does not show it.

    Parameters
    ----------
    clock : local times, ns, in the rows' order; they may fall from row to row
    put_back : what the clock is put back by, ns
    """
    steps = np.diff(clock)
    if np.sum(steps < 0) > np.sum(steps > 0):
        reverse = _in_second_pass(clock[::-1], put_back)
        return None if reverse is None else reverse[::-1]
    years = np.split(clock, np.flatnonzero(np.abs(steps) > DAY_NS) + 1)
    found = [_behind_step(each, put_back) for each in years]
    known = [each for each in found if each is not None]
    return np.concatenate(known) if len(known) == len(found) else None


def _behind_step(clock: Integers, put_back: int) -> Booleans | None:
    """Whether rows of one repeated hour are behind its change; None without exactly one change.

    It is a step back by more than half of what the clock is put back by: rows that are repeated, swapped or late step
    back by less. Stamps that are that far off those around them do not count.
    """
    from scipy.ndimage import median_filter

    if clock.size < _AROUND:
        return None
    around = median_filter(clock, _AROUND, mode="mirror")
    sound = np.flatnonzero(np.abs(clock - around) <= put_back // 2)
    changes = np.flatnonzero(np.diff(clock[sound]) < -put_back // 2)
    return np.arange(clock.size) >= sound[changes[0] + 1] if changes.size == 1 else None
