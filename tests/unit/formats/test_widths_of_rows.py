"""Text whose header and rows differ in their number of cells: what is harmless is read, the rest is named by line."""

from pathlib import Path

import numpy as np
import pytest

from drillid.errors import LogError
from drillid.formats import Dialect, first_stamp, headers, read_log

STAMPS = np.datetime64("2025-03-03T06:00:00", "ns") + np.arange(600) * np.timedelta64(100, "ms")
TIMES = [str(stamp)[:23].replace("T", " ") for stamp in STAMPS]
SPEED = (118 + np.arange(600) / 200).round(3)


def saved(tmp_path: Path, header: str, row: str, **lines: str) -> Path:
    """A log with rows of such a form; `lines` replaces some, as line_300='…'."""
    rows = [row.format(time=time, rpm=rpm) for time, rpm in zip(TIMES, SPEED, strict=True)]
    for name, text in lines.items():
        rows[int(name.removeprefix("line_")) - 2 - header.count("\n")] = text
    path = tmp_path / "log.csv"
    path.write_text("\n".join([header, *rows, ""]))
    return path


def check(path: Path, *missing: int, header_line: int | None = None) -> None:
    """The log has all rows but some."""
    found = read_log(path, "Time", ["RPM"], dialect=Dialect(header_line=header_line))
    assert (found.stamps == np.delete(STAMPS, missing)).all()
    np.testing.assert_array_equal(found.pop("RPM"), np.delete(SPEED, missing))


@pytest.mark.parametrize("decimals", [".", ","])
def test_a_header_that_is_short_of_a_name_is_refused(decimals: str, tmp_path: Path) -> None:
    """As by a comma before the milliseconds, which shifts every column but the first."""
    extra = "{time},0.12,{rpm},10.1,7.5" if decimals == "." else "{time},{rpm},10.1,2000.5"
    path = tmp_path / "log.csv"
    rows = [extra.format(time=time.replace(".", decimals), rpm=rpm) for time, rpm in zip(TIMES, SPEED, strict=True)]
    path.write_text("\n".join(["Rig 7", "Time,RPM,TQ,DMEA", *rows]))
    for read in (headers, lambda path: read_log(path, "Time", ["RPM"]), lambda path: first_stamp(path, "Time")):
        with pytest.raises(LogError, match="names 4 columns in line 2, and line 3 has 5 cells: '2025") as raised:
            read(path)
        assert "file.columns" in raised.value.remedy
    stated = Dialect(columns=("Time", "ms", "RPM", "TQ", "DMEA") if decimals == "," else ("Time", "X", "RPM", "Y", "Z"))
    assert read_log(path, "Time", ["RPM"], dialect=stated).pop("RPM")[0] == SPEED[0]
    with pytest.raises(LogError, match="names 4 columns in line 2, and line 3 has 5 cells"):
        headers(path, Dialect(header_line=2))


@pytest.mark.parametrize("delimiter", [",", ";", "\t"])
def test_delimiters_at_the_ends_of_rows_or_header_alone_are_harmless(delimiter: str, tmp_path: Path) -> None:
    plain, ended = "Time,RPM,TQ", "Time,RPM,TQ,"
    for header, row in (
        (plain, "{time},{rpm},1.5,"),
        (ended, "{time},{rpm},1.5"),
        (ended, "{time},{rpm},1.5,"),
        (f"{ended},,", "{time},{rpm},1.5"),
        (f"{ended}\n,rpm,kN.m,", "{time},{rpm},1.5"),
        (f"{plain}\n,rpm,kN.m", "{time},{rpm},1.5,"),
        (f"{plain},", "{time},{rpm},1.5,0"),
    ):
        header, row = header.replace(",", delimiter), row.replace(",", delimiter)
        path = saved(tmp_path, header, row)
        check(path)
        check(path, header_line=1)
        lines = header.count("\n") + 1
        check(saved(tmp_path, header, row, line_300=header.splitlines()[0]), 299 - lines)


@pytest.mark.parametrize(
    ("line", "cells"),
    [
        ("2025-03-03 06:00:40.000,118,2", 3),
        ("2025-03-03 06:00:40.000,118,2,pumps on, rotate", 5),
        ("2025-03-03 06:00", 1),
        ("2025-03-03 06:00:40.000,1182025-03-03 06:00:40.100,118,2,", 5),
    ],
)
def test_a_row_with_another_number_of_cells_is_named(line: str, cells: int, tmp_path: Path) -> None:
    for header in ("Time,RPM,TQ,Remark", "# by a recorder\nTime,RPM,TQ,Remark\n\n"):
        number = 403 + header.count("\n")
        path = saved(tmp_path, header, "{time},{rpm},1.5,", **{f"line_{number}": line})
        what = f"line {number} has {cells} cells? and the header names 4 columns: '2025-03-03 06:00"
        for dialect in (Dialect(), Dialect(thousands=" ")):
            with pytest.raises(LogError, match=what) as raised:
                read_log(path, "Time", ["RPM"], dialect=dialect)
            assert "Correct the line" in raised.value.remedy


def test_the_line_is_named_among_remarks_and_text(tmp_path: Path) -> None:
    path = saved(
        tmp_path,
        "Time,RPM,TQ",
        "{time},{rpm},1.5",
        line_100="pumps on",
        line_200="# resumed, again",
        line_300=f"{TIMES[298]},broken,1.5",
        line_400=f"{TIMES[398]},118",
    )
    with pytest.raises(LogError, match="line 400 has 2 cells and the header names 3 columns"):
        read_log(path, "Time", ["RPM"])


@pytest.mark.parametrize("blank", ["", "   ", "\t", " \t \t", "\t\t", "\t\t\t\t"])
@pytest.mark.parametrize("delimiter", [",", ";", "\t", " "])
def test_blank_lines_are_no_rows(delimiter: str, blank: str, tmp_path: Path) -> None:
    row = "{time},{rpm},1.5".replace(",", delimiter)
    path = saved(tmp_path, "Time,RPM,TQ".replace(",", delimiter), row, line_300=blank, line_500=blank)
    check(path, 298, 498)
    path.write_text(path.read_text().replace(f"{SPEED[400]}", "broken"))
    with pytest.raises(LogError, match=r"'broken' is not a number.* in line 402 of the file"):
        read_log(path, "Time", ["RPM"]).pop("RPM")
