"""Rows without data: what is left out and told, and what is still refused."""

from pathlib import Path

import pytest

from drillid.errors import LogError
from drillid.formats import read_log
from drillid.formats.rows_without_data import rows_without_data

NAMES = "Time,RPM,WOB"
ROWS = [f"2025-03-03 06:00:{second:02d},60.5,12" for second in range(20)]


def read(tmp_path: Path, *lines: str) -> tuple[int, list[str]]:
    """Number of rows, and what is told of a log with such lines."""
    (tmp_path / "log.csv").write_text("\n".join(lines))
    log = read_log(tmp_path / "log.csv", "Time", ["RPM"])
    return log.pop("RPM").size, [what for what, _ in log.notes]


def test_a_row_that_is_wrong_is_no_footer(tmp_path: Path) -> None:
    for wrong in ("yesterday,60.5,12", "Mean,60.5,12", ",60.5,12"):
        with pytest.raises(LogError, match=r"column 'Time', row 11: '.*' is not a time"):
            read(tmp_path, NAMES, *ROWS[:10], wrong, *ROWS[10:])
    with pytest.raises(LogError, match=r"row 11: 'broken' is not a number.* in line 13 of the file"):
        read(tmp_path, NAMES, *ROWS[:5], "remark", *ROWS[5:10], "2025-03-03 06:00:09,broken,12", *ROWS[10:])


def test_what_ends_a_log_is_left_out(tmp_path: Path) -> None:
    rows, told = read(tmp_path, NAMES, *ROWS, ",60.5,240", "Mean;60.5", "2025-03-03 06:00:20,60")
    assert rows == 20
    assert [what.split(" ")[1] for what in told] == ["22", "23", "24"]


def test_many_are_told_together(tmp_path: Path) -> None:
    rows, told = read(tmp_path, NAMES, *[line for row in ROWS * 2 for line in (row, NAMES)][:-1])
    assert rows == 40
    assert len(told) == 21
    assert "19 more" in told[-1]


def test_a_table_with_more_of_them_than_data_is_another_than_it_seems() -> None:
    data, remark = ["2025-03-03", "1"], ["no data"]
    rows = [(at, cells, True) for at, cells in enumerate([data, remark, remark, data, data])]
    assert rows_without_data(rows, [], [0]).credible
    assert not rows_without_data([*rows, (5, remark, True)], [], [0]).credible
    nameless = [(at, ["Monday", "1"], True) for at in range(101)]
    assert not rows_without_data(nameless, [], [0]).rows
