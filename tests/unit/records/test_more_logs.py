"""Logs that are added, come late, are corrected or taken away: only they are read, and the result is that of all."""

import errno
import json
import os
from collections.abc import Sequence
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pandas as pd
import pytest
import xarray as xr

from drillid.config.settings import Settings
from drillid.datasets.store import Problem, WellFolders
from drillid.fleet.aside import forget_aside, set_aside
from drillid.fleet.manifest import KEY
from drillid.formats import log as reader_of_log
from drillid.records import stage
from tests.raw_logs import RIG, START, drilling, save

SETTINGS = Settings()
SECONDS = 4
HOURLY = pd.Timedelta(hours=1)
ON_END = pd.Timedelta(seconds=SECONDS)
OVERLAPPING = pd.Timedelta(seconds=SECONDS - 1)


@pytest.fixture
def read(monkeypatch: pytest.MonkeyPatch) -> list[str]:
    """Names of the logs that are read, as they are."""
    names: list[str] = []
    reading = stage.read_channels

    def noted(path: Path, *rest: Any) -> Any:
        names.append(path.stem)
        return reading(path, *rest)

    monkeypatch.setattr(stage, "read_channels", noted)
    return names


def log(folder: Path, number: int, every: pd.Timedelta, seed: int = 0) -> Path:
    """One log of the well; with another seed it is a corrected one."""
    start = START + number * every
    return save(drilling(SECONDS, 100 * seed + number, start=start), folder / f"{number}.parquet")


def run(results: Path, logs: Sequence[Path]) -> list[Problem]:
    """The stage as a run of the workflow does it, after whatever runs there were."""
    folders = WellFolders(results, "W1", "basis")
    well: Any = SimpleNamespace(name="W1", rig=RIG, logs=tuple(logs))
    set_aside(folders, "records")
    problems = stage.process(well, folders, SETTINGS)
    (folders.stage("records") / KEY).write_text(json.dumps({"key": "1", "status": "done", "basis": "basis"}))
    forget_aside(folders, "records")
    return problems


def stored(results: Path) -> list[xr.Dataset]:
    return [WellFolders(results, "W1").read("records", name).load() for name in ("records", "logs")]


def files(results: Path) -> dict[str, bytes]:
    """All that the stage wrote, by its place."""
    folder = results / "records" / "W1"
    return {str(path.relative_to(folder)): path.read_bytes() for path in folder.rglob("*") if path.is_file()}


def compare(results: Path, logs: Sequence[Path], problems: list[Problem], fresh: Path) -> None:
    assert problems == run(fresh, logs)
    for found, expected in zip(stored(results), stored(fresh), strict=True):
        xr.testing.assert_identical(found, expected)
    assert files(results) == files(fresh)


@pytest.mark.parametrize("every", [HOURLY, ON_END, OVERLAPPING], ids=["apart", "on end", "overlapping"])
@pytest.mark.parametrize("seed", range(2))
def test_any_sequence_of_changes_ends_as_if_all_logs_had_come_at_once(
    every: pd.Timedelta, seed: int, tmp_path: Path
) -> None:
    draw, there = np.random.default_rng(seed), dict[int, Path]()
    for night in range(4):
        number = int(draw.integers(6))
        if draw.random() < 0.2 and len(there) > 1:
            del there[sorted(there)[number % len(there)]]
        else:
            there[number] = log(tmp_path, number, every, seed=night)
        problems = run(tmp_path / "results", list(there.values()))
        compare(tmp_path / "results", list(there.values()), problems, tmp_path / f"fresh{night}")


def test_a_new_day_costs_one_log(tmp_path: Path, read: list[str]) -> None:
    logs = [log(tmp_path, number, ON_END) for number in range(3)]
    run(tmp_path / "results", logs[:2])
    read.clear()
    problems = run(tmp_path / "results", logs)
    assert read == ["2"]
    compare(tmp_path / "results", logs, problems, tmp_path / "fresh")


@pytest.mark.parametrize(("every", "again"), [(HOURLY, ["1", "2"]), (ON_END, ["1", "2"])], ids=["apart", "on end"])
def test_a_late_log_costs_itself_and_the_one_that_follows_it(
    every: pd.Timedelta, again: list[str], tmp_path: Path, read: list[str]
) -> None:
    logs = [log(tmp_path, number, every) for number in range(5)]
    run(tmp_path / "results", [*logs[:1], *logs[2:]])
    read.clear()
    problems = run(tmp_path / "results", logs)
    assert read[: len(again)] == again
    assert every is ON_END or read == again
    compare(tmp_path / "results", logs, problems, tmp_path / "fresh")


def test_a_corrected_log_costs_itself_where_its_end_is_the_same(tmp_path: Path, read: list[str]) -> None:
    logs = [log(tmp_path, number, HOURLY) for number in range(4)]
    run(tmp_path / "results", logs)
    before = stored(tmp_path / "results")[1]["key"].values
    logs[1] = log(tmp_path, 1, HOURLY, seed=1)
    read.clear()
    problems = run(tmp_path / "results", logs)
    assert read == ["1"]
    assert (stored(tmp_path / "results")[1]["key"].values == before).tolist() == [True, False, True, True]
    compare(tmp_path / "results", logs, problems, tmp_path / "fresh")


def test_a_refused_log_is_not_read_again_and_its_row_stays(tmp_path: Path, read: list[str]) -> None:
    lacking = save(drilling(SECONDS, start=START + HOURLY).drop(columns="RPM"), tmp_path / "lacking.parquet")
    logs = [log(tmp_path, 0, HOURLY), lacking]
    first = run(tmp_path / "results", logs)
    read.clear()
    logs.append(log(tmp_path, 2, HOURLY))
    assert run(tmp_path / "results", logs) == first
    assert read == ["2"]
    assert len(first) == 1


def test_a_log_at_which_the_program_failed_is_tried_again(
    tmp_path: Path, read: list[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    logs = [log(tmp_path, number, HOURLY) for number in range(3)]
    reading = stage.regular_record
    failing = lambda path, *rest: 1 // 0 if path == logs[1] else reading(path, *rest)  # noqa: E731
    with monkeypatch.context() as patched:
        patched.setattr(stage, "regular_record", failing)
        assert len(run(tmp_path / "results", logs)) == 1
    read.clear()
    problems = run(tmp_path / "results", logs)
    assert read[0] == "1"
    compare(tmp_path / "results", logs, problems, tmp_path / "fresh")


@pytest.mark.parametrize("failing", ["tables", "start", "channels"])
@pytest.mark.parametrize("fault", [errno.EACCES, errno.EIO, errno.ESTALE, errno.ETIMEDOUT], ids=errno.errorcode.get)
def test_a_log_that_could_not_be_read_is_tried_again(
    failing: str, fault: int, tmp_path: Path, read: list[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    logs = [log(tmp_path, number, HOURLY) for number in range(3)]
    reading, seen = reader_of_log.reader_of, list[Path]()

    def unreadable(path: Path) -> Any:
        """Fails from the first, second or third time on that the log is opened."""
        seen.extend([path] if path == logs[1] else [])
        if path == logs[1] and len(seen) > ["tables", "start", "channels"].index(failing):
            raise OSError(fault, os.strerror(fault), str(path))
        return reading(path)

    with monkeypatch.context() as patched:
        patched.setattr(reader_of_log, "reader_of", unreadable)
        [problem] = run(tmp_path / "results", logs)
    assert problem.again
    assert "damaged" not in problem.remedy
    read.clear()
    problems = run(tmp_path / "results", logs)
    assert read[0] == "1"
    assert problems == []
    compare(tmp_path / "results", logs, problems, tmp_path / "fresh")


def test_without_the_earlier_records_everything_is_read_again(tmp_path: Path, read: list[str]) -> None:
    logs = [log(tmp_path, number, HOURLY) for number in range(3)]
    run(tmp_path / "results", logs[:2])
    folders = WellFolders(tmp_path / "results", "W1", "basis")
    set_aside(folders, "records")
    # a run that was killed has used the earlier series up
    (folders.aside("records") / "records.zarr").rename(folders.stage("records") / "records.part")
    read.clear()
    problems = run(tmp_path / "results", logs)
    assert read == ["0", "1", "2"]
    compare(tmp_path / "results", logs, problems, tmp_path / "fresh")
