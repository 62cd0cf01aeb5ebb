"""Recorded logs of four rigs, where they are at hand."""

from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest
import xarray as xr

from drillid.config.rig import Rig
from drillid.config.settings import Settings
from drillid.datasets.store import Problem, WellFolders
from drillid.records import stage as records
from drillid.units import RPM
from drillid.windows import stage as windows

ROOT = Path(__file__).resolve().parents[2]
LOGS = ROOT.parent / "shared" / "data" / "rig-logs"

pytestmark = pytest.mark.skipif(not LOGS.exists(), reason=f"{LOGS} is not there")


def run(name: str, results: Path) -> tuple[list[Problem], xr.Dataset, pd.DataFrame]:
    class ThisWell:
        rig = Rig.from_yaml(ROOT / "config" / "shared-rigs" / "rigs" / f"{name}.yaml")
        logs = tuple(sorted((LOGS / name).iterdir()))

    well: Any = ThisWell()
    well.name = name
    folders = WellFolders(results, name)
    problems = records.process(well, folders, Settings())
    problems += windows.process(well, folders, Settings())
    table = pd.read_csv(folders.stage("windows") / "segments.csv", keep_default_na=False)
    return problems, folders.read("windows", "windows").load(), table


def test_every_stand_of_gaps_jitter_and_spikes_is_told_and_gives_a_window_on_either_side(tmp_path: Path) -> None:
    """Four stands of 20 min with a gap of 37 s each, dropped rows and zero spikes, then 4 min of connection.

    The gap leaves 400 s before it, which is a shorter window, and 763 s behind it.
    """
    problems, found, table = run("W23", tmp_path)
    for fault in ("spikes in speed replaced", "gap of 37.0 s", "filled by interpolation"):
        assert sum(fault in problem.what for problem in problems) == 4, fault
    assert len(problems) == 3 * 4
    assert found.sizes["window"] == 8
    assert np.unique(np.round(found["samples"].values / 50.0)).tolist() == [400, 600]
    stand = table["reason"].eq("connection").shift(fill_value=False).cumsum()
    time = table["duration_s"].groupby([stand, table["reason"].eq("connection")]).sum().unstack()
    np.testing.assert_allclose(time[False], 1200.0, atol=0.1)
    np.testing.assert_allclose(time[True], 240.0, atol=0.1)
    assert table["reason"].eq("gap of 37.0 s").groupby(stand).sum().tolist() == [1] * 4


def test_two_windows_a_stand_and_nothing_to_mend(tmp_path: Path) -> None:
    """22 stands of 20 min from 2745 m to 3375 m at 120 rpm, of a recorder without any fault."""
    problems, found, table = run("W10", tmp_path)
    assert problems == []
    assert found.sizes["window"] == 44
    assert float(found["flagged_share"].max()) == 0
    assert table["state"].tolist() == ["drilling", "connection"] * 22
    np.testing.assert_allclose(found["speed"], 120 * RPM, rtol=2e-3)
    assert 2745 <= float(found["hole_depth"].min()) < float(found["hole_depth"].max()) <= 3405


def test_us_units_and_dropped_rows(tmp_path: Path) -> None:
    """Six stands from 1810 m to 1960 m at 100 rpm."""
    problems, found, _ = run("W21", tmp_path)
    assert all("filled by interpolation" in problem.what for problem in problems)
    assert found.sizes["window"] == 12
    assert 1810 <= float(found["hole_depth"].min()) < 1815
    np.testing.assert_allclose(found["speed"], 100 * RPM, rtol=1e-3)
