"""The demo's hidden wash-out, simulated in time and recorded with a recorder's faults, is found; nothing else is."""

from dataclasses import replace
from pathlib import Path

import pandas as pd
import pytest

from drillid.config.settings import Settings
from drillid.config.sheets import read_sheets
from drillid.datasets.store import WellFolders
from drillid.demo.wells import STAND_LENGTH, WELLS, write_demo_logs
from drillid.discrepancy import stage as discrepancy
from drillid.fits import stage as fits
from drillid.mobility import stage as mobility
from drillid.records import stage as records
from drillid.spectra import stage as spectra
from drillid.windows import stage as windows

ROOT = Path(__file__).resolve().parents[3]
SETTINGS = Settings.from_yaml(ROOT / "config/demo/config.yaml")
assert SETTINGS.simulate is not None
SIMULATE = SETTINGS.simulate.model_copy(update={"time_step_s": 0.005})
"""Twice the time step of the demo at a quarter of its cost; its error of 0.1 % is far below the noise."""


def flagged(name: str, folder: Path) -> pd.DataFrame:
    sheets = SETTINGS.model_copy(update={key: str(ROOT / getattr(SETTINGS, key)) for key in ("wells", "logs", "rigs")})
    well = read_sheets(sheets)[name]
    logs = tuple(folder / log.name for log in well.logs)
    write_demo_logs(name, logs, SIMULATE)
    folders = WellFolders(folder / "results", name)
    loaded = replace(well, logs=logs).load()
    for stage in (records, windows, spectra, mobility, fits, discrepancy):
        stage.process(loaded, folders, SETTINGS)
    return pd.read_csv(folders.stage("discrepancy") / "intervals.csv")


@pytest.mark.parametrize("name", list(WELLS))
def test_the_wash_out_is_flagged_and_nothing_else(name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    # sets are examined without the intervals, and take most of the time
    monkeypatch.setattr(discrepancy, "examine_well", lambda *_: [])
    found = flagged(name, tmp_path)
    truth = WELLS[name].wash_out
    if truth is None:
        assert found.empty
        return
    assert len(found) == 1
    window = STAND_LENGTH * SETTINGS.windows.length_s / SIMULATE.drilling_s
    assert found["from_m"][0] == pytest.approx(truth.from_depth, abs=window)
    assert found["to_m"][0] == pytest.approx(truth.to_depth, abs=window)
    assert "BHA damping up by" in found["evidence"][0]
    usual, inside, noise = (found[name][0] for name in ("error_by_usual", "error_by_interval", "speed_noise"))
    assert inside < 0.6 * usual
    assert 0.5 * noise < inside < 2 * noise
