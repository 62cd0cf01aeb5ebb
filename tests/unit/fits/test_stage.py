"""The fits stage on simulated wells: controller, knowledge, refusals, and what is stored."""

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr

from drillid.config.rig import Rig
from drillid.config.settings import Settings
from drillid.errors import EstimationError
from drillid.fits.datasheet import data_sheet, stated_controller
from drillid.fits.window_fit import Measured, Prior, fit, measured_rows
from drillid.physics.equipment import Controller
from drillid.physics.parameters import PARAMETERS
from tests.simulated import RIG, SHALLOW, Processed

SETTINGS = Settings()
DATA_SHEET: dict[str, Any] = {
    "drive_delay": {"value": "28 ms", "tolerance": "3 ms"},
    "top_drive_inertia": {"value": "455 kg m^2", "relative": "5 %"},
    "pipe": {"outer_diameter": "88.9 mm", "inner_diameter": "70.2 mm", "relative": "5 %", "length_relative": "10 %"},
}


def rig(**changes: Any) -> Rig:
    """The shallow rig with other data sheets; None takes one away."""
    told = {**RIG.model_dump(exclude_none=True), **changes}
    return Rig.checked({name: value for name, value in told.items() if value is not None}, "changed rig")


def test_all_windows_and_their_stack_are_fitted(healthy: Processed) -> None:
    fits, stack = healthy.dataset("fits", "fits"), healthy.dataset("fits", "stack_fits")
    assert healthy.problems["fits"] == []
    assert fits["accepted"].values.all()
    assert (fits["reason"] == "").all()
    assert fits["parameter"].values.tolist() == list(PARAMETERS)
    assert stack["accepted"].values.tolist() == [True]
    chosen = ["inertia_td", "delay", "polar_moment"]
    truth = dict(zip(PARAMETERS, SHALLOW.parameters, strict=True))
    for dataset in (fits, stack):
        pulls = (dataset["value"] - [truth[name] for name in PARAMETERS]) / dataset["standard_error"]
        assert (np.abs(pulls.sel(parameter=chosen)) < 4.5).all()
    narrowed = stack["standard_error"].values[0] / fits["standard_error"].values.mean(axis=0)
    assert 0.35 < narrowed[list(PARAMETERS).index("inertia_td")] < 0.7  # four windows halve an error


def test_correlations_are_correlations(healthy: Processed) -> None:
    correlation = healthy.dataset("fits", "fits")["correlation"].values
    np.testing.assert_allclose(np.diagonal(correlation, axis1=1, axis2=2), 1.0)
    np.testing.assert_allclose(correlation, np.swapaxes(correlation, 1, 2), atol=1e-12)
    assert np.linalg.eigvalsh(correlation).min() > -1e-9


def test_the_controller_is_read_from_the_command_where_the_data_sheets_are_silent(
    healthy: Processed, tmp_path: Path
) -> None:
    spectra = healthy.dataset("spectra", "spectra")
    found, truth = stated_controller(rig(controller=None), spectra), SHALLOW.top_drive.controller
    assert found.proportional == pytest.approx(truth.proportional, rel=0.02)
    assert found.integral == pytest.approx(truth.integral, rel=0.02)
    well = healthy.copied(tmp_path / "results")
    assert well.run("fits", rig=rig(controller=None)) == []
    told, found_again = healthy.dataset("fits", "fits"), well.dataset("fits", "fits")
    assert found_again.attrs["controller_proportional"] == pytest.approx(found.proportional)
    moved = ((found_again["value"] - told["value"]) / told["standard_error"]).sel(parameter=["inertia_td", "delay"])
    assert (np.abs(moved) < 1).all()
    # gains that the last window shows are nothing to the others, which stay as they are but for rounding
    spectra["cross_command"][-1] *= 1.1
    well.folders.write("spectra", "spectra", spectra)
    well.run("fits", rig=rig(controller=None))
    later, others = well.dataset("fits", "fits"), slice(None, -1)
    assert later.attrs["controller_proportional"] != found_again.attrs["controller_proportional"]
    xr.testing.assert_allclose(later.isel(window=others), found_again.isel(window=others), rtol=1e-6)


def test_a_window_without_a_logged_command_has_the_gains_of_the_others(healthy: Processed, tmp_path: Path) -> None:
    well = healthy.copied(tmp_path / "results")
    spectra = well.dataset("spectra", "spectra")
    spectra["cross_command"][-1] = complex(np.nan, np.nan)
    well.folders.write("spectra", "spectra", spectra)
    assert well.run("fits", rig=rig(controller=None)) == []
    found, told = well.dataset("fits", "fits")["value"], healthy.dataset("fits", "fits")
    off = (found - told["value"]) / told["standard_error"]
    assert (np.abs(off.isel(window=-1).sel(parameter=["inertia_td", "delay"])) < 1).all()


def test_without_controller_and_command_nothing_can_be_fitted(healthy: Processed, tmp_path: Path) -> None:
    well = healthy.copied(tmp_path / "results")
    spectra = well.dataset("spectra", "spectra")
    spectra["cross_command"][:] = complex(np.nan, np.nan)
    well.folders.write("spectra", "spectra", spectra)
    with pytest.raises(EstimationError, match="small rig: neither describes its controller nor logs"):
        well.run("fits", rig=rig(controller=None))
    assert well.run("fits") == []  # the data sheets tell it
    spectra["cross_speed"][:] = complex(np.nan, np.nan)
    well.folders.write("spectra", "spectra", spectra)
    with pytest.raises(EstimationError, match="no window is long enough to read it from the logged command"):
        well.run("fits", rig=rig(controller=None))


def test_too_few_frequencies_are_refused_with_their_number(healthy: Processed) -> None:
    whole = measured_rows(healthy.dataset("mobility", "mobility"))[0]
    few = Measured(*(values[100:112] for values in vars(whole).values()))
    refused = fit(few, SHALLOW.known, Prior.silent(), SETTINGS.fits)
    assert not refused.accepted
    assert refused.reason == "only 12 frequencies passed the gate, of 20 needed"
    assert np.isnan(refused.value).all()


def test_a_speed_that_stands_still_is_refused(healthy: Processed) -> None:
    """As one that is recorded in steps coarser than it moves."""
    whole = measured_rows(healthy.dataset("mobility", "mobility"))[0]
    still = replace(whole, mobility=0.0 * whole.mobility, variance=0.0 * whole.variance)
    refused = fit(still, SHALLOW.known, Prior.silent(), SETTINGS.fits)
    assert not refused.accepted
    assert refused.reason.endswith("frequencies have no noise at all, as where the recorded speed stands still")


def test_a_window_without_frequencies_is_a_row_and_the_others_stand(troubled: Processed) -> None:
    fits = troubled.dataset("fits", "fits")
    assert fits["accepted"].values.tolist() == [True, True, False]
    assert np.isnan(fits["value"].values[2]).all()
    [problem] = troubled.problems["fits"]
    assert problem.where.startswith("window 2 at ")
    assert problem.what == fits["reason"].values[2] == "only 0 frequencies passed the gate, of 20 needed"


def test_a_window_of_a_sweep_that_does_not_repeat_is_fitted_too(troubled: Processed) -> None:
    fits = troubled.dataset("fits", "fits").isel(window=1)
    pulls = (fits["value"].values - SHALLOW.parameters) / fits["standard_error"].values
    for name in ("inertia_td", "delay", "length"):
        assert abs(pulls[list(PARAMETERS).index(name)]) < 5
    assert float(fits["chi2_per_dof"]) == pytest.approx(1, abs=0.3)


def test_a_stack_knows_its_length_by_the_depth_of_the_bit_as_windows_do(healthy: Processed, tmp_path: Path) -> None:
    well = healthy.copied(tmp_path / "results")
    windows = well.dataset("windows", "windows")
    windows["bit_depth"] = windows["bit_depth"] - 20.0
    well.folders.write("windows", "windows", windows)
    well.run("fits", rig=rig(**DATA_SHEET))
    lengths = [well.dataset("fits", name)["prior"].sel(parameter="length") for name in ("fits", "stack_fits")]
    np.testing.assert_allclose(lengths[1], [lengths[0].values.mean()])


def test_knowledge_is_stored_and_narrows_the_errors(healthy: Processed, tmp_path: Path) -> None:
    well = healthy.copied(tmp_path / "results")
    described = rig(**DATA_SHEET)
    assert well.run("fits", rig=described) == []
    alone, told = healthy.dataset("fits", "fits"), well.dataset("fits", "fits")
    prior = data_sheet(described, Controller(350.0), SHALLOW.bit_depth).prior(SHALLOW.bit_depth)
    np.testing.assert_allclose(told["prior"], np.tile(prior.value, (4, 1)))
    np.testing.assert_allclose(told["prior_error"], np.tile(prior.error, (4, 1)))
    assert np.isnan(alone["prior"]).all()
    moment, before = (dataset["standard_error"].sel(parameter="polar_moment") for dataset in (told, alone))
    assert (moment < 0.75 * before).all()
    assert (moment < prior.error[list(PARAMETERS).index("polar_moment")]).all()
    unused = Settings.checked({"fits": {"use_data_sheets": False}}, "test")
    well.run("fits", rig=described, settings=unused)
    again = well.dataset("fits", "fits")
    assert np.isnan(again["prior"]).all()
    np.testing.assert_allclose(again["value"], alone["value"], rtol=1e-6)


def test_a_tight_wrong_data_sheet_shows(healthy: Processed, tmp_path: Path) -> None:
    """It pulls the fit off the data, which refuse it with a reason; a wide one is overruled by them."""
    well = healthy.copied(tmp_path / "results")
    wrong = {"top_drive_inertia": {"value": "600 kg m^2", "relative": "0.1 %"}}
    problems = well.run("fits", rig=rig(**wrong))
    fits = well.dataset("fits", "fits")
    assert not fits["accepted"].any()
    told_once = list(dict.fromkeys(fits["reason"].values.tolist()))
    assert [problem.what for problem in problems[: len(told_once)]] == told_once
    told = ("the residuals are larger than the noise allows", "length ended at the edge of what is searched")
    assert all(reason.startswith(told) for reason in fits["reason"].values)

    wide = {"top_drive_inertia": {"value": "600 kg m^2", "relative": "20 %"}}
    assert well.run("fits", rig=rig(**wide)) == []
    inertia = well.dataset("fits", "fits")["value"].sel(parameter="inertia_td")
    np.testing.assert_allclose(inertia, SHALLOW.top_drive.inertia, rtol=0.015)
