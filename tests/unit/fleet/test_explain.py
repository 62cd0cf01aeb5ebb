"""How a result came to be, in words."""

import hashlib
import json
import os
from pathlib import Path

import pytest
from typer.testing import CliRunner

from drillid.commands import app
from drillid.config.listing import Listing
from drillid.config.settings import Settings
from drillid.errors import SettingsError
from drillid.fleet import explain as explain_module
from drillid.fleet import run as fleet
from drillid.fleet.explain import explain, inputs_of, known_inputs, remember_inputs
from drillid.fleet.run import Task, process_well
from tests.workflow.toys import RIG


def test_it_names_the_log_with_its_checksum_and_the_code(tmp_path: Path) -> None:
    """A log that cannot be read is enough: a failure is explained as well."""
    (tmp_path / "toy.yaml").write_text(RIG)
    log = tmp_path / "a.csv"
    log.write_text("Time,SWEEP,RPM,DMEA\n")
    listing = Listing("W1", tmp_path / "toy.yaml", (log,))
    process_well(Task("records", listing, Settings(), tmp_path / "results", fleet._LOADED))
    text = explain(tmp_path / "results/records/W1/problems.csv")
    assert f"{log}: sha256 {hashlib.sha256(log.read_bytes()).hexdigest()}" in text
    assert "the code as it is now" in text
    assert "interpolate_up_to_s" in text
    assert "numpy" in text


def test_programs_get_the_same_as_json(tmp_path: Path) -> None:
    (tmp_path / "toy.yaml").write_text(RIG)
    log = tmp_path / "a.csv"
    log.write_text("Time,SWEEP,RPM,DMEA\n")
    listing = Listing("W1", tmp_path / "toy.yaml", (log,))
    process_well(Task("records", listing, Settings(), tmp_path / "results", fleet._LOADED))
    done = CliRunner().invoke(app, ["explain", str(tmp_path / "results/records/W1"), "--json"])
    assert str(log) in json.loads(done.stdout)["records"]["inputs"]


def test_anything_else_is_refused(tmp_path: Path) -> None:
    with pytest.raises(SettingsError, match="is not a result of a stage of a well"):
        explain(tmp_path)


def test_what_does_not_exist_is_not_explained(tmp_path: Path) -> None:
    with pytest.raises(SettingsError, match="does not exist"):
        explain(tmp_path / "results/records/W1/recrods.zarr")


def test_a_log_is_read_again_only_where_its_state_has_changed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    log, new = tmp_path / "log.csv", tmp_path / "new.csv"
    for path in (log, new):
        path.write_text(path.name)
    os.utime(log, (1e9, 1e9))
    assert known_inputs(tmp_path) == {}
    first = inputs_of([log, new, tmp_path / "missing.csv"])
    sums = {str(path): hashlib.sha256(path.read_bytes()).hexdigest() for path in (log, new)}
    assert {name: checksum for name, (_, checksum) in first.items()} == sums
    remember_inputs(tmp_path, first)
    read: list[Path] = []
    local = explain_module.local_file
    monkeypatch.setattr(explain_module, "local_file", lambda path: read.append(path) or local(path))
    # a file that was just written may change once more without a trace in its time
    assert inputs_of([log, new], known_inputs(tmp_path)) == first
    assert read == [new]
    log.write_text("changed")
    os.utime(log, (1e9, 1e9 + 1))
    assert inputs_of([log], known_inputs(tmp_path))[str(log)][1] == hashlib.sha256(b"changed").hexdigest()
    assert read == [new, log]
