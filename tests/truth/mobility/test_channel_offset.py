"""Clock offsets between recorded channels are found with the error that is stated."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from drillid.errors import EstimationError
from drillid.mobility.channel_offset import ChannelOffset, channel_offset
from drillid.mobility.responses import channel_offsets
from drillid.simulation.recorder import Recorder
from drillid.spectra.cross_spectra import Spectra, stacked
from drillid.spectra.periodic import line_spectra
from tests.simulated import RATE, SHALLOW, drilled

FREQUENCY = np.arange(6, 481) / 120.0


@cache
def window() -> dict[str, np.ndarray]:
    return drilled(SHALLOW, 600.0, 9)


def spectra_of(command: np.ndarray) -> Spectra:
    channels = (window()["torque_sweep"], window()["speed"], command)
    return line_spectra(*channels, RATE, 120.0, FREQUENCY, 40)


def recorded(offset: float, noise: float, seed: int = 0) -> ChannelOffset:
    recorder = Recorder(1 / RATE, clock_offset=offset, noise=noise)
    command = recorder.record(window()["torque_command"], 1 / RATE, np.random.default_rng(seed))
    return channel_offset(spectra_of(command), FREQUENCY)


@pytest.mark.parametrize("offset", [0.0, 0.013, 0.36, -1.2])
def test_the_offset_and_the_control_are_found(offset: float) -> None:
    found = recorded(offset, noise=1.0)
    assert found.offset == pytest.approx(offset, abs=2e-4)
    assert found.proportional == pytest.approx(350, rel=0.02)
    assert found.integral == pytest.approx(180, rel=0.05)


def test_its_standard_error_is_that_of_repeated_records() -> None:
    found = [recorded(0.01, noise=30.0, seed=seed) for seed in range(25)]
    pulls = np.array([(one.offset - 0.01) / one.standard_error for one in found])
    assert 0.6 < np.sqrt(np.mean(pulls**2)) < 1.4


def test_without_a_logged_command_it_is_told() -> None:
    with pytest.raises(EstimationError, match="torque command"):
        channel_offset(spectra_of(np.full(window()["speed"].size, np.nan)), FREQUENCY)


def test_a_channel_that_does_not_respond_has_no_offset() -> None:
    spectra = spectra_of(window()["torque_command"])
    still = replace(spectra, cross_speed=np.zeros_like(spectra.cross_speed))
    with pytest.raises(EstimationError, match="does not respond to the sweep"):
        channel_offset(still, FREQUENCY)
    assert np.isnan(channel_offsets(stacked([still], FREQUENCY))["channel_offset"].values).all()
