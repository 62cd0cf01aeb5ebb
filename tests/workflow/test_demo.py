"""One simulated stand through the real stages: from the sheets to the depth dataset and the report."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pandas as pd
import pytest
import xarray as xr
import yaml

from drillid.demo.wells import WELLS
from drillid.fleet.stages import STAGES
from tests.workflow.toys import ROOT

LOG = "results/raw/D03_20250601T0600.csv.gz"
KERNELS = ROOT / ".venv/kernels"
"""Is newer than all sources of the compiled functions in the cache beside it."""
CACHE = Path(os.environ.get("NUMBA_CACHE_DIR", ROOT / ".venv/numba"))


@pytest.fixture(scope="module")
def demo(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("demo")
    (folder / "config").mkdir()
    shutil.copy(ROOT / "config/config.yaml", folder / "config")
    (folder / "config/wells.tsv").write_text("well\trig\tdescription\nD03\tcharlie\tone stand\n")
    (folder / "config/logs.tsv").write_text(f"well\tlog\nD03\t{LOG}\n")
    settings = {
        "results": "results",
        "rigs": str(ROOT / "config/demo/rigs"),
        "simulate": {"drilling_s": 620.0, "connection_s": 60.0},
        "figures": {"dpi": 60},
    }
    (folder / "demo.yaml").write_text(yaml.safe_dump(settings))
    if CACHE.is_dir():
        shutil.copytree(CACHE, folder / "numba")
    run(folder)
    return folder


def run(folder: Path) -> str:
    """Run the repository's own workflow in `folder`; its output."""
    environment = {name: value for name, value in os.environ.items() if name != "PYTHONPATH"}
    environment["NUMBA_CACHE_DIR"] = str(folder / "numba")
    command = [sys.executable, "-m", "snakemake", "--snakefile", str(ROOT / "Snakefile"), "--cores", "1"]
    done = subprocess.run(
        [*command, "--scheduler", "greedy", "--configfile", "demo.yaml", "--show-failed-logs"],
        cwd=folder,
        env=environment,
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout + done.stderr


def test_the_depth_dataset_holds_what_the_simulator_was_given(demo: Path) -> None:
    with xr.open_zarr(demo / "results/depth/D03/depth.zarr") as depth:
        assert depth.sizes["depth"] == 1
        found = depth[["accepted", "inertia_td"]].load()
    assert found["accepted"].item()
    assert found["inertia_td"].item() == pytest.approx(WELLS["D03"].system(0).top_drive.inertia, rel=0.03)


def test_make_setup_had_compiled_all_functions_that_a_well_needs(demo: Path) -> None:
    sources = [
        path
        for room in ("compiled.py", "physics", "fits", "simulation")
        for path in (ROOT / "drillid").glob(f"{room}*")
    ]
    files = [file for path in sources for file in ([path] if path.is_file() else path.rglob("*.py"))]
    if not KERNELS.exists() or KERNELS.stat().st_mtime < max(file.stat().st_mtime for file in files):
        pytest.skip("needs `make setup` after an edit of compiled functions")
    before, after = ({path.relative_to(folder) for path in folder.rglob("*.nbc")} for folder in (CACHE, demo / "numba"))
    assert after
    assert sorted(after - before) == []


def test_nothing_is_found_in_a_well_in_which_nothing_is_hidden(demo: Path) -> None:
    assert pd.read_csv(demo / "results/discrepancy/D03/intervals.csv").empty
    assert pd.read_csv(demo / "results/verdicts.csv")["verdict"].tolist() == ["none"]


def test_every_stage_leaves_its_key_and_its_problems(demo: Path) -> None:
    for stage in STAGES:
        assert {"key.json", "problems.csv"} <= {path.name for path in (demo / "results" / stage / "D03").iterdir()}
    problems = pd.read_csv(demo / "results/problems.csv")
    assert not problems["remedy"].str.contains("report it").any(), problems.to_string()


def test_figures_and_report_are_there(demo: Path) -> None:
    assert list((demo / "results/figures/D03").glob("*.png"))
    assert "D03" in (demo / "results/report.html").read_text()


def test_a_second_run_does_nothing(demo: Path) -> None:
    assert "Nothing to be done" in run(demo)
