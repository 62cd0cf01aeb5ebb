"""The joint fit as a dataset of the fits stage, in the depth dataset and in the figure."""

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
import xarray as xr
from matplotlib.colors import to_rgba
from matplotlib.figure import Figure

from drillid.config.settings import Settings
from drillid.datasets.identified import JOINT_FITS
from drillid.figures.style import CHANGE, JOINT
from drillid.figures.tracks import draw_joint
from drillid.fits.joint.coordinates import GAINS, SHARED
from drillid.fits.joint.dataset import STATE, counted_once, joint_dataset
from drillid.fits.window_fit import Measured, Prior, measured_rows
from drillid.physics.parameters import PARAMETERS
from tests.simulated import SHALLOW, Processed


def test_windows_of_one_well_share_drive_and_pipe(healthy: Processed) -> None:
    joint, alone = healthy.dataset("fits", "joint"), healthy.dataset("fits", "fits")
    truth = dict(zip(PARAMETERS, SHALLOW.parameters.tolist(), strict=True))
    for name in ("delay", "inertia_td", "polar_moment"):
        found, own = joint.sel(parameter=name), alone.sel(parameter=name)
        assert np.ptp(found["value"].values) == 0
        assert float(found["lower"].min()) < truth[name] < float(found["upper"].max())
        assert float(found["standard_error"].max()) < 0.75 * float(own["standard_error"].mean())
        np.testing.assert_allclose(joint["shared_value"].sel(shared=name), found["value"][0])
    assert joint.sizes["change"] == 0
    assert (joint["weight"] == 1).all()


def test_the_state_to_carry_on_gives_the_newest_windows_shared_values(healthy: Processed) -> None:
    joint = healthy.dataset("fits", "joint")
    mean = np.linalg.solve(joint["last_information"].values, joint["last_vector"].values)
    assert joint["state"].values.tolist() == STATE
    factor = mean[STATE.index("length_factor")]
    assert factor == pytest.approx(float(joint["shared_value"].sel(shared="length_factor")), rel=1e-4)


def test_the_depth_dataset_takes_the_bands_over(healthy: Processed) -> None:
    joint, depth = healthy.dataset("fits", "joint"), healthy.dataset("depth", "depth")
    for name in PARAMETERS:
        for suffix, variable in (("", "value"), ("_lower", "lower"), ("_upper", "upper")):
            np.testing.assert_array_equal(depth[f"{name}_joint{suffix}"], joint[variable].sel(parameter=name))


def test_without_any_fit_the_dataset_says_nothing(healthy: Processed) -> None:
    fits = healthy.dataset("fits", "fits")
    fits["value"] = fits["value"] * np.nan
    empty, problems = joint_dataset([], [], np.array([]), Prior.silent(), fits.isel(window=[]), Settings().fits)
    assert problems == []
    conformed = JOINT_FITS.conform(empty)
    assert conformed.sizes["window"] == 0
    assert conformed["shared"].values.tolist() == [*SHARED, *GAINS]
    assert np.isnan(conformed["shared_value"]).all()


def test_windows_whose_own_fits_are_refused_have_no_joint_fit(healthy: Processed) -> None:
    """An error of the model that they have in common would be averaged as noise, to tight bands about a wrong value."""
    fits = healthy.dataset("fits", "fits")
    fits["accepted"] = xr.zeros_like(fits["accepted"])
    count = fits.sizes["window"]
    measured: list[Any] = [None] * count
    refused, (problem,) = joint_dataset(measured, [], np.zeros(count), Prior.silent(), fits, Settings().fits)
    assert refused["value"].isnull().all()
    assert "no window's own fit is accepted" in problem.what


def test_time_that_two_windows_hold_counts_once() -> None:
    begin = np.datetime64("2025-01-01T00:00", "ns") + np.array([0, 5, 20]) * np.timedelta64(60, "s")
    share = counted_once(begin, begin + np.timedelta64(600, "s"))
    np.testing.assert_allclose(share, [0.75, 0.75, 1.0])


def test_time_that_a_window_shares_with_one_that_says_nothing_is_all_its_own(healthy: Processed) -> None:
    mobility, fits = (healthy.dataset(stage, stage).isel(window=[0, 1]) for stage in ("mobility", "fits"))
    first, second = measured_rows(mobility)
    rows = [first, Measured(*(values[:0] for values in vars(second).values()))]
    known, depth = [SHALLOW.known, SHALLOW.known], np.array([900.0, 905.0])
    apart, _ = joint_dataset(rows, known, depth, Prior.silent(), fits, Settings().fits)
    overlapping = fits.assign_coords({name: ("window", fits[name].values[[0, 0]]) for name in ("start", "end")})
    found, _ = joint_dataset(rows, known, depth, Prior.silent(), overlapping, Settings().fits)
    np.testing.assert_array_equal(found["shared_error"], apart["shared_error"])


def test_the_band_is_drawn_and_broken_at_a_change() -> None:
    windows = xr.Dataset({"hole_depth": ("window", [100.0, 110.0, 120.0, 130.0])})
    changes = {"change_parameter": ("change", ["delay", "kappa"]), "change_depth": ("change", [115.0, 125.0])}
    results: Any = SimpleNamespace(windows=windows, joint=xr.Dataset(changes))
    axis = Figure().subplots()
    band = np.array([[0.0, 1.0, 5.0, 6.0], [1.0, 2.0, 6.0, 7.0], [2.0, 3.0, 7.0, 8.0]])
    draw_joint(axis, results, "delay", band)
    above, below, change = axis.lines
    assert above.get_xdata().tolist() == [1.0, 2.0, 2.0]
    assert above.get_ydata().tolist() == [100.0, 110.0, 115.0]
    assert below.get_xdata().tolist() == [6.0, 6.0, 7.0]
    assert below.get_ydata().tolist() == [115.0, 120.0, 130.0]
    assert (above.get_color(), change.get_color()) == (JOINT, CHANGE)
    assert [to_rgba(each.get_facecolor()[0])[:3] for each in axis.collections] == [to_rgba(JOINT)[:3]] * 2
