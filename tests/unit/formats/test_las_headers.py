"""Headers of LAS files that state a date alone, or fewer curves than the rows hold."""

from pathlib import Path

import numpy as np
import pytest

from drillid.errors import LogError
from drillid.formats import TimeColumn, read_log


def las(well: str, time: str, first: float, curves: str = "TQ.kN.m : torque\nRPM.rpm : speed\n") -> str:
    """A log of thirty seconds that count from `first`."""
    rows = "".join(f"{first + at:g} {12 + at / 8} 120\n" for at in range(30))
    return f"~V\nVERS. 2.0 :\nWRAP. NO :\n~W\n{well}NULL. -999.25 :\n~C\n{time}\n{curves}~A\n{rows}"


def saved(tmp_path: Path, text: str, encoding: str = "utf-8") -> Path:
    """The file of a text."""
    path = tmp_path / "log.las"
    path.write_text(text, encoding=encoding)
    return path


WELL = "STRT.S {0} :\nSTOP.S {1} :\nSTEP.S 1 :\nDATE. 2025-03-04 : Log date\n"


@pytest.mark.parametrize("time", ["TIME.S : Time", "TIME.SEC : Time of day", "SECS.S : Seconds"])
def test_seconds_of_the_day_count_from_the_header_s_date(tmp_path: Path, time: str) -> None:
    log = read_log(saved(tmp_path, las(WELL.format(21600, 21629), time, 21600)), None, ["TQ"])
    assert log.stamps[0] == np.datetime64("2025-03-04T06:00:00", "ns")
    assert any("count from 2025-03-04T00:00:00.000, as the file's header says" in what for what, _ in log.notes)


@pytest.mark.parametrize("first", [0, 3600])
def test_a_start_may_stand_where_strt_is_described(tmp_path: Path, first: int) -> None:
    well = WELL.format(first, first + 29).replace(f"STRT.S {first} :", f"STRT.S {first} : 2025-03-04 06:00:00")
    stamps = read_log(saved(tmp_path, las(well, "ETIM.S : Time", first)), None, ["TQ"]).stamps
    assert stamps[0] == np.datetime64("2025-03-04T06:00:00", "ns")


def test_they_are_of_the_rigs_clock(tmp_path: Path) -> None:
    path = saved(tmp_path, las(WELL.format(21600, 21629), "TIME.S : Time", 21600))
    stamps = read_log(path, TimeColumn(zone="Europe/Oslo"), ["TQ"]).stamps
    assert stamps[0] == np.datetime64("2025-03-04T05:00:00", "ns")


OPEN = {
    "it begins at zero": (WELL.format(0, 29), "TIME.S : Time", 0),
    "it begins near zero": (WELL.format(30, 59), "TIME.S : Time", 30),
    "it is called elapsed": (WELL.format(21600, 21629), "ETIM.S : Time", 21600),
    "it is described as elapsed": (WELL.format(21600, 21629), "TIME.S : Elapsed time", 21600),
    "it ends after the day": (WELL.format(21600, 3015000), "TIME.S : Time", 21600),
    "STRT is another value": (WELL.format(0, 29), "TIME.S : Time", 21600),
    "its unit is another": (WELL.format(21600, 21629).replace(".S", ".MIN"), "TIME.MIN : Time", 21600),
    "the date is that of the export": (
        WELL.format(21600, 21629).replace("Log date", "Export date"),
        "TIME.S : Time",
        21600,
    ),
}


@pytest.mark.parametrize(("well", "time", "first"), OPEN.values(), ids=OPEN)
def test_other_counts_beside_a_date_are_refused(tmp_path: Path, well: str, time: str, first: int) -> None:
    with pytest.raises(LogError, match=r"time\.start"):
        read_log(saved(tmp_path, las(well, time, first)), None, ["TQ"])


def test_rows_of_more_cells_than_curves_are_told_to_be_so(
    tmp_path: Path, capfd: pytest.CaptureFixture[str], caplog: pytest.LogCaptureFixture
) -> None:
    text = las("STRT. 2025-03-04T06:00:00 :\n", "TIME.S : Time", 0, "TORQUE kNm torque\nRPM.rpm : speed\n")
    with pytest.raises(
        LogError, match=r"has a row of 3 cells, and its section ~C names 2 curves.*Write a line for each"
    ):
        read_log(saved(tmp_path, text), None, ["RPM"])
    assert capfd.readouterr().err == ""
    assert caplog.text == ""


def test_a_file_in_utf_16_is_to_be_saved_in_another(tmp_path: Path) -> None:
    path = saved(tmp_path, las(WELL.format(21600, 21629), "TIME.S : Time", 21600), "utf-16")
    with pytest.raises(LogError, match=r"is in UTF-16.*Save it in UTF-8"):
        read_log(path, None, ["TQ"])
