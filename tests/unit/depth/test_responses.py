"""Responses and times of windows, of parameters that are given."""

import numpy as np
import pytest
import xarray as xr

from drillid.config.settings import DepthSettings
from drillid.datasets.codes import RigState
from drillid.depth import stage
from drillid.depth.responses import identified_models, identified_responses
from drillid.depth.stage import time_in_states
from drillid.discrepancy.catalogue import WindowModel
from drillid.physics.responses import bit_mobility, command_mobility, laplace
from drillid.physics.sensor import Recording
from drillid.physics.time_responses import bit_step_response
from tests.simulated import RIG, SHALLOW


def test_responses_are_those_of_the_system_stiff_and_controlled() -> None:
    frequency = np.geomspace(0.05, 4.0, 40)
    depth, controller = np.array([SHALLOW.bit_depth]), SHALLOW.top_drive.controller
    settings = DepthSettings(step_duration_s=2.0, step_interval_s=0.1)
    models = identified_models(RIG, [controller], SHALLOW.parameters[None], depth)
    found = identified_responses(models, frequency, settings).isel(depth=0)
    s = laplace(frequency)
    np.testing.assert_allclose(found["command_mobility_fitted"], command_mobility(SHALLOW.system, s), rtol=1e-9)
    np.testing.assert_allclose(found["bit_mobility_controlled"], bit_mobility(SHALLOW.system, s), rtol=1e-9)
    np.testing.assert_allclose(found["bit_mobility_stiff"], bit_mobility(SHALLOW.system, s, stiff=True), rtol=1e-9)
    np.testing.assert_allclose(found["lag"], np.arange(0, 2.05, 0.1))
    assert not np.allclose(found["bit_step_stiff"], found["bit_step_controlled"])


@pytest.mark.parametrize("interval", [0.02, 0.04, 0.07])
def test_steps_of_a_control_that_holds_are_those_of_a_continuous_one_of_its_delay(interval: float) -> None:
    settings = DepthSettings(step_duration_s=5.0, step_interval_s=0.02)
    held = WindowModel(SHALLOW.system, Recording(), control_interval=interval).held()
    found = identified_responses([held], np.geomspace(0.05, 4.0, 10), settings).isel(depth=0)
    _, expected = bit_step_response(SHALLOW.system, 5.0, 0.02)
    np.testing.assert_allclose(found["bit_step_controlled"], expected, rtol=1e-9, atol=1e-15)


@pytest.mark.parametrize("block", [7, 1_000_000])
def test_time_in_states_runs_from_the_window_before_to_the_end_of_each(
    block: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(stage, "_BLOCK", block)
    state = np.repeat(
        [RigState.CONNECTION, RigState.DRILLING, RigState.SWEEP_OFF, RigState.DRILLING], [50, 100, 30, 70]
    )
    time = np.datetime64("2025-05-01", "ns") + np.arange(state.size) * np.timedelta64(500, "ms")
    states = xr.Dataset({"rig_state": ("time", state)}, {"time": time})
    windows = xr.Dataset({"first_sample": ("window", [50, 200]), "samples": ("window", [100, 50])})
    found = time_in_states(states, windows)
    assert found.shape == (2, len(RigState))
    assert found[0, RigState.CONNECTION] == 25.0
    assert found[:, RigState.DRILLING] == pytest.approx([50.0, 35.0])
    assert found[:, RigState.SWEEP_OFF] == pytest.approx([0.0, 15.0])
