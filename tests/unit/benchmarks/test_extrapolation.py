"""10,000 wells on paper: from measured constants alone, and none where they have not been measured."""

import json
from pathlib import Path

import pytest
from rich.console import Console

from benchmarks.fleet import extrapolation
from benchmarks.fleet.extrapolation import Constants, forecast
from drillid.errors import SettingsError

MEASURED = {
    "computing_s_of_a_well": 8.0,
    "overhead_s_200": 200 * 0.03 + 16 * 2.0,
    "plan_s_of_a_well": 0.01,
    "tables_s_of_a_well": 0.02,
}


@pytest.fixture
def file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    path = tmp_path / "bench-fleet.json"
    path.write_text(json.dumps(MEASURED))
    monkeypatch.setattr(extrapolation, "FILE", path)
    return path


def test_the_constants_are_those_of_the_file(file: Path) -> None:
    """200 wells in two batches are 16 jobs, whose start is what planning, tables and report leave of the overhead."""
    assert Constants.measured() == Constants(well=8.0, job=pytest.approx(2.0), plan=0.01, tables=0.02)


@pytest.mark.parametrize("name", MEASURED)
def test_a_constant_that_was_not_measured_is_named(file: Path, name: str) -> None:
    file.write_text(json.dumps({key: value for key, value in MEASURED.items() if key != name}))
    with pytest.raises(SettingsError, match=f"lacks {name}. Run the parts"):
        Constants.measured()


def test_a_hundred_nodes_take_four_rounds_of_jobs(file: Path) -> None:
    """400 jobs on 100 nodes; 25 wells on 16 cores are two after another."""
    found = forecast(Constants.measured(), 10_000, 100, 16, 25)
    rounds = 4 * (8 * 2.0 + 2 * 8.0)
    assert found.serial_hours * 3600 == pytest.approx(300.0)
    assert found.hours * 3600 == pytest.approx(300.0 + rounds)
    assert found.efficiency == pytest.approx(10_000 * 8.0 / (428.0 * 1600))
    assert extrapolation.measure(Console(quiet=True)).tables["forecast_10000_wells_by_nodes"].keys() == {"1", "100"}
