"""Gate and stacks hold their stated error rates, and what is there is found."""

import numpy as np
import pytest
import xarray as xr
from scipy.stats import binom

from drillid.config.settings import MobilitySettings, SpectraSettings
from drillid.datasets.codes import Gate
from drillid.excitation.torques import exponential_sweeps, odd_multisine
from drillid.mobility.gate import gated_mobility
from drillid.mobility.stacks import stack_windows
from drillid.spectra.cross_spectra import stacked, welch_spectra
from drillid.spectra.local_polynomial import local_spectra
from drillid.spectra.periodic import line_spectra
from drillid.spectra.stage import frequency_grid
from drillid.statistics import expected_ratio

FREQUENCY = np.arange(6, 481) / 120.0
PERIODS, FREEDOM = 5.0, 18.0
RATE, SPECTRA = 50.0, SpectraSettings()
START, WINDOW = np.datetime64("2025-06-01T00:00:00", "ns"), np.timedelta64(600, "s")


def synthetic_spectra(
    rng: np.random.Generator, windows: int, signal_to_noise: float, change: float = 0.0
) -> xr.Dataset:
    """Windows with Gaussian noise of known power, its estimate independent between every fifth frequency."""
    shape = (windows, FREQUENCY.size)
    truth = np.sqrt(signal_to_noise / PERIODS) * np.exp(1j * FREQUENCY) * (1 + change * np.arange(windows)[:, None])
    error = (rng.normal(size=shape) + 1j * rng.normal(size=shape)) / np.sqrt(2 * PERIODS)
    blocks = rng.chisquare(2 * FREEDOM, size=(windows, FREQUENCY.size // 5 + 1)) / (2 * FREEDOM)
    noise = np.repeat(blocks, 5, axis=1)[:, : FREQUENCY.size]
    speed = truth + error
    dims = ("window", "frequency")
    return xr.Dataset(
        {
            "sweep_power": (dims, np.ones(shape)),
            "speed_power": (dims, np.abs(speed) ** 2 + noise * (PERIODS - 1) / PERIODS),
            "speed_noise": (dims, noise),
            "cross_speed": (dims, speed),
            "cross_command": (dims, np.zeros(shape, complex)),
            "averages": (dims, np.full(shape, PERIODS)),
            "degrees_of_freedom": (dims, np.full(shape, FREEDOM)),
        },
        {
            "frequency": FREQUENCY,
            "window": np.arange(windows),
            "hole_depth": ("window", 3000.0 + np.arange(windows)),
            "start": ("window", START + WINDOW * np.arange(windows)),
            "end": ("window", START + WINDOW * np.arange(1, windows + 1)),
        },
    )


@pytest.mark.parametrize("error_rate", [0.01, 0.1])
def test_bands_without_response_pass_at_the_error_rate(error_rate: float) -> None:
    settings = MobilitySettings(error_rate=error_rate)
    result = gated_mobility(synthetic_spectra(np.random.default_rng(5), 300, 0.0), settings)
    assert_at_rate(passing(result, FREQUENCY, settings), error_rate)


@pytest.mark.parametrize(("estimator", "seconds"), [("lines", 600), ("lines", 240), ("local", 600), ("welch", 600)])
def test_whatever_estimates_the_spectra_noise_passes_at_the_error_rate(estimator: str, seconds: float) -> None:
    settings = MobilitySettings(error_rate=0.1)
    time = np.arange(round(seconds * RATE)) / RATE
    sweep = exponential_sweeps(time, 500.0, period=120.0)
    frequency = frequency_grid(120.0 if estimator == "lines" else 60.0, SPECTRA, RATE)
    frequency = frequency[frequency < 4.0]
    estimates = []
    for seed in range(80):
        speed = np.random.default_rng(seed).normal(size=time.size)
        if estimator == "lines":
            estimates.append(line_spectra(sweep, speed, speed, RATE, 120.0, frequency, SPECTRA.noise_lines))
        elif estimator == "local":
            estimates.append(local_spectra(sweep, speed, speed, RATE, frequency, SPECTRA.noise_lines // 4))
        else:
            estimates.append(welch_spectra(sweep, speed, speed, RATE, 120.0, frequency))
    assert_at_rate(passing(gated_mobility(stacked(estimates, frequency), settings), frequency, settings), 0.1)


def passing(mobility: xr.Dataset, frequency: np.ndarray, settings: MobilitySettings) -> np.ndarray:
    """Whether each band of each window passes."""
    bands = np.floor(np.log2(frequency / frequency[0]) / settings.band_octaves).astype(int)
    first_of_band = np.unique(bands, return_index=True)[1]
    return np.asarray(mobility["gate"].values[:, first_of_band] != Gate.TOO_INCOHERENT)


def assert_at_rate(passed: np.ndarray, rate: float) -> None:
    """Neither more nor fewer than the rate, at a chance of 0.1 % each."""
    assert binom.sf(passed.sum() - 1, passed.size, rate) > 1e-3
    assert binom.cdf(passed.sum(), passed.size, rate) > 1e-3


@pytest.mark.parametrize("loud", [1.0, 2.5, 6.0])
def test_a_burst_in_one_of_two_periods_closes_no_gate(loud: float) -> None:
    time = np.arange(round(240 * RATE)) / RATE
    sweep, frequency = exponential_sweeps(time, 500.0, period=120.0), frequency_grid(120.0, SPECTRA, RATE)
    frequency = frequency[frequency < 4.0]
    estimates = []
    for seed in range(10):
        noise = np.random.default_rng(seed).normal(size=time.size) * np.where((time > 50) & (time < 80), loud, 1.0)
        speed = 0.02 * sweep + noise
        estimates.append(line_spectra(sweep, speed, speed, RATE, 120.0, frequency, SPECTRA.noise_lines))
    mobility = gated_mobility(stacked(estimates, frequency), MobilitySettings())
    assert np.mean(mobility["gate"].values == Gate.USED) > 0.98
    ratio = np.abs(mobility["command_mobility"] - 0.02) ** 2 / mobility["command_mobility_variance"]
    assert float((ratio / expected_ratio(mobility["degrees_of_freedom"])).mean()) == pytest.approx(1.0, abs=0.15)


def test_good_frequencies_are_seldom_too_coherent_and_never_too_incoherent() -> None:
    result = gated_mobility(synthetic_spectra(np.random.default_rng(6), 100, 30.0), MobilitySettings(error_rate=0.01))
    assert np.mean(result["gate"].values == Gate.TOO_INCOHERENT) == 0
    assert np.mean(result["gate"].values == Gate.TOO_COHERENT) <= 0.01


def test_a_frequency_with_an_impossible_noise_is_too_coherent() -> None:
    spectra = synthetic_spectra(np.random.default_rng(7), 3, 30.0)
    spectra["speed_noise"][1, 100] *= 1e-4
    spectra["speed_power"][1, 100] = np.abs(spectra["cross_speed"][1, 100]) ** 2 * (1 + 1e-5)
    gates = gated_mobility(spectra, MobilitySettings())["gate"].values
    assert gates[1, 100] == Gate.TOO_COHERENT
    assert np.count_nonzero(gates == Gate.TOO_COHERENT) <= 3


def test_frequencies_without_sweep_are_outside() -> None:
    spectra = synthetic_spectra(np.random.default_rng(8), 2, 30.0)
    spectra["sweep_power"][:, 400:] *= 1e-6
    gates = gated_mobility(spectra, MobilitySettings())["gate"].values
    assert np.all(gates[:, 400:] == Gate.OUTSIDE_SWEEP)
    assert np.all(gates[:, :400] != Gate.OUTSIDE_SWEEP)


@pytest.mark.parametrize("stack", [2, 6])
def test_agreeing_windows_are_refused_at_most_at_the_error_rate(stack: int) -> None:
    settings = MobilitySettings(stack_windows=stack, agreement_error_rate=0.05)
    # gated together, as the gate takes each window by itself
    gated = gated_mobility(synthetic_spectra(np.random.default_rng(0), 120 * stack, 30.0), settings)
    groups = (gated.isel(window=slice(first, first + stack)) for first in range(0, 120 * stack, stack))
    refused = sum(bool(stack_windows(group, settings)[1]) for group in groups)
    assert binom.sf(refused - 1, 120, 0.05) > 1e-3


def test_errors_of_a_stack_are_as_large_as_it_says() -> None:
    settings = MobilitySettings(stack_windows=6)
    ratios = []
    for seed in range(60):
        spectra = synthetic_spectra(np.random.default_rng(1000 + seed), 6, 30.0)
        stack = stack_windows(gated_mobility(spectra, settings), settings)[0].isel(stack=0)
        error = stack["command_mobility"].values - np.sqrt(30.0 / PERIODS) * np.exp(1j * FREQUENCY)
        ratios.append(np.mean(np.abs(error) ** 2 / stack["command_mobility_variance"].values))
        assert int(stack["windows"]) >= 2
    assert np.mean(ratios) == pytest.approx(1.0, abs=0.03)


@pytest.mark.parametrize("quieter", [1.0, 4.0])
def test_the_variance_of_a_stack_is_as_well_known_as_it_says(quieter: float) -> None:
    """Also where one window dominates: the sum of squared errors is then no sharper than that window's own."""
    settings = MobilitySettings(stack_windows=6)
    sums = []
    for seed in range(60):
        spectra = synthetic_spectra(np.random.default_rng(2000 + seed), 6, 30.0)
        mobility = gated_mobility(spectra, settings)
        truth = np.sqrt(30.0 / PERIODS) * np.exp(1j * FREQUENCY)
        mobility["command_mobility"][0] = truth + (mobility["command_mobility"][0] - truth) / quieter
        mobility["command_mobility_variance"][0] /= quieter**2
        stack = stack_windows(mobility, settings)[0].isel(stack=0)
        ratio = np.abs(stack["command_mobility"].values - truth) ** 2 / stack["command_mobility_variance"].values
        sums.append(np.mean(ratio / expected_ratio(stack["degrees_of_freedom"].values)))
    assert np.mean(sums) == pytest.approx(1.0, abs=0.02)


def test_a_stack_is_as_coherent_as_its_windows() -> None:
    spectra = synthetic_spectra(np.random.default_rng(16), 6, 30.0)
    mobility = gated_mobility(spectra, MobilitySettings())
    stacks, _ = stack_windows(mobility, MobilitySettings())
    assert float(stacks["coherence"].mean()) == pytest.approx(float(mobility["coherence"].mean()), abs=0.03)


def test_windows_that_share_samples_are_not_stacked_together() -> None:
    spectra = synthetic_spectra(np.random.default_rng(17), 6, 30.0)
    half = np.timedelta64(300, "s")
    spectra = spectra.assign_coords(
        start=("window", START + half * np.arange(6)), end=("window", START + half * np.arange(6) + 2 * half)
    )
    stacks, _ = stack_windows(gated_mobility(spectra, MobilitySettings()), MobilitySettings())
    assert stacks["windows"].values.tolist() == [3]


def test_windows_far_apart_in_depth_are_not_stacked_together() -> None:
    spectra = synthetic_spectra(np.random.default_rng(18), 6, 30.0)
    spectra = spectra.assign_coords(hole_depth=("window", 1500.0 + 30.0 * np.arange(6)))
    stacks, problems = stack_windows(gated_mobility(spectra, MobilitySettings()), MobilitySettings())
    assert stacks["windows"].values.tolist() == [2, 2, 2]
    assert problems == []


def test_a_stack_weighs_by_variance_and_ends_where_windows_disagree() -> None:
    settings = MobilitySettings(stack_windows=6)
    spectra = synthetic_spectra(np.random.default_rng(11), 6, 30.0)
    spectra["cross_speed"][3:] *= np.exp(1j)
    mobility = gated_mobility(spectra, settings)
    stacks, problems = stack_windows(mobility, settings)
    assert stacks["first_window"].values.tolist() == [0, 3]
    assert stacks["last_window"].values.tolist() == [2, 5]
    assert len(problems) == 1
    assert "windows 0 to 2" in problems[0].what
    members = mobility.isel(window=slice(0, 3))
    weight = 1 / members["command_mobility_variance"].values
    mean = np.sum(members["command_mobility"].values * weight, axis=0) / weight.sum(axis=0)
    np.testing.assert_allclose(stacks["command_mobility"][0].values, mean)
    share = weight / weight.sum(axis=0)
    meier = 1 + np.sum(2 * share * (1 - share), axis=0) / FREEDOM
    np.testing.assert_allclose(stacks["command_mobility_variance"][0].values, meier / weight.sum(axis=0))


def test_windows_that_all_disagree_make_no_stack() -> None:
    spectra = synthetic_spectra(np.random.default_rng(12), 4, 100.0, change=1.0)
    stacks, problems = stack_windows(gated_mobility(spectra, MobilitySettings()), MobilitySettings())
    assert stacks.sizes["stack"] == 0
    assert len(problems) == 3


def test_lines_that_a_multisine_leaves_out_are_outside_of_the_sweep() -> None:
    multisine, _ = odd_multisine(np.random.default_rng(6), 1000.0, (0.05, 4.0), 120.0)
    # as recorded, to the last digit
    sweep = np.round(np.tile(multisine.sampled(6000), 5), 1)
    frequency = frequency_grid(120.0, SPECTRA, RATE)
    speed = 1e-3 * sweep + 1e-7 * sweep**2 + 1e-3 * np.random.default_rng(1).normal(size=sweep.size)
    spectra = line_spectra(sweep, speed, np.full(sweep.size, np.nan), RATE, 120.0, frequency, SPECTRA.noise_lines)
    gates = gated_mobility(stacked([spectra], frequency), MobilitySettings())["gate"].values[0]
    excited = np.isin(np.rint(frequency * 120).astype(int), multisine.harmonics)
    assert (gates[~excited] == Gate.OUTSIDE_SWEEP).all()
    assert np.mean(gates[excited] == Gate.USED) > 0.95
