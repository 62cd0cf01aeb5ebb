"""Headers among the rows of concatenated logs: those that repeat the first are left out, any others are refused."""

from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from drillid.errors import LogError
from drillid.formats import Dialect, first_stamp, read_log

NAMES = "Time,SWEEP [kN.m],TQ [kN.m],RPM [rpm],DMEA [m]"
BARE, UNITS = "Time,SWEEP,TQ,RPM,DMEA", ",kN.m,kN.m,rpm,m"
UPPER, LOWER = ",Sweep,Command,Top drive,Hole", "Time,torque,torque,speed,depth"
ROWS = [f"2025-03-03 06:00:{second:02d},0.1,10.5,120,2000" for second in range(40)]


def concatenated(path: Path, first: list[str], second: list[str], delimiter: str = ",") -> Path:
    """Two logs of 20 rows one below the other, each under its own header; as text or as a sheet."""
    lines = [*first, *ROWS[:20], *second, *ROWS[20:]]
    if path.suffix == ".xlsx":
        cells = [[float(cell) if cell.isdigit() else cell for cell in line.split(",")] for line in lines]
        width = max(map(len, cells))
        pd.DataFrame([row + [""] * (width - len(row)) for row in cells]).to_excel(path, index=False, header=False)
    else:
        path.write_text("\n".join(lines).replace(",", delimiter))
    return path


def depth(header: list[str]) -> str:
    """Name of the last column."""
    return "Hole depth" if header == [UPPER, LOWER] else "DMEA"


@pytest.mark.parametrize("name", ["log.csv", "log.xlsx"])
@pytest.mark.parametrize(
    ("first", "second", "line", "what"),
    [
        ([NAMES], ["Time,TQ [kN.m],SWEEP [kN.m],RPM [rpm],DMEA [m]"], 22, "names other columns.*'Time, TQ"),
        ([NAMES], ["Time,TQ,SWEEP,RPM,DMEA"], 22, "names other columns"),
        ([NAMES], ["Time,Torque,Sweep,Speed,Depth"], 22, "names other columns"),
        ([NAMES], [NAMES.replace("[m]", "[ft]")], 22, "gives 'DMEA' in 'ft' and the header in 'm'"),
        ([NAMES], [BARE, ",kft.lbf,kft.lbf,rpm,m"], 23, "gives 'SWEEP' in 'kft.lbf' and the header in 'kN.m'"),
        ([BARE, UNITS], [BARE, ",kft.lbf,kft.lbf,rpm,ft"], 24, "gives 'SWEEP' in 'kft.lbf' and the header in 'kN.m'"),
        ([UPPER, LOWER], [",Command,Sweep,Top drive,Hole", LOWER], 23, "names other columns"),
        ([UPPER, LOWER], [UPPER, "Time,torque,speed,torque,depth"], 24, "names other columns"),
    ],
)
def test_a_header_that_differs_is_refused(
    name: str, first: list[str], second: list[str], line: int, what: str, tmp_path: Path
) -> None:
    path = concatenated(tmp_path / name, first, second)
    place = f"line {line}" if path.suffix == ".csv" else f"row {line} of sheet 'Sheet1'"
    with pytest.raises(LogError, match=f"{name}: {place} {what}") as raised:
        read_log(path, "Time", [depth(first)])
    assert "Split the file there" in raised.value.remedy


@pytest.mark.parametrize("name", ["log.csv", "log.xlsx"])
@pytest.mark.parametrize(
    ("first", "second"),
    [
        ([NAMES], [NAMES]),
        ([NAMES], [BARE]),
        ([NAMES], [NAMES.replace("kN.m", "kNm").upper()]),
        ([NAMES], [BARE, ",kNm,kNm,RPM,m"]),
        ([BARE], [BARE, UNITS]),
        ([BARE, UNITS], [BARE, UNITS]),
        ([BARE, UNITS], [NAMES]),
        ([UPPER, LOWER], [UPPER, LOWER]),
        (["Well: 34/10,Rig 7,Page 1 of 2", NAMES], ["Well: 34/10,Rig 7,Page 2 of 2", NAMES]),
        ([NAMES], ["Time", "drilling resumed,at TD,RPM raised,slips out,in the hole"]),
        ([NAMES], ["TQ", "m,,,,", "--,--,--,--,--", "nan,nan,nan,nan,nan"]),
    ],
)
def test_what_repeats_the_header_or_is_none_is_left_out(
    name: str, first: list[str], second: list[str], tmp_path: Path
) -> None:
    path = concatenated(tmp_path / name, first, second)
    found = read_log(path, "Time", [depth(first)])
    assert found.pop(depth(first)).tolist() == [2000] * 40
    told = [what for what, _ in found.notes if "is not a row of data and is left out" in what]
    assert len(told) == len(second)


def test_headers_above_dates_and_times_of_day_between_spaces_are_compared(tmp_path: Path) -> None:
    names = NAMES.replace(" [", "[")
    path = concatenated(tmp_path / "log.txt", [names], [names], " ")
    assert read_log(path, "Time", ["DMEA"]).stamps.size == 40
    concatenated(path, [names], [names.replace("[m]", "[ft]")], " ")
    with pytest.raises(LogError, match="line 22 gives 'DMEA' in 'ft' and the header in 'm'"):
        read_log(path, "Time", ["DMEA"])


def test_the_header_that_differs_is_refused_before_the_width_of_its_rows(tmp_path: Path) -> None:
    wider = [f"{row},12" for row in ROWS]
    (tmp_path / "log.csv").write_text("\n".join([NAMES, *ROWS * 12, f"{NAMES},WOB [t]", *wider]))
    with pytest.raises(LogError, match="line 482 names other columns"):
        read_log(tmp_path / "log.csv", "Time", ["DMEA"])


@pytest.mark.parametrize("delimiter", [",", " "])
def test_headers_in_comments_are_compared_as_well(delimiter: str, tmp_path: Path) -> None:
    other = "# Time,TQ [kN.m],SWEEP [kN.m],RPM [rpm],DMEA [m]"
    rows = [row.replace(" ", "T") for row in ROWS]
    for second, refused in ((other, True), (f"# {NAMES}", False), ("# drilling resumed", False)):
        lines = [f"# {NAMES}", *rows[:20], second, *rows[20:]]
        (tmp_path / "log.csv").write_text("\n".join(lines).replace(" [", "[").replace(",", delimiter))
        if refused:
            with pytest.raises(LogError, match="line 22 names other columns"):
                read_log(tmp_path / "log.csv", "Time", ["DMEA"])
        else:
            assert read_log(tmp_path / "log.csv", "Time", ["DMEA"]).stamps.size == 40


def test_columns_that_the_description_names_are_the_header(tmp_path: Path) -> None:
    path = concatenated(tmp_path / "log.csv", [], ["Time,TQ,SWEEP,RPM,DMEA"])
    stated = Dialect(columns=tuple(BARE.split(",")))
    with pytest.raises(LogError, match="line 21 names other columns"):
        read_log(path, "Time", ["DMEA"], dialect=stated)
    assert first_stamp(concatenated(path, [], [BARE]), "Time", dialect=stated) == np.datetime64("2025-03-03T06:00:00")
