"""Raw logs of one well → one series of records, whatever their format, order, overlap and clocks."""

from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pandas as pd
import pytest
import xarray as xr

from drillid.config.settings import Settings
from drillid.datasets.codes import RecordFlag
from drillid.datasets.store import Problem, WellFolders
from drillid.records import stage
from drillid.records.stage import process
from tests.raw_logs import RATE, RIG, START, drilling, save, standstill

SETTINGS = Settings()


def well(*logs: Path) -> Any:
    return SimpleNamespace(name="W1", rig=RIG, logs=logs)


def run(tmp_path: Path, *logs: Path) -> tuple[xr.Dataset, list[Problem]]:
    folders = WellFolders(tmp_path / "results", "W1")
    problems = process(well(*logs), folders, SETTINGS)
    return folders.read("records", "records").load(), problems


def test_logs_of_any_format_in_any_order_make_one_series(tmp_path: Path) -> None:
    later = START + pd.Timedelta(seconds=30)
    second = save(standstill(20, later, 2000.4), tmp_path / "a.csv.gz")
    first = save(drilling(30), tmp_path / "b.parquet")
    records, problems = run(tmp_path, second, first)
    assert problems == []
    assert np.bincount(records["log"].values).tolist() == [1500, 1000]
    assert (np.diff(records["time"].values) == np.timedelta64(20, "ms")).all()
    assert records["speed"].dtype == np.float32
    assert records["speed"].attrs["units"] == "rad s-1"
    np.testing.assert_allclose(records["speed"][:1500], drilling(30)["RPM"] * np.pi / 30, rtol=1e-6)


def test_logs_of_one_name_are_told_apart_by_their_folders(tmp_path: Path) -> None:
    hour = pd.Timedelta(hours=1)
    logs = [tmp_path / name for name in ("a/x/run.csv", "b/x/run.csv", "b/once.csv")]
    for number, path in enumerate(logs):
        path.parent.mkdir(parents=True, exist_ok=True)
        table = drilling(30, start=START + number * hour)
        table.loc[700, "RPM"] = 1e4
        save(table, path)
    _, problems = run(tmp_path, *logs)
    assert list(dict.fromkeys(problem.where for problem in problems)) == ["a/x/run.csv", "b/x/run.csv", "once.csv"]
    names = WellFolders(tmp_path / "results", "W1").read("records", "logs")["file"]
    assert names.values.tolist() == ["a/x/run.csv", "b/x/run.csv", "once.csv"]
    _, alone = run(tmp_path, *logs[1:])
    assert list(dict.fromkeys(problem.where for problem in alone)) == ["run.csv", "once.csv"]


def test_a_bad_log_is_a_row_and_the_others_go_on(tmp_path: Path) -> None:
    good = save(drilling(30), tmp_path / "good.csv")
    lacking = save(drilling(30, start=START + pd.Timedelta(hours=1)).drop(columns="RPM"), tmp_path / "lacking.csv")
    broken = tmp_path / "broken.parquet"
    broken.write_bytes(b"nothing")
    records, problems = run(tmp_path, broken, good, lacking, tmp_path / "gone.csv")
    assert records.sizes["time"] == 1500
    assert [(Path(problem.where).name, problem.what.split("; ")[0][:20]) for problem in problems] == [
        ("broken.parquet", "cannot be read (Parq"),
        ("gone.csv", "does not exist"),
        ("lacking.csv", "has no column 'RPM'"),
    ]
    assert all(problem.remedy for problem in problems)


def test_a_fault_of_the_program_with_one_log_is_its_row_and_the_others_go_on(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    good, bad, worse = (
        save(drilling(30, start=START + pd.Timedelta(hours=hour)), tmp_path / f"{name}.csv")
        for hour, name in enumerate(("good", "bad", "worse"))
    )
    read, started = stage.read_channels, stage.first_stamp

    def reading(path: Path, *rest: Any) -> Any:
        return read(path, *rest) if path != bad else 1 // 0

    def starting(path: Path, *rest: Any) -> Any:
        return started(path, *rest) if path != worse else [][1]

    monkeypatch.setattr(stage, "read_channels", reading)
    monkeypatch.setattr(stage, "first_stamp", starting)
    records, problems = run(tmp_path, bad, worse, good)
    assert records.sizes["time"] == 1500
    assert [Path(problem.where).name for problem in problems] == ["worse.csv", "bad.csv"]
    assert problems[1].what.startswith(
        "cannot be used (ZeroDivisionError: integer division or modulo by zero, in stage.py, "
    )
    assert all("fault in the program" in problem.remedy for problem in problems)


@pytest.mark.parametrize("error", [OSError("no space left on device"), MemoryError()])
def test_a_fault_of_the_machine_is_no_fault_of_the_log(
    error: Exception, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def failing(*_: Any) -> Any:
        raise error

    monkeypatch.setattr(stage, "read_channels", failing)
    with pytest.raises(type(error)):
        run(tmp_path, save(drilling(30), tmp_path / "good.csv"))


def test_overlapping_logs_are_used_once(tmp_path: Path) -> None:
    first = save(drilling(30), tmp_path / "a.csv")
    second = save(drilling(30, start=START + pd.Timedelta(seconds=20)), tmp_path / "b.csv")
    inside = save(drilling(5, start=START + pd.Timedelta(seconds=5)), tmp_path / "c.csv")
    records, problems = run(tmp_path, first, second, inside)
    assert records.sizes["time"] == 2500
    assert (np.diff(records["time"].values) > np.timedelta64(0)).all()
    assert any("500 samples overlap" in problem.what for problem in problems)
    assert any("entirely within" in problem.what for problem in problems)


def test_another_rate_is_refused(tmp_path: Path) -> None:
    fast = drilling(30, start=START + pd.Timedelta(hours=1))
    fast["Time"] = fast["Time"].iloc[0] + (fast["Time"] - fast["Time"].iloc[0]) / 2
    logs = save(drilling(30), tmp_path / "a.csv"), save(fast, tmp_path / "b.csv")
    records, problems = run(tmp_path, *logs)
    assert records.sizes["time"] == 1500
    assert ["100 Hz, the well's other logs at 50 Hz" in problem.what for problem in problems] == [True]


def test_without_any_usable_log_every_reason_stays_and_there_is_no_store(tmp_path: Path) -> None:
    wrong = drilling(30)
    wrong["RPM"] = wrong["RPM"].astype(str)
    wrong.loc[41, "RPM"] = "n/a!"
    logs = save(wrong, tmp_path / "wrong.csv"), tmp_path / "gone.csv"
    folders = WellFolders(tmp_path / "results", "W1")
    problems = process(well(*logs), folders, SETTINGS)
    assert [(Path(row.where).name, row.what) for row in problems] == [
        ("gone.csv", "does not exist"),
        ("wrong.csv, column 'RPM', row 42", "'n/a!' is not a number"),
    ]
    assert all(row.remedy for row in problems)
    assert not folders.has("records", "records")


def drifting(seconds: float, parts: float, start: pd.Timestamp = START, phase: float = 0.0) -> pd.DataFrame:
    """Drilling whose stamps, to the millisecond, drift by so many parts per million and begin `phase` s later."""
    log, jitter = drilling(seconds, start=start), np.random.default_rng(8).normal(0, 5e-4, round(seconds * RATE))
    at = np.arange(len(log)) / RATE * (1 + parts * 1e-6) + phase + jitter
    return log.assign(Time=start + pd.to_timedelta(np.round(at * 1e3), unit="ms"))


def follow_on(parts: list[float], minutes: list[float]) -> list[pd.DataFrame]:
    """Logs cut from an unbroken series of samples, whose stamps drift."""
    logs, begin, phase = list[pd.DataFrame](), START, 0.0
    for drift, length in zip(parts, minutes, strict=True):
        logs.append(drifting(60 * length, drift, begin, phase))
        begin, phase = begin + pd.Timedelta(minutes=length), phase + 60 * length * drift * 1e-6
    return logs


@pytest.mark.parametrize("parts", [[50.0] * 4, [-50.0] * 4, [18.0, 20.0, 25.0, 30.0]], ids=["fast", "slow", "mixed"])
def test_logs_whose_clock_drifts_are_all_used_and_join(parts: list[float], tmp_path: Path) -> None:
    minutes = [10.0, 14.0, 18.0, 24.0]
    logs = [save(log, tmp_path / f"{number}.parquet") for number, log in enumerate(follow_on(parts, minutes))]
    records, problems = run(tmp_path, *logs)
    # the kink where the made-up sweep begins anew passes for a spike now and then
    assert [problem for problem in problems if "spikes in speed" not in problem.what] == []
    assert np.bincount(records["log"].values).tolist() == [round(60 * length * RATE) for length in minutes]
    assert (np.diff(records["time"].values) == np.timedelta64(20, "ms")).all()
    assert not (records["flags"].values & ~np.uint8(RecordFlag.SPIKE)).any()


@pytest.mark.parametrize("drift", [-250.0, 250.0])
def test_a_large_drift_is_told_and_hides_no_pause(drift: float, tmp_path: Path) -> None:
    first, second = follow_on([drift, drift], [2.0, 2.0])
    second["Time"] += pd.Timedelta(seconds=4)
    records, problems = run(tmp_path, save(first, tmp_path / "a.parquet"), save(second, tmp_path / "b.parquet"))
    assert len(problems) == 2
    assert all(f"{-drift:+.0f} parts per million off the rate of 50 Hz" in row.what for row in problems), problems
    assert np.max(np.diff(records["time"].values)) == np.timedelta64(4020, "ms")
    assert records.sizes["time"] == len(first) + len(second)


def test_after_a_long_pause_a_log_goes_by_its_stamps_again(tmp_path: Path) -> None:
    first = drifting(600, -150)
    second = drifting(60, -150, START + pd.Timedelta(hours=1))
    records, _ = run(tmp_path, save(first, tmp_path / "a.parquet"), save(second, tmp_path / "b.parquet"))
    begin = records["time"].values[records["log"].values == 1][0]
    assert abs(begin - second["Time"].iloc[0].to_datetime64()) < np.timedelta64(20, "ms")


@pytest.mark.parametrize("kept", [True, False], ids=["on the new clock", "on the old clock"])
def test_the_log_after_a_set_clock_joins_whichever_clock_it_keeps(kept: bool, tmp_path: Path) -> None:
    first, second = drilling(60), drilling(30, start=START + pd.Timedelta(seconds=60))
    first.loc[1612:, "Time"] -= pd.Timedelta(seconds=20)
    second["Time"] -= pd.Timedelta(seconds=20 * kept)
    records, problems = run(tmp_path, save(first, tmp_path / "a.parquet"), save(second, tmp_path / "b.parquet"))
    assert records.sizes["time"] == 4500
    assert (np.diff(records["time"].values) == np.timedelta64(20, "ms")).all()
    assert ["+20.0 s off its stamp" in problem.what for problem in problems[1:]] == [True] * kept


def test_a_bad_stamp_far_down_a_log_is_told_once_with_its_row(tmp_path: Path) -> None:
    log = drilling(60)
    log["Time"] = [stamp.isoformat() + "Z" for stamp in log["Time"]]
    log.loc[2500, "Time"] = "noon"
    log.to_csv(tmp_path / "log.csv", index=False)
    problems = process(well(tmp_path / "log.csv"), WellFolders(tmp_path / "results", "W1"), SETTINGS)
    assert [(Path(row.where).name, row.what) for row in problems] == [
        ("log.csv, column 'Time', row 2501", "'noon' is not a time")
    ]
