"""Stability and settings of the speed control, of models that are given."""

from dataclasses import replace

import numpy as np
import pytest

from drillid.config.settings import DepthSettings
from drillid.control.margins import is_stable
from drillid.control.stick_slip import critical_slope
from drillid.control.tuning import controlled_by, tune
from drillid.depth.speed_control import VARIABLES, speed_control, tuned_rows
from drillid.discrepancy.catalogue import WindowModel
from drillid.errors import SettingsError
from drillid.physics.equipment import Controller
from drillid.physics.sensor import Recording
from tests.simulated import SHALLOW

MODEL = WindowModel(SHALLOW.system, Recording())
DEPTHS = np.array([1000.0, 1010.0, 1020.0, 1030.0, 1040.0])


def found(settings: DepthSettings, weight: float = 1e5) -> dict[str, np.ndarray]:
    """Of five windows, of which two have no accepted fit."""
    accepted = np.array([False, False, True, True, True])
    models = [MODEL if each else None for each in accepted]
    tuned = tuned_rows(DEPTHS, accepted, settings.tuning_interval_m)
    sought = [MODEL if each else None for each in tuned]
    return speed_control(models, sought, np.full(5, weight), settings)


def test_settings_are_sought_once_in_an_interval_and_stability_everywhere() -> None:
    values = found(DepthSettings(tuning_interval_m=20.0))
    assert tuple(values) == VARIABLES
    assert np.isfinite(values["critical_slope"]).tolist() == [False, False, True, True, True]
    assert np.isfinite(values["tuned_proportional"]).tolist() == [False, False, False, True, True]
    slope, frequency = critical_slope(SHALLOW.system)
    assert values["critical_slope"][2] == pytest.approx(slope)
    assert values["critical_frequency"][2] == pytest.approx(frequency)


def test_settings_are_those_of_the_model_of_all_windows_and_stability_of_the_window() -> None:
    pipe, collars = SHALLOW.pipe, SHALLOW.collars
    other = replace(SHALLOW.system, string=(replace(pipe, kappa=5 * pipe.kappa), collars))
    sought = [WindowModel(other, Recording())]
    values = speed_control([MODEL], sought, np.array([1e5]), DepthSettings())
    assert values["critical_slope"][0] == pytest.approx(critical_slope(SHALLOW.system)[0])
    assert values["tuned_proportional"][0] == pytest.approx(tune(other).controller.proportional)
    assert values["tuned_proportional"][0] != pytest.approx(tune(SHALLOW.system).controller.proportional)


@pytest.mark.parametrize("interval", [0.02, 0.03, 0.05])
def test_a_control_that_holds_is_tuned_as_a_continuous_one_of_its_delay(interval: float) -> None:
    held = WindowModel(SHALLOW.system, Recording(), control_interval=interval).held()
    values, expected = (speed_control([model], [model], np.array([1e5]), DepthSettings()) for model in (held, MODEL))
    for name in VARIABLES:
        np.testing.assert_allclose(values[name], expected[name], rtol=1e-9)
        assert np.isfinite(values[name]).all()


def test_tuned_gains_vibrate_less() -> None:
    values = found(DepthSettings(tuning_interval_m=1000.0))
    assert 0 < values["tuned_vibration"][-1] <= 1
    assert values["tuned_proportional"][-1] > 0


def test_without_weight_no_speed_is_stated_and_more_weight_needs_more() -> None:
    settings = DepthSettings(tuning_interval_m=1000.0)
    assert np.isnan(found(settings, np.nan)["lowest_stable_speed"]).all()
    light, heavy = (found(settings, weight)["lowest_stable_speed"][2] for weight in (5e4, 2e5))
    assert 0 < light < heavy


@pytest.mark.parametrize("weight", [1e5, np.nan])
def test_a_bit_that_feeds_vibration_by_itself_has_no_stable_speed(weight: float) -> None:
    """Whatever the weight on it: its own damping is negative beyond what string and top drive take up."""
    slope = critical_slope(SHALLOW.system)[0]
    system = replace(SHALLOW.system, bit=replace(SHALLOW.system.bit, damping=SHALLOW.system.bit.damping - 2 * slope))
    values = speed_control([WindowModel(system, Recording())], [None], np.array([weight]), DepthSettings())
    assert values["critical_slope"][0] == pytest.approx(-slope, rel=1e-6)
    assert values["critical_frequency"][0] > 0
    assert values["lowest_stable_speed"][0] == np.inf


def test_a_control_that_is_unstable_without_the_rock_has_no_stable_speed() -> None:
    system = controlled_by(SHALLOW.system, Controller(40000.0, 5000.0))
    assert not is_stable(system)
    values = speed_control([WindowModel(system, Recording())], [None], np.array([1e5]), DepthSettings())
    assert values["lowest_stable_speed"][0] == np.inf
    assert np.isnan([values["critical_slope"][0], values["critical_frequency"][0]]).all()


def test_a_bit_whose_torque_rises_with_speed_is_refused() -> None:
    with pytest.raises(SettingsError, match="above the torque at standstill"):
        DepthSettings.checked({"bit_torque_fast_m": 0.1}, "test")


def test_present_gains_are_those_of_the_model_with_what_is_named() -> None:
    stronger = MODEL.with_controller(proportional=2 * MODEL.system.top_drive.controller.proportional)
    values = speed_control([MODEL, None, stronger], [None, None, stronger], np.full(3, 1e5), DepthSettings())
    stated = MODEL.system.top_drive.controller.proportional
    assert values["present_proportional"] == pytest.approx([stated, np.nan, 2 * stated], nan_ok=True)
