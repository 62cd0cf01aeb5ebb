"""Times as year, month, day, hour, minute and second in a column each."""

from pathlib import Path

import numpy as np
import pytest

from drillid.errors import LogError
from drillid.formats import TimeColumn, read_log

EXPECTED = np.datetime64("2025-03-04T06:00:00", "ns") + np.arange(30) * np.timedelta64(100, "ms")
NAMES = {
    "words": "Year,Month,Day,Hour,Minute,Second",
    "with units": "Year,Month,Day (d),Hour (h),Minute (min),Second (s)",
    "letters": "YYYY,MM,DD,HH,MI,SS",
    "letters that repeat": "YYYY,MM,DD,HH,MM,SS",
    "short words": "Yr,Mo,Dy,Hr,Mn,Sec",
    "plural": "year,month,day,hours,minutes,seconds",
    "another order": "Second,Minute,Hour,Day,Month,Year",
}


def saved(tmp_path: Path, names: str, cells: str = "2025,3,4,6,0,{s}", rows: int = 30) -> Path:
    """A log at 10 Hz; `cells` with its second as {s}."""
    path = tmp_path / "log.csv"
    lines = [
        f"{cells.format(s=f'{at / 10:.1f}', ms=at % 10 * 100, whole=at // 10)},{12 + at / 8}" for at in range(rows)
    ]
    path.write_text(f"{names},TQ (kN.m)\n" + "\n".join(lines) + "\n")
    return path


@pytest.mark.parametrize("names", NAMES.values(), ids=NAMES)
def test_the_parts_of_times_are_put_together(tmp_path: Path, names: str) -> None:
    cells = "{s},0,6,4,3,2025" if names.startswith("Second") else "2025,3,4,6,0,{s}"
    log = read_log(saved(tmp_path, names, cells), None, ["TQ"])
    assert np.array_equal(log.stamps, EXPECTED)
    assert any(what.startswith("the times are combined from the columns") for what, _ in log.notes)
    assert log.pop("TQ")[1] == 12.125


def test_they_are_of_the_rigs_clock_and_years_may_be_short(tmp_path: Path) -> None:
    path = saved(tmp_path, NAMES["words"], "25,03,04,06,00,{s}")
    log = read_log(path, TimeColumn(zone="Europe/Oslo"), ["TQ"])
    assert np.array_equal(log.stamps, EXPECTED - np.timedelta64(1, "h"))


def test_milliseconds_beside_them_are_added(tmp_path: Path) -> None:
    path = saved(tmp_path, NAMES["words"] + ",Millisecond", "2025,3,4,6,0,{whole},{ms}")
    assert np.array_equal(read_log(path, None, ["TQ"]).stamps, EXPECTED)


def test_a_column_of_times_comes_before_their_parts(tmp_path: Path) -> None:
    path = saved(tmp_path, "Time," + NAMES["words"], "2025-03-04T06:00:0{s}Z,2024,1,1,0,0,0")
    assert np.array_equal(read_log(path, None, ["TQ"]).stamps, EXPECTED)


def test_las_curves_of_parts_are_read(tmp_path: Path) -> None:
    names = ("YEAR", "MONTH", "DAY", "HOUR", "MIN", "SECONDS.S")
    curves = "".join(f"{name if '.' in name else name + '.'} : part\n" for name in names)
    rows = "".join(f"2025 3 4 6 0 {at / 10:.1f} {12 + at / 8}\n" for at in range(30))
    path = tmp_path / "log.las"
    path.write_text(f"~V\nVERS. 2.0:\nWRAP. NO:\n~W\nNULL. -999.25:\n~C\n{curves}TQ.kN.m : torque\n~A\n{rows}")
    assert np.array_equal(read_log(path, None, ["TQ"]).stamps, EXPECTED)


@pytest.mark.parametrize(
    ("cells", "where"),
    [
        ("2025,2,30,6,0,{s}", "column 'Day', row 1: '30' is not a time"),
        ("2025,13,4,6,0,{s}", "column 'Month', row 1: '13' is not a time"),
        ("2025,3,4,6.5,0,{s}", "column 'Hour', row 1: '6.5' is not a time"),
        ("2025,3,4,6,0,6{s}", "column 'Second', row 11: '61.0' is not a time"),
        ("2025,3,4,,0,{s}", "column 'Hour', row 1: '' is not a time"),
        ("2025,Mar,4,6,0,{s}", "column 'Month', row 1: 'Mar' is not a time"),
    ],
)
def test_what_is_no_part_of_a_time_is_named(tmp_path: Path, cells: str, where: str) -> None:
    with pytest.raises(LogError, match=where):
        read_log(saved(tmp_path, NAMES["words"], cells), None, ["TQ"])
