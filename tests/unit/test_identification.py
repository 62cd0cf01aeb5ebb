"""One well's logs to parameters in memory: the same as the workflow makes on disk, and what is refused."""

import importlib
import json
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
import xarray as xr
from typer.testing import CliRunner

import drillid
from drillid.commands import app
from drillid.config.settings import Settings
from drillid.datasets.store import WellFolders
from drillid.errors import EstimationError, LogError, SettingsError
from drillid.identification import Identification
from tests import raw_logs
from tests.simulated import RATE, SHALLOW, drilled

ROOT = Path(__file__).resolve().parents[2]
DESCRIPTION = """
name: small rig
time: {column: Time}
channels:
  torque_sweep: {column: SWEEP, unit: N m}
  torque_command: {column: TQ, unit: N m}
  speed: {column: SPEED, unit: rad/s}
  speed_set: {column: SET, unit: rad/s}
  hole_depth: {column: HOLE, unit: m}
controller: {proportional: 350 N m s/rad, integral: 180 N m/rad}
collars: [{outer_diameter: 120.6 mm, inner_diameter: 57.2 mm, length: 60 m}]
"""
SETTINGS = Settings.checked({"windows": {"length_s": 480.0}}, "settings of the test")
STAGES = {"records": "records", "windows": "windows", "spectra": "spectra", "mobility": "mobility", "fits": "fits"}


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("well")
    (folder / "rig.yaml").write_text(DESCRIPTION)
    channels = drilled(SHALLOW, 1000.0, seed=3)
    seconds = np.arange(channels["speed"].size) / RATE
    log = pd.DataFrame(
        {
            "Time": [f"{stamp.isoformat()}Z" for stamp in pd.Timestamp(2025, 3, 3) + pd.to_timedelta(seconds, "s")],
            "SWEEP": channels["torque_sweep"].round(1),
            "TQ": channels["torque_command"].round(1),
            "SPEED": channels["speed"].round(4),
            "SET": 10.5,
            "HOLE": SHALLOW.bit_depth + 0.005 * seconds,
        }
    )
    log.to_csv(folder / "stand.csv", index=False)
    return folder


@pytest.fixture(scope="module")
def identified(folder: Path) -> Identification:
    return drillid.identify(folder / "stand.csv", folder / "rig.yaml", SETTINGS)


def test_memory_holds_what_the_stages_write_on_disk(identified: Identification, tmp_path: Path) -> None:
    folders = WellFolders(tmp_path, "W1", name=identified.well.name)
    for stage, name in STAGES.items():
        importlib.import_module(f"drillid.{stage}.stage").process(identified.well, folders, SETTINGS)
        written = folders.read(stage, name).load()
        xr.testing.assert_identical(written, getattr(identified, name).load())


def test_the_true_string_is_found(identified: Identification) -> None:
    table = identified.parameters.set_index(["window", "parameter"])
    assert table.index.get_level_values("window").nunique() == 2
    for name, truth in (("length", SHALLOW.pipe.length), ("inertia_td", SHALLOW.top_drive.inertia)):
        found = table.xs(name, level="parameter")
        assert found["accepted"].all()
        assert (np.abs(found["value"] - truth) < 4 * found["standard_error"]).all()
        assert (found["standard_error"] < 0.05 * truth).all()


def test_figures_and_verdicts_come_when_they_are_asked_for(identified: Identification) -> None:
    assert set(identified.verdicts["verdict"]) <= {"none"}
    assert identified.draw("command_mobility_fitted").axes
    with pytest.raises(SettingsError, match="command_mobility_fitted"):
        identified.draw("no such figure")


def test_the_example_of_the_readme_runs_as_it_stands(
    folder: Path, identified: Identification, monkeypatch: pytest.MonkeyPatch
) -> None:
    """With the windows of these tests, which are identified once."""
    example = (ROOT / "README.md").read_text().partition("```python\n")[2].partition("```")[0]
    assert len(example.splitlines()) <= 10
    monkeypatch.chdir(folder)
    known = {(log.name, "rig.yaml"): identified for log in identified.well.logs}
    monkeypatch.setattr(drillid, "identify", lambda log, rig: known[log, rig], raising=False)
    exec(compile(example, "README.md", "exec"), {})
    assert (folder / "mobility.png").read_bytes().startswith(b"\x89PNG")


def test_what_cannot_be_identified_is_refused_with_its_reason(folder: Path, tmp_path: Path) -> None:
    with pytest.raises(LogError, match=r"none\.csv"):
        drillid.identify(tmp_path / "none.csv", folder / "rig.yaml")
    with pytest.raises(EstimationError, match="too short"):
        drillid.identify(
            folder / "stand.csv", folder / "rig.yaml", Settings.checked({"windows": {"length_s": 3600.0}}, "long")
        )
    with pytest.raises(SettingsError, match="no log"):
        drillid.identify([], folder / "rig.yaml")


def test_windows_too_short_for_their_sweep_are_told_as_such(tmp_path: Path) -> None:
    log = raw_logs.save(raw_logs.drilling(30), tmp_path / "log.csv")
    short = Settings.checked({"windows": {"length_s": 20.0}}, "settings of the test")
    with pytest.raises(EstimationError, match="too short for a sweep that does not repeat in it: 240 s are needed"):
        drillid.identify(log, raw_logs.RIG, short)


def test_the_command_prints_and_writes_the_same(folder: Path, identified: Identification, tmp_path: Path) -> None:
    (tmp_path / "settings.yaml").write_text("windows: {length_s: 480}\n")
    words = ["fit", folder / "stand.csv", "--rig", folder / "rig.yaml", "--configfile", tmp_path / "settings.yaml"]
    table, plot = tmp_path / "parameters.csv", tmp_path / "mobility.svg"
    result = CliRunner().invoke(app, [*map(str, words), "--json", "--table", str(table), "--plot", str(plot)])
    assert result.exit_code == 0, result.output
    rows = json.loads(result.stdout)["parameters"]
    assert [row["value"] for row in rows] == identified.parameters["value"].tolist()
    np.testing.assert_array_equal(pd.read_csv(table)["value"], identified.parameters["value"])
    assert "<svg" in plot.read_text()
    refused = CliRunner().invoke(app, ["fit", str(tmp_path / "none.csv"), "--rig", str(folder / "rig.yaml")])
    assert refused.exit_code == 1
    assert "none.csv" in refused.stderr


def test_control_is_tuned_to_the_fit(folder: Path, identified: Identification, tmp_path: Path) -> None:
    (tmp_path / "settings.yaml").write_text("windows: {length_s: 480}\n")
    words = ["tune", folder / "stand.csv", "--rig", folder / "rig.yaml", "--configfile", tmp_path / "settings.yaml"]
    result = CliRunner().invoke(app, [*map(str, words), "--json"])
    assert result.exit_code == 0, result.output
    content = json.loads(result.stdout)
    assert content["bit_mobility_tuned"] < content["bit_mobility_now"]
    assert content["gain_margin"] > 1.99
    assert content["settings"]["proportional"]["unit"] == "kN m/rpm"
