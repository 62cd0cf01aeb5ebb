"""Laws of a coupling and laws with memory: what they are in closed form, and that no energy comes from them."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import cumulative_trapezoid
from scipy.signal import lfilter

from drillid.errors import SettingsError
from drillid.physics.attachments import with_joint
from drillid.physics.nonlinear import ErrorLaw, NonlinearRig, SpeedLaw, TwistLaw
from drillid.physics.top_drive import with_gains
from drillid.simulation.simulate import TIME_STEP, Simulation, simulate
from tests.simulated import SHALLOW

PUSH, SPEED = 1500.0, 10.0
TORQUE = np.linspace(-2e4, 2e4, 401)


def pushed(rig: NonlinearRig, seconds: float = 20.0, top_speed: float = SPEED) -> Simulation:
    """A rig whose bit is braked by more and less torque, under a top drive of constant speed."""
    time = np.arange(round(seconds / TIME_STEP)) * TIME_STEP
    push = PUSH * (1 + 0.5 * np.sin(2 * np.pi * 0.7 * time) * (1 - np.exp(-time)))
    speed = np.full(time.size, top_speed)
    return simulate(
        rig, 0 * time, speed, push, mean_bit_torque=PUSH, top_speed=speed, sample_interval=TIME_STEP, energies=True
    )


def closure(result: Simulation) -> float:
    balance = result.energies
    assert balance is not None
    return abs(balance.supplied - balance.dissipated - balance.stored) / abs(balance.dissipated)


def test_a_straight_coupling_is_a_soft_joint() -> None:
    compliance, depth = 2e-5, 500.0
    law = TwistLaw(depth, TORQUE, compliance * TORQUE)
    by_law = pushed(NonlinearRig(SHALLOW.system, coupling=law))
    joined = pushed(NonlinearRig(replace(SHALLOW.system, string=with_joint(SHALLOW.system.string, depth, compliance))))
    by_coupling, by_joint = (result.bit_speed - SPEED for result in (by_law, joined))
    without = pushed(NonlinearRig(SHALLOW.system)).bit_speed - SPEED
    assert np.std(by_coupling - by_joint) < 0.1 * np.std(without - by_joint)


def test_a_coupling_that_softens_turns_back_by_its_twist_under_a_torque() -> None:
    law = TwistLaw(400.0, TORQUE, 1e-5 * TORQUE + 1e-9 * np.sign(TORQUE) * TORQUE**2)
    rigs = [NonlinearRig(SHALLOW.system), NonlinearRig(SHALLOW.system, coupling=law)]
    time = np.arange(round(60.0 / TIME_STEP)) * TIME_STEP
    still = np.zeros(time.size)
    # the torque on a string at rest rises slowly and stays
    push = -PUSH * np.clip(time / 20.0, 0.0, 1.0)
    turned = [
        float(np.sum(simulate(rig, still, still, push, top_speed=still, sample_interval=TIME_STEP).bit_speed))
        * TIME_STEP
        for rig in rigs
    ]
    assert turned[1] - turned[0] == pytest.approx(1e-5 * PUSH + 1e-9 * PUSH**2, rel=2e-3)


def test_the_energies_of_a_coupling_close() -> None:
    law = TwistLaw(400.0, TORQUE, 1e-5 * TORQUE + 1e-9 * np.sign(TORQUE) * TORQUE**2)
    assert closure(pushed(NonlinearRig(SHALLOW.system, coupling=law))) < 1e-3


@pytest.mark.parametrize("memory", [0.05, 0.8])
def test_a_law_with_memory_follows_the_speed_of_the_bit(memory: float) -> None:
    speed = np.linspace(-10.0, 40.0, 501)
    law = SpeedLaw(speed, 3.0 * speed * np.abs(speed), memory)
    result = pushed(NonlinearRig(SHALLOW.system, law=law))
    share = -np.expm1(-TIME_STEP / memory)
    between = (result.bit_speed[1:] + result.bit_speed[:-1]) / 2
    followed, _ = lfilter([share], [1.0, share - 1.0], between, zi=[(1 - share) * SPEED])
    middle = (followed[1:] + followed[:-1]) / 2
    time = np.arange(result.bit_speed.size) * TIME_STEP
    push = PUSH * (1 + 0.5 * np.sin(2 * np.pi * 0.7 * time) * (1 - np.exp(-time)))
    added = (result.torque_on_bit - push)[1:-1]
    truth = np.interp(middle, speed, law.torque)
    np.testing.assert_allclose(added, truth, atol=3e-3 * np.ptp(truth))
    assert closure(result) < 1e-3


def test_the_control_adds_the_torque_of_its_law_at_the_speed_error() -> None:
    error = np.linspace(-3.0, 3.0, 601)
    law = ErrorLaw(error, 400.0 * error**3)
    time = np.arange(round(30.0 / TIME_STEP)) * TIME_STEP
    sweep, still = 800.0 * np.sin(2 * np.pi * 0.3 * time), np.zeros(time.size)
    rig = NonlinearRig(SHALLOW.system, control_law=law)
    result = simulate(rig, sweep, still + SPEED, still, sample_interval=TIME_STEP)
    controller, off = SHALLOW.top_drive.controller, SPEED - result.speed_reading
    integral = cumulative_trapezoid(controller.integral * off, time, initial=0)
    added = result.torque_command - sweep - controller.proportional * off - integral
    expected = np.interp(off, error, law.torque)
    assert np.ptp(expected) > 100.0
    np.testing.assert_allclose(added - added[0], expected - expected[0], atol=1e-3 * np.ptp(expected))


def test_a_straight_law_of_the_control_is_a_larger_gain() -> None:
    error = np.linspace(-3.0, 3.0, 601)
    time = np.arange(round(20.0 / TIME_STEP)) * TIME_STEP
    sweep, still = 800.0 * np.sin(2 * np.pi * 0.3 * time), np.zeros(time.size)
    larger = with_gains(SHALLOW.top_drive.controller, np.array([1.5, 1.0]))
    top_drive = replace(SHALLOW.top_drive, controller=larger)
    more = larger.proportional - SHALLOW.top_drive.controller.proportional
    rigs = (
        NonlinearRig(SHALLOW.system, control_law=ErrorLaw(error, more * error)),
        NonlinearRig(replace(SHALLOW.system, top_drive=top_drive)),
    )
    by_law, by_gain = (simulate(rig, sweep, still + SPEED, still).speed for rig in rigs)
    np.testing.assert_allclose(by_law, by_gain, atol=1e-9)


def test_a_coupling_whose_twist_falls_and_a_memory_below_zero_are_refused() -> None:
    with pytest.raises(SettingsError, match="never falls"):
        TwistLaw(100.0, TORQUE, -1e-5 * TORQUE)
    with pytest.raises(SettingsError, match="memory"):
        SpeedLaw(TORQUE, TORQUE, -1.0)


def test_a_law_of_the_control_needs_equal_steps() -> None:
    with pytest.raises(SettingsError, match="law of the speed control"):
        ErrorLaw(np.array([0.0, 1.0, 3.0]), np.zeros(3))
