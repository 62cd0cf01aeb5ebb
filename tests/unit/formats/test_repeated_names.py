"""Logs in which several columns have one name, above all times before every channel, as trends are exported."""

from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from drillid.errors import LogError
from drillid.formats import read_log

STAMPS = pd.date_range("2025-03-03T06:00", periods=50, freq="20ms")
SPEED = np.linspace(119, 121, 50)


def trend(path: Path, *groups: dict[str, object]) -> Path:
    """A log out of groups of columns beside one another."""
    columns = pd.concat([pd.DataFrame(group) for group in groups], axis=1)
    if path.suffix == ".xlsx":
        columns.to_excel(path, index=False)
    else:
        columns.to_csv(path, index=False)
    return path


@pytest.mark.parametrize("name", ["log.csv", "log.xlsx"])
def test_channels_with_other_times_of_their_own_are_refused(name: str, tmp_path: Path) -> None:
    later = STAMPS + pd.Timedelta("2s")
    path = trend(tmp_path / name, {"Time": STAMPS, "SWEEP": 1.0}, {"Time": later, "RPM": SPEED})
    row = 2 if path.suffix == ".xlsx" else 1
    with pytest.raises(LogError, match=rf"'Time:2', row {row}: the times before column 'RPM' are not those") as raised:
        read_log(path, None, ["SWEEP", "RPM"])
    assert "a file of its own" in raised.value.remedy
    np.testing.assert_array_equal(read_log(path, "Time", ["SWEEP"]).pop("SWEEP"), 1.0)
    found = read_log(path, "Time:2", ["RPM"])
    assert (found.stamps == later.to_numpy()).all()


def test_the_first_row_that_differs_is_named(tmp_path: Path) -> None:
    drifting = [*STAMPS[:30], *(STAMPS[30:] + pd.Timedelta("1ms"))]
    path = trend(tmp_path / "log.csv", {"Time": STAMPS, "SWEEP": 1.0}, {"Time": drifting, "RPM": SPEED})
    with pytest.raises(LogError, match=r"'Time:2', row 31: .*06:00:00\.601 and .*06:00:00\.600"):
        read_log(path, None, ["SWEEP", "RPM"])


def test_times_that_are_alike_are_read_once(tmp_path: Path) -> None:
    written = [f"{stamp.isoformat()}Z" for stamp in STAMPS]
    path = trend(tmp_path / "log.csv", {"Time": STAMPS, "SWEEP": 1.0}, {"Time": written, "RPM": SPEED})
    found = read_log(path, None, ["SWEEP", "RPM"])
    np.testing.assert_array_equal(found.pop("RPM"), SPEED)
    assert (found.stamps == STAMPS.to_numpy()).all()


def test_rows_without_other_times_are_no_difference(tmp_path: Path) -> None:
    speed = np.where(np.arange(50) % 5, np.nan, SPEED)
    times = pd.Series(STAMPS).where(np.isfinite(speed))
    path = trend(tmp_path / "log.csv", {"Time": STAMPS, "SWEEP": 1.0}, {"Time": times, "RPM": speed})
    np.testing.assert_array_equal(read_log(path, None, ["SWEEP", "RPM"]).pop("RPM"), speed)


def test_dates_and_times_of_day_before_every_channel_are_compared(tmp_path: Path) -> None:
    path = tmp_path / "log.csv"
    groups = [{"Date": "2025-03-03", "Time": STAMPS.strftime("%H:%M:%S.%f"), name: SPEED} for name in ("SWEEP", "RPM")]
    assert (read_log(trend(path, *groups), None, ["RPM"]).stamps == STAMPS.to_numpy()).all()
    groups[1]["Date"] = "2025-03-04"
    with pytest.raises(LogError, match="the times before column 'RPM' are not those in 'Time'"):
        read_log(trend(path, *groups), None, ["RPM"])


def test_times_in_two_forms_side_by_side_are_of_all_columns(tmp_path: Path) -> None:
    beside = {"Time": np.arange(50) * 0.02, "RPM": SPEED, "SWEEP": 1.0}
    path = trend(tmp_path / "log.csv", {"Time": STAMPS}, beside)
    assert (read_log(path, None, ["RPM"]).stamps == STAMPS.to_numpy()).all()


def test_of_other_columns_of_one_name_the_first_is_read(tmp_path: Path) -> None:
    path = trend(tmp_path / "log.csv", {"Time": STAMPS, "RPM": SPEED}, {"RPM": 2 * SPEED})
    found = read_log(path, None, ["RPM"])
    np.testing.assert_array_equal(found.pop("RPM"), SPEED)
    assert found.notes == [
        (
            "has several columns 'RPM'; the first is read",
            "Name 'RPM:2' in the rig description if the second is meant",
        )
    ]
