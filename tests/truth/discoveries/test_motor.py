"""Causes weighed on one response: data of the lumped two-inertia formula, which the weighed model does not use."""

from dataclasses import replace

import numpy as np
import pytest

from benchmarks.discoveries.motor import CANDIDATES, base_fit, gain_of, motor
from benchmarks.discoveries.motor_balance import balances
from benchmarks.discoveries.motor_fit import PERIOD, RATE, complex_stiffness, two_inertias
from benchmarks.discoveries.response import Response, with_distortion
from benchmarks.discoveries.weigh import Weighed, look, relative_gain
from drillid.arrays import Complex
from drillid.discrepancy.verdicts.verdict import NONE
from drillid.physics.responses import laplace

TRUE = {"motor": 0.0048, "load": 0.0046, "stiffness": 540.0, "damping": 0.02, "drag": 0.07, "load_drag": 0.06}
FREQUENCY = np.arange(11.0, 251.0)
NOISE = 0.02
SOME = tuple(one for one in CANDIDATES if one.cause in ("drive_lag", "recorder_filter", "hysteretic_damping"))


def measured(response: Complex, seed: int) -> Response:
    generator = np.random.default_rng(seed)
    noise = generator.standard_normal((2, FREQUENCY.size)) * NOISE * np.abs(response) / np.sqrt(2)
    return Response(FREQUENCY, response + noise[0] + 1j * noise[1], NOISE * np.abs(response))


def weighed(response: Complex, seed: int = 0) -> Weighed:
    return look(base_fit, measured(response, seed), SOME)


def test_the_cascade_is_the_lumped_model() -> None:
    s = laplace(FREQUENCY)
    cascade = motor([*TRUE.values(), 1.2e-4]).mobility(s)
    np.testing.assert_allclose(cascade, two_inertias(TRUE | {"delay": 1.2e-4}, s), rtol=1e-5)


def test_a_plain_motor_has_no_cause() -> None:
    found = weighed(two_inertias(TRUE | {"delay": 1.2e-4}, laplace(FREQUENCY)))
    assert found.verdict == NONE
    assert 0.6 < found.base.misfit < 1.1


def test_a_lag_is_a_class_with_the_filter_and_gains_on_lines_that_were_not_fitted() -> None:
    lagging = two_inertias(TRUE | {"delay": 1.2e-4, "lag": 2e-3}, laplace(FREQUENCY))
    found = weighed(lagging)
    assert found.verdict == "drive_lag|recorder_filter"
    size, error = found.fits["drive_lag"].size
    assert size == pytest.approx(2e-3, abs=3 * error)
    assert error < 1e-4
    odd, even = found.base.problem.measured, measured(lagging, 1)
    gain = gain_of(found, odd=odd, even=even)
    assert gain[1] > 0
    fitted = np.arange(FREQUENCY.size) % 2 == 0
    odd = replace(odd, value=np.where(fitted, odd.value, np.nan))
    even = replace(even, value=np.where(fitted, np.nan, even.value))
    assert gain_of(found, odd=odd, even=even) == gain


def test_a_loss_factor_is_told_from_a_lag() -> None:
    lossy = complex_stiffness(TRUE | {"damping": 1e-4, "delay": 1.2e-4, "loss_factor": 0.2}, laplace(FREQUENCY))
    found = weighed(lossy)
    assert found.verdict == "hysteretic_damping"
    size, error = found.fits["hysteretic_damping"].size
    assert size > 3 * error
    assert found.fits["hysteretic_damping"].misfit < found.base.misfit


def test_what_jumps_from_line_to_line_is_noise_and_a_smooth_misfit_is_not() -> None:
    response = two_inertias(TRUE | {"delay": 1.2e-4}, laplace(FREQUENCY))
    told = replace(measured(response, 4), deviation=np.full(FREQUENCY.size, 1e-9))
    level = with_distortion(told, response).deviation / np.abs(response)
    assert np.median(level) == pytest.approx(NOISE, rel=0.2)
    smooth = replace(told, value=response * (1 + 0.1 * np.sin(np.log(FREQUENCY))))
    assert np.median(with_distortion(smooth, response).deviation / np.abs(response)) < NOISE / 10


def test_the_share_of_misfit_that_is_taken_away() -> None:
    held = measured(np.ones(FREQUENCY.size, dtype=complex), 5)
    share, low, high = relative_gain(np.full(FREQUENCY.size, 1.5 + 0j), np.full(FREQUENCY.size, 1.1 + 0j), held)
    assert share == pytest.approx(0.8, abs=0.01)
    assert low < share < high


@pytest.mark.parametrize("softening", [0.0, 0.05])
def test_a_softening_coupling_is_found_in_both_balances_and_play_is_not(softening: float) -> None:
    """Angles are drawn, the torques that they need follow: balances hold exactly, but for softening."""
    generator = np.random.default_rng(6)
    lines = np.arange(11, 251)
    wave = np.zeros(PERIOD // 2 + 1, dtype=complex)
    wave[lines] = np.exp(2j * np.pi * generator.random(lines.size)) / lines
    twist = np.fft.irfft(wave, PERIOD)
    s = 2j * np.pi * np.fft.rfftfreq(PERIOD, 1 / RATE)
    torque = TRUE["stiffness"] * twist * (1 - softening * (twist / np.abs(twist).max()) ** 2)
    # the load's speed follows from the torque, the motor's current from its own speed
    spun = np.fft.rfft(torque) / (TRUE["load"] * s + TRUE["load_drag"])
    turned = spun + s * np.fft.rfft(twist)
    current = np.fft.irfft((TRUE["motor"] * s + TRUE["drag"]) * turned + np.fft.rfft(torque), PERIOD)
    periods = [
        np.tile(one, (6, 1)) for one in (current, np.fft.irfft(turned, PERIOD), np.fft.irfft(spun, PERIOD), twist)
    ]
    found = balances(*periods, delay=0.0)
    for side in ("motor", "load"):
        assert found[f"softening, {side}"].relative == pytest.approx(-softening, abs=0.005)
        if softening:
            assert found[f"softening, {side}"].after < 0.2 * found[f"softening, {side}"].before
            assert found[f"play, {side}"].after > 0.5 * found[f"play, {side}"].before
