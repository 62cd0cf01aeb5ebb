"""One well through one stage: what is left alone, what is done again, and how failures end."""

import dataclasses
import errno
import hashlib
import json
from collections.abc import Callable
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pandas as pd
import pytest
import xarray as xr

import drillid
from drillid.config.listing import Listing, Well
from drillid.config.settings import FitsSettings, Settings, WindowsSettings
from drillid.datasets.registry import DATASETS
from drillid.datasets.store import Problem, WellFolders
from drillid.errors import LogError, SettingsError
from drillid.fleet import run as fleet
from drillid.fleet.manifest import out_of_date, stored, write_manifest
from drillid.fleet.outcome import failed_wells
from drillid.fleet.run import Outcome, Task, collect_problems, process_well
from drillid.fleet.stages import failed_on
from tests.workflow.toys import RIG

Process = Callable[[Well, WellFolders, Settings], list[Problem]]


@pytest.fixture
def task(tmp_path: Path) -> Task:
    (tmp_path / "toy.yaml").write_text(RIG)
    (tmp_path / "a.csv").write_text("samples")
    listing = Listing("W1", tmp_path / "toy.yaml", (tmp_path / "a.csv",))
    return Task("records", listing, Settings(), tmp_path / "results", fleet._LOADED)


@pytest.fixture
def stage(monkeypatch: pytest.MonkeyPatch) -> Callable[[Process], None]:
    def use(process: Process) -> None:
        module = SimpleNamespace(process=process)
        monkeypatch.setattr(fleet, "importlib", SimpleNamespace(import_module=lambda _: module))

    return use


def good(well: Well, folders: WellFolders, settings: Settings) -> list[Problem]:
    for name in ("records", "logs"):
        (folders.stage("records") / f"{name}.zarr").mkdir(parents=True)
    return [Problem("a.csv", "a spike", "None needed")]


def raising(error: Exception) -> Process:
    def process(well: Well, folders: WellFolders, settings: Settings) -> list[Problem]:
        (folders.stage("records") / "records.zarr").mkdir(parents=True)
        raise error

    return process


def test_a_well_with_faults_in_the_sheets_fails_with_all_of_them_until_they_are_mended(
    task: Task, stage: Callable[[Process], None]
) -> None:
    stage(good)
    faults = tuple(SettingsError(f"logs.tsv, row {row}", "is wrong", "Mend it") for row in (2, 5))
    refused = dataclasses.replace(task, listing=dataclasses.replace(task.listing, faults=faults))
    assert [process_well(refused).status for _ in range(2)] == ["failed", "kept"]
    rows = collect_problems(task.results, ["W1"])
    assert rows["where"].tolist() == ["logs.tsv, row 2", "logs.tsv, row 5"]
    assert process_well(task).status == "done"


def with_settings(task: Task, **sections: Any) -> Task:
    return dataclasses.replace(task, settings=task.settings.model_copy(update=sections))


def rows(task: Task) -> list[list[str]]:
    path = task.results / "records/W1/problems.csv"
    return list(pd.read_csv(path)[["where", "what", "remedy"]].to_numpy().tolist())


def test_an_unchanged_well_is_kept_with_its_problems(task: Task, stage: Callable[[Process], None]) -> None:
    stage(good)
    assert process_well(task).status == "done"
    stage(raising(AssertionError("must not be called")))
    assert process_well(task) == Outcome("W1", "kept", problems=1)
    assert process_well(with_settings(task, fits=FitsSettings(starts=2))).status == "kept"


@pytest.mark.parametrize(
    "change",
    [
        lambda task: task.listing.logs[0].write_text("more samples"),
        lambda task: task.listing.rig_file.write_text(RIG.replace("SWEEP", "SWEEP2")),
    ],
)
def test_a_changed_input_is_done_again(
    task: Task, stage: Callable[[Process], None], change: Callable[[Task], None]
) -> None:
    stage(good)
    process_well(task)
    change(task)
    assert process_well(task).status == "done"


def test_a_change_upstream_reaches_the_next_stage(task: Task, stage: Callable[[Process], None]) -> None:
    stage(good)
    process_well(task)
    windows = dataclasses.replace(task, stage="windows")
    stage(lambda well, folders, settings: [])
    assert [process_well(windows).status for _ in range(2)] == ["done", "kept"]
    assert process_well(with_settings(windows, windows=WindowsSettings(overlap=0.5))).status == "done"
    stage(good)
    task.listing.logs[0].write_text("more samples")
    process_well(task)
    stage(lambda well, folders, settings: [])
    assert process_well(windows).status == "done"


def test_a_failure_is_a_row_and_leaves_no_dataset_of_before(task: Task, stage: Callable[[Process], None]) -> None:
    stage(good)
    process_well(task)
    task.listing.logs[0].write_text("bad samples")
    stage(raising(LogError("a.csv, row 3", "is not a number", "Correct it")))
    assert process_well(task).status == "failed"
    assert rows(task) == [["a.csv, row 3", "is not a number", "Correct it"]]
    assert not WellFolders(task.results, "W1").has("records", "records")
    assert process_well(task).status == "kept"
    assert process_well(dataclasses.replace(task, stage="windows")) == Outcome(
        "W1", "empty", seconds=pytest.approx(0, abs=60)
    )


def test_what_nobody_foresaw_is_a_row_with_its_place_and_is_tried_again(
    task: Task, stage: Callable[[Process], None]
) -> None:
    stage(raising(ZeroDivisionError("a fault")))
    outcome = process_well(task)
    assert outcome.status == "failed"
    assert "ZeroDivisionError: a fault" in outcome.trace
    [[where, what, remedy]] = rows(task)
    assert where.startswith("drillid/fleet/run.py, line ")  # the last place within the program
    assert what == "ZeroDivisionError: a fault"
    assert "report it" in remedy
    assert process_well(task).status == "failed"
    stage(good)
    assert process_well(task).status == "done"


def test_a_well_without_a_log_that_could_not_be_read_is_done_and_done_again_by_the_next_run(
    task: Task, stage: Callable[[Process], None]
) -> None:
    def without_a_log(well: Well, folders: WellFolders, settings: Settings) -> list[Problem]:
        return [*good(well, folders, settings), Problem("b.csv", "is not readable", "Ask for permission", again=True)]

    folder, manifest = task.results / "records/W1", task.results / "records/W1.json"
    windows = dataclasses.replace(task, stage="windows")

    def nights(process: Process) -> tuple[str, str, bool]:
        stage(process)
        first = process_well(task).status
        write_manifest(manifest, ["W1"])
        stage(lambda well, folders, settings: [])
        return first, process_well(windows).status, not out_of_date(manifest, ["W1"], lambda _: "")

    assert nights(without_a_log) == ("done", "done", False)
    assert stored(folder)["status"] == "done"
    # what reads these results is done again once they have changed
    assert nights(without_a_log) == ("done", "kept", False)
    assert nights(good) == ("done", "done", True)
    assert nights(good) == ("kept", "kept", True)


def test_a_failure_that_may_be_the_machines_is_tried_again(task: Task, stage: Callable[[Process], None]) -> None:
    def unreadable(well: Well, folders: WellFolders, settings: Settings) -> list[Problem]:
        try:
            raise OSError(errno.ESTALE, "Stale file handle")
        except OSError as error:
            raise SettingsError("toy.yaml", "cannot be read", "Write the file") from error

    stage(unreadable)
    assert [process_well(task).status for _ in range(2)] == ["failed", "failed"]
    write_manifest(task.results / "records/W1.json", ["W1"])
    assert out_of_date(task.results / "records/W1.json", ["W1"], lambda _: failed_on(task.listing))
    assert failed_wells(task.results, ["W1"]) == {"W1": "records: toy.yaml: cannot be read"}
    stage(good)
    assert process_well(task).status == "done"


def test_the_key_says_what_the_folder_was_made_from(task: Task, stage: Callable[[Process], None]) -> None:
    stage(good)
    process_well(task)
    key = json.loads((task.results / "records/W1/key.json").read_text())
    assert key.keys() == {"key", "basis", "source", "settings", "rig", "logs", "upstream"} | {
        *("status", "versions", "inputs", "files")
    }
    assert key["settings"] == {"records": Settings().records.model_dump()}


def test_a_dataset_says_what_it_comes_from(task: Task, stage: Callable[[Process], None]) -> None:
    def write(well: Well, folders: WellFolders, settings: Settings) -> list[Problem]:
        for name in ("records", "logs"):
            folders.write("records", name, DATASETS[name].empty())
        return []

    def attributes() -> dict[str, Any]:
        assert process_well(task).status == "done"
        return dict(xr.open_zarr(task.results / "records/W1/records.zarr").attrs)

    stage(write)
    first, log = attributes(), task.listing.logs[0]
    key = json.loads((task.results / "records/W1/key.json").read_text())
    assert first["code_hash"] == key["source"]
    assert f"drillid {drillid.__version__}, numba " in first["versions"]
    assert f"{hashlib.sha256(log.read_bytes()).hexdigest()}  a.csv" in first["input_sha256"].splitlines()
    log.write_text("other samples")
    second = attributes()
    assert {name for name in first if first[name] != second[name]} == {"input_sha256"}
    log.write_text("samples")
    assert attributes() == first, "the same inputs, the same attributes"


def test_a_process_with_older_code_refuses_to_work(task: Task) -> None:
    with pytest.raises(SettingsError, match="Restart the dask workers"):
        process_well(dataclasses.replace(task, code="another"))


def test_problems_are_collected_over_wells_and_stages(task: Task, stage: Callable[[Process], None]) -> None:
    stage(good)
    process_well(task)
    found = collect_problems(task.results, ["W0", "W1"])
    assert found.to_dict("records") == [
        {"well": "W1", "stage": "records", "where": "a.csv", "what": "a spike", "remedy": "None needed"}
    ]
    assert collect_problems(task.results, ["W0"]).empty
