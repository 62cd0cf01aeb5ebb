"""Recorded responses: linear transfers against the time-domain simulator and its recorder."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from drillid.arrays import Floats
from drillid.errors import SettingsError
from drillid.physics.dual_numbers import derivatives
from drillid.physics.equipment import Controller, DrillingSystem, ImpedanceMatching
from drillid.physics.nonlinear import NonlinearRig, SpeedSensor
from drillid.physics.responses import command_mobility, laplace
from drillid.physics.sensor import Recording, recorded, sensed
from drillid.simulation.recorder import Recorder
from drillid.simulation.simulate import SAMPLE_INTERVAL, TIME_STEP, Simulation, simulate
from tests.truth.rigs import (
    CONTROLLER,
    FREQUENCIES,
    PERIOD,
    PIPE,
    SPEED,
    SYSTEM,
    TOP_DRIVE,
    lines_of,
    multisine,
)

S = laplace(FREQUENCIES)
SWEEP = multisine(round(PERIOD / TIME_STEP))
LARGEST_ERROR = 3e-3
MATCHED = replace(CONTROLLER, matching=ImpedanceMatching(0.5 / PIPE.characteristic_admittance, 1100.0, 0.05, 5.0))


def vibrated(rig: DrillingSystem | NonlinearRig, periods: int = 5, amplitude: float = 1.0) -> Simulation:
    """Periods of the multisine, every step recorded, the last of them settled."""
    steady = np.ones(periods * SWEEP.size)
    return simulate(
        rig,
        amplitude * np.tile(SWEEP, periods),
        SPEED * steady,
        4e3 * steady,
        mean_bit_torque=4e3,
        sample_interval=TIME_STEP,
    )


def row_mobility(speed: Floats, sweep: Recorder, periods: int = 5) -> np.ndarray:
    """Rows of speed, of the last period, per rows of the sweep."""
    samples = round(PERIOD / SAMPLE_INTERVAL)
    return lines_of(speed, samples) / lines_of(sweep.record(np.tile(SWEEP, periods), TIME_STEP), samples)


def worst(measured: np.ndarray, expected: np.ndarray) -> float:
    return float(np.max(np.abs(measured / expected - 1)))


@pytest.fixture(scope="module")
def plain() -> Simulation:
    return vibrated(SYSTEM)


@pytest.mark.parametrize(
    "size",
    [
        {"scale": 0.93},
        {"scale": -1.0},
        {"clock_offset": 0.031},
        {"filter_frequency": 4.0, "filter_order": 1},
        {"filter_frequency": 4.0, "filter_order": 2},
        {"filter_frequency": 6.0, "filter_order": 5},
        {"scale": 1.05, "clock_offset": -0.012, "filter_frequency": 8.0, "filter_order": 4},
    ],
    ids=["scale", "sign", "offset", "first order", "second order", "fifth order", "all"],
)
def test_recorded_mobility_is_the_true_one_times_the_transfer_of_its_channel(
    size: dict[str, Any], plain: Simulation
) -> None:
    rows = Recorder(SAMPLE_INTERVAL, **size).record(plain.speed, TIME_STEP)
    measured = row_mobility(rows, Recorder(SAMPLE_INTERVAL))
    truth = command_mobility(SYSTEM, S)
    recording = Recording(**size)
    assert worst(measured, recorded(truth, S, recording)) < LARGEST_ERROR
    assert worst(measured, truth) > 10 * LARGEST_ERROR


def test_a_transfer_common_to_both_channels_cancels(plain: Simulation) -> None:
    """Equal filters and clocks leave the mobility unchanged; different ones change it by their ratio."""
    filtered = Recorder(SAMPLE_INTERVAL, filter_frequency=5.0, clock_offset=0.02)
    later = replace(filtered, clock_offset=0.05)
    measured = row_mobility(later.record(plain.speed, TIME_STEP), filtered)
    channels = [Recording(clock_offset=offset, filter_frequency=5.0) for offset in (0.05, 0.02)]
    truth = command_mobility(SYSTEM, S)
    assert worst(measured, recorded(truth, S, *channels)) < LARGEST_ERROR
    np.testing.assert_allclose(recorded(truth, S, channels[0], channels[0]), truth, rtol=1e-14)


@pytest.mark.parametrize("controller", [CONTROLLER, MATCHED], ids=["PI", "impedance matching"])
def test_a_scale_of_the_control_sensor_changes_the_rig(controller: Controller) -> None:
    system = replace(SYSTEM, top_drive=replace(TOP_DRIVE, controller=controller))
    result = vibrated(NonlinearRig(system, sensor=SpeedSensor(scale=1.1)))
    measured = [
        row_mobility(speed[:: round(SAMPLE_INTERVAL / TIME_STEP)], Recorder(SAMPLE_INTERVAL))
        for speed in (result.speed, result.speed_reading)
    ]
    assert np.mean(result.speed) == pytest.approx(SPEED / 1.1, rel=1e-3)
    rig = command_mobility(sensed(system, 1.1), S)
    assert worst(measured[0], rig) < LARGEST_ERROR
    assert worst(measured[1], recorded(rig, S, Recording(1.1))) < LARGEST_ERROR
    # a scale of the record alone is another effect
    assert worst(measured[1], recorded(command_mobility(system, S), S, Recording(1.1))) > 10 * LARGEST_ERROR


def test_jitter_of_the_delay_acts_by_its_mean() -> None:
    """At 12 ms and 5 Hz the mean reduces the torque by 7 %; the random part falls with the number of periods."""
    shaken = replace(SYSTEM, top_drive=replace(TOP_DRIVE, delay_jitter=0.012))
    periods = 15
    result = vibrated(shaken, periods, 20.0)
    every, samples = round(SAMPLE_INTERVAL / TIME_STEP), round(PERIOD / SAMPLE_INTERVAL)
    speeds = result.speed[::every].reshape(periods, samples)[4:]
    lines = np.array([lines_of(speed, samples) for speed in speeds]) / lines_of(20.0 * SWEEP[::every], samples)
    measured, error = lines.mean(axis=0), lines.std(axis=0, ddof=1) / np.sqrt(len(lines))
    high = FREQUENCIES > 3
    gain = np.mean((measured / command_mobility(SYSTEM, S))[high])
    gain_error = np.mean((error / np.abs(command_mobility(SYSTEM, S)))[high]) / np.sqrt(high.sum())
    expected = np.mean((command_mobility(shaken, S) / command_mobility(SYSTEM, S))[high])
    assert abs(gain - expected) < 4 * gain_error + 1e-3
    assert abs(gain - 1) > 4 * (4 * gain_error + 1e-3)


def test_jitter_of_time_stamps_acts_by_its_mean() -> None:
    """Rows of one tone at jittering times; the mean over 40 000 rows."""
    generator = np.random.default_rng(3)
    nominal = SAMPLE_INTERVAL * np.arange(40000)
    rms, frequency = 0.02, 4.0
    rows = np.exp(2j * np.pi * frequency * (nominal - rms * generator.standard_normal(nominal.size)))
    measured = np.mean(rows * np.exp(-2j * np.pi * frequency * nominal))
    transfer = Recording(clock_jitter=rms).transfer(laplace(np.array([frequency])))[0]
    assert abs(measured - transfer) < 4 / np.sqrt(nominal.size)
    assert abs(transfer - 1) > 0.1


def test_a_signal_that_is_renewed_at_intervals_is_late_by_its_age() -> None:
    """Rows of one tone, each of the last sample before it; intervals and rows have no common multiple."""
    rows = SAMPLE_INTERVAL * np.arange(40000)
    interval, frequency = 0.1 * np.sqrt(2), 4.0
    samples = np.exp(2j * np.pi * frequency * np.floor(rows / interval) * interval)
    measured = np.mean(samples * np.exp(-2j * np.pi * frequency * rows))
    transfer = Recording(renewal=interval).transfer(laplace(np.array([frequency])))[0]
    assert abs(measured - transfer) < 1e-3
    assert abs(transfer) < 0.6


def test_no_size_is_no_effect() -> None:
    assert np.array_equal(Recording().transfer(S), np.ones(S.size))
    truth = command_mobility(SYSTEM, S)
    np.testing.assert_allclose(command_mobility(sensed(SYSTEM, 1.0), S), truth, rtol=1e-15)


def test_derivatives_are_exact() -> None:
    """Central differences, good to about 1e-8, for every parameter of the transfer and the sensor scale."""
    point = np.array([1.02, 0.03, 0.02, 6.0, 0.05, 1.1])

    def response(scale: Any, offset: Any, jitter: Any, corner: Any, renewal: Any, sensor: Any) -> Any:
        recording = Recording(scale, offset, jitter, corner, 3, renewal)
        return recorded(command_mobility(sensed(SYSTEM, sensor), S), S, recording)

    value, slopes = derivatives(response, point)
    assert slopes.shape == (point.size, FREQUENCIES.size)
    for row, size in enumerate(point):
        ahead, behind = point.copy(), point.copy()
        ahead[row] += 1e-5 * size
        behind[row] -= 1e-5 * size
        difference = (response(*ahead) - response(*behind)) / (2e-5 * size)
        np.testing.assert_allclose(slopes[row], difference, rtol=1e-6, atol=1e-8 * np.max(np.abs(value)) / size)


def test_one_description_covers_many_records() -> None:
    several = Recording(
        clock_offset=np.array([[0.0], [0.01], [0.02]]), filter_frequency=np.array([[5.0], [7.0], [9.0]])
    )
    single = Recording(clock_offset=0.01, filter_frequency=7.0)
    assert several.transfer(S).shape == (3, FREQUENCIES.size)
    np.testing.assert_allclose(several.transfer(S)[1], single.transfer(S), rtol=1e-14)


def test_a_filter_without_order_is_refused() -> None:
    with pytest.raises(SettingsError):
        Recording(filter_frequency=5.0, filter_order=0)
