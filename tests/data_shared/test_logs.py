"""Recorded logs of four rigs, where they are at hand."""

from pathlib import Path
from typing import Any

import pandas as pd
import pytest
import xarray as xr

from drillid.config.rig import Rig
from drillid.config.settings import Settings
from drillid.datasets.store import Problem, WellFolders
from drillid.records import stage as records
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


def test_gaps_and_spikes_are_listed_and_each_stand_gives_a_window(tmp_path: Path) -> None:
    problems, found, table = run("W23", tmp_path)
    spikes = [problem.what.split(" replaced")[0] for problem in problems if "spikes" in problem.what]
    assert spikes == ["18 spikes in speed", "23 spikes in speed", "22 spikes in speed", "20 spikes in speed"]
    assert sum("gap of 37.0 s" in problem.what for problem in problems) == 4
    filled = [problem.what.split()[0] for problem in problems if "filled by interpolation" in problem.what]
    assert filled == ["76", "65", "69", "89"]
    assert len(problems) == 12
    assert found.sizes["window"] == 4
    assert table["reason"].tolist()[:5] == [
        "too short: 400.0 s of 600.0 s",
        "gap of 37.0 s",
        "too short: 163.0 s of 600.0 s",
        "",
        "connection",
    ]


def test_two_windows_a_stand_and_nothing_to_mend(tmp_path: Path) -> None:
    problems, found, table = run("W10", tmp_path)
    assert problems == []
    assert found.sizes["window"] == 44
    assert float(found["flagged_share"].max()) == 0
    assert table["state"].tolist() == ["drilling", "connection"] * 22


def test_us_units_and_dropped_rows(tmp_path: Path) -> None:
    problems, found, _ = run("W21", tmp_path)
    assert len(problems) == 6
    assert found.sizes["window"] == 12
    assert found["hole_depth"].values[0] == pytest.approx(1813.6, abs=0.5)
    assert found["speed"].values[0] == pytest.approx(100 * 3.14159265 / 30, rel=1e-3)
