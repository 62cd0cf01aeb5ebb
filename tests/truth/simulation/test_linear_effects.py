"""Every linear effect of both the simulator and the transmission-line model, at small amplitude."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from drillid.discrepancy.catalogue.cause import WindowModel
from drillid.errors import SettingsError
from drillid.physics.attachments import MountedInertia, Relaxation, with_joint, with_law, with_lump
from drillid.physics.damping import ConstantLossFactor, DampingLaw, HystereticLoss, RootDrag, StokesLayerDrag
from drillid.physics.equipment import (
    Bit,
    Controller,
    DrillingSystem,
    ImpedanceMatching,
    Motor,
    RegenerativeCutting,
    Shaping,
    StribeckCutting,
)
from drillid.physics.gaussian_process import ProcessShaping
from drillid.physics.nonlinear import (
    Cutting,
    Gear,
    NonlinearRig,
    RegenerativeBit,
    Weakening,
)
from drillid.physics.responses import command_mobility, laplace, string_torque
from drillid.physics.sensor import Recording
from drillid.physics.strings import String
from drillid.simulation.simulate import SAMPLE_INTERVAL, TIME_STEP, simulate
from tests.truth.rigs import (
    COLLARS,
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

WEIGHT = 5e4
LARGEST_ERROR = 3e-3
PERIODS = 3
"""Of which the last is compared, and the others let the start die away; what is left of it counts as an error."""


def mobility_error(
    rig: DrillingSystem | NonlinearRig, linear: DrillingSystem, bit_torque: float = 4e3, amplitude: float = 20.0
) -> float:
    """Largest relative deviation of the simulated command mobility over 0.05–5 Hz, after settling."""
    sweep = multisine(round(PERIOD / TIME_STEP), amplitude)
    steady = np.ones(PERIODS * sweep.size)
    result = simulate(
        rig,
        np.tile(sweep, PERIODS),
        SPEED * steady,
        bit_torque * steady,
        mean_bit_torque=bit_torque,
        weight_on_bit=WEIGHT,
    )
    samples = result.speed.size // PERIODS
    measured = lines_of(result.speed, samples) / lines_of(sweep[:: round(SAMPLE_INTERVAL / TIME_STEP)], samples)
    expected = command_mobility(linear, laplace(FREQUENCIES))
    return float(np.max(np.abs(measured - expected) / np.abs(expected)))


def top(**parameters: Any) -> DrillingSystem:
    return replace(SYSTEM, top_drive=replace(TOP_DRIVE, **parameters))


def controlled(controller: Controller) -> DrillingSystem:
    return replace(SYSTEM, top_drive=replace(TOP_DRIVE, controller=controller))


def damped(*laws: DampingLaw) -> DrillingSystem:
    return replace(SYSTEM, string=(replace(PIPE, laws=laws), COLLARS))


STRING = (PIPE, COLLARS)


def attached(string: String) -> DrillingSystem:
    return replace(SYSTEM, string=string)


MATCHED = 0.5 / PIPE.characteristic_admittance


@pytest.mark.parametrize(
    "system",
    [
        pytest.param(top(gain=0.8), id="actuator-gain"),
        pytest.param(
            controlled(replace(CONTROLLER, compensated_inertia=400.0, compensation_filter=0.05)),
            id="inertia-compensation",
        ),
        pytest.param(controlled(replace(CONTROLLER, compensated_inertia=100.0)), id="unfiltered-compensation"),
        pytest.param(
            controlled(Controller(3000.0, 800.0, matching=ImpedanceMatching(MATCHED, 1100.0, 0.05, 5.0))),
            id="impedance-matching",
        ),
        pytest.param(
            controlled(replace(CONTROLLER, matching=ImpedanceMatching(0.6 * MATCHED, 1100.0, 0.03))),
            id="matching-of-the-mean",
        ),
        pytest.param(replace(SYSTEM, motor=Motor(2e4, 50.0, 15.0), bit=Bit(25.0, 40.0)), id="motor"),
        pytest.param(damped(RootDrag(200.0)), id="root-drag"),
        pytest.param(damped(StokesLayerDrag(1200.0, 0.03, 0.1397, 0.1214)), id="mud-drag"),
        pytest.param(damped(ConstantLossFactor(0.02), RootDrag(100.0)), id="loss-factor-and-drag"),
        pytest.param(damped(Relaxation(2000.0, 8.0)), id="drag-through-an-elastic-layer"),
        pytest.param(damped(Relaxation(2000.0, 1.0)), id="drag-through-a-soft-layer"),
        pytest.param(damped(Relaxation(5e4, 20.0), RootDrag(100.0)), id="strong-drag-beside-that-of-mud"),
        pytest.param(attached(with_law(STRING, 1500.0, MountedInertia(30.0, 1.3, 0.4))), id="mounted-inertia"),
        pytest.param(attached(with_lump(STRING, 900.0, 60.0, 80.0)), id="lump"),
        pytest.param(attached(with_joint(STRING, 1900.0, 3e-5)), id="soft-joint"),
    ],
)
def test_simulated_command_mobility_has_the_effect(system: DrillingSystem) -> None:
    assert mobility_error(system, system) < LARGEST_ERROR


def test_damping_laws_with_memory_only_have_their_steady_drag_in_steady_rotation() -> None:
    """Drag by √s vanishes at rest of all change; the fit's last damper stands for what is slower than it resolves."""
    steady = np.full(4000, SPEED)
    dragged = damped(RootDrag(200.0), ConstantLossFactor(0.02))
    result = simulate(dragged, 0 * steady, steady, 4e3 + 0 * steady, mean_bit_torque=4e3)
    np.testing.assert_allclose(result.speed, SPEED, rtol=1e-9)
    plain = simulate(SYSTEM, 0 * steady, steady, 4e3 + 0 * steady, mean_bit_torque=4e3)
    slowest = abs(RootDrag(200.0).shunt(PIPE, laplace(np.array([0.02])))[0]) * PIPE.length * SPEED
    assert 0 <= result.drive_torque[0] - plain.drive_torque[0] < slowest


def test_ideal_hysteretic_damping_is_simulated_as_its_causal_relative() -> None:
    assert mobility_error(damped(HystereticLoss(0.01)), damped(ConstantLossFactor(0.01))) < LARGEST_ERROR


def test_stribeck_cutting_has_its_slope_at_small_amplitude() -> None:
    rig = NonlinearRig(SYSTEM, cutting=Cutting(0.05, 0.02, Weakening(6.0)))
    linear = rig.linearised(SPEED, WEIGHT)
    assert mobility_error(rig, linear, bit_torque=0.0, amplitude=2.0) < LARGEST_ERROR
    assert mobility_error(rig, SYSTEM, bit_torque=0.0, amplitude=2.0) > 10 * LARGEST_ERROR


def test_blades_feed_back_what_they_cut_a_blade_time_ago() -> None:
    rig = NonlinearRig(SYSTEM, regenerative=RegenerativeBit(5, 1.5e5, 0.004, 1.0))
    linear = rig.linearised(SPEED, WEIGHT)
    assert mobility_error(rig, linear, bit_torque=0.0, amplitude=2.0) < LARGEST_ERROR
    assert mobility_error(rig, SYSTEM, bit_torque=0.0, amplitude=2.0) > 10 * LARGEST_ERROR


def test_sampled_control_holds_its_command_half_an_interval_longer() -> None:
    rig = NonlinearRig(SYSTEM, control_interval=2 * TIME_STEP)
    assert mobility_error(rig, top(delay=TOP_DRIVE.delay + TIME_STEP)) < LARGEST_ERROR
    assert mobility_error(rig, SYSTEM) > 3 * LARGEST_ERROR


@pytest.mark.parametrize("step", [TIME_STEP, 2 * TIME_STEP])
def test_sampled_control_has_its_delay_whatever_the_time_step(step: float) -> None:
    interval, frequency, seconds, speed = 0.02, 1.0, 60.0, 10.0
    time = np.arange(round(seconds / step)) * step
    sweep = 100.0 * np.sin(2 * np.pi * frequency * time)
    rig = NonlinearRig(SYSTEM, control_interval=interval)
    steady = np.full(time.size, speed), np.zeros(time.size)
    result = simulate(rig, sweep, *steady, sample_interval=interval, time_step=step)
    late = round(20.0 / interval)
    turning = np.exp(-2j * np.pi * frequency * result.time[-late:])
    # 100 sin(ωt) is −100j at its frequency, by a factor that both sums have
    measured = 2 / late * (result.speed[-late:] - speed) @ turning / -100j
    held = top(delay=TOP_DRIVE.delay + interval / 2)
    expected = WindowModel(held, Recording(), control_interval=interval).mobility(laplace(np.array([frequency])))
    assert abs(measured / expected.item() - 1) < 1e-3


def test_a_gear_whose_teeth_stay_in_contact_is_nearly_rigid() -> None:
    rig = NonlinearRig(SYSTEM, gear=Gear(play=0.05, output_inertia=150.0, stiffness=1e7))
    assert mobility_error(rig, SYSTEM, bit_torque=8e3) < LARGEST_ERROR


@pytest.mark.parametrize(
    "law",
    [StribeckCutting(2500.0, 1000.0, 6.0, SPEED, 1.2), RegenerativeCutting(300.0, SPEED, 5)],
    ids=["Stribeck", "blades"],
)
def test_linear_cutting_laws_convert_to_a_rig_that_has_them(law: StribeckCutting | RegenerativeCutting) -> None:
    linear = replace(SYSTEM, bit=Bit(40.0, 40.0, (law,)))
    rig = NonlinearRig.from_linear(linear, WEIGHT)
    assert mobility_error(rig, linear, bit_torque=0.0, amplitude=2.0) < LARGEST_ERROR
    s = laplace(FREQUENCIES)
    np.testing.assert_allclose(
        command_mobility(rig.linearised(SPEED, WEIGHT), s), command_mobility(linear, s), rtol=1e-12
    )


def test_cutting_laws_without_weight_or_twice_are_refused() -> None:
    law = StribeckCutting(2500.0, 1000.0, 6.0, SPEED)
    for laws, weight in (((law,), 0.0), ((law, law), WEIGHT)):
        with pytest.raises(SettingsError, match="cutting needs"):
            NonlinearRig.from_linear(replace(SYSTEM, bit=Bit(40.0, 40.0, laws)), weight)


def test_simulated_torque_into_the_string_is_what_an_instrumented_sub_shows() -> None:
    """The simulator's torques belong to half a step after its speeds."""
    sweep = multisine(round(PERIOD / TIME_STEP))
    steady = np.ones(PERIODS * sweep.size)
    result = simulate(SYSTEM, np.tile(sweep, PERIODS), SPEED * steady, 4e3 * steady, mean_bit_torque=4e3)
    samples = result.string_torque.size // PERIODS
    half_step_later = np.exp(laplace(FREQUENCIES) * TIME_STEP / 2)
    lines = lines_of(sweep[:: round(SAMPLE_INTERVAL / TIME_STEP)], samples)
    measured = lines_of(result.string_torque, samples) / lines / half_step_later
    expected = string_torque(SYSTEM, laplace(FREQUENCIES))
    assert np.max(np.abs(measured - expected) / np.abs(expected)) < LARGEST_ERROR


def test_linear_cutting_laws_are_refused_rather_than_dropped() -> None:
    rig = NonlinearRig(SYSTEM, cutting=Cutting(0.05, 0.02))
    with pytest.raises(SettingsError, match="linear cutting laws"):
        simulate(rig.linearised(SPEED, WEIGHT), np.zeros(10), np.ones(10), np.zeros(10))


def test_a_motor_too_stiff_for_the_time_step_is_refused() -> None:
    system = replace(SYSTEM, motor=Motor(1e9, 0.0, 15.0), bit=Bit(5.0))
    with pytest.raises(SettingsError, match="too fast for a time step"):
        simulate(system, np.zeros(10), np.ones(10), np.zeros(10))
    rigid = replace(system, motor=Motor(np.inf, 0.0, 15.0))
    with pytest.raises(SettingsError, match="motor is rigid"):
        simulate(rigid, np.zeros(10), np.ones(10), np.zeros(10))


LEARNT = (Shaping(zero_1=0.02, pole_1=0.05), Shaping(zero_1=0.05, zero_2=0.004, pole_1=0.08, pole_2=0.006))


@pytest.mark.parametrize("factor", LEARNT)
def test_learnt_factors_of_drive_and_control_act_as_in_the_linear_model(factor: Shaping) -> None:
    for rig in (top(shaping=factor), top(controller=replace(CONTROLLER, shaping=factor))):
        assert mobility_error(rig, rig) < LARGEST_ERROR
        assert mobility_error(rig, SYSTEM) > 10 * LARGEST_ERROR


@pytest.mark.parametrize("factor", [Shaping(zero_1=0.1), Shaping(zero_2=0.1, pole_1=0.1), ProcessShaping()])
def test_factors_without_a_realisation_are_refused(factor: Shaping) -> None:
    still = np.zeros(10)
    with pytest.raises(SettingsError, match="not a proper, stable rational one"):
        simulate(top(shaping=factor), still, still + SPEED, still)
