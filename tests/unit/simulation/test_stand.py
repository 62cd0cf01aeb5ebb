"""Stands and noise that changes with time, and a whole stand simulated from rest to rest."""

import numpy as np
import pytest

from drillid.errors import SettingsError
from drillid.excitation.torques import coloured_noise
from drillid.physics.nonlinear import Cutting, NonlinearRig, WallContact
from drillid.simulation.simulate import TIME_STEP, simulate
from drillid.simulation.stand import StandSchedule, varying_noise
from tests.truth.rigs import SYSTEM

STAND = StandSchedule(12.0, 8e4, drilling=60.0)


def test_a_stand_goes_through_its_phases_in_order() -> None:
    time = np.array([0, 10, 15, 20, 40, 45, 50, 110, 115, 120, 140, 145, 150, 209, 500.0])
    np.testing.assert_allclose(STAND.speed_set(time) / 12, [0, 0, 0.5, 1, 1, 1, 1, 1, 1, 1, 1, 0.5, 0, 0, 0])
    np.testing.assert_allclose(STAND.weight_on_bit(time) / 8e4, [0, 0, 0, 0, 0, 0.5, 1, 1, 0.5, 0, 0, 0, 0, 0, 0])
    assert STAND.is_drilling(time).tolist() == [False] * 6 + [True] + [False] * 8
    assert STAND.duration == 210.0


def test_unusable_stands_are_refused() -> None:
    with pytest.raises(SettingsError, match="stand"):
        StandSchedule(12.0, 8e4, drilling=-1.0)
    with pytest.raises(SettingsError, match="stand"):
        StandSchedule(12.0, 8e4, speeding_up=0.0)


def test_noise_that_does_not_vary_is_the_stationary_one() -> None:
    """The same recursion in other arithmetic."""
    still = varying_noise(np.random.default_rng(5), 0.01, 300.0, 2.0, 5000)
    np.testing.assert_allclose(still, coloured_noise(np.random.default_rng(5), 5000, 0.01, 300.0, 2.0), rtol=1e-9)


def test_noise_follows_strength_and_bandwidth() -> None:
    half = 200_000
    rms = np.repeat([100.0, 400.0], half)
    bandwidth = np.repeat([5.0, 1.0], half)
    noise = varying_noise(np.random.default_rng(6), 0.01, rms, bandwidth, 2 * half)
    for part, strength, corner in ((noise[:half], 100.0, 5.0), (noise[half:], 400.0, 1.0)):
        assert part.std() == pytest.approx(strength, rel=0.03)
        neighbours = np.mean(part[1:] * part[:-1]) / np.mean(part**2)
        assert neighbours == pytest.approx(np.exp(-2 * np.pi * corner * 0.01), abs=0.01)


def test_a_stand_is_simulated_from_rest_to_rest() -> None:
    """Friction holds the string before and after; on bottom the drive carries cutting and friction."""
    time = TIME_STEP * np.arange(round(STAND.duration / TIME_STEP), dtype=float)
    contact = WallContact(np.array([0.0, 3000.0]), np.array([1.5]), np.array([1.0]))
    rig = NonlinearRig(SYSTEM, contact=contact, cutting=Cutting(0.05, 0.05))
    result = simulate(rig, 0 * time, STAND.speed_set(time), 0 * time, weight_on_bit=STAND.weight_on_bit(time))
    assert not result.speed[result.time < 10].any()
    assert not result.bit_speed[result.time > 180].any()
    off_bottom, on_bottom = ((result.time > a) & (result.time < b) for a, b in ((35, 40), (90, 110)))
    cutting = result.string_torque[on_bottom].mean() - result.string_torque[off_bottom].mean()
    assert cutting == pytest.approx(0.05 * 8e4, rel=0.05)
