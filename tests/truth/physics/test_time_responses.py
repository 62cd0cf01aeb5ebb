"""Inverse Laplace transforms against closed forms and mpmath; steps, impulses and the command's step."""

from collections.abc import Callable
from dataclasses import replace

import mpmath
import numpy as np
import pytest

from drillid.errors import EstimationError
from drillid.physics.equipment import Bit, Controller, DrillingSystem, Section, Shaping, TopDrive
from drillid.physics.modes import modes
from drillid.physics.time_responses import (
    bit_impulse_response,
    bit_step_response,
    command_step_response,
    inverse_laplace,
)
from drillid.simulation.simulate import TIME_STEP, simulate

SOFT = Controller(1500.0, 800.0)
PIPE = Section(2600.0, 1.6e-5, 150.0, 3e8)


def rig(lag: float = 0.0, delay: float = 0.04, shaping: Shaping | None = None) -> DrillingSystem:
    top_drive = TopDrive(1100.0, delay, Controller(1500.0, 800.0), lag, 0.95, shaping=shaping)
    return DrillingSystem(top_drive, (PIPE,), Bit(90.0, 40.0))


def test_smooth_functions_of_time() -> None:
    lags, values = inverse_laplace(lambda s: 1 / ((s + 0.3) ** 2 + 4) ** 2, 10.0, 0.05)
    exact = np.exp(-0.3 * lags) * (np.sin(2 * lags) - 2 * lags * np.cos(2 * lags)) / 16
    np.testing.assert_allclose(values, exact, atol=2e-8)
    lags, values = inverse_laplace(lambda s: 1 / (s - 0.1) ** 4, 10.0, 0.05)
    exact = lags**3 * np.exp(0.1 * lags) / 6
    np.testing.assert_allclose(values, exact, atol=1e-5 * exact.max())


@pytest.mark.parametrize("growth", [0.5, 2.0, 9.0])
def test_growing_motion_is_refused_rather_than_misrepresented(growth: float) -> None:
    def oscillation(s: np.ndarray) -> np.ndarray:
        return 1 / ((s - growth) ** 2 + 4) + 1 / ((s + 0.3) ** 2 + 4)

    with pytest.raises(EstimationError, match="unstable"):
        inverse_laplace(oscillation, 10.0, 0.05)


def test_an_unstable_window_leaves_the_others() -> None:
    pipe, bit = Section(2600.0, 1.6e-5, 50.0, 1e8), Bit(150.0, np.array([[20.0], [-900.0], [np.nan]]))
    _, speed = bit_step_response(DrillingSystem(rig().top_drive, (pipe,), bit), 12.0, 0.05)
    alone = bit_step_response(DrillingSystem(rig().top_drive, (pipe,), Bit(150.0, 20.0)), 12.0, 0.05)[1]
    np.testing.assert_allclose(speed[0], alone, rtol=1e-9, atol=1e-15)
    assert np.isnan(speed[1:, 1:]).all()


@pytest.mark.parametrize("response", [bit_step_response, bit_impulse_response, command_step_response])
@pytest.mark.parametrize(
    ("controller", "delay"), [(Controller(1e4, 8e3), 0.3), (Controller(2e4, 5e3), 0.1), (Controller(1e5, 3e4), 0.039)]
)
def test_a_control_that_feeds_vibration_is_refused_though_the_bit_hardly_takes_part(
    response: Callable[..., tuple[np.ndarray, np.ndarray]], controller: Controller, delay: float
) -> None:
    """The simulated rig vibrates without bound; the transform alone gives a bounded curve."""
    pipe = Section(4455.0, 1.633e-5, 217.0, 2.354e8)
    unstable = DrillingSystem(TopDrive(1104.0, delay, controller), (pipe,), Bit(86.0))
    steps = round(20 / TIME_STEP)
    simulated = simulate(unstable, np.zeros(steps), np.zeros(steps), -np.ones(steps))
    early, late = np.array_split(np.abs(simulated.speed), 4)[1::2]
    assert late.max() > 10 * early.max()
    with pytest.raises(EstimationError, match="unstable"):
        response(unstable, 20.0, 0.05)
    gains = np.array([[controller.proportional], [1500.0]]), np.array([[controller.integral], [800.0]])
    pair, stable = (replace(unstable, top_drive=TopDrive(1104.0, delay, each)) for each in (Controller(*gains), SOFT))
    _, speed = response(pair, 20.0, 0.05)
    assert np.isnan(speed[0]).all()
    np.testing.assert_allclose(speed[1], response(stable, 20.0, 0.05)[1], rtol=1e-9, atol=1e-15)


@pytest.mark.parametrize(("inertia", "delta"), [(10.0, 2.5e8), (40.0, 1e9)])
def test_a_light_bit_below_lossy_steel_is_not_taken_for_unstable(inertia: float, delta: float) -> None:
    system = DrillingSystem(rig().top_drive, (replace(PIPE, delta=delta),), Bit(inertia, 40.0))
    assert np.all(modes(system, 0.01, 5.0).poles.real < 0)
    lags, impulse = bit_impulse_response(system, 5.0, 0.01)
    slope = np.gradient(bit_step_response(system, 5.0, 0.01)[1], lags)
    np.testing.assert_allclose(impulse[50:-1], slope[50:-1], atol=2e-3 * impulse[0])


def by_mpmath(lag: float, shaping: Shaping, times: np.ndarray) -> tuple[list[float], list[float]]:
    """Command step and bit impulse of `rig` by de Hoog's method on the paper's equations, written anew."""

    def parts(s: mpmath.mpc) -> tuple[mpmath.mpc, mpmath.mpc, mpmath.mpc, mpmath.mpc]:
        alpha, beta = PIPE.density * s + PIPE.kappa, PIPE.shear_modulus / s + PIPE.delta
        y0 = PIPE.polar_moment * mpmath.sqrt(alpha * beta)
        tangent = mpmath.tanh(mpmath.sqrt(alpha / beta) * PIPE.length)
        prompt = mpmath.mpf("0.95") / (1 + s * lag) * (1 + s * shaping.zero_1) / (1 + s * shaping.pole_1)
        return y0, tangent, prompt, prompt * mpmath.exp(-s * mpmath.mpf("0.04"))

    def command(s: mpmath.mpc) -> mpmath.mpc:
        # the delay of the sweep itself is taken out, which the method likes better
        y0, tangent, prompt, drive = parts(s)
        load = 90 * s + 40
        string = y0 * (load + y0 * tangent) / (y0 + load * tangent)
        return prompt / (1100 * s + string + drive * (1500 + 800 / s)) / s

    def impulse(s: mpmath.mpc) -> mpmath.mpc:
        y0, tangent, _, drive = parts(s)
        top = 1100 * s + drive * (1500 + 800 / s)
        return 1 / (90 * s + 40 + y0 * (top + y0 * tangent) / (y0 + top * tangent))

    with mpmath.workdps(20):
        return (
            [float(mpmath.invertlaplace(command, t - 0.04, method="dehoog", degree=50)) for t in times],
            [float(mpmath.invertlaplace(impulse, t, method="dehoog", degree=50)) for t in times],
        )


@pytest.mark.parametrize(
    ("lag", "shaping", "error"), [(0.0, None, 2e-6), (0.05, None, 2e-6), (0.0, Shaping(zero_1=0.02, pole_1=0.1), 1e-4)]
)
def test_command_step_and_bit_impulse(lag: float, shaping: Shaping | None, error: float) -> None:
    times = np.array([0.9, 4.0, 7.0])
    command, impulse = by_mpmath(lag, shaping or Shaping(), times)
    system = rig(lag, shaping=shaping)
    lags, speed = command_step_response(system, 10.0, 0.05)
    at = np.rint(times / 0.05).astype(int)
    np.testing.assert_allclose(speed[at], command, atol=error * np.abs(speed).max())
    lags, bit_speed = bit_impulse_response(system, 10.0, 0.05)
    np.testing.assert_allclose(lags[at], times, atol=1e-12)
    np.testing.assert_allclose(bit_speed[at], impulse, atol=2e-5 * np.abs(bit_speed).max())


@pytest.mark.parametrize("stiff", [True, False])
def test_a_step_is_the_sum_of_impulses(stiff: bool) -> None:
    lags, impulse = bit_impulse_response(rig(), 8.0, 0.002, stiff=stiff)
    _, step = bit_step_response(rig(), 8.0, 0.002, stiff=stiff)
    assert impulse[0] == pytest.approx(1 / 90.0, rel=0.01)
    summed = np.concatenate([[0.0], np.cumsum((impulse[1:] + impulse[:-1]) / 2 * np.diff(lags))])
    np.testing.assert_allclose(step, summed, atol=2e-5 * np.abs(step).max())


def test_the_top_drive_stands_still_until_the_delay_is_over_and_then_turns_its_inertia_alone() -> None:
    system = rig(delay=0.5)
    lags, speed = command_step_response(system, 6.0, 0.01)
    assert np.abs(speed[lags < 0.49]).max() < 1e-5 * np.abs(speed).max()
    just_after = (lags > 0.51) & (lags < 0.56)
    resistance = PIPE.characteristic_admittance
    alone = -0.95 * np.expm1(-(lags - 0.5) * resistance / 1100) / resistance
    np.testing.assert_allclose(speed[just_after], alone[just_after], rtol=0.01)


def test_windows_are_computed_at_once() -> None:
    lengths = np.array([[2000.0], [2600.0]])
    systems = [
        DrillingSystem(rig().top_drive, (Section(length, 1.6e-5, 150.0, 3e8),), Bit(90.0, 40.0))
        for length in (lengths, 2000.0, 2600.0)
    ]
    for response in (bit_step_response, bit_impulse_response, command_step_response):
        together, *alone = (response(system, 5.0, 0.05)[1] for system in systems)
        np.testing.assert_allclose(together, alone, rtol=1e-9, atol=1e-15)
