"""What was finished is set aside while it is made again, and is there only where it is whole and of the same basis."""

import json
from pathlib import Path

import pytest

from drillid.datasets.store import WellFolders
from drillid.fleet.aside import clear, forget_aside, set_aside
from drillid.fleet.manifest import KEY


@pytest.fixture
def folders(tmp_path: Path) -> WellFolders:
    return WellFolders(tmp_path, "W1", "code 1")


def finish(folders: WellFolders, content: str, **key: str) -> None:
    """The stage's folder with one file, and its key."""
    folder = folders.stage("fits")
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "fits.zarr").write_text(content)
    (folder / KEY).write_text(json.dumps({"key": "1", "status": "done", "basis": folders.basis, **key}))


def aside(folders: WellFolders) -> str:
    path = folders.aside("fits") / "fits.zarr"
    return path.read_text() if path.exists() else ""


def test_a_finished_folder_is_set_aside_and_its_place_is_empty(folders: WellFolders) -> None:
    finish(folders, "first")
    (folders.stage("fits") / ".snakemake_timestamp").touch()
    set_aside(folders, "fits")
    assert aside(folders) == "first"
    assert [path.name for path in folders.stage("fits").iterdir()] == [".snakemake_timestamp"]
    forget_aside(folders, "fits")
    assert not folders.aside("fits").exists()


@pytest.mark.parametrize("key", [{"status": "failed"}, {"status": "empty"}, {"basis": "code 2"}], ids=str)
def test_what_failed_or_comes_from_other_code_is_not_set_aside(folders: WellFolders, key: dict[str, str]) -> None:
    finish(folders, "first", **key)
    set_aside(folders, "fits")
    assert aside(folders) == ""
    assert not list(folders.stage("fits").iterdir())


def test_a_failure_in_between_leaves_what_lies_aside(folders: WellFolders) -> None:
    finish(folders, "first")
    set_aside(folders, "fits")
    finish(folders, "nothing", status="failed")
    set_aside(folders, "fits")
    assert aside(folders) == "first"


def test_the_newest_finished_folder_replaces_what_lies_aside(folders: WellFolders) -> None:
    for content in ("first", "second"):
        finish(folders, content)
        set_aside(folders, "fits")
    assert aside(folders) == "second"


def test_what_was_half_deleted_or_half_made_is_not_used(folders: WellFolders) -> None:
    finish(folders, "first")
    set_aside(folders, "fits")
    (folders.aside("fits") / KEY).unlink()
    (folders.stage("fits") / "fits.part").write_text("half")
    set_aside(folders, "fits")
    assert aside(folders) == ""
    assert not list(folders.stage("fits").iterdir())


def test_a_run_killed_between_moving_and_making_the_folder_is_taken_up(folders: WellFolders) -> None:
    finish(folders, "first")
    set_aside(folders, "fits")
    folders.stage("fits").rmdir()
    set_aside(folders, "fits")
    assert aside(folders) == "first"
    assert folders.stage("fits").is_dir()


def test_clearing_leaves_what_lies_aside(folders: WellFolders) -> None:
    finish(folders, "first")
    set_aside(folders, "fits")
    clear(folders, "fits")
    assert aside(folders) == "first"
