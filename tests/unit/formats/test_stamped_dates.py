"""Columns named like dates whose cells hold times of day as well, beside elapsed times or times of day."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from drillid.formats import TimeColumn, first_stamp, read_log
from tests.unit.formats.test_times_of_text import STAMPS, saved

LONG = pd.date_range("2025-03-03T06:00:00", periods=1500, freq="100ms").as_unit("ns")
ELAPSED = np.arange(1500) / 10
FORM = "%Y-%m-%d %H:%M:%S.%f"
START = "2025-03-03 06:00:00"


def log(tmp_path: Path, **columns: Sequence[object]) -> Path:
    """A log of a date, a time and a torque."""
    path = tmp_path / "log.csv"
    pd.DataFrame(columns).assign(TQ=1.5).to_csv(path, index=False)
    return path


def check(path: Path, *told: str, stamps: pd.DatetimeIndex = LONG, within_ns: int = 0, **described: str) -> None:
    """The log has these stamps, UTC, by what is described, and so much is told of it."""
    time = TimeColumn(**described)
    found = read_log(path, time, ["TQ"])
    assert np.abs(found.stamps.view(np.int64) - stamps.asi8).max() <= within_ns
    assert abs(first_stamp(path, time) - found.stamps[0]) <= np.timedelta64(within_ns, "ns")
    notes = [what for what, _ in found.notes]
    for words in told:
        assert any(words in what for what in notes), notes
    assert told or not any("'Date'" in what for what in notes if "the dates are taken from" not in what), notes


@pytest.mark.parametrize("name", ["ETIM (s)", "Elapsed Time", "Time"])
@pytest.mark.parametrize("first", [0.0, 700.0])
def test_dates_with_times_of_day_are_the_times_of_elapsed_rows(name: str, first: float, tmp_path: Path) -> None:
    path = log(tmp_path, **{"Date": LONG.strftime(FORM), name: ELAPSED + first})
    check(path, "column 'Date' holds times of day as well and is used alone")
    path = log(tmp_path, **{"Date": 25569 + LONG.asi8 / 864e11, name: ELAPSED + first})
    check(path, "column 'Date' holds times of day as well and is used alone", within_ns=1_000_000)
    path = log(tmp_path, **{"Date": LONG.strftime(FORM) + "Z", name: ELAPSED + first})
    check(path, "column 'Date' holds times of day as well and is used alone", zone="Europe/Oslo")


def test_elapsed_times_may_be_written_as_hours_minutes_and_seconds(tmp_path: Path) -> None:
    clock = (pd.Timestamp("2000-01-01") + pd.to_timedelta(ELAPSED, unit="s")).strftime("%H:%M:%S.%f")
    check(
        log(tmp_path, Date=LONG.strftime(FORM), Time=clock),
        "column 'Date' holds times of day as well and is used alone",
    )
    check(log(tmp_path, Date=[START] * 1500, Time=clock), "count from 2025-03-03T06:00:00.000")


@pytest.mark.parametrize(
    ("name", "elapsed"),
    [("ETIM (s)", ELAPSED), ("Elapsed Time (min)", ELAPSED / 60), ("Time", ELAPSED), ("ETIM (s)", ELAPSED + 90_000)],
)
def test_elapsed_times_count_from_one_date_with_a_time_of_day(name: str, elapsed: np.ndarray, tmp_path: Path) -> None:
    stamps = LONG + pd.Timedelta(90_000 if elapsed[0] else 0, "s")
    path = log(tmp_path, **{"Date": [START] * 1500, name: elapsed})
    check(path, "count from 2025-03-03T06:00:00.000, the time in column 'Date'", stamps=stamps, within_ns=1000)
    later = stamps + pd.Timedelta(1, "h")
    check(path, "count from 2025-03-03T07:00:00.000", stamps=later, within_ns=1000, start="2025-03-03T07:00:00Z")


DAY = "2025-03-03"
OF_MIDNIGHT = "count from midnight of 2025-03-03, as column 'Date' holds no times of day"


@pytest.mark.parametrize(
    ("name", "elapsed"),
    [
        *((name, ELAPSED) for name in ("ETIM (s)", "Elapsed Time", "Time", "Time (s)")),
        *((name, ELAPSED / 60) for name in ("Elapsed Time (min)", "Time (min)")),
        ("ETIM (s)", ELAPSED + 90_000),
    ],
)
def test_elapsed_times_beside_one_date_count_from_its_midnight_if_no_start_is_stated(
    name: str, elapsed: np.ndarray, tmp_path: Path
) -> None:
    path = log(tmp_path, **{"Date": [DAY] * 1500, name: elapsed})
    begun = pd.Timestamp(DAY) + pd.Timedelta(90_000 if elapsed[0] else 0, "s")
    stamps = LONG + (begun - LONG[0])
    check(path, OF_MIDNIGHT, stamps=stamps, within_ns=1000)
    later = stamps + pd.Timedelta(6, "h")
    check(path, "count from 2025-03-03T06:00:00.000, as stated", stamps=later, within_ns=1000, start=f"{DAY}T06:00:00")


@pytest.mark.parametrize(
    ("name", "first"),
    [("Time (s)", 21_600.0), ("Time", 21_600.0), ("Seconds since midnight", 21_600.0), ("Seconds since midnight", 0.0)],
)
def test_seconds_of_the_day_beside_one_date_remain_times_of_day(name: str, first: float, tmp_path: Path) -> None:
    path = log(tmp_path, **{"Date": [DAY] * 1500, name: ELAPSED + first})
    time = TimeColumn(column=name, date="Date", start=f"{DAY}T03:00:00")
    found = read_log(path, time, ["TQ"])
    assert found.stamps[0] == np.datetime64(DAY) + np.timedelta64(int(first), "s")
    assert not any("no times of day" in what for what, _ in found.notes)


def test_clocks_that_begin_at_midnight_are_times_of_day(tmp_path: Path) -> None:
    begun = LONG - pd.Timedelta(6, "h")
    check(log(tmp_path, Date=[DAY] * 1500, Time=ELAPSED / 86_400), stamps=begun, within_ns=1000)
    for form in ("%H:%M:%S.%f", "%H%M%S.%f"):
        check(log(tmp_path, Date=[DAY] * 1500, Time=begun.strftime(form)), stamps=begun)


def test_a_stated_start_is_preferred_to_dates_with_times_of_day(tmp_path: Path) -> None:
    path = log(tmp_path, **{"Date": LONG.strftime(FORM), "ETIM (s)": ELAPSED})
    later = LONG + pd.Timedelta(1, "h")
    check(path, "count from 2025-03-03T07:00:00.000", stamps=later, start="2025-03-03T07:00:00")


@pytest.mark.parametrize("form", ["%Y-%m-%d", "%Y-%m-%d 00:00:00", "%Y-%m-%d %H:%M:%S", "%Y-%m-%d %H:%M", FORM])
@pytest.mark.parametrize("clock", ["%H:%M:%S.%f", "%H%M%S.%f"])
def test_times_of_day_that_dates_repeat_are_the_times(form: str, clock: str, tmp_path: Path) -> None:
    for start in ("2025-03-03T06:00:00", "2025-03-03T23:59:00"):
        stamps = LONG + (pd.Timestamp(start) - LONG[0])
        check(log(tmp_path, Date=stamps.strftime(form), Time=stamps.strftime(clock)), stamps=stamps)


def test_dates_rounded_past_midnight_do_not_move_their_times_of_day(tmp_path: Path) -> None:
    stamps = LONG + (pd.Timestamp("2025-03-03T23:59:00") - LONG[0])
    rounded = (stamps + pd.Timedelta(0.5, "s")).strftime("%Y-%m-%d %H:%M:%S")
    check(log(tmp_path, Date=rounded, Time=stamps.strftime("%H:%M:%S.%f")), stamps=stamps)


def test_times_of_day_beside_the_time_of_an_export_are_the_times(tmp_path: Path) -> None:
    for name, cells in (("Time", LONG.strftime("%H:%M:%S.%f")), ("Time (s)", ELAPSED + 21_600)):
        path = log(tmp_path, **{"Date": ["2025-03-03 18:12:05"] * 1500, name: cells})
        check(path, f"the times of day in column 'Date' are not those in column '{name}' and are not used")


def test_times_of_day_with_a_zone_are_never_elapsed(tmp_path: Path) -> None:
    early = LONG + (pd.Timestamp("2025-03-03T00:01:00") - LONG[0])
    clock = early.strftime("%H:%M:%S.%f") + "Z"
    check(
        log(tmp_path, Date=["2025-03-03 18:12:05"] * 1500, Time=clock),
        "are not those",
        stamps=early,
        zone="Europe/Oslo",
    )


def test_dates_of_a_parquet_file_may_have_times_of_day(tmp_path: Path) -> None:
    path = tmp_path / "log.parquet"
    pd.DataFrame({"Date": LONG, "ETIM": ELAPSED, "TQ": 1.5}).to_parquet(path)
    check(path, "column 'Date' holds times of day as well and is used alone")
    path.unlink()
    pd.DataFrame({"Date": LONG.normalize(), "Time": LONG.time, "TQ": 1.5}).to_parquet(path)
    check(path)


def test_dates_alone_beside_seconds_are_as_before(tmp_path: Path) -> None:
    seconds = (STAMPS - STAMPS.normalize()).total_seconds()
    path = saved(tmp_path / "log.csv", **{"Date": ["2025-03-03"] * 50, "Time (s)": [f"{each:.2f}" for each in seconds]})
    assert (read_log(path, None, ["RPM"]).stamps == STAMPS.to_numpy()).all()
