"""A start of rotation from its files to dataset, figure, description and problems."""

import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
import xarray as xr

from drillid.config.described_well import DescribedWell
from drillid.config.listing import StartUp, StartUpListing
from drillid.config.settings import Settings
from drillid.config.sheets import read_start_ups
from drillid.datasets.store import WellFolders
from drillid.errors import SettingsError
from drillid.report.start_ups import start_up_rows
from drillid.simulation.start_up import rig_at, start_up
from drillid.simulation.start_up_files import ramped_speed, read_survey, write_start_up
from drillid.simulation.start_up_fit import BIT_SCALE, TORQUE_SCALE
from drillid.start_ups.judging import gain
from drillid.start_ups.stage import process
from drillid.units import RPM

WELL = """
top_drive: {inertia: 2000 kg m^2, proportional: 30e3 N m s/rad}
pipe: {outer_diameter: 5 in, inner_diameter: 4.276 in}
assembly: [{length: 100 m, outer_diameter: 6.5 in, inner_diameter: 2.8125 in}]
friction: {sliding: 0.2, kappa: 20}
"""
DEPTH = 700.0


@pytest.fixture(scope="module")
def files(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Description, survey, and a log of a well whose friction is a quarter larger than described."""
    folder = tmp_path_factory.mktemp("start")
    (folder / "well.yaml").write_text(WELL)
    pd.DataFrame({"depth_m": [0, 200, 500, 900], "inclination_deg": [0, 0, 60, 60]}).to_csv(folder / "survey.csv")
    described = DescribedWell.from_yaml(folder / "well.yaml")
    friction = replace(described.described_friction, sliding=0.25)
    speed = ramped_speed(60.0, 5.0, 30.0)
    rig = rig_at(DEPTH, read_survey(folder / "survey.csv"), described.described_equipment, friction)
    made = start_up(rig, speed)
    write_start_up(made, speed, folder / "made.csv")
    log = pd.read_csv(folder / "made.csv")
    named = log.rename(columns={"td_rpm": "td_rpm_measured", "torque_knm": "torque_knm_measured"})
    named[["t_s", "td_rpm_measured", "torque_knm_measured"]].to_csv(folder / "log.csv", index=False)
    return folder


@pytest.fixture(scope="module")
def results(files: Path) -> Path:
    """The stage's results of a fit of the sliding friction alone."""
    start = StartUp("B/1", files / "well.yaml", files / "survey.csv", files / "log.csv", DEPTH, ("sliding",))
    settings = Settings(start_ups={"evaluations": 12}, figures={"dpi": 50})
    folders = WellFolders(files / "results", "B-1", name="B/1")
    problems = process(start, folders, settings)
    assert [problem.where for problem in problems] == ["bit_rpm_min_measured"]
    return files / "results"


def test_what_is_fitted_is_kept_where_it_predicts_better(results: Path) -> None:
    dataset = xr.open_zarr(results / "start_ups/B-1/start_ups.zarr").load()
    assert dataset["kept"].values.tolist() == [False, True]
    assert dataset["value"].sel(model="fitted", parameter="sliding") == pytest.approx(0.25, rel=0.02)
    described, fitted = dataset["torque_rms"].sel(span="held out").values
    assert fitted < 0.3 * described
    assert dataset["gain_low"].sel(model="fitted") > 0
    assert float(dataset["span_to"][0]) == pytest.approx(18.0)
    kept = DescribedWell.from_yaml(results / "start_ups/B-1/description.yaml")
    assert kept.friction.sliding == pytest.approx(0.25, rel=0.02)
    assert (results / "start_ups/B-1/start_up.png").stat().st_size > 1000


def test_the_report_has_a_row_for_it_and_for_one_that_failed(results: Path, files: Path) -> None:
    paths = (files / "log.csv", files / "survey.csv")
    listings = {
        folder: StartUpListing(name, files / "well.yaml", paths, folder=folder, depth=DEPTH)
        for name, folder in (("B/1", "B-1"), ("lost", "lost"))
    }
    problems = pd.DataFrame([["lost", "start_ups", "lost.csv", "is missing", "Give it"]])
    problems.columns = pd.Index(["well", "stage", "where", "what", "remedy"])
    done, failed = start_up_rows(results, listings, problems)
    assert done["verdict"].startswith("the fitted model is kept")
    said = re.search(r"it removes (\d+) to (\d+) % of the squared error", done["verdict"])
    assert said is not None
    held = xr.open_zarr(results / "start_ups/B-1/start_ups.zarr").sel(span="held out").load()
    scaled = np.array([held["torque_rms"] / (1e3 * TORQUE_SCALE), held["bit_rms"] / (RPM * BIT_SCALE)])
    described, fitted = np.nansum(scaled**2, axis=0)
    assert int(said[1]) - 1 <= 100 * (1 - fitted / described) <= int(said[2]) + 1
    assert int(said[2]) <= 100
    assert "kft·lbf" in done["torque"]
    assert " ft" in done["depth"]
    assert done["figure"] == "start_ups/B-1/start_up.png"
    assert failed["verdict"] == "failed: lost.csv: is missing"


def test_a_gain_of_few_blocks_is_not_certain() -> None:
    assert gain(np.array([2.0, 2.0]), np.array([1.0, 1.0])).low < 0 < gain(np.full(4, 2.0), np.arange(4) / 9).low


def test_its_sheet_rejects_rows_that_cannot_be_used(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    head = "start_up\tdescription\tsurvey\tlog\tdepth_m\tfitted"
    rows = ["A\tw.yaml\ts.csv\tl.csv\t900\tsliding, kappa", "A\tw.yaml\ts.csv\tl.csv\t1\t"]
    rows += ["B\t/etc/w.yaml\ts.csv\tl.csv\t900\t", "C\tw.yaml\ts.csv\tl.csv\tdeep\t"]
    Path("starts.tsv").write_text("\n".join([head, *rows]))
    found = read_start_ups(Settings(start_up_sheet="starts.tsv"))
    assert found["A"].fitted == ("sliding", "kappa")
    assert {name: [fault.where for fault in listing.faults] for name, listing in found.items()} == {
        "A": ["starts.tsv, row 3"],
        "B": ["starts.tsv, 'B'"],
        "C": ["starts.tsv, row 5"],
    }
    assert read_start_ups(Settings()) == {}
    Path("starts.tsv").write_text(head)
    with pytest.raises(SettingsError, match=r"starts\.tsv: lists no starts of rotation\. Add a row for each, or"):
        read_start_ups(Settings(start_up_sheet="starts.tsv"))
