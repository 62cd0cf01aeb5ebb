"""The depth dataset of simulated wells: its form, its responses, its tables, and the fleet's."""

import shutil
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
import xarray as xr

from drillid.datasets.codes import RigState
from drillid.datasets.identified import DEPTH, FLEET
from drillid.datasets.store import WellFolders
from drillid.depth import stage
from drillid.depth.fleet import write_fleet
from drillid.depth.responses import identified_models, identified_responses
from drillid.fits.datasheet import data_sheet, stored_controller
from drillid.physics.eight_parameters import drilling_system
from drillid.physics.parameters import PARAMETERS
from drillid.physics.responses import bit_mobility, command_mobility, laplace
from drillid.physics.time_responses import bit_step_response
from tests.simulated import RIG, SHALLOW, Processed


@pytest.fixture(scope="module")
def stored(healthy: Processed) -> xr.Dataset:
    """The depth dataset; read only."""
    return healthy.dataset("depth", "depth")


@pytest.mark.parametrize("name", list(DEPTH.variables))
def test_every_variable_is_as_declared(stored: xr.Dataset, name: str) -> None:
    depth, declared = stored, DEPTH.variables[name]
    assert depth[name].dims == declared.dims
    assert depth[name].attrs["long_name"] == declared.long_name
    if not declared.dtype.startswith("datetime"):
        assert depth[name].attrs.get("units", "") == declared.units
        kind = np.dtypes.StringDType() if declared.dtype == "str" else np.dtype(declared.dtype)
        assert depth[name].dtype == kind
    if declared.flags is not None:
        meanings = depth[name].attrs["flag_meanings"].split()
        assert len(meanings) == len(depth[name].attrs["flag_values"]) == len(declared.flags)


def test_the_dataset_explains_itself(healthy: Processed) -> None:
    depth = healthy.dataset("depth", "depth")
    assert depth.attrs["Conventions"].startswith("CF-")
    assert depth.attrs["title"] == DEPTH.title
    assert depth.attrs["well"] == "healthy"
    assert set(depth.coords) == {"depth", "frequency", "lag", "state", "window", "start", "end"}
    assert dict(depth.sizes) == {"depth": 4, "frequency": 595, "lag": 201, "state": len(RigState)}
    assert depth["state"].values.tolist() == [state.name.lower() for state in RigState]
    assert (depth["state_time"].sel(state="drilling") >= 599).all()
    windows = healthy.dataset("windows", "windows")
    assert (depth["depth"].values == windows["hole_depth"].values).all()
    assert (depth["start"].values == windows["start"].values).all()


def test_a_plain_open_and_a_copy_hold_the_same(healthy: Processed, tmp_path: Path) -> None:
    with xr.open_zarr(healthy.folders.stage("depth") / "depth.zarr", consolidated=False) as opened:
        loaded = opened.load()
    loaded.drop_encoding().to_zarr(tmp_path / "copy.zarr", consolidated=False)
    with xr.open_zarr(tmp_path / "copy.zarr", consolidated=False) as again:
        xr.testing.assert_identical(again.load(), loaded)
    xr.testing.assert_identical(loaded.sel(depth=loaded["depth"][2]), loaded.isel(depth=2))


def test_responses_are_those_of_the_stored_parameters(healthy: Processed) -> None:
    depth, fits = healthy.dataset("depth", "depth"), healthy.dataset("fits", "fits")
    s = laplace(depth["frequency"].values)
    for row in range(4):
        stored, controller = depth.isel(depth=row), stored_controller(fits.isel(window=row))
        assert controller.proportional == pytest.approx(SHALLOW.top_drive.controller.proportional, rel=0.01)
        values = np.array([float(stored[name]) for name in PARAMETERS])
        system = drilling_system(values, data_sheet(RIG, controller, SHALLOW.bit_depth).equipment)
        np.testing.assert_allclose(stored["command_mobility_fitted"], command_mobility(system, s), rtol=1e-12)
        np.testing.assert_allclose(stored["bit_mobility_stiff"], bit_mobility(system, s, stiff=True), rtol=1e-12)
        np.testing.assert_allclose(stored["bit_mobility_controlled"], bit_mobility(system, s), rtol=1e-12)
        for name, stiff in (("bit_step_stiff", True), ("bit_step_controlled", False)):
            lag, step = bit_step_response(system, 10.0, 0.05, stiff=stiff)
            np.testing.assert_allclose(stored["lag"], lag)
            np.testing.assert_allclose(stored[name], step, rtol=1e-9, atol=1e-12)


def test_a_window_without_fit_has_no_responses(troubled: Processed) -> None:
    depth = troubled.dataset("depth", "depth")
    assert depth["accepted"].values.tolist()[2] is False
    for name in ("command_mobility_fitted", "bit_mobility_stiff", "bit_step_stiff", "bit_step_controlled"):
        assert np.isnan(depth[name].values[2]).all()
        assert np.isfinite(depth[name].values[:2]).all()
    assert np.isnan(depth["inertia_td"].values[2])
    assert np.isfinite(depth["command_mobility"].values[2]).all()


def test_a_well_without_any_fit_has_no_responses(healthy: Processed) -> None:
    nothing, depths = np.full((2, len(PARAMETERS)), np.nan), np.full(2, SHALLOW.bit_depth)
    models = identified_models(RIG, [SHALLOW.top_drive.controller] * 2, nothing, depths)
    found = identified_responses(models, np.array([0.1, 1.0]), healthy.settings.depth)
    assert all(np.isnan(found[name]).all() for name in found.data_vars)
    assert dict(found.sizes) == {"depth": 2, "frequency": 2, "lag": 201}


def test_the_table_names_units_and_holds_the_values(healthy: Processed) -> None:
    depth = healthy.dataset("depth", "depth")
    table = pd.read_csv(healthy.folders.stage("depth") / "parameters.csv", keep_default_na=False, na_values=["nan"])
    assert len(table) == 4
    assert table.columns[:3].tolist() == ["window", "start", "depth [m]"]
    for name, (unit, _) in PARAMETERS.items():
        np.testing.assert_allclose(table[f"{name} [{unit}]"], depth[name])
        np.testing.assert_allclose(table[f"{name}_error [{unit}]"], depth[f"{name}_error"])
    assert table["reason"].tolist() == [""] * 4
    assert table["accepted"].all()


def test_the_table_tells_why_a_fit_is_refused(troubled: Processed) -> None:
    table = pd.read_csv(troubled.folders.stage("depth") / "parameters.csv")
    assert table["accepted"].tolist() == [True, True, False]
    assert table["reason"][2] == "only 0 frequencies passed the gate, of 20 needed"
    assert table["inertia_td [kg m2]"].isna().tolist() == [False, False, True]


def test_the_fleet_holds_every_row_of_every_well(healthy: Processed, troubled: Processed, tmp_path: Path) -> None:
    results = healthy.copied(tmp_path / "results").folders.results
    shutil.copytree(troubled.folders.stage("depth"), results / "depth" / "troubled")
    write_fleet(results, ["healthy", "absent", "troubled"])
    with xr.open_zarr(results / "fleet.zarr", consolidated=False) as opened:
        fleet = opened.load()
    assert fleet["well"].values.tolist() == ["healthy"] * 4 + ["troubled"] * 3
    assert fleet.variables.keys() == FLEET.variables.keys()
    first, second = healthy.dataset("depth", "depth"), troubled.dataset("depth", "depth")
    for name in ("inertia_td", "length_error", "depth", "accepted", "window"):
        np.testing.assert_array_equal(fleet[name], np.concatenate([first[name], second[name]]))
    assert fleet["inertia_td"].attrs["units"] == "kg m2"


def test_a_fleet_without_wells_is_empty_and_can_be_opened(tmp_path: Path) -> None:
    write_fleet(tmp_path, ["absent"])
    with xr.open_zarr(tmp_path / "fleet.zarr", consolidated=False) as fleet:
        assert fleet.sizes["row"] == 0
        assert fleet.variables.keys() == FLEET.variables.keys()


def test_responses_of_windows_that_have_not_changed_are_kept(
    healthy: Processed, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    copy = healthy.copied(tmp_path / "results")
    earlier = WellFolders(copy.folders.results, copy.folders.well)
    there = earlier.aside("depth")
    there.parent.mkdir()
    earlier.stage("depth").rename(there)
    asked: list[int] = []
    for name in ("identified_responses", "speed_control"):
        find = getattr(stage, name)
        monkeypatch.setattr(
            stage, name, lambda models, *rest, find=find: asked.append(len(models)) or find(models, *rest)
        )
    copy.run("depth")
    assert asked == []
    xr.testing.assert_identical(copy.dataset("depth", "depth"), healthy.dataset("depth", "depth"))
    fits = copy.dataset("fits", "fits")
    fits["key"] = "window", np.array(["another", *fits["key"].values[1:]], dtype=object)
    gains = {key: value for key, value in fits.attrs.items() if key.startswith("controller_")}
    copy.folders.write("fits", "fits", fits, **gains)
    copy.run("depth")
    assert asked == [1, 1]
