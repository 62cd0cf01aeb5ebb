"""What the recorded logs of W10 must give: drive and pipe as on the data sheets, its wash-out and little else."""

import shutil
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
import xarray as xr

from drillid import discrepancy
from drillid.config.listing import Well
from drillid.config.rig import Rig
from drillid.config.settings import FitsSettings, Settings
from drillid.datasets.store import WellFolders
from drillid.depth import stage as depth
from drillid.fits import stage as fits
from drillid.mobility import stage as mobility
from drillid.physics.equipment import polar_moment
from drillid.records import stage as records
from drillid.spectra import stage as spectra
from drillid.windows import stage as windows

ROOT = Path(__file__).resolve().parents[2]
LOGS = ROOT.parent / "shared" / "data" / "rig-logs" / "W10"
WASHED_OUT = (3085.0, 3145.0)

pytestmark = [
    pytest.mark.skipif(not LOGS.exists(), reason=f"{LOGS} is not there"),
    pytest.mark.xdist_group("W10"),
]


RIG = ROOT / "config" / "shared-rigs" / "rigs" / "W10.yaml"


def w10() -> Well:
    return Well("W10", Rig.from_yaml(RIG), tuple(sorted(LOGS.iterdir())))


@pytest.fixture(scope="module")
def measured(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Its mobilities, which hang on no data sheets."""
    folders = WellFolders(tmp_path_factory.mktemp("W10"), "W10")
    for stage in (records, windows, spectra, mobility):
        stage.process(w10(), folders, Settings())
    return folders.results


@pytest.fixture(scope="module", params=[True, False], ids=["with the data sheets", "without advance information"])
def well(request: pytest.FixtureRequest, measured: Path, tmp_path_factory: pytest.TempPathFactory) -> WellFolders:
    settings = Settings(fits=FitsSettings(use_data_sheets=request.param))
    root = tmp_path_factory.mktemp("fitted")
    shutil.copytree(measured, root, dirs_exist_ok=True)
    folders = WellFolders(root, "W10")
    with pytest.MonkeyPatch.context() as without_names:
        # nothing here asks what the engine names, which takes minutes
        without_names.setattr("drillid.discrepancy.stage.examine_well", lambda *given: [])
        for stage in (fits, discrepancy, depth):
            stage.process(w10(), folders, settings)
    return folders


def dataset(well: WellFolders) -> xr.Dataset:
    return well.read("depth", "depth").load()


def test_drive_and_pipe_are_those_on_the_data_sheet(well: WellFolders) -> None:
    found = dataset(well)
    outside = (found["depth"] < WASHED_OUT[0]) | (found["depth"] > WASHED_OUT[1] + 15)
    sound = found.isel(depth=np.flatnonzero(outside))
    inertia = np.abs(sound["inertia_td"] / 1105 - 1) < 0.015
    delay = np.abs(sound["delay"] - 0.0405) < 0.001
    pipe = np.abs(sound["polar_moment"] - polar_moment(0.1397, 0.1214)) < 3 * sound["polar_moment_error"]
    assert float(inertia.mean()) >= 0.95
    assert float(delay.mean()) >= 0.95
    assert float(pipe.mean()) >= 0.95


def test_the_wash_out_is_flagged_and_nothing_else(well: WellFolders) -> None:
    flagged = pd.read_csv(well.stage("discrepancy") / "intervals.csv")
    assert len(flagged) == 1
    assert WASHED_OUT[0] <= flagged["from_m"][0] < WASHED_OUT[1]
    assert abs(flagged["to_m"][0] - WASHED_OUT[1]) < 15


def test_the_lighter_collars_below_the_casing_show_as_a_drop_of_bha_inertia(well: WellFolders) -> None:
    found = dataset(well)
    above, below = found.sel(depth=slice(0, 3000)), found.sel(depth=slice(3000, WASHED_OUT[0]))
    assert float(above["inertia_bha"].min()) > float(below["inertia_bha"].max())
    washed_out = found.sel(depth=slice(3105, 3150))
    assert float(washed_out["damping_bha"].min()) > 2 * float(below["damping_bha"].max())


def test_the_model_explains_the_windows(well: WellFolders) -> None:
    found = dataset(well)
    assert bool(found["accepted"].all())
    assert float(found["chi2_per_dof"].mean()) == pytest.approx(1.0, abs=0.03)


def test_the_joint_fit_finds_the_change_of_collars_and_both_ends_of_the_wash_out(well: WellFolders) -> None:
    joint = well.read("fits", "joint").load()
    found = {
        name: joint["change_depth"].values[joint["change_parameter"].values == name]
        for name in ("inertia_bha", "damping_bha", "kappa", "delta")
    }
    collars, *_ = found["inertia_bha"]
    top, bottom = found["damping_bha"]
    assert abs(collars - 3000) < 25
    assert abs(top - WASHED_OUT[0]) < 25
    assert abs(bottom - WASHED_OUT[1]) < 25
    assert found["kappa"].size == found["delta"].size == 0
    assert float(joint["weight"].min()) == 1.0


def test_the_joint_bands_do_not_touch_across_the_changes(well: WellFolders) -> None:
    found = dataset(well)
    above, below = found.sel(depth=slice(0, 3000)), found.sel(depth=slice(3005, 3080))
    assert float(above["inertia_bha_joint_lower"].min()) > float(below["inertia_bha_joint_upper"].max())
    washed_out = found.sel(depth=slice(3105, 3150))
    assert float(washed_out["damping_bha_joint_lower"].min()) > 3 * float(below["damping_bha_joint_upper"].max())
