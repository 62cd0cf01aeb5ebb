"""How a result came to be, in words."""

import hashlib
from pathlib import Path

import pytest

from drillid.config.settings import Settings
from drillid.config.sheets import Listing
from drillid.errors import SettingsError
from drillid.fleet import run as fleet
from drillid.fleet.explain import explain
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


def test_anything_else_is_refused(tmp_path: Path) -> None:
    with pytest.raises(SettingsError, match="is no result of a stage of a well"):
        explain(tmp_path)
