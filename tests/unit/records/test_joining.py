"""Slow logs beside fast ones: joined by time, clocks compared, what cannot be joined told."""

import json
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pandas as pd
import pytest
import xarray as xr

from drillid.config.listing import Well
from drillid.config.rig import Rig
from drillid.config.settings import Settings
from drillid.datasets.store import Problem, WellFolders
from drillid.fleet.aside import forget_aside, set_aside
from drillid.fleet.manifest import KEY
from drillid.records import joining, stage
from drillid.records.stage import process
from tests.raw_logs import RATE, RIG, START, drilling, save, standstill

SECONDS = 200
FAST = ["Time", "TQ", "SWEEP", "RPM", "SET"]
OTHERS = {
    "files": "*_depth.csv",
    "channels": {
        "hole_depth": {"column": "Hole", "unit": "m"},
        "bit_depth": {"column": "Bit", "unit": "m"},
        "flow": {"column": "Flow", "unit": "L/min"},
        "speed": {"column": "Speed", "unit": "rpm"},
    },
}


def whole_log(start: pd.Timestamp = START) -> pd.DataFrame:
    """Drilling, a connection and drilling again."""
    half = pd.Timedelta(seconds=SECONDS)
    first = drilling(SECONDS, start=start)
    depth = float(first["HOLE"].iloc[-1]) * 0.3048
    pause = standstill(20, start + half, depth)
    last = drilling(SECONDS, seed=2, depth=depth, start=start + half + pd.Timedelta(seconds=20))
    return pd.concat([first, pause, last], ignore_index=True)


def slow_log(log: pd.DataFrame, seconds_ahead: float = 0.0) -> pd.DataFrame:
    """Each 50th row, a third of a second late within the second, in other names and units."""
    rows = log.iloc[16::50]
    times = rows["Time"] + pd.to_timedelta(seconds_ahead, unit="s")
    depth = {"Hole": rows["HOLE"] * 0.3048, "Bit": rows["BIT"] * 0.3048}
    return pd.DataFrame({"Time": times, **depth, "Flow": rows["FLOW"], "Speed": rows["RPM"].round(1)})


def run(folder: Path, *logs: Path, **keys: Any) -> tuple[xr.Dataset, list[Problem]]:
    rig = Rig.checked({**RIG.model_dump(), "other_logs": [OTHERS], **keys}, "rig")
    folders = WellFolders(folder / "results", "W1")
    problems = process(Well("W1", rig, logs), folders, Settings())
    return folders.read("records", "records").load(), problems


def alike(joined: xr.Dataset, whole: xr.Dataset, depth: float = 0.02) -> None:
    """The joined record is the whole one; slow channels are within what a second changes."""
    inside = joined.isel(time=slice(100, -100))
    whole = whole.sel(time=inside["time"])
    for name in ("torque_sweep", "torque_command", "speed"):
        assert (inside[name] == whole[name]).all()
    np.testing.assert_allclose(inside["hole_depth"], whole["hole_depth"], atol=depth)
    steady = np.abs(whole["flow"] - whole["flow"].median()) < 1e-6
    assert np.mean(np.isclose(inside["flow"], whole["flow"])[steady]) > 0.98


@pytest.mark.parametrize("ahead", [0.0, 37.4, -1803.25])
def test_depth_from_a_slow_log_is_joined_with_the_offset_of_its_clock(ahead: float, tmp_path: Path) -> None:
    log = whole_log()
    whole, _ = run(tmp_path / "whole", save(log, tmp_path / "whole.csv"))
    fast = save(log[FAST], tmp_path / "a_fast.csv")
    slow = save(slow_log(log, ahead), tmp_path / "a_depth.csv")
    joined, problems = run(tmp_path / "joined", slow, fast)
    alike(joined, whole)
    (told,) = (problem.what for problem in problems if "taken from a_depth.csv at 1 Hz" in problem.what)
    assert told.startswith("hole_depth, bit_depth, flow taken from")
    if ahead:
        found = float(told.split(" by ")[1].split(" s,")[0])
        error = float(told.split("standard error ")[1].split(" s,")[0])
        assert abs(found - ahead) < 4 * error < 0.5
        assert "in both logs shows; corrected" in told
    else:
        assert "the clocks agree, as speed in both logs shows" in told


def test_where_no_channel_is_in_both_logs_the_clocks_are_taken_to_agree_and_that_is_told(tmp_path: Path) -> None:
    log = whole_log()
    fast = save(log[FAST], tmp_path / "a_fast.csv")
    slow = save(slow_log(log).drop(columns="Speed"), tmp_path / "a_depth.csv")
    joined, problems = run(tmp_path, fast, slow)
    assert np.isfinite(joined["hole_depth"][100:-100]).all()
    assert any("no channel is in both logs, so the clocks are assumed to agree" in problem.what for problem in problems)


def test_several_slow_logs_supply_what_each_fast_log_lacks(tmp_path: Path) -> None:
    days = [START + pd.Timedelta(hours=hours) for hours in (0, 1)]
    logs = [whole_log(day) for day in days]
    fast = [save(log[FAST], tmp_path / f"{at}_fast.csv") for at, log in enumerate(logs)]
    slow = [save(slow_log(log), tmp_path / f"{at}_depth.csv") for at, log in enumerate(logs)]
    joined, _ = run(tmp_path, *slow, *fast)
    assert np.bincount(joined["log"].values).tolist() == [len(log) for log in logs]
    for number in (0, 1):
        held = np.isfinite(joined["hole_depth"].values[joined["log"].values == number])
        assert np.mean(held) > 0.98


def one_channel_a_row(slow: pd.DataFrame, names: list[str]) -> pd.DataFrame:
    """The slow log with a row for each of these channels at each stamp, in this order."""
    rows = [slow[["Time", name]].reindex(columns=slow.columns) for name in names]
    return pd.concat(rows).sort_index(kind="stable").assign(Time=lambda log: log["Time"].dt.floor("s"))


@pytest.mark.parametrize("first", [0, 1, 2])
def test_rows_of_a_slow_log_that_share_a_stamp_may_hold_a_channel_each(first: int, tmp_path: Path) -> None:
    log, names = whole_log(), ["Hole", "Bit", "Flow"]
    slow = slow_log(log).drop(columns="Speed")
    fast = save(log[FAST], tmp_path / "a_fast.csv")
    rows = one_channel_a_row(slow, [*names[first:], *names[:first]])
    whole = save(slow.assign(Time=slow["Time"].dt.floor("s")), tmp_path / "a_depth.csv")
    expected, _ = run(tmp_path / "whole", fast, whole)
    joined, problems = run(tmp_path / "rows", fast, save(rows, tmp_path / "a_depth.csv"))
    xr.testing.assert_equal(joined, expected)
    assert not any("of an earlier row" in problem.what for problem in problems)


def test_of_values_that_share_a_stamp_the_first_is_used_and_the_others_are_told(tmp_path: Path) -> None:
    log = whole_log()
    slow = slow_log(log).drop(columns="Speed")
    fast = save(log[FAST], tmp_path / "a_fast.csv")
    expected, _ = run(tmp_path / "whole", fast, save(slow, tmp_path / "a_depth.csv"))
    again = slow.iloc[50:90].assign(Hole=lambda rows: rows["Hole"] + 3, Flow=np.nan)
    twice = pd.concat([slow, slow.iloc[:50], again]).sort_index(kind="stable")
    joined, problems = run(tmp_path / "twice", fast, save(twice, tmp_path / "a_depth.csv"))
    xr.testing.assert_equal(joined, expected)
    (told,) = (problem.what for problem in problems if "of an earlier row" in problem.what)
    when = slow["Time"].iloc[50].strftime("%Y-%m-%dT%H:%M:%S.%f")[:-3]
    assert told == (
        "40 rows of a_depth.csv repeat the stamp of an earlier row with another hole_depth, the first at "
        f"{when} UTC; only the first value of a channel at a stamp is used"
    )


def test_what_cannot_be_joined_is_told(tmp_path: Path) -> None:
    log = whole_log()
    whole = save(log, tmp_path / "whole.csv")
    later = save(slow_log(whole_log(START + pd.Timedelta(days=9))), tmp_path / "later_depth.csv")
    (tmp_path / "broken_depth.csv").write_text("Time,Hole,Bit\n" + "noon,1,2\n" * 50)
    _, problems = run(tmp_path / "one", whole, later, tmp_path / "broken_depth.csv")
    told = {Path(problem.where.split(",")[0]).name: problem.what for problem in problems}
    assert told["broken_depth.csv"] == "'noon' is not a time"
    assert "no log of the well that does covers its time; not used" in told["later_depth.csv"]
    lacking = save(log[FAST], tmp_path / "fast.csv")
    with pytest.raises(FileNotFoundError):
        run(tmp_path / "two", lacking, later)
    good = save(slow_log(log), tmp_path / "a_depth.csv")
    _, problems = run(tmp_path / "three", lacking, good, tmp_path / "broken_depth.csv")
    assert any("'noon' is not a time" in problem.what for problem in problems)


def test_dynamics_are_taken_from_another_file_only_where_it_was_sampled_at_the_same_times(tmp_path: Path) -> None:
    log = whole_log()
    sweep = save(log[["Time", "SWEEP", "SET", "HOLE", "BIT", "FLOW"]], tmp_path / "sweep.csv")
    together = save(log[["Time", "RPM", "TQ"]], tmp_path / "together.csv")
    apart = save(slow_log(log)[["Time", "Speed"]], tmp_path / "apart_depth.csv")
    joined, problems = run(tmp_path / "one", sweep, together)
    np.testing.assert_allclose(joined["speed"], log["RPM"] * np.pi / 30, rtol=1e-6)
    assert any(f"speed taken from together.csv at {RATE:.0f} Hz" in problem.what for problem in problems)
    sweep = save(log[["Time", "SWEEP", "SET", "TQ", "HOLE", "BIT", "FLOW"]], tmp_path / "sweep.csv")
    folders = WellFolders(tmp_path / "two", "W1")
    rig = Rig.checked({**RIG.model_dump(), "other_logs": [OTHERS]}, "rig")
    problems = process(Well("W1", rig, (sweep, apart)), folders, Settings())
    (problem,) = (each for each in problems if "holds no speed; " in each.what)
    assert "cannot be joined: their samples are not at this log's times" in problem.what


def test_a_slow_channel_goes_on_from_file_to_file(tmp_path: Path) -> None:
    log = whole_log()
    cut = len(log) // 100 * 50
    parts = log[:cut], log[cut:]
    fast = [save(part[FAST], tmp_path / f"{at}_fast.csv") for at, part in enumerate(parts)]
    slow = [save(slow_log(part), tmp_path / f"{at}_depth.csv") for at, part in enumerate(parts)]
    joined, _ = run(tmp_path, *fast, *slow)
    known = np.isfinite(joined["hole_depth"].values)
    # before the first row of all slow logs, and behind the last one
    assert np.flatnonzero(~known[20:-50]).size == 0


def test_a_later_run_reads_only_what_is_new_or_joined_with_what_is_new(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    days = [START + pd.Timedelta(days=day) for day in range(4)]
    logs = [whole_log(day) for day in days]
    fast = [save(log[FAST], tmp_path / f"{at}_fast.csv") for at, log in enumerate(logs)]
    slow = [save(slow_log(log), tmp_path / f"{at}_depth.csv") for at, log in enumerate(logs)]
    rig = Rig.checked({**RIG.model_dump(), "other_logs": [OTHERS]}, "rig")
    read = list[str]()
    reading = joining.read_channels

    def noted(path: Path, *rest: Any) -> Any:
        read.append(path.name)
        return reading(path, *rest)

    monkeypatch.setattr(joining, "read_channels", noted)
    monkeypatch.setattr(stage, "read_channels", noted)

    def night(results: str, number: int) -> tuple[xr.Dataset, list[Problem]]:
        read.clear()
        folders = WellFolders(tmp_path / results, "W1", "same code and settings")
        set_aside(folders, "records")
        problems = process(Well("W1", rig, (*fast[:number], *slow[:number])), folders, Settings())
        state = {"key": "1", "status": "done", "basis": "same code and settings"}
        (folders.stage("records") / KEY).write_text(json.dumps(state))
        forget_aside(folders, "records")
        return folders.read("records", "records").load(), problems

    night("nightly", 3)
    found, problems = night("nightly", 4)
    assert set(read) == {"3_fast.csv", "3_depth.csv"} | {"2_fast.csv", "2_depth.csv"}
    whole, expected = night("at once", 4)
    xr.testing.assert_identical(found, whole)
    assert problems == expected


def test_tables_of_one_file_are_joined_as_files_are(tmp_path: Path) -> None:
    log = whole_log()
    with h5py.File(tmp_path / "log.h5", "w") as file:
        for name, table in (("fast", log[FAST]), ("slow", log.iloc[::50][["Time", "HOLE", "BIT", "FLOW"]])):
            group = file.create_group(name)
            for column in table:
                values = table[column]
                group[column] = values.astype("datetime64[ms]").astype(np.int64) if column == "Time" else values
    joined, problems = run(tmp_path, tmp_path / "log.h5", other_logs=[])
    assert np.isfinite(joined["hole_depth"][:-50]).all()
    assert any("hole_depth, bit_depth, flow taken from log.h5 at 1 Hz" in problem.what for problem in problems)
