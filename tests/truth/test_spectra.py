"""Spectra of a known response in known noise: errors have the variance that is stated, and nothing is biased."""

import numpy as np
import pytest
import xarray as xr
from scipy.signal import lfilter
from scipy.stats import f as fisher
from scipy.stats import kstest

from drillid.config import SpectraSettings
from drillid.excitation import exponential_sweeps
from drillid.mobility import command_mobility, sharing
from drillid.spectra import Spectra, frequency_grid, line_spectra, spectrogram, sweep_period, welch_spectra
from drillid.statistics import expected_ratio, sum_of_ratios_probability

RATE = 50.0
SETTINGS = SpectraSettings()
NUMERATOR, DENOMINATOR = [0.0, 0.02, 0.01], [1.0, -1.7, 0.8]
TIME = np.arange(int(600 * RATE)) / RATE


def response(frequency: np.ndarray) -> np.ndarray:
    z = np.exp(-2j * np.pi * frequency / RATE)
    return np.polyval(NUMERATOR[::-1], z) / np.polyval(DENOMINATOR[::-1], z)


def measured(seed: int, sweep: np.ndarray, noise: float) -> np.ndarray:
    """Speed from the sweep, already steady, with noise coloured by a resonance near 1 Hz."""
    rng = np.random.default_rng(seed)
    steady = lfilter(NUMERATOR, DENOMINATOR, np.tile(sweep, 2))[-sweep.size :]
    coloured = lfilter([1.0], [1.0, -1.97, 0.985], rng.normal(size=2 * sweep.size))[-sweep.size :]
    return steady + noise * coloured


def mobility_of(spectra: Spectra, frequency: np.ndarray) -> xr.Dataset:
    dataset = xr.Dataset({name: ("frequency", values) for name, values in vars(spectra).items()})
    return command_mobility(dataset.assign_coords(frequency=frequency))


def test_the_period_is_found_and_a_single_chirp_has_none() -> None:
    rng = np.random.default_rng(1)
    for period in (60.0, 120.0, 97.5):
        sweep = exponential_sweeps(TIME, 500.0, period=period) + rng.normal(scale=1.0, size=TIME.size)
        assert sweep_period(sweep, RATE, 0.05) == pytest.approx(period, abs=0.5 / RATE)
    assert sweep_period(exponential_sweeps(TIME, 500.0, period=600.0), RATE, 0.05) == 0
    assert sweep_period(rng.normal(size=TIME.size), RATE, 0.05) == 0
    assert sweep_period(np.zeros(TIME.size), RATE, 0.05) == 0
    assert sweep_period(exponential_sweeps(TIME, 500.0, period=120.0) + 2e4, RATE, 0.05) == pytest.approx(120.0)


@pytest.mark.parametrize("method", ["lines", "welch"])
def test_errors_over_their_stated_variance_follow_fisher(method: str) -> None:
    sweep = exponential_sweeps(TIME, 500.0, period=120.0)
    grid_period = 120.0 if method == "lines" else 40.0
    frequency = frequency_grid(grid_period, SETTINGS, RATE)
    frequency = frequency[frequency < 4.0]
    ratios, freedom, whole = [], np.nan, []
    for seed in range(40):
        speed = measured(seed, sweep, noise=5.0)
        if method == "lines":
            spectra = line_spectra(sweep, speed, sweep, RATE, 120.0, frequency, SETTINGS.noise_lines)
        else:
            spectra = welch_spectra(sweep, speed, sweep, RATE, 2 * grid_period, frequency)
        mobility = mobility_of(spectra, frequency)
        error = mobility["command_mobility"].values - response(frequency)
        ratio = np.abs(error) ** 2 / mobility["command_mobility_variance"].values
        freedoms = spectra.degrees_of_freedom
        freedom = float(freedoms[0])
        ratios.append(ratio)
        shared = sharing(freedoms, spectra.averages)
        whole.append(sum_of_ratios_probability(float(ratio.sum()), freedoms, shared, fitted=0.0))
    pooled = np.concatenate([ratio[::7] for ratio in ratios])
    assert np.mean(ratios) == pytest.approx(float(expected_ratio(freedom)), rel=0.03 if method == "lines" else 0.1)
    if method == "lines":
        assert kstest(pooled, fisher(2, 2 * freedom).cdf).pvalue > 1e-3
        assert kstest(whole, "uniform").pvalue > 1e-3


def test_the_lines_are_exact_without_noise() -> None:
    sweep = exponential_sweeps(TIME, 500.0, period=120.0)
    frequency = frequency_grid(120.0, SETTINGS, RATE)
    frequency = frequency[frequency < 4.0]
    spectra = line_spectra(sweep, measured(0, sweep, 0.0), sweep, RATE, 120.0, frequency, SETTINGS.noise_lines)
    mobility = mobility_of(spectra, frequency)["command_mobility"].values
    np.testing.assert_allclose(mobility, response(frequency), rtol=1e-9)


def test_a_drift_of_the_mean_does_not_reach_the_response() -> None:
    sweep = exponential_sweeps(TIME, 500.0, period=120.0)
    frequency = frequency_grid(120.0, SETTINGS, RATE)
    frequency = frequency[frequency < 4.0]
    steady = measured(0, sweep, 0.0)
    drifting = steady + 0.5 * np.abs(steady).max() * TIME / TIME[-1]
    values = [
        line_spectra(sweep, speed, sweep, RATE, 120.0, frequency, SETTINGS.noise_lines).cross_speed
        for speed in (steady, drifting)
    ]
    assert np.median(np.abs(values[1] / values[0] - 1)) < 0.01


def test_power_of_the_spectrogram_is_that_of_the_signal() -> None:
    rng = np.random.default_rng(3)
    noise = rng.normal(scale=3.0, size=TIME.size)
    frequency, time, power = spectrogram(noise, RATE, 20.0, highest=RATE / 2)
    assert power.mean(axis=1).sum() * (frequency[1] - frequency[0]) == pytest.approx(9.0, rel=0.05)
    assert time[0] > 0
    assert time[-1] < TIME[-1]
    tone = np.sin(2 * np.pi * 1.5 * TIME)
    frequency, _, power = spectrogram(tone, RATE, 20.0, highest=5.0)
    assert frequency[power.mean(axis=1).argmax()] == pytest.approx(1.5)
    assert frequency[-1] <= 5.0
