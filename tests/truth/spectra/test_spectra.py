"""Spectra of a known response in known noise: errors have the variance that is stated, and nothing is biased."""

import numpy as np
import pytest
import xarray as xr
from scipy.signal import lfilter
from scipy.stats import f as fisher
from scipy.stats import kstest

from drillid.config.settings import SpectraSettings
from drillid.excitation.torques import band_limited_noise, exponential_sweeps
from drillid.mobility.responses import closed_loop_responses, command_mobility
from drillid.spectra.cross_spectra import Spectra, stacked, welch_spectra
from drillid.spectra.local_polynomial import local_spectra
from drillid.spectra.period import sweep_period
from drillid.spectra.periodic import line_spectra
from drillid.spectra.stage import frequency_grid, spectrogram
from drillid.statistics import expected_ratio, sharing, sum_of_ratios_probability

RATE = 50.0
SETTINGS = SpectraSettings()
NUMERATOR, DENOMINATOR = [0.0, 0.02, 0.01], [1.0, -1.7, 0.8]
TIME = np.arange(int(600 * RATE)) / RATE


def response(frequency: np.ndarray) -> np.ndarray:
    z = np.exp(-2j * np.pi * frequency / RATE)
    return np.polyval(NUMERATOR[::-1], z) / np.polyval(DENOMINATOR[::-1], z)


def measured(seed: int, sweep: np.ndarray, noise: float, gain: np.ndarray | float = 1.0) -> np.ndarray:
    """Speed from the sweep, already steady, with noise of some gain coloured by a resonance near 1 Hz."""
    rng = np.random.default_rng(seed)
    steady = lfilter(NUMERATOR, DENOMINATOR, np.tile(sweep, 2))[-sweep.size :]
    force = rng.normal(size=2 * sweep.size)
    force[-sweep.size :] *= gain
    coloured = lfilter([1.0], [1.0, -1.97, 0.985], force)[-sweep.size :]
    return steady + noise * coloured


def mobility_of(spectra: Spectra, frequency: np.ndarray) -> xr.Dataset:
    return command_mobility(stacked([spectra], frequency).isel(window=0))


def test_the_period_is_found_and_a_single_chirp_has_none() -> None:
    rng = np.random.default_rng(1)
    for period in (60.0, 120.0, 97.5):
        sweep = exponential_sweeps(TIME, 500.0, period=period) + rng.normal(scale=1.0, size=TIME.size)
        assert sweep_period(sweep, RATE, 0.05) == pytest.approx(period, rel=1e-6)
    assert sweep_period(exponential_sweeps(TIME, 500.0, period=600.0), RATE, 0.05) == 0
    assert sweep_period(rng.normal(size=TIME.size), RATE, 0.05) == 0
    assert sweep_period(np.zeros(TIME.size), RATE, 0.05) == 0
    assert sweep_period(exponential_sweeps(TIME, 500.0, period=120.0) + 2e4, RATE, 0.05) == pytest.approx(120.0)


@pytest.mark.parametrize("noise", [0.01, 0.0003])
@pytest.mark.parametrize(("rate", "period"), [(10.0, 60 * (1 + 83e-6)), (20.0, 60 * (1 - 2e-4)), (10.0, 60.05)])
def test_a_recorder_with_a_clock_of_its_own_costs_no_precision(rate: float, period: float, noise: float) -> None:
    """Clock errors of a crystal and larger ones; a period of a whole number and a half of samples."""
    time = np.arange(round(1200 * rate)) / rate
    lines, phases = np.arange(3, 250) / period, np.random.default_rng(0).uniform(0, 2 * np.pi, 247)
    sweep, response = (
        0.1 * np.cos(2 * np.pi * np.outer(time - late, lines) + phases).sum(axis=1) for late in (0.0, 0.3)
    )
    found = sweep_period(sweep, rate, 0.05)
    assert found == pytest.approx(period, rel=1e-9)
    frequency = frequency_grid(found, SETTINGS, rate)
    error, variance = [], []
    for seed in range(10):
        speed = response + np.random.default_rng(seed).normal(scale=noise, size=time.size)
        spectra = line_spectra(sweep, speed, sweep, rate, found, frequency, SETTINGS.noise_lines)
        mobility = spectra.cross_speed / spectra.sweep_power
        error.append(np.abs(mobility - np.exp(-0.6j * np.pi * frequency)) ** 2 * spectra.sweep_power)
        variance.append(spectra.speed_noise)
    np.testing.assert_allclose(np.mean(variance), 4 * noise**2 / (found * rate), rtol=0.1)
    np.testing.assert_allclose(np.mean(error), np.mean(variance) / int(1200 / period), rtol=0.15)


def estimated(method: str, sweep: np.ndarray, speed: np.ndarray, frequency: np.ndarray) -> Spectra:
    if method == "lines":
        return line_spectra(sweep, speed, sweep, RATE, 120.0, frequency, SETTINGS.noise_lines)
    if method == "local":
        return local_spectra(sweep, speed, sweep, RATE, frequency, SETTINGS.noise_lines // 4)
    return welch_spectra(sweep, speed, sweep, RATE, 2 / (frequency[1] - frequency[0]), frequency)


def errors(
    method: str, sweep: np.ndarray, speeds: list[np.ndarray], highest: float = 4.0
) -> tuple[np.ndarray, np.ndarray, Spectra]:
    """Errors and stated variances of the response, (window, frequency), and the last spectra."""
    frequency = frequency_grid(120.0 if method == "lines" else 60.0, SETTINGS, RATE)
    frequency = frequency[frequency < highest]
    error, variance = [], []
    for speed in speeds:
        spectra = estimated(method, sweep, speed, frequency)
        mobility = mobility_of(spectra, frequency)
        error.append(mobility["command_mobility"].values - response(frequency))
        variance.append(mobility["command_mobility_variance"].values)
    return np.array(error), np.array(variance), spectra


def stated(error: np.ndarray, variance: np.ndarray, freedom: np.ndarray) -> float:
    """Mean of |error|²/variance per what it is in the mean, 1."""
    return float(np.mean(np.abs(error) ** 2 / variance / expected_ratio(freedom)))


@pytest.mark.parametrize("method", ["lines", "local", "welch"])
def test_errors_over_their_stated_variance_follow_fisher(method: str) -> None:
    sweep = exponential_sweeps(TIME, 500.0, period=120.0)
    if method == "local":
        sweep = band_limited_noise(np.random.default_rng(7), TIME.size, 1 / RATE, 600.0, (0.03, 4.5))
    error, variance, spectra = errors(method, sweep, [measured(seed, sweep, 5.0) for seed in range(40)])
    freedom = spectra.degrees_of_freedom
    ratio = np.abs(error) ** 2 / variance
    assert stated(error, variance, freedom) == pytest.approx(1, abs=0.03)
    if method == "lines":
        shared = sharing(freedom, spectra.averages)
        whole = [sum_of_ratios_probability(float(row.sum()), freedom, shared, fitted=0.0) for row in ratio]
        p_values = fisher.cdf(ratio, 2, 2 * freedom)
        assert kstest(p_values[:, ::7].ravel(), "uniform").pvalue > 1e-3
        assert kstest(whole, "uniform").pvalue > 1e-3


def test_noise_that_falls_towards_zero_frequency_has_its_stated_variance_there() -> None:
    sweep = exponential_sweeps(TIME, 500.0, period=120.0)
    # a high pass of 0.1 Hz, as the integral part of a speed control makes it
    pole = np.exp(-2 * np.pi * 0.1 / RATE)
    speeds = []
    for seed in range(40):
        noise = lfilter([1, -1], [1, -pole], np.random.default_rng(seed).normal(size=2 * TIME.size))
        speeds.append(measured(seed, sweep, 0.0) + noise[-TIME.size :])
    error, variance, spectra = errors("lines", sweep, speeds)
    low = slice(0, 12)
    assert stated(error[:, low], variance[:, low], spectra.degrees_of_freedom[low]) == pytest.approx(1, abs=0.1)


@pytest.mark.parametrize("method", ["lines", "local"])
def test_a_burst_spoils_no_window_and_none_costs_nothing(method: str) -> None:
    sweep = exponential_sweeps(TIME, 500.0, period=120.0 if method == "lines" else 600.0)
    powers = {}
    for name, gain in {"quiet": 1.0, "burst": np.where((TIME > 210) & (TIME < 230), 10.0, 1.0)}.items():
        error, variance, spectra = errors(method, sweep, [measured(seed, sweep, 5.0, gain) for seed in range(20)])
        powers[name] = np.mean(np.abs(error) ** 2, axis=0)
        assert stated(error, variance, spectra.degrees_of_freedom) == pytest.approx(1, abs=0.06)
        assert name == "burst" or (spectra.averages > 0.97 * spectra.averages.max()).all()
    # 1.25 if a period were cut out; one long sweep loses the frequencies that it passes meanwhile, and those alone
    assert np.median(powers["burst"] / powers["quiet"]) < (1.25 if method == "lines" else 1.15)


def test_noise_that_grows_slowly_has_the_variance_that_is_stated() -> None:
    sweep = exponential_sweeps(TIME, 500.0, period=120.0)
    speeds = [measured(seed, sweep, 5.0, 1 + 2 * TIME / TIME[-1]) for seed in range(20)]
    error, variance, spectra = errors("lines", sweep, speeds)
    assert stated(error, variance, spectra.degrees_of_freedom) == pytest.approx(1, abs=0.05)


@pytest.mark.parametrize("gain", [np.where(TIME < 290, 1.0, 0.93), 1 - 0.15 * TIME / TIME[-1]])
def test_the_response_to_a_sweep_whose_amplitude_changes_is_no_noise(gain: np.ndarray) -> None:
    sweep = gain * exponential_sweeps(TIME, 500.0, period=120.0)
    error, variance, spectra = errors("lines", sweep, [measured(seed, sweep, 2.0) for seed in range(6)])
    # 0.8 where it counted as noise
    assert stated(error, variance, spectra.degrees_of_freedom) == pytest.approx(1, abs=0.06)


def test_a_window_that_begins_at_rest_is_freed_of_its_transient() -> None:
    rng = np.random.default_rng(3)
    sweep = band_limited_noise(rng, TIME.size, 1 / RATE, 600.0, (0.03, 4.5))
    from_rest = lfilter(NUMERATOR, DENOMINATOR, sweep) + 0.3 * np.exp(-TIME / 5.0) * sweep.std()
    frequency = frequency_grid(60.0, SETTINGS, RATE)
    frequency = frequency[frequency < 4.0]
    bare = np.fft.rfft(from_rest)[np.rint(frequency * 600).astype(int)]
    bare = bare / np.fft.rfft(sweep)[np.rint(frequency * 600).astype(int)]
    found = mobility_of(estimated("local", sweep, from_rest, frequency), frequency)["command_mobility"].values
    left, removed = (np.abs(value - response(frequency)) for value in (bare, found))
    assert np.median(removed) < 1e-3 * np.median(left)


def test_beside_a_sharp_resonance_the_rational_model_is_taken_and_is_right(monkeypatch: pytest.MonkeyPatch) -> None:
    pole = 0.999 * np.exp(2j * np.pi * 1.003 / RATE)
    denominator = [1.0, -2 * pole.real, abs(pole) ** 2]
    sweep = band_limited_noise(np.random.default_rng(4), 2 * TIME.size, 1 / RATE, 600.0, (0.03, 4.5))
    speed = lfilter([0.0, 1e-4], denominator, sweep)[-TIME.size :]
    speed += 1e-4 * np.random.default_rng(5).normal(size=speed.size)
    frequency = np.arange(55, 66) / 60.0
    z = np.exp(-2j * np.pi * frequency / RATE)
    truth = 1e-4 * z / np.polyval(denominator[::-1], z)
    misses = []
    for rate in (0.01, 1e-300):
        monkeypatch.setattr("drillid.spectra.local_polynomial._RATIONAL_RATE", rate)
        spectra = estimated("local", sweep[-TIME.size :], speed, frequency)
        value = mobility_of(spectra, frequency)["command_mobility"].values
        misses.append(np.abs(value / truth - 1).max())
    assert misses[0] < 0.2 * misses[1]


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
    values = [estimated("lines", sweep, speed, frequency).cross_speed for speed in (steady, drifting)]
    assert np.max(np.abs(values[1] / values[0] - 1)) < 1e-3


def test_what_does_not_repeat_in_the_sweep_leaves_the_controls_response_alone() -> None:
    gain, sweep = 300.0, exponential_sweeps(TIME, 500.0, period=120.0)
    sweep[-1] += 50.0
    speed = measured(1, sweep, 5.0)
    frequency = frequency_grid(120.0, SETTINGS, RATE)
    spectra = line_spectra(sweep, speed, sweep - gain * speed, RATE, 120.0, frequency, SETTINGS.noise_lines)
    control = closed_loop_responses(stacked([spectra], frequency))["control_response"].values
    np.testing.assert_allclose(control, gain, rtol=1e-6)


@pytest.mark.parametrize("periods", [3, 6])
def test_steps_of_the_recorded_sweep_are_an_error_of_the_control_that_no_period_averages(periods: int) -> None:
    step, gain = 4.0, 30.0
    sweep = exponential_sweeps(TIME, 500.0, period=120.0)[: round(periods * 120 * RATE)]
    frequency = frequency_grid(120.0, SETTINGS, RATE)
    frequency = frequency[frequency < 4]
    ratios = []
    for seed in range(2):
        speed = measured(seed, sweep, 1.0)
        recorded = step * np.rint(sweep / step)
        spectra = line_spectra(recorded, speed, sweep - gain * speed, RATE, 120.0, frequency, SETTINGS.noise_lines)
        loop = closed_loop_responses(stacked([spectra], frequency)).isel(window=0)
        ratios.append(np.abs(loop["control_response"] - gain) ** 2 / loop["control_response_rounding"])
    assert np.mean(ratios) == pytest.approx(1, abs=0.15)  # of 472 lines, the same in both
    exact = line_spectra(sweep, speed, sweep - gain * speed, RATE, 120.0, frequency, SETTINGS.noise_lines)
    assert np.all(exact.sweep_rounding == 0)


def test_power_of_the_spectrogram_is_that_of_the_signal() -> None:
    rng = np.random.default_rng(3)
    noise = rng.normal(scale=3.0, size=TIME.size)
    frequency, time, power = spectrogram(noise, RATE, 20.0, highest=RATE / 2)
    assert power.mean(axis=1).sum() * (frequency[1] - frequency[0]) == pytest.approx(9.0, rel=0.05)
    # the middles of segments of 20 s that overlap by half
    np.testing.assert_allclose(time, np.arange(10.0, 591.0, 10.0))
    tone = np.sin(2 * np.pi * 1.5 * TIME)
    frequency, _, power = spectrogram(tone, RATE, 20.0, highest=5.0)
    assert frequency[power.mean(axis=1).argmax()] == pytest.approx(1.5)
    assert frequency[-1] <= 5.0


@pytest.mark.parametrize("method", ["lines", "welch"])
def test_power_of_a_speed_without_response_is_the_noise(method: str) -> None:
    sweep = exponential_sweeps(TIME, 500.0, period=120.0)
    frequency = frequency_grid(120.0 if method == "lines" else 60.0, SETTINGS, RATE)
    frequency = frequency[frequency < 4.0]
    ratios = []
    for seed in range(20):
        noise = np.random.default_rng(seed).normal(size=TIME.size)
        spectra = estimated(method, sweep, noise, frequency)
        ratios.append(spectra.speed_power.mean() / spectra.speed_noise.mean())
    assert np.mean(ratios) == pytest.approx(1, abs=0.02)


@pytest.mark.parametrize("samples", [12000, 12001, 12002])
def test_a_sweep_of_two_periods_repeats(samples: int) -> None:
    assert sweep_period(exponential_sweeps(np.arange(samples) / RATE, 500.0), RATE, 0.05) == 120.0


@pytest.mark.parametrize(("rate", "period", "seconds"), [(2.0, 120.0, 250.0), (5.0, 60.0, 130.0), (10.0, 30.0, 70.0)])
def test_few_periods_at_a_low_rate_have_spectra(rate: float, period: float, seconds: float) -> None:
    time = np.arange(round(seconds * rate)) / rate
    sweep = exponential_sweeps(time, 500.0, period=period)
    frequency = frequency_grid(period, SETTINGS, rate)
    speed = 1e-3 * sweep + 1e-2 * np.random.default_rng(0).normal(size=time.size)
    spectra = line_spectra(sweep, speed, np.full(time.size, np.nan), rate, period, frequency, SETTINGS.noise_lines)
    within = frequency < 0.35 * rate
    off = np.abs(spectra.cross_speed / spectra.sweep_power - 1e-3) / np.sqrt(spectra.speed_noise / spectra.sweep_power)
    assert np.isfinite(spectra.degrees_of_freedom).all()
    assert np.median(off[within]) < 2
