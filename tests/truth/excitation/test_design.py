"""Signals, expected errors and experiment design against closed forms and the time-domain simulator."""

from dataclasses import replace

import numpy as np
import pytest

from benchmarks.excitation import experiment as benchmark_experiment
from benchmarks.excitation import table
from drillid.arrays import Complex, Floats
from drillid.errors import EstimationError, SettingsError
from drillid.excitation.design import (
    Criterion,
    Design,
    Experiment,
    band_information,
    crest_factor,
    criterion_of,
    design,
    half_octaves,
    line_power,
    lines_within,
    power_per_band,
)
from drillid.excitation.detection_lines import distortion, sweep_orders
from drillid.excitation.torques import (
    SWEEP_BANDS,
    Multisine,
    band_limited_noise,
    coloured_noise,
    coloured_noise_density,
    exponential_phase,
    exponential_sweeps,
    linear_sweep,
    odd_multisine,
    powered_sweep,
    white_noise,
)
from drillid.physics.eight_parameters import command_mobility_with_derivatives
from drillid.physics.nonlinear import DriveLimits, NonlinearRig
from drillid.physics.parameters import PARAMETERS
from drillid.physics.responses import laplace
from drillid.simulation.simulate import SAMPLE_INTERVAL, TIME_STEP, simulate
from tests.simulated import RATE, SHALLOW

BAND = (0.05, 4.0)
EDGES = half_octaves(*BAND)
PERIOD = 60.0
NOISE = 20.0
"""N m rms, weak enough for errors in proportion to it."""
TIME = np.arange(0, PERIOD, 0.005)


def experiment(duration: float = PERIOD) -> Experiment:
    frequency = np.geomspace(0.01, 25.0, 400)
    density = coloured_noise_density(frequency, NOISE, 2.0)
    return Experiment(SHALLOW.parameters, SHALLOW.known, frequency, density, duration)


@pytest.mark.parametrize(
    ("torque", "crest"),
    [
        (linear_sweep(TIME, 300.0, (0.05, 4.0), PERIOD), np.sqrt(2)),
        (exponential_sweeps(TIME, 300.0, [(0.05, 4.0)], PERIOD), np.sqrt(2)),
        (powered_sweep(TIME, 300.0, EDGES, np.arange(1.0, EDGES.size), PERIOD), np.sqrt(2)),
        (exponential_sweeps(TIME, 300.0, SWEEP_BANDS, PERIOD), np.sqrt(6)),
        (np.where(np.sin(2 * np.pi * 3 * TIME / PERIOD) >= 0, 2.0, -2.0), 1.0),
        (Multisine(PERIOD, np.arange(1, 6), np.ones(5), np.zeros(5)).sampled(1000), np.sqrt(10)),
    ],
)
def test_crest_factor_is_that_of_the_closed_form(torque: Floats, crest: float) -> None:
    """√2 of a sweep; √6 where three sweeps peak together; √(2n) of n cosines in phase."""
    assert crest_factor(torque) == pytest.approx(crest, rel=0.03)


@pytest.mark.parametrize("samples", [1000, 1001])
def test_power_of_lines_adds_to_the_mean_square(samples: int) -> None:
    torque = 3.0 + np.random.default_rng(1).standard_normal(samples)
    frequency, power = line_power(torque, 50.0)
    assert power.sum() == pytest.approx(np.mean(torque**2), rel=1e-12)
    edges = np.array([0.0, 3.0, 11.0, 25.1])
    bands = power_per_band(torque, 50.0, edges)
    assert bands.sum() == pytest.approx(power.sum(), rel=1e-12)
    passed = np.fft.rfft(torque) * ((frequency >= 3.0) & (frequency < 11.0))
    assert bands[1] == pytest.approx(np.mean(np.fft.irfft(passed, samples) ** 2), rel=1e-9)


def test_powered_sweep_has_the_given_power_per_band() -> None:
    wanted = np.array([4.0, 0.0, 1.0, 3.0, 2.0])
    edges = np.array([0.2, 0.4, 0.8, 1.2, 2.0, 4.0])
    torque = powered_sweep(np.arange(0, 400.0, 0.005), 100.0, edges, wanted, 400.0)
    share = power_per_band(torque, 200.0, edges) / np.mean(torque**2)
    np.testing.assert_allclose(share, wanted / wanted.sum(), atol=0.02)
    with pytest.raises(SettingsError, match="some power"):
        powered_sweep(TIME, 1.0, edges, np.zeros(5), 400.0)


def test_linear_sweep_has_equal_power_per_hertz_and_exponential_per_octave() -> None:
    time = np.arange(0, 400.0, 0.005)
    linear = power_per_band(linear_sweep(time, 100.0, (0.5, 4.5), 400.0), 200.0, np.arange(1.0, 4.6, 0.5))
    assert np.ptp(linear) < 0.08 * linear.mean()
    octaves = power_per_band(
        exponential_sweeps(time, 100.0, [(0.25, 8.0)], 400.0), 200.0, np.array([0.5, 1.0, 2.0, 4.0])
    )
    assert np.ptp(octaves) < 0.08 * octaves.mean()


def test_odd_multisine_omits_even_lines_and_one_odd_line_of_each_group() -> None:
    multisine, omitted = odd_multisine(np.random.default_rng(4), 250.0, BAND, 100.0)
    torque = multisine.torque(20000, 0.005)
    _, power = line_power(torque, 200.0)
    assert np.mean(torque**2) == pytest.approx(250.0**2, rel=1e-9)
    assert np.all(power[multisine.harmonics] > 1.0)
    assert power[::2].max() < 1e-15
    assert power[omitted].max() < 1e-15
    assert np.all(omitted % 2 == 1)
    assert np.all(np.diff(omitted) <= 14)


@pytest.mark.parametrize(("band", "first", "last"), [((0.14, 4.0), 7, 199), ((0.1, 0.58), 5, 29)])
def test_lines_at_the_edges_of_a_band_belong_to_it(band: tuple[float, float], first: int, last: int) -> None:
    """0.14 Hz × 50 s is a little more than 7 in floating point, 0.58 Hz × 50 s a little less than 29."""
    multisine, omitted = odd_multisine(np.random.default_rng(4), 250.0, band, 50.0)
    odd = np.union1d(multisine.harmonics, omitted)
    assert (odd[0], odd[-1]) == (first, last)
    equal = Design(half_octaves(*band), np.ones(half_octaves(*band).size - 1), 0.0, 0.0).multisine(50.0)
    assert {first, last} <= set(equal.harmonics.tolist())


def test_phases_of_low_crest_keep_the_spectrum_and_fall_well_below_random_ones() -> None:
    multisine, _ = odd_multisine(np.random.default_rng(4), 250.0, BAND, 100.0)
    low = multisine.with_low_crest()
    np.testing.assert_array_equal(low.amplitudes, multisine.amplitudes)
    assert low.rms == pytest.approx(250.0)
    assert crest_factor(multisine.sampled(20000)) > 2.5
    assert crest_factor(low.sampled(20000)) < 1.75


def test_noises_have_their_rms_and_band() -> None:
    generator = np.random.default_rng(8)
    assert white_noise(generator, 100000, 40.0).std() == pytest.approx(40.0, rel=0.02)
    limited = band_limited_noise(generator, 100000, 0.01, 40.0, (1.0, 5.0))
    assert limited.std() == pytest.approx(40.0, rel=0.05)
    power = power_per_band(limited, 100.0, np.array([0.0, 0.99, 2.0, 3.0, 4.0, 5.001, 50.1]))
    assert power[[0, -1]].max() < 1e-20
    np.testing.assert_allclose(power[1:-1], 400.0, rtol=0.15)


def test_density_of_coloured_noise_is_that_of_its_realisations() -> None:
    noise = coloured_noise(np.random.default_rng(3), 2**19, 0.005, 400.0, 2.0)
    edges = np.geomspace(0.05, 10.0, 8)
    measured = power_per_band(noise, 200.0, edges)
    for lower, upper, power in zip(edges[:-1], edges[1:], measured, strict=True):
        frequency = np.linspace(lower, upper, 200)
        expected = np.trapezoid(coloured_noise_density(frequency, 400.0, 2.0), frequency)
        assert power == pytest.approx(expected, rel=0.12)


WINDOWS = 60


@pytest.fixture(scope="module")
def windows() -> tuple[Complex, Complex]:
    """Spectra of one period of sweep and of many of speed, at 50 Hz, of one long run of the time-domain simulator.

    Differences are taken before windows are cut, so that the strong slow noise does not leak into fast lines; the
    bound is that of an estimate without leakage.
    """
    steps = round((WINDOWS + 2) * PERIOD / TIME_STEP)
    time = np.arange(steps) * TIME_STEP
    noise = coloured_noise(np.random.default_rng(11), steps, TIME_STEP, NOISE, 2.0)
    sweep = exponential_sweeps(time, 150.0, SWEEP_BANDS, PERIOD)
    result = simulate(SHALLOW.system, sweep, np.full(steps, 10.5), 1500.0 + noise, mean_bit_torque=1500.0)
    samples = round(PERIOD * RATE)
    every = round(SAMPLE_INTERVAL / TIME_STEP)
    # one difference makes the noise nearly white
    speeds, sweeps = (np.diff(series, prepend=series[0]) for series in (result.speed, sweep[::every]))
    speed_lines = np.fft.rfft(speeds[2 * samples :].reshape(WINDOWS, samples))
    return np.fft.rfft(sweeps[2 * samples : 3 * samples]), speed_lines


def sweep_lines() -> tuple[Floats, Floats]:
    period = exponential_sweeps(np.arange(0, PERIOD, SAMPLE_INTERVAL), 150.0, SWEEP_BANDS, PERIOD)
    return lines_within(period, RATE, BAND)


def test_bound_is_the_spread_of_estimates_from_simulated_windows(windows: tuple[Complex, Complex]) -> None:
    """Maximum-likelihood estimates of 60 windows scatter according to the bound, each parameter and all together."""
    sweep, speeds = windows
    frequency, power = sweep_lines()
    lines = np.rint(frequency * PERIOD).astype(int)
    mobility = speeds[:, lines] / sweep[lines]
    case = experiment()
    model, slopes = command_mobility_with_derivatives(case.parameters, case.equipment, laplace(frequency))
    weight = 2 * PERIOD * power / case.speed_noise(frequency)
    covariance = case.covariance(frequency, power)
    score = ((mobility - model) * weight) @ np.conj(slopes).T
    estimates = score.real @ covariance
    spread = estimates - estimates.mean(axis=0)
    ratio = spread.std(axis=0, ddof=1) / np.sqrt(np.diag(covariance))
    per_parameter = 1 / np.sqrt(2 * (WINDOWS - 1))
    assert np.all(np.abs(ratio - 1) < 3.5 * per_parameter), dict(zip(PARAMETERS, ratio, strict=True))
    joint = np.einsum("wi,ij,wj->", spread, np.linalg.inv(covariance), spread) / (8 * (WINDOWS - 1))
    assert joint == pytest.approx(1.0, abs=3.5 * np.sqrt(2 / (8 * (WINDOWS - 1))))


def test_expected_coherence_is_the_simulated_one(windows: tuple[Complex, Complex]) -> None:
    _, speeds = windows
    frequency, power = sweep_lines()
    lines = np.rint(frequency * PERIOD).astype(int)
    spectra = speeds[:, lines]
    coherence = np.abs(spectra.mean(axis=0)) ** 2 / np.mean(np.abs(spectra) ** 2, axis=0)
    expected = experiment().coherence(frequency, power * PERIOD)
    ratio = np.log((1 - coherence) / (1 - expected))
    assert np.abs(np.mean(ratio)) < 0.05
    assert np.std(ratio) < 2 / np.sqrt(WINDOWS)


@pytest.mark.parametrize("criterion", ["errors", "volume"])
@pytest.mark.parametrize("chosen", [("length", "polar_moment"), ("inertia_bha",), tuple(PARAMETERS)])
def test_design_beats_the_sweep_and_no_shift_of_power_improves_it(
    chosen: tuple[str, ...], criterion: Criterion
) -> None:
    case = experiment()
    best = design(case, 180.0, chosen, criterion=criterion)
    assert best.power.sum() == pytest.approx(180.0**2)
    assert best.distance < 2e-6
    exponential = np.full(best.power.size, 180.0**2 / best.power.size)
    plain = criterion_of(case, best.edges, exponential, chosen, criterion)
    assert best.criterion < plain
    generator = np.random.default_rng(2)
    for _ in range(20):
        other = generator.dirichlet(np.full(best.power.size, 0.5)) * 180.0**2
        shifted = 0.95 * best.power + 0.05 * other
        assert criterion_of(case, best.edges, shifted, chosen, criterion) >= best.criterion - 1e-9 * abs(best.criterion)


def test_signals_of_a_design_have_its_expected_errors() -> None:
    """The multisine and the sweep of a design have the expected error of the length."""
    case = experiment(200.0)
    best = design(case, 180.0, ("length",))
    multisine = best.multisine(200.0)
    torques = {
        "multisine": multisine.sampled(10000),
        "sweep": best.sweep(np.arange(10000) / 50.0, 200.0),
    }
    for name, torque in torques.items():
        error = case.standard_errors(*lines_within(torque, 50.0, (0.03, 6.0)))[2] / case.parameters[2]
        assert error == pytest.approx(np.sqrt(best.criterion), rel=0.15), name
    assert crest_factor(torques["multisine"]) < 2.0
    peaked = design(case, 180.0 * np.sqrt(2), ("length",), limit="peak")
    np.testing.assert_allclose(peaked.power, best.power, rtol=1e-9)
    assert np.max(np.abs(torques["sweep"])) <= 180.0 * np.sqrt(2) * (1 + 1e-12)


@pytest.mark.parametrize("name", ["kappa", "delay", "damping_bha"])
@pytest.mark.parametrize("prior", [None, np.array([50.0, np.nan, 1.0, np.nan, 1e-3, np.nan, 5.0, np.nan])])
def test_errors_of_a_parameter_that_is_zero_are_the_limit_of_small_ones(name: str, prior: Floats | None) -> None:
    row = list(PARAMETERS).index(name)
    limit, zero = (
        replace(experiment(), parameters=np.where(np.arange(8) == row, value, SHALLOW.parameters), prior_error=prior)
        for value in (1e-7 * SHALLOW.parameters[row], 0.0)
    )
    lines = sweep_lines()
    np.testing.assert_allclose(zero.standard_errors(*lines), limit.standard_errors(*lines), rtol=1e-4)
    best = design(zero, 180.0, ("length", name))
    assert best.distance < 2e-6
    relative = (zero.standard_errors(*_lines_of(best)) / zero.scale)[[2, row]]
    assert np.mean(relative**2) == pytest.approx(best.criterion, rel=1e-6)


def _lines_of(best: Design) -> tuple[Floats, Floats]:
    """Forty lines in the middle of equal parts of each band, of equal power."""
    share = (np.arange(40) + 0.5) / 40
    frequency = best.edges[:-1, None] + np.diff(best.edges)[:, None] * share
    return frequency.ravel(), np.repeat(best.power / 40, 40)


def test_prior_and_power_lower_the_bound_as_they_must() -> None:
    """Four times the power or time halves every error; prior knowledge of a parameter bounds its error."""
    case = experiment()
    frequency, power = lines_within(
        exponential_sweeps(np.arange(0, PERIOD, 0.02), 150.0, SWEEP_BANDS, PERIOD), 50.0, BAND
    )
    error = case.standard_errors(frequency, power)
    np.testing.assert_allclose(case.standard_errors(frequency, 4 * power), error / 2, rtol=1e-6)
    np.testing.assert_allclose(
        replace(case, duration=4 * PERIOD).standard_errors(frequency, power), error / 2, rtol=1e-6
    )
    prior = np.full(8, np.nan)
    prior[7] = error[7] / 3
    informed = replace(case, prior_error=prior).standard_errors(frequency, power)
    assert informed[7] == pytest.approx(error[7] / np.sqrt(10), rel=1e-6)
    assert np.all(informed <= error * (1 + 1e-9))
    with pytest.raises(EstimationError, match="does not determine"):
        case.standard_errors(frequency[:2], power[:2])
    with pytest.raises(SettingsError, match="weight"):
        design(case, 100.0, ("weight",))
    assert band_information(case, EDGES).shape == (EDGES.size - 1, 8, 8)


def response(rig: NonlinearRig, torque: Floats) -> Floats:
    """Speed at 50 Hz to periods of a torque, with little noise."""
    noise = coloured_noise(np.random.default_rng(9), torque.size, TIME_STEP, 1.0, 2.0)
    result = simulate(rig, torque, np.full(torque.size, 10.5), 1500.0 + noise, mean_bit_torque=1500.0)
    return result.speed


def test_torque_limit_shows_as_distortion_and_a_linear_rig_shows_none() -> None:
    """A limit symmetric to the mean torque distorts in odd order; one above the mean alone in even order too."""
    multisine, _ = odd_multisine(np.random.default_rng(6), 200.0, BAND, 40.0)
    torque = np.tile(multisine.sampled(round(40.0 / TIME_STEP)), 5)
    edges = np.array([0.1, 1.0, 4.0])
    kept = round(40.0 * RATE)
    levels = {}
    for name, limit in (("linear", np.inf), ("limited", 2050.0)):
        rig = NonlinearRig(SHALLOW.system, limits=DriveLimits(torque=limit))
        speed = response(rig, torque)[kept:]
        levels[name] = distortion(speed, torque[:: round(SAMPLE_INTERVAL / TIME_STEP)][kept:], RATE, 40.0, edges)
    linear, limited = levels["linear"], levels["limited"]
    for level in (linear.even, linear.odd):
        np.testing.assert_allclose(level, linear.noise, rtol=0.5)
    assert np.all(limited.even > 5 * limited.noise)
    assert np.all(limited.odd > 5 * limited.noise)
    assert np.all(linear.response > 20 * linear.noise)
    # a record of whole 10 N m has a little of every line
    coarse = np.round(torque[:: round(SAMPLE_INTERVAL / TIME_STEP)][kept:] / 10) * 10
    np.testing.assert_allclose(distortion(speed, coarse, RATE, 40.0, edges).odd, limited.odd)
    with pytest.raises(EstimationError, match="periods"):
        distortion(speed[:kept], torque, RATE, 40.0, edges)


def test_the_mean_speed_is_no_distortion_in_a_band_from_zero() -> None:
    time = np.arange(0, 80.0, 1 / RATE)
    torque = 200.0 * np.cos(2 * np.pi * 0.125 * time)
    speed = 12.0 + 0.02 * np.cos(2 * np.pi * 0.125 * time + 1.0) + 1e-3 * np.cos(2 * np.pi * 0.25 * time)
    levels = distortion(speed, torque, RATE, 40.0, np.array([0.0, 1.0]))
    assert levels.response[0] == pytest.approx(0.02 / np.sqrt(2))
    # of the even lines up to 1 Hz, one is distorted
    assert levels.even[0] == pytest.approx(1e-3 / np.sqrt(2 * 20), rel=0.03)
    assert levels.odd[0] < 1e-12


def test_orders_of_a_sweep_show_the_torque_limit_in_the_simulator() -> None:
    """A limit of the total torque causes a third order in the speed that a linear rig does not have."""
    steps = round(80.0 / TIME_STEP)
    time = np.arange(steps) * TIME_STEP
    kept = slice(round(40.0 * RATE), None)
    phase = exponential_phase(time[:: round(SAMPLE_INTERVAL / TIME_STEP)], (0.5, 4.0), 40.0)[kept]
    amplitudes = {}
    for name, limit in (("linear", np.inf), ("limited", 1650.0)):
        rig = NonlinearRig(SHALLOW.system, limits=DriveLimits(torque=limit))
        speed = response(rig, exponential_sweeps(time, 300.0, [(0.5, 4.0)], 40.0))[kept]
        _, amplitude, _ = sweep_orders(speed, phase, (1, 2, 3), RATE, sections=24)
        amplitudes[name] = amplitude / amplitude[0]
    assert np.all(amplitudes["limited"][2, 4:-4] > 3 * amplitudes["linear"][2, 4:-4])


def test_orders_of_a_static_curve_are_its_chebyshev_coefficients_and_images_fold() -> None:
    """The curve x + 0.1 x² + 0.05 x³ of a cosine gives 1 + 3·0.05/4, 0.1/2, 0.05/4; the third order folds."""
    phase = exponential_phase(np.arange(0, 400.0, 0.1), (0.2, 4.0), 400.0)
    wave = np.cos(phase)
    speed = 10.0 + wave + 0.1 * wave**2 + 0.05 * wave**3
    speed = speed + 0.002 * np.random.default_rng(7).standard_normal(speed.size)
    frequency, amplitude, error = sweep_orders(speed, phase, (1, 2, 3, 4), 10.0)
    expected = np.array([1.0375, 0.05, 0.0125, 0.0])
    assert 3 * frequency[-1] > 5.0
    assert np.all(np.diff(frequency) > 0)
    assert np.all(np.abs(amplitude - expected[:, None])[:3] < 5 * error[:3])
    assert np.all(amplitude[3] < 5 * error[3])
    assert np.all(error < 5e-4)


def test_white_noise_needs_several_times_the_sweeps_amplitude_for_their_coherence() -> None:
    """The sweeps need their own rms; noise of the same coherence in the middle of the band more, in peak far more."""
    rows = {row.name: row for row in table(benchmark_experiment())}
    sweeps, white = rows["three exponential sweeps"], rows["white noise to 25 Hz"]
    assert sweeps.rms_everywhere == pytest.approx(500 * np.sqrt(1.5), rel=0.01)
    assert 3 < white.rms_middle / sweeps.rms_middle < 4.5
    assert white.rms_middle * white.crest > 5 * sweeps.rms_middle * sweeps.crest
    assert np.all(white.errors > 1.25 * sweeps.errors)
    in_band = rows["noise, 0.05 to 4 Hz"]
    # white noise spends its power up to half the sample rate
    assert white.rms_middle / in_band.rms_middle == pytest.approx(np.sqrt(25.0 / 3.95), rel=0.1)
    low = rows["odd multisine, low crest"]
    assert low.rms_middle * low.crest < 0.65 * sweeps.rms_middle * sweeps.crest
