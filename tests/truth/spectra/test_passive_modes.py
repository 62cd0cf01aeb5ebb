"""Modes from the speed of a simulated rig without sweep are the poles of the equipment."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.signal import lfilter
from scipy.stats import binom

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
    # the control damps the lowest so much that its hump is no clearer than those of chance
    sharp = truth.damping_ratio < 0.2
    assert np.flatnonzero(~sharp).tolist() == [0]
    assert [one.frequency.size for one in found] == [np.count_nonzero(sharp)] * 4
    frequency, damping = truth.frequency[sharp], truth.damping_ratio[sharp]
    miss = np.array([one.frequency - frequency for one in found])
    stated = np.array([one.frequency_error for one in found])
    assert np.all(np.abs(miss / frequency) < 0.02)
    assert np.sqrt(np.mean((miss / stated) ** 2)) < 2.5
    assert np.all(stated / frequency < 0.01)
    ratios = np.array([one.damping_ratio for one in found]) / damping
    assert np.all(np.abs(ratios.mean(axis=0) - 1) < 0.25)
    stated = np.array([one.damping_ratio_error for one in found]) / damping
    assert np.sqrt(np.mean(((ratios - 1) / stated) ** 2)) < 2.5
    assert np.all(stated < 0.1)


@pytest.mark.parametrize("memory", [0.0, 0.9])
def test_noise_has_no_modes(memory: float) -> None:
    found = 0
    for seed in range(40):
        noise = lfilter([1.0], [1.0, -memory], np.random.default_rng(seed).normal(size=30000))
        found += passive_modes(noise, RATE, (0.1, 4.0)).frequency.size > 0
    assert binom.sf(found - 1, 40, 0.01) > 1e-3


def test_a_faint_mode_is_found_where_it_is() -> None:
    pole = 0.995 * np.exp(2j * np.pi * 1.5 / RATE)
    noise = np.random.default_rng(0).normal(size=(2, 60000))
    speed = 30 * noise[0] + lfilter([1.0], [1.0, -2 * pole.real, abs(pole) ** 2], noise[1])
    found = passive_modes(speed, RATE, (0.1, 4.0))
    np.testing.assert_allclose(found.frequency, [1.5], atol=0.05)


def test_a_short_record_is_told() -> None:
    with pytest.raises(EstimationError, match="too short"):
        passive_modes(np.random.default_rng(0).normal(size=1000), RATE, (0.1, 4.0))
