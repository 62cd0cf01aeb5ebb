"""Logs over the hour that clocks repeat in autumn: the order of the rows must show which pass of it a row is of."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from drillid.errors import LogError
from drillid.formats import TimeColumn, first_stamp, read_log

Change = Callable[[pd.DatetimeIndex, int], pd.DatetimeIndex]
OSLO = pd.date_range("2025-10-25T23:50", "2025-10-26T01:50", freq="1s", tz="UTC")
"""From 01:50 in summer time to 02:50 in winter time; the clock is put back at 01:00 UTC."""


def saved(tmp_path: Path, times: pd.DatetimeIndex, zone: str = "Europe/Oslo") -> Path:
    """A log with these times, UTC, as the clock of a zone shows them."""
    local = times.tz_convert(zone).strftime("%Y-%m-%d %H:%M:%S.%f")
    path = tmp_path / "log.csv"
    pd.DataFrame({"Time": local, "TQ": 1.5}).to_csv(path, index=False)
    return path


def repeated(times: pd.DatetimeIndex, row: int) -> pd.DatetimeIndex:
    return times.insert(row, times[row])


def swapped(times: pd.DatetimeIndex, row: int) -> pd.DatetimeIndex:
    order = np.arange(len(times))
    order[[row, row + 1]] = row + 1, row
    return times[order]


def gap(times: pd.DatetimeIndex, start: str, stop: str) -> pd.DatetimeIndex:
    return times[(times < pd.Timestamp(start, tz="UTC")) | (times > pd.Timestamp(stop, tz="UTC"))]


@pytest.mark.parametrize(
    "times",
    [
        OSLO,
        repeated(OSLO, 1500),
        swapped(repeated(OSLO, 5000), 1500),
        gap(OSLO, "2025-10-26T00:55", "2025-10-26T01:15"),
        gap(gap(OSLO, "2025-10-26T00:10", "2025-10-26T00:50"), "2025-10-26T01:05", "2025-10-26T01:40"),
        OSLO[::-1],
        OSLO[::60],
        OSLO[600:4202],
    ],
    ids=["plain", "a repeated row", "swapped rows", "a gap", "gaps", "reversed", "a row a minute", "ends in the hour"],
)
def test_the_change_is_where_the_clock_goes_back(times: pd.DatetimeIndex, tmp_path: Path) -> None:
    path = saved(tmp_path, times)
    expected = times.tz_localize(None).to_numpy()
    assert (read_log(path, None, ["TQ"], zone="Europe/Oslo").stamps == expected).all()
    if times[0] < times[-1]:
        assert first_stamp(path, None, "Europe/Oslo") == expected[0]


def test_a_damaged_stamp_is_no_change(tmp_path: Path) -> None:
    local = OSLO.tz_convert("Europe/Oslo").strftime("%Y-%m-%d %H:%M:%S").to_numpy(dtype=object)
    local[3000] = "2025-10-26 02:00:00"
    path = tmp_path / "log.csv"
    pd.DataFrame({"Time": local, "TQ": 1.5}).to_csv(path, index=False)
    others = np.arange(len(local)) != 3000
    found = read_log(path, None, ["TQ"], zone="Europe/Oslo").stamps
    assert (found[others] == OSLO.tz_localize(None).to_numpy()[others]).all()
    for rows in (slice(2400, 3400), slice(2400, 3001), slice(3000, 3400)):
        pd.DataFrame({"Time": local[rows], "TQ": 1.5}).to_csv(path, index=False)
        with pytest.raises(LogError, match="occurs twice there"):
            read_log(path, None, ["TQ"], zone="Europe/Oslo")


def test_half_an_hour_may_be_put_back_and_more_than_once(tmp_path: Path) -> None:
    times = pd.date_range("2025-04-05T14:00", "2025-04-05T16:00", freq="1s", tz="UTC")
    years = times.append(times + (pd.Timestamp("2026-04-04") - pd.Timestamp("2025-04-05")))
    path = saved(tmp_path, repeated(years, 3700), "Australia/Lord_Howe")
    found = read_log(path, None, ["TQ"], zone="Australia/Lord_Howe")
    assert (found.stamps == repeated(years, 3700).tz_localize(None).to_numpy()).all()


@pytest.mark.parametrize("change", [repeated, swapped])
@pytest.mark.parametrize(("first", "last"), [("00:10", "00:20"), ("00:30", "02:10"), ("01:10", "01:20")])
def test_rows_that_are_repeated_or_swapped_are_no_change(change: Change, first: str, last: str, tmp_path: Path) -> None:
    times = pd.date_range(f"2025-10-26T{first}", f"2025-10-26T{last}", freq="1s", tz="UTC")
    if first == "00:30":
        times = gap(times, "2025-10-26T00:59:59", "2025-10-26T01:59:59")
    path = saved(tmp_path, change(times, 300))
    with pytest.raises(LogError, match=r"row 1: .*2025-10-26 02:\d0:00 occurs twice there"):
        read_log(path, None, ["TQ"], zone="Europe/Oslo")


@pytest.mark.parametrize("start", ["2025-10-25T20:00:00", "2025-03-29T20:00:00", "2025-03-30T01:59:30"])
def test_seconds_go_on_where_clocks_are_changed(tmp_path: Path, start: str) -> None:
    """As a counter does that began before the change."""
    seconds = np.arange(60.0, 9 * 3600.0, 60.0)
    pd.DataFrame({"t": seconds, "TQ": 1.5}).to_csv(tmp_path / "log.csv", index=False)
    log = read_log(tmp_path / "log.csv", TimeColumn("t", zone="Europe/Oslo", start=start), ["TQ"])
    begin = pd.Timestamp(start).tz_localize("Europe/Oslo").value
    np.testing.assert_array_equal(log.stamps.astype(np.int64), begin + np.round(seconds * 1e9).astype(np.int64))
