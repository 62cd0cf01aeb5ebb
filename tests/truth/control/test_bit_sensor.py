"""The virtual bit sensor against the bit of the time-domain simulator, whose torque is coloured noise."""

from dataclasses import replace

import numpy as np
import pytest

from drillid.control.bit_sensor import NoiseLevels, command_of_control, sense_bit, severity
from drillid.errors import EstimationError, SettingsError
from drillid.excitation.torques import coloured_noise, exponential_sweeps
from drillid.physics.equipment import Bit, Controller, DrillingSystem, Section, TopDrive, polar_moment
from drillid.simulation.simulate import SAMPLE_INTERVAL, TIME_STEP, Simulation, simulate

RATE = 1 / SAMPLE_INTERVAL
LEAD_IN = round(120.0 * RATE)
MEAN_TORQUE = 4000.0
SYSTEM = DrillingSystem(
    TopDrive(1105.0, 0.04, Controller(1500.0, 800.0)),
    (
        Section(3100.0, polar_moment(0.1397, 0.1214), kappa=200.0, delta=2.5e8),
        Section(100.0, polar_moment(0.1651, 0.0714), kappa=200.0, delta=2.5e8),
    ),
    Bit(40.0, 40.0),
)
NOISE = NoiseLevels(bit_torque=500.0, bandwidth=2.0, speed=0.005, torque=20.0)


def drilling(seed: int) -> Simulation:
    steps = round(420.0 / TIME_STEP)
    noise = coloured_noise(np.random.default_rng(seed), steps, TIME_STEP, NOISE.bit_torque, NOISE.bandwidth)
    sweep = exponential_sweeps(np.arange(steps) * TIME_STEP, 530.0)
    return simulate(SYSTEM, sweep, np.full(steps, 10.5), MEAN_TORQUE + noise, mean_bit_torque=MEAN_TORQUE)


def log_of(drilled: Simulation, seed: int) -> tuple[np.ndarray, np.ndarray]:
    """Torque command and speed as logged, with the errors stated in NOISE."""
    generator = np.random.default_rng(seed)
    samples = drilled.time.size - LEAD_IN
    command = drilled.torque_command[LEAD_IN:] + NOISE.torque * generator.standard_normal(samples)
    return command, drilled.speed[LEAD_IN:] + NOISE.speed * generator.standard_normal(samples)


@pytest.fixture(scope="module")
def drilled() -> Simulation:
    return drilling(1)


@pytest.fixture(scope="module")
def logged(drilled: Simulation) -> tuple[np.ndarray, np.ndarray]:
    return log_of(drilled, 2)


def test_bit_speed_and_torque_lie_within_their_bands_at_the_stated_rate(
    drilled: Simulation, logged: tuple[np.ndarray, np.ndarray]
) -> None:
    motion = sense_bit(SYSTEM, *logged, RATE, NOISE)
    for estimate, truth, error in (
        (motion.speed, drilled.bit_speed, motion.speed_error),
        (motion.torque, drilled.torque_on_bit, motion.torque_error),
    ):
        misses = (estimate - truth[LEAD_IN:])[motion.inner]
        assert np.std(misses) == pytest.approx(error, rel=0.05)
        assert abs(misses.mean()) < 0.1 * error
        assert 0.91 < np.mean(np.abs(misses) < 1.96 * error) < 0.98
    assert motion.speed_error < 0.1 * np.std(drilled.bit_speed)


def test_bit_speed_follows_the_truth_where_it_is_observed(
    drilled: Simulation, logged: tuple[np.ndarray, np.ndarray]
) -> None:
    from scipy.signal import csd, welch

    motion = sense_bit(SYSTEM, *logged, RATE, NOISE)
    pair = motion.speed[motion.inner], drilled.bit_speed[LEAD_IN:][motion.inner]
    frequency, cross = csd(*pair, RATE, nperseg=1000)
    coherence = np.abs(cross) ** 2 / (welch(pair[0], RATE, nperseg=1000)[1] * welch(pair[1], RATE, nperseg=1000)[1])
    share = np.interp(frequency, motion.frequency, motion.observed_share)
    inside = (frequency > 0.1) & (frequency < 3.0)
    assert np.corrcoef(*pair)[0, 1] > 0.99
    assert np.min(coherence[inside & (share > 0.98)]) > 0.9
    # Wiener: coherence of estimate and truth is the share of the variance that the data explain
    assert np.mean(coherence[(frequency > 2.5) & (frequency < 4.5)]) == pytest.approx(
        np.mean(share[(frequency > 2.5) & (frequency < 4.5)]), abs=0.1
    )


def test_severity_index_lies_within_its_interval_at_the_stated_rate() -> None:
    """Nine spans of each of five windows; a correct sensor would miss more often with probability 0.001."""
    from scipy.stats import binom

    inside, pulls = [], []
    for seed in range(5):
        simulated = drilling(10 + seed)
        motion = sense_bit(SYSTEM, *log_of(simulated, 20 + seed), RATE, NOISE)
        indices = severity(motion, 30.0)
        assert len(indices) == 9
        blocks = simulated.bit_speed[LEAD_IN:][motion.inner][: len(indices) * 1500].reshape(-1, 1500)
        true = np.ptp(blocks, axis=1) / (2 * blocks.mean(axis=1))
        for estimate, index in zip(indices, true, strict=True):
            inside.append(estimate.interval[0] < index < estimate.interval[1])
            pulls.append((estimate.index - index) / estimate.error)
            assert estimate.error < 0.05 * index
    assert len(inside) - sum(inside) <= binom.ppf(0.999, len(inside), 0.05)
    assert 0.75 < np.sqrt(np.mean(np.square(pulls))) < 1.35


def test_estimates_are_as_good_at_the_ends_of_the_inner_samples(
    drilled: Simulation, logged: tuple[np.ndarray, np.ndarray]
) -> None:
    motion = sense_bit(SYSTEM, *logged, RATE, NOISE)
    misses = (motion.speed - drilled.bit_speed[LEAD_IN:])[motion.inner]
    for end in (misses[:200], misses[-200:]):
        assert np.sqrt(np.mean(end**2)) < 1.5 * motion.speed_error


def test_the_command_is_recovered_from_sweep_and_controller(logged: tuple[np.ndarray, np.ndarray]) -> None:
    command, speed = logged
    sweep = exponential_sweeps(np.arange(speed.size) * SAMPLE_INTERVAL, 530.0)
    recovered = command_of_control(SYSTEM.top_drive.controller, sweep, speed, RATE)
    inner = slice(3000, -3000)
    misses = (recovered - command)[inner]
    assert np.std(misses) < 0.05 * np.std(command[inner])


def test_a_wrong_model_misses_by_more_than_its_band_and_draws_of_the_model_widen_it(
    drilled: Simulation, logged: tuple[np.ndarray, np.ndarray]
) -> None:
    longer = replace(SYSTEM, string=(replace(SYSTEM.string[0], length=3255.0), SYSTEM.string[1]))
    motion = sense_bit(longer, *logged, RATE, NOISE)
    misses = (motion.speed - drilled.bit_speed[LEAD_IN:])[motion.inner]
    assert np.std(misses) > 1.5 * motion.speed_error
    lengths = 3100.0 * (1 + 0.05 * np.random.default_rng(3).standard_normal((8, 1)))
    uncertain = replace(SYSTEM, string=(replace(SYSTEM.string[0], length=lengths), SYSTEM.string[1]))
    widened = sense_bit(uncertain, *logged, RATE, NOISE)
    assert widened.speed_error > 1.5 * motion.speed_error
    assert severity(widened, 30.0)[0].error > 1.5 * severity(motion, 30.0)[0].error


def test_noisier_logs_have_larger_errors_and_smaller_observed_shares(logged: tuple[np.ndarray, np.ndarray]) -> None:
    clean, noisy = (sense_bit(SYSTEM, *logged, RATE, replace(NOISE, speed=size)) for size in (0.005, 0.1))
    assert noisy.speed_error > 2 * clean.speed_error
    assert np.all(noisy.observed_share <= clean.observed_share + 1e-9)
    assert np.all((clean.observed_share >= 0) & (clean.observed_share <= 1))


@pytest.mark.parametrize("fault", ["gap", "short", "unequal"])
def test_a_window_that_cannot_be_sensed_is_refused(fault: str, logged: tuple[np.ndarray, np.ndarray]) -> None:
    command, speed = (series.copy() for series in logged)
    if fault == "gap":
        speed[100] = np.nan
    elif fault == "short":
        command, speed = command[:200], speed[:200]
    else:
        command = command[1:]
    with pytest.raises(EstimationError):
        sense_bit(SYSTEM, command, speed, RATE, NOISE)


def test_noise_without_size_and_spans_longer_than_the_window_are_refused(
    logged: tuple[np.ndarray, np.ndarray],
) -> None:
    with pytest.raises(SettingsError):
        replace(NOISE, speed=0.0)
    motion = sense_bit(SYSTEM, *logged, RATE, NOISE)
    with pytest.raises(EstimationError):
        severity(motion, 1e4)
