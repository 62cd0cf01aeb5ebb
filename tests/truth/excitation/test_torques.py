"""The sweep's closed form and the noise's statistics."""

import numpy as np
import pytest

from drillid.errors import SettingsError
from drillid.excitation.torques import SWEEP_BANDS, SWEEP_PERIOD, coloured_noise, exponential_sweeps

STEP = 0.001


@pytest.mark.parametrize("band", SWEEP_BANDS)
def test_instantaneous_frequency_rises_exponentially_through_the_band(band: tuple[float, float]) -> None:
    """Zero crossings count half cycles; their density is the exponential law between the band's edges."""
    time = np.arange(0, SWEEP_PERIOD, STEP)
    torque = exponential_sweeps(time, 1.0, [band])
    sign_changes = np.flatnonzero(np.signbit(torque[1:-1]) != np.signbit(torque[2:])) + 1
    crossings = time[sign_changes] + STEP * torque[sign_changes] / (torque[sign_changes] - torque[sign_changes + 1])
    lower, upper = band
    growth = np.log(upper / lower) / SWEEP_PERIOD
    cycles = np.expm1(growth * crossings) * lower / growth
    segment = (np.arange(1, crossings.size + 1) / 2) / cycles
    assert np.ptp(segment) < 1e-4
    assert abs(segment.mean() - 1) <= 0.5 / (lower * np.expm1(growth * SWEEP_PERIOD) / growth)


@pytest.mark.parametrize("band", [(1.0, 1.0), (0.0, 2.0), (-1.0, 2.0), (np.nan, 2.0)])
def test_a_band_that_has_no_exponential_sweep_is_refused(band: tuple[float, float]) -> None:
    with pytest.raises(SettingsError, match="two positive frequencies"):
        exponential_sweeps(np.arange(10.0), 100.0, (band,), 10.0)


def test_torque_repeats_without_a_jump() -> None:
    time = np.arange(-1.0, 2 * SWEEP_PERIOD, STEP)
    torque = exponential_sweeps(time, 500.0)
    steepest = 500 * 2 * np.pi * sum(upper for _, upper in SWEEP_BANDS) * STEP
    assert np.max(np.abs(np.diff(torque))) < 1.05 * steepest
    np.testing.assert_allclose(torque, exponential_sweeps(time + 3 * SWEEP_PERIOD, 500.0), atol=1e-8)


def test_rms_is_that_of_three_sines() -> None:
    torque = exponential_sweeps(np.arange(0, SWEEP_PERIOD, STEP), 490.0)
    assert np.sqrt(np.mean(torque**2)) == pytest.approx(490 * np.sqrt(1.5), rel=0.02)


def test_noise_has_its_rms_and_bandwidth() -> None:
    """Power density of a first-order low pass: half the plateau at the corner, and the rms in all."""
    samples, bandwidth, rms = 2**20, 2.0, 400.0
    noise = coloured_noise(np.random.default_rng(3), samples, 0.01, rms, bandwidth)
    assert noise.std() == pytest.approx(rms, rel=0.02)
    power = np.abs(np.fft.rfft(noise)) ** 2
    frequency = np.fft.rfftfreq(samples, 0.01)
    plateau = power[(frequency > 0.01) & (frequency < 0.2)].mean()
    corner = power[np.abs(frequency - bandwidth) < 0.1].mean()
    assert corner / plateau == pytest.approx(0.5, rel=0.05)


def test_noise_is_stationary_from_its_first_sample() -> None:
    generator = np.random.default_rng(5)
    first = [coloured_noise(generator, 2, 0.001, 1.0, 0.5)[:2] for _ in range(4000)]
    np.testing.assert_allclose(np.std(first, axis=0), 1.0, rtol=0.05)
