"""Years of two digits beside named months or under names such as YYMMDD, and times of day before dates."""

from pathlib import Path

import numpy as np
import pytest

from drillid.errors import LogError
from drillid.formats import TimeColumn, read_log

EXPECTED = np.datetime64("2025-03-04T06:00:00", "ns") + np.arange(30) * np.timedelta64(1, "s")


def saved(tmp_path: Path, names: str, cells: str) -> Path:
    """Thirty rows, one a second, which is {s:02d} in `cells`."""
    path = tmp_path / "log.csv"
    path.write_text(f"{names},TQ (kN.m)\n" + "".join(f"{cells.format(s=second)},12.5\n" for second in range(30)))
    return path


READ = {
    "a date apart": ("DATE,TIME", "04-Mar-25,06:00:{s:02d}"),
    "capitals without signs": ("DATE,TIME", "04MAR25,06:00:{s:02d}"),
    "another language": ("DATE,TIME", "4 Mrz 25,06:00:{s:02d}"),
    "one column": ("TIME", "04-Mar-25 06:00:{s:02d}"),
    "time of day before it": ("TIME", "06:00:{s:02d}/04-Mar-25"),
    "time of day before a year of four digits": ("TIME", "06:00:{s:02d}/04-Mar-2025"),
    "a stroke between year first and time of day": ("TIME", "2025-03-04/06:00:{s:02d}"),
    "year first by its name": ("YYMMDD,HHMMSS", "250304,0600{s:02d}"),
    "day first by its name": ("DDMMYY,HHMMSS", "040325,0600{s:02d}"),
    "month first by its name": ("MM/DD/YY,HH:MM:SS", "03/04/25,06:00:{s:02d}"),
    "month first by its name with the century": ("MM/DD/YYYY,HH:MM:SS", "03/04/2025,06:00:{s:02d}"),
}


@pytest.mark.parametrize(("names", "cells"), READ.values(), ids=READ)
def test_dates_that_leave_no_doubt_are_read(tmp_path: Path, names: str, cells: str) -> None:
    assert np.array_equal(read_log(saved(tmp_path, names, cells), None, ["TQ"]).stamps, EXPECTED)


def test_short_years_are_noted_and_may_be_of_the_last_century(tmp_path: Path) -> None:
    log = read_log(saved(tmp_path, "DATE,TIME", "13-DEC-86,06:00:{s:02d}"), None, ["TQ"])
    assert log.stamps[0] == np.datetime64("1986-12-13T06:00:00", "ns")
    assert any("day, month and year of two digits, from 1980 to 2079" in what for what, _ in log.notes)


def test_a_stated_format_is_used_as_it_is(tmp_path: Path) -> None:
    path = saved(tmp_path, "TIME", "25-Mar-04 06:00:{s:02d}")
    log = read_log(path, TimeColumn("TIME", format="%y-%b-%d %H:%M:%S"), ["TQ"])
    assert np.array_equal(log.stamps, EXPECTED)


@pytest.mark.parametrize("cells", ["25-Mar-{s:02d},06:00:00", "04-03-25,06:00:{s:02d}", "04 abc 25,06:00:{s:02d}"])
def test_dates_that_leave_doubt_are_refused(tmp_path: Path, cells: str) -> None:
    with pytest.raises(LogError, match=r"two digits|not a time"):
        read_log(saved(tmp_path, "DATE,TIME", cells), None, ["TQ"])


def test_dates_and_times_of_day_of_las_curves_without_units(tmp_path: Path) -> None:
    curves = "DEPT.feet : depth\nTOR.ft_lb : torque\nYYMMDD. : date\nHHMMSS. : time\n"
    rows = "".join(f"{7 + at / 100:.2f} 120 250304 0600{at:02d}\n" for at in range(30))
    path = tmp_path / "log.las"
    path.write_text(f"~V\nVERS. 2.0:\nWRAP. NO:\n~W\nNULL. -999.25:\n~C\n{curves}~A\n{rows}")
    log = read_log(path, TimeColumn(zone="UTC"), ["TOR", "DEPT"])
    assert np.array_equal(log.stamps, EXPECTED)
    assert log.units == {"TOR": "ft_lb", "DEPT": "feet"}
