"""A start of rotation that anyone may bring: simulated with another friction, fitted by command, judged on the rest."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from typer.testing import CliRunner

from benchmarks.field.well_b import EQUIPMENT, FRICTION, SURVEY
from drillid.commands import app
from drillid.config.described_well import DescribedWell
from drillid.errors import SettingsError
from drillid.simulation.start_up import WellFriction, rig_at, start_up
from drillid.simulation.start_up_files import ramped_speed, read_start_up
from drillid.simulation.start_up_fit import MeasuredStartUp, StartUpModel
from drillid.units import RPM

WELL = "benchmarks/field/well_b.yaml"
DEPTH, SLIDING = 900.0, 0.19


@pytest.fixture
def log(tmp_path: Path) -> Path:
    speed = ramped_speed(60.0, 10.0, 24.0)
    made = start_up(rig_at(DEPTH, SURVEY, EQUIPMENT, replace(FRICTION, sliding=SLIDING)), speed)
    table = {
        "t_s": made.time,
        "td_rpm_measured": speed[: made.time.size] / RPM,
        "torque_knm_measured": made.torque / 1e3,
    }
    path = tmp_path / "log.csv"
    pd.DataFrame(table).to_csv(path, index=False)
    return path


def test_friction_is_recovered_and_the_rest_of_the_log_foretold(log: Path, tmp_path: Path) -> None:
    survey, output = tmp_path / "survey.csv", tmp_path / "fitted.yaml"
    survey.write_text("depth_m,inclination_deg\n0,0\n300,0\n700,40\n1250,40\n1300,45\n2700,45\n")
    arguments = ["simulate", "fit-start-up", WELL, str(log), "--depth", str(DEPTH), "--survey", str(survey)]
    result = CliRunner().invoke(
        app, [*arguments, "--fitted", "sliding", "--evaluations", "25", "--output", str(output)]
    )
    assert result.exit_code == 0, result.stderr
    fitted = DescribedWell.from_yaml(output)
    assert fitted.friction.sliding == pytest.approx(SLIDING, rel=0.01)
    assert fitted.described_equipment == EQUIPMENT
    lines = [line for line in result.stdout.splitlines() if "rms" in line]
    assert [line.split()[0] for line in lines] == ["described", "described", "fitted", "fitted"]
    described, better = (float(lines[row].split()[6]) for row in (1, 3))
    assert better < 0.5 * described


@pytest.mark.parametrize("fitted", [("kappa", "rest"), ("rest", "kappa")], ids=" ".join)
def test_what_is_described_as_absent_is_found(fitted: tuple[str, ...]) -> None:
    """Drag and friction of rest are 0 in a description that does not state them, below all bounds of the fit."""
    speed = ramped_speed(60.0, 10.0, 20.0)
    true = WellFriction(SLIDING, kappa=2000.0, rest=0.3, assembly_rest=0.3)
    made = start_up(rig_at(DEPTH, SURVEY, EQUIPMENT, true), speed)
    unmeasured = np.full(made.torque.size, np.nan)
    measured = MeasuredStartUp(speed[: made.torque.size], made.torque, unmeasured, unmeasured)
    found = StartUpModel(EQUIPMENT, SURVEY, DEPTH, WellFriction(SLIDING), fitted).fit(measured, 20.0, 100)
    assert found.friction.kappa == pytest.approx(2000.0, rel=0.1)
    assert found.friction.rest == pytest.approx(0.3, rel=0.1)


def test_a_log_without_bit_speed_is_read(log: Path) -> None:
    measured = read_start_up(log)
    assert np.all(np.isnan(measured.bit_slowest))
    assert np.all(np.isfinite(measured.torque))


def test_what_has_no_bounds_is_refused() -> None:
    with pytest.raises(SettingsError, match="colour"):
        StartUpModel(EQUIPMENT, SURVEY, DEPTH, FRICTION, ("colour",))
