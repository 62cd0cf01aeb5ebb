"""The time-domain simulator against the transmission line, with which it shares no formula."""

import numpy as np
import pytest

from drillid.arrays import Floats
from drillid.errors import SettingsError
from drillid.excitation.torques import coloured_noise
from drillid.physics.equipment import Bit, Controller, DrillingSystem, Section, TopDrive
from drillid.physics.responses import bit_mobility, command_mobility, laplace
from drillid.simulation.simulate import SAMPLE_INTERVAL, TIME_STEP, simulate
from tests.truth.rigs import COLLARS, FREQUENCIES, PERIOD, PIPE, SOFT, SPEED, lines_of, multisine

PERIODS = 3
"""Of which the last is compared, and the others let the start die away; what is left of it counts as an error."""


def rig(
    delay: float = 0.0413, lag: float = 0.0, speed_filter: float = 0.0, torque_filter: float = 0.0
) -> DrillingSystem:
    controller = Controller(1500.0, 800.0, speed_filter, torque_filter)
    return DrillingSystem(TopDrive(1100.0, delay, controller, lag), (PIPE, COLLARS), Bit(40.0, 40.0))


def mobility_errors(system: DrillingSystem, time_step: float = TIME_STEP) -> Floats:
    """Relative deviation of the simulated command mobility, after settling."""
    sweep = multisine(round(PERIOD / time_step))
    steady = np.full(PERIODS * sweep.size, 1.0)
    result = simulate(
        system, np.tile(sweep, PERIODS), SPEED * steady, 4e3 * steady, mean_bit_torque=4e3, time_step=time_step
    )
    samples = result.speed.size // PERIODS
    measured = lines_of(result.speed, samples) / lines_of(sweep[:: round(SAMPLE_INTERVAL / time_step)], samples)
    expected = command_mobility(system, laplace(FREQUENCIES))
    return np.abs(measured - expected) / np.abs(expected)


@pytest.mark.parametrize(
    "system",
    [
        pytest.param(rig(), id="plain"),
        pytest.param(rig(delay=0.0), id="no-delay"),
        pytest.param(rig(delay=0.0037), id="short-delay"),
        pytest.param(rig(lag=0.05), id="drive-lag"),
        pytest.param(rig(speed_filter=0.06), id="speed-filter"),
        pytest.param(rig(torque_filter=0.04), id="torque-filter"),
        pytest.param(
            DrillingSystem(rig().top_drive, (PIPE, SOFT, COLLARS), Bit(0.0, 300.0)), id="three-sections-no-bit-inertia"
        ),
    ],
)
def test_simulated_command_mobility_is_that_of_the_line(system: DrillingSystem) -> None:
    """Within 0.1 % of |M| at every line over 0.05–5 Hz."""
    assert mobility_errors(system).max() < 1e-3


def test_error_is_of_second_order_in_the_time_step() -> None:
    coarse, middle, fine = (mobility_errors(rig(), step).max() for step in (0.01, 0.005, 0.0025))
    assert 3.5 < coarse / middle < 4.5
    assert 3.5 < middle / fine < 4.5


def test_simulated_bit_mobility_is_that_of_the_line() -> None:
    """Torque of the rock slows the bit by the bit mobility; the bit torque acts half a step after the speeds."""
    shake = multisine(round(PERIOD / TIME_STEP))
    steady = np.full(PERIODS * shake.size, 1.0)
    result = simulate(rig(), 0 * steady, SPEED * steady, 4e3 + np.tile(shake, PERIODS), mean_bit_torque=4e3)
    samples = result.speed.size // PERIODS
    every = round(SAMPLE_INTERVAL / TIME_STEP)
    s = laplace(FREQUENCIES)
    torque = lines_of(shake[::every], samples) * np.exp(-s * TIME_STEP / 2)
    expected = -bit_mobility(rig(), s)
    assert np.max(np.abs(lines_of(result.bit_speed, samples) / torque - expected) / np.abs(expected)) < 1e-3


def test_command_is_the_sweep_plus_the_response_of_the_controller() -> None:
    """(T_com − T_sweep)/ω = −(P + I/s), with the command ahead of the drive's delay."""
    sweep = multisine(round(PERIOD / TIME_STEP))
    steady = np.full(PERIODS * sweep.size, 1.0)
    result = simulate(rig(), np.tile(sweep, PERIODS), SPEED * steady, 4e3 * steady, mean_bit_torque=4e3)
    samples = result.speed.size // PERIODS
    response = lines_of(result.torque_command, samples) - lines_of(
        sweep[:: round(SAMPLE_INTERVAL / TIME_STEP)], samples
    )
    ratio = -response / lines_of(result.speed, samples)
    np.testing.assert_allclose(ratio, 1500 + 800 / laplace(FREQUENCIES), rtol=1e-4)


def test_energy_balance_closes() -> None:
    """Work of drive and rock, summed over steps, is lost in dampers or stored: the scheme creates none."""
    steps = round(60 / TIME_STEP)
    noise = coloured_noise(np.random.default_rng(1), steps, TIME_STEP, 400.0, 2.0)
    result = simulate(
        rig(), multisine(steps), np.linspace(8, 15, steps), 5e3 + noise, mean_bit_torque=4e3, energies=True
    )
    energies = result.energies
    assert energies is not None
    assert energies.dissipated > 0.1 * abs(energies.supplied)
    assert energies.supplied == pytest.approx(energies.dissipated + energies.stored, rel=1e-8)


def test_undisturbed_rotation_stays_steady() -> None:
    steady = np.ones(4000)
    result = simulate(rig(speed_filter=0.1), 0 * steady, SPEED * steady, 4e3 * steady, mean_bit_torque=4e3)
    np.testing.assert_allclose(result.speed, SPEED, rtol=1e-10)
    np.testing.assert_allclose(result.bit_speed, SPEED, rtol=1e-10)
    friction = SPEED * (sum(s.kappa * s.polar_moment * s.length for s in (PIPE, COLLARS)) + 40.0)
    np.testing.assert_allclose(result.drive_torque, 4e3 + friction, rtol=1e-10)


def test_drive_torque_responds_after_the_delay() -> None:
    """A pulse smooth enough for the interpolation reaches the drive one delay later, unchanged."""
    time = np.arange(4000) * TIME_STEP
    pulse = 500 * np.exp(-(((time - 4) / 0.2) ** 2))
    system = rig(delay=0.5)
    result = simulate(system, pulse, np.full(4000, SPEED), np.full(4000, 4e3), mean_bit_torque=4e3)
    expected = np.interp(result.time + TIME_STEP / 2 - 0.5, result.time, result.torque_command)
    late = result.time > 0.6
    np.testing.assert_allclose(result.drive_torque[late], expected[late], atol=0.6)


def test_same_input_gives_the_same_bits() -> None:
    def run() -> bytes:
        noise = coloured_noise(np.random.default_rng(7), 4000, TIME_STEP, 400.0, 2.0)
        result = simulate(rig(), multisine(4000), np.full(4000, SPEED), 4e3 + noise, mean_bit_torque=4e3)
        return result.speed.tobytes() + result.torque_command.tobytes() + result.bit_speed.tobytes()

    assert run() == run()


@pytest.mark.parametrize(
    ("time_step", "length", "message"),
    [(0.003, 100.0, "not a whole number of time steps"), (0.005, 10.0, "a wave travels")],
)
def test_unusable_time_steps_are_refused(time_step: float, length: float, message: str) -> None:
    short = Section(length, COLLARS.polar_moment)
    system = DrillingSystem(rig().top_drive, (PIPE, short), Bit(40.0))
    with pytest.raises(SettingsError, match=message):
        simulate(system, np.zeros(10), np.zeros(10), np.zeros(10), time_step=time_step)
