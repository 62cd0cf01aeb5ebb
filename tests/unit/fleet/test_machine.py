"""A full disk, a folder that may not be written and damaged results: a row or an exit code, and nothing by halves."""

import dataclasses
import json
import os
import subprocess
import threading
import time
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pandas as pd
import pytest
import xarray as xr

from drillid.config.listing import Listing, Well
from drillid.config.settings import Settings
from drillid.datasets.checksums import SUFFIX, write_checksums
from drillid.datasets.store import Problem, WellFolders, write_store
from drillid.errors import DamageError
from drillid.fleet import run as fleet
from drillid.fleet.run import Task, collect_problems, drop_damaged, process_well
from tests.workflow.toys import RIG


@pytest.fixture
def task(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Task:
    """A well whose records are a megabyte of noise."""
    (tmp_path / "toy.yaml").write_text(RIG)
    (tmp_path / "a.csv").write_text("samples")
    monkeypatch.setattr(fleet, "importlib", SimpleNamespace(import_module=lambda _: SimpleNamespace(process=noise)))
    listing = Listing("W1", tmp_path / "toy.yaml", (tmp_path / "a.csv",))
    return Task("records", listing, Settings(), tmp_path / "results", fleet._LOADED)


def noise(well: Well, folders: WellFolders, settings: Settings) -> list[Problem]:
    store(folders.stage("records") / "records.zarr")
    return []


def store(path: Path) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    write_store(xr.Dataset({"a": ("x", np.random.default_rng(1).normal(size=130_000))}), path)
    write_checksums(path, path.with_suffix(SUFFIX))


@pytest.fixture
def small_disk(tmp_path: Path) -> Iterator[Path]:
    """A disk of half a megabyte."""
    place = tmp_path / "disk"
    place.mkdir()
    mount = ["mount", "-t", "tmpfs", "-o", "size=512k", "tmpfs", str(place)]
    if os.getuid() != 0 or subprocess.run(mount, capture_output=True, check=False).returncode:
        pytest.skip("only root can mount a small disk")
    yield place
    subprocess.run(["umount", str(place)], check=True)


def test_a_full_disk_fails_the_job_with_a_row_and_the_next_run_tries_again(task: Task, small_disk: Path) -> None:
    full = dataclasses.replace(task, results=small_disk)
    outcome = process_well(full)
    assert outcome.fatal
    assert "No space left" in outcome.trace
    assert not (small_disk / "records/W1/key.json").exists()
    assert not (small_disk / "records/W1/records.zarr").exists()
    assert "Fix the disk" in collect_problems(small_disk, ["W1"])["remedy"].iloc[0]
    assert process_well(task).status == "done"


def test_a_disk_without_room_for_a_row_fails_the_job_all_the_same(task: Task, small_disk: Path) -> None:
    with pytest.raises(OSError, match="No space left"):
        (small_disk / "other").write_bytes(bytes(2**20))
    outcome = process_well(dataclasses.replace(task, results=small_disk))
    assert (outcome.status, outcome.fatal) == ("failed", True)


def test_results_that_may_not_be_written_fail_the_job(task: Task) -> None:
    task.results.write_text("a file where the folder should be")
    outcome = process_well(task)
    assert (outcome.status, outcome.fatal) == ("failed", True)


@pytest.mark.parametrize("name", ["records.zarr", f"records{SUFFIX}", "problems.csv"])
def test_a_result_that_is_gone_is_made_again(task: Task, name: str) -> None:
    process_well(task)
    assert process_well(task).status == "kept"
    path = task.results / "records/W1" / name
    path.rename(task.results / "elsewhere")
    assert process_well(task).status == "done"
    assert path.exists()
    assert name in json.loads((path.parent / "key.json").read_text())["files"]


@pytest.mark.parametrize("left", [0, 40])
def test_a_damaged_table_is_a_row_before_tables_are_made_and_is_made_again(task: Task, left: int) -> None:
    folders = WellFolders(task.results, "W1")
    folders.write_table("discrepancy", "intervals", pd.DataFrame({"from_m": np.arange(20.0), "to_m": np.arange(20.0)}))
    path = task.results / "discrepancy/W1/intervals.csv"
    assert len(folders.read_table("discrepancy", "intervals")) == 20
    path.write_bytes(path.read_bytes()[:left])
    with pytest.raises(DamageError, match="has changed since it was written"):
        folders.read_table("discrepancy", "intervals")
    (path.parent / "key.json").write_text("{}")
    drop_damaged(task.results, ["W1"])
    assert not path.exists()
    assert not (path.parent / "key.json").exists()
    rows = pd.read_csv(path.parent / "problems.csv")
    assert rows[["well", "stage", "where"]].to_numpy().tolist() == [["W1", "discrepancy", str(path)]]


def test_a_well_waits_for_a_worker_that_is_still_at_it(task: Task, monkeypatch: pytest.MonkeyPatch) -> None:
    ends = {"first": threading.Event(), "second": threading.Event()}
    begun, journal = threading.Event(), list[str]()

    def slow(well: Well, folders: WellFolders, settings: Settings) -> list[Problem]:
        which = "second" if begun.is_set() else "first"
        begun.set()
        journal.append(f"{which} begins")
        ends[which].wait(20)
        journal.append(f"{which} ends")
        return noise(well, folders, settings)

    monkeypatch.setattr(fleet, "importlib", SimpleNamespace(import_module=lambda _: SimpleNamespace(process=slow)))
    other = dataclasses.replace(task, settings=Settings.checked({"records": {"stuck_s": 4.0}}, "test"))
    with ThreadPoolExecutor(2) as pool:
        first = pool.submit(process_well, task)
        begun.wait(20)
        second = pool.submit(process_well, other)
        ends["second"].set()
        # where the second one does not wait, it is done by then
        time.sleep(0.3)
        ends["first"].set()
        assert [each.result().status for each in (first, second)] == ["done", "done"]
    assert journal == ["first begins", "first ends", "second begins", "second ends"]
    assert process_well(other).status == "kept"


def test_a_damaged_dataset_is_a_row_before_tables_are_made_and_no_other_well_suffers(task: Task) -> None:
    for well in ("W1", "W2"):
        store(task.results / "depth" / well / "depth.zarr")
    chunk = next((task.results / "depth/W1/depth.zarr/a/c").iterdir())
    chunk.unlink()
    drop_damaged(task.results, ["W1", "W2"])
    assert not (task.results / "depth/W1/depth.zarr").exists()
    assert (task.results / "depth/W2/depth.zarr").exists()
    rows = pd.read_csv(task.results / "depth/W1/problems.csv")
    assert rows[["well", "stage", "what"]].to_numpy().tolist() == [["W1", "depth", "is missing"]]
