"""The closing line: wells that failed, and those that a run did not take through all stages."""

import json
from pathlib import Path

import pytest

from drillid.fleet.outcome import (
    closing_line,
    failed_start_ups,
    failed_wells,
    missing_logs,
    missing_logs_line,
    unfinished_start_ups,
    unfinished_wells,
)
from drillid.fleet.stages import STAGES

ROW = "well,stage,where,what,remedy\nW,records,a.csv,is bad,Mend it\n"


@pytest.fixture
def results(tmp_path: Path) -> Path:
    for stage in STAGES:
        write(tmp_path / stage / "Done", "done")
    write(tmp_path / "records/Begun", "done")
    write(tmp_path / "records/Bad", "failed", ROW)
    for stage in list(STAGES)[1:]:
        write(tmp_path / stage / "Bad", "empty")
    return tmp_path


def write(folder: Path, status: str, rows: str = "") -> None:
    folder.mkdir(parents=True)
    (folder / "problems.csv").write_text(rows or ROW.splitlines()[0] + "\n")
    (folder / "key.json").write_text(json.dumps({"key": "1", "status": status}))


def line(results: Path, *wells: str) -> str:
    return closing_line(wells, failed_wells(results, wells), unfinished_wells(results, wells))


def test_a_well_that_a_run_did_not_reach_is_no_failed_one(results: Path) -> None:
    assert line(results, "Done") == "1 of 1 wells done."
    assert line(results, "Done", "Begun", "New") == "1 of 3 wells have gone through all stages, none failed."


def test_failed_wells_are_named_beside_those_not_reached(results: Path) -> None:
    assert line(results, "Bad", "Begun", "Done") == (
        "1 of 3 wells failed: Bad (records: a.csv: is bad). See problems.csv for the remedies. "
        "1 have not gone through all stages."
    )


def test_what_nobody_foresaw_leaves_a_row_without_a_key(results: Path) -> None:
    write(results / "windows/Begun", "done", ROW)
    (results / "windows/Begun/key.json").unlink()
    assert failed_wells(results, ["Begun"]) == {"Begun": "windows: a.csv: is bad"}


def test_starts_of_rotation_have_the_same_line(results: Path) -> None:
    write(results / "start_ups/First", "done")
    write(results / "start_ups/Bad", "failed", ROW)

    def told(*starts: str) -> str:
        failed, unfinished = failed_start_ups(results, starts), unfinished_start_ups(results, starts)
        return closing_line(starts, failed, unfinished, "starts of rotation")

    assert told("First") == "1 of 1 starts of rotation done."
    assert told("First", "New") == "1 of 2 starts of rotation have gone through all stages, none failed."
    assert told("First", "Bad").startswith("1 of 2 starts of rotation failed: Bad (start_ups: a.csv: is bad).")


def test_listed_logs_that_are_not_there_are_counted_and_named(tmp_path: Path) -> None:
    there = tmp_path / "a.csv"
    there.touch()
    assert missing_logs([there]) == []
    assert missing_logs_line([]) == ""
    logs = [there, *(tmp_path / f"{number}.csv" for number in range(6)), Path("memory:/no/b.csv")]
    missing = missing_logs(logs)
    assert missing == [*(f"{tmp_path}/{number}.csv" for number in range(6)), "memory://no/b.csv"]
    line = missing_logs_line(missing)
    assert line.startswith(f"Listed logs that are not there: 7 ({tmp_path}/0.csv, ")
    assert line.endswith(f"{tmp_path}/4.csv and 2 more).")
