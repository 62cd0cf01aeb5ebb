"""Modes from the speed of a simulated rig without sweep are the poles of the equipment."""

from dataclasses import replace

import numpy as np
import pytest

from drillid.errors import EstimationError
from drillid.physics.modes import modes
from drillid.spectra.passive_modes import passive_modes
from tests.simulated import RATE, SHALLOW, drilled


def test_modes_of_the_string_are_found_without_a_sweep() -> None:
    truth = modes(SHALLOW.system, highest=4.5)
    found = [
        passive_modes(drilled(replace(SHALLOW, sweep_amplitude=0.0), 1200.0, seed)["speed"], RATE, (0.05, 4.3))
        for seed in range(4)
    ]
    assert [one.frequency.size for one in found] == [truth.frequency.size] * 4
    sharp = truth.damping_ratio < 0.2
    frequency, damping = truth.frequency[sharp], truth.damping_ratio[sharp]
    miss = np.array([one.frequency[sharp] - frequency for one in found])
    stated = np.array([one.frequency_error[sharp] for one in found])
    assert np.all(np.abs(miss / frequency) < 0.02)
    assert np.sqrt(np.mean((miss / stated) ** 2)) < 2.5
    assert np.all(stated / frequency < 0.01)
    ratios = np.array([one.damping_ratio[sharp] for one in found]) / damping
    assert np.all(np.abs(ratios.mean(axis=0) - 1) < 0.25)
    stated = np.array([one.damping_ratio_error[sharp] for one in found]) / damping
    assert np.sqrt(np.mean(((ratios - 1) / stated) ** 2)) < 2.5
    assert np.all(stated < 0.1)


def test_white_noise_has_no_sharp_modes_and_a_short_record_is_told() -> None:
    noise = np.random.default_rng(0).normal(size=30000)
    found = passive_modes(noise, RATE, (0.1, 4.0))
    assert np.all(found.damping_ratio > 0.1)  # chance makes humps, but no peaks
    with pytest.raises(EstimationError, match="too short"):
        passive_modes(noise[:1000], RATE, (0.1, 4.0))
