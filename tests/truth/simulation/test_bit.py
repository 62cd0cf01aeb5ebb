"""Cutting in the simulator: torque laws, stick–slip as it arises by itself, blades, motor."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import brentq

from drillid.arrays import Floats
from drillid.errors import SettingsError
from drillid.physics.equipment import Bit, Controller, Motor
from drillid.physics.nonlinear import Cutting, NonlinearRig, RegenerativeBit, SpeedLaw, Weakening
from drillid.physics.responses import bit_mobility, laplace
from drillid.simulation.simulate import TIME_STEP, Simulation, simulate
from tests.truth.rigs import COLLARS, PIPE, SPEED, SYSTEM, TOP_DRIVE, closure, steps_in

STIFF = replace(
    SYSTEM,
    top_drive=replace(TOP_DRIVE, controller=Controller(20e3, 10e3)),
    string=(replace(PIPE, kappa=50.0), replace(COLLARS, kappa=50.0)),
    bit=Bit(40.0, 10.0),
)
WEIGHT = 8e4
CUTTING = Cutting(0.12, 0.04, Weakening(4.0))


def drilled(rig: NonlinearRig, speed: float, seconds: float, kick: float = 200.0) -> Simulation:
    """Steady drilling with one push of the bit at 5 s."""
    time = TIME_STEP * np.arange(steps_in(seconds), dtype=float)
    push = np.where((time > 5) & (time < 6), kick, 0.0)
    return simulate(rig, 0 * time, np.full(time.size, speed), push, weight_on_bit=WEIGHT, energies=True)


def first_mode() -> tuple[float, float]:
    """Frequency (Hz) and damping (N m s/rad) of the string's first mode as the bit feels it: 1/B is real there."""

    def reactance(frequency: float) -> float:
        return float((1 / bit_mobility(STIFF, laplace(np.array([frequency]))))[0].imag)

    frequency = brentq(reactance, 0.15, 0.35)
    return float(frequency), float((1 / bit_mobility(STIFF, laplace(np.array([frequency]))))[0].real)


def critical_speed() -> float:
    """Speed at which the cutting law's slope takes away the first mode's damping."""
    _, damping = first_mode()
    weakening = CUTTING.weakening
    levels = (WEIGHT * CUTTING.static, WEIGHT * CUTTING.dynamic)
    return float(brentq(lambda speed: weakening.slope(*levels, speed) + damping, 8.0, 30.0))


def swing(result: Simulation, start: float, end: float) -> float:
    """Standard deviation of the bit's speed over a segment."""
    return float(result.bit_speed[(result.time >= start) & (result.time < end)].std())


def upward_crossings(time: Floats, series: Floats) -> Floats:
    level = series - series.mean()
    return np.asarray(time[1:][(level[1:] > 0) & (level[:-1] <= 0)], dtype=float)


def test_steady_cutting_takes_the_torque_of_its_law() -> None:
    rig = NonlinearRig(STIFF, cutting=CUTTING)
    result = drilled(rig, 20.0, 4.0)
    np.testing.assert_allclose(result.torque_on_bit, CUTTING.torque(WEIGHT, 20.0), rtol=1e-9)
    np.testing.assert_allclose(result.bit_speed, 20.0, rtol=1e-9)


def test_vibration_dies_above_the_critical_speed_and_grows_below() -> None:
    critical = critical_speed()
    above = drilled(NonlinearRig(STIFF, cutting=CUTTING), 1.07 * critical, 200.0)
    below = drilled(NonlinearRig(STIFF, cutting=CUTTING), 0.93 * critical, 200.0, kick=20.0)
    assert swing(above, 150, 200) < 0.5 * swing(above, 20, 70)
    assert swing(below, 150, 200) > 2 * swing(below, 20, 70)
    assert above.bit_speed.min() > 0


def test_stick_slip_has_a_period_a_bit_longer_than_the_first_mode() -> None:
    frequency, _ = first_mode()
    result = drilled(NonlinearRig(STIFF, cutting=CUTTING), 0.8 * critical_speed(), 200.0)
    late = result.time > 100
    period = np.diff(upward_crossings(result.time[late], result.bit_speed[late])).mean() * frequency
    assert 1.0 < period < 1.2
    assert np.mean(result.bit_speed[late] == 0) > 0.1
    assert result.bit_speed[late].max() > 2 * result.speed[late].mean()
    assert closure(result) < 1e-9


def test_a_bit_that_sticks_bears_up_to_the_static_torque() -> None:
    result = drilled(NonlinearRig(STIFF, cutting=CUTTING), 8.0, 100.0)
    stuck = result.bit_speed == 0
    assert stuck.any()
    greatest = WEIGHT * CUTTING.static
    assert 0.98 * greatest < result.torque_on_bit[stuck].max() <= greatest * (1 + 1e-12)


def test_a_bit_without_weight_cuts_nothing() -> None:
    rig = NonlinearRig(STIFF, cutting=CUTTING, regenerative=RegenerativeBit(5, 1e6, 0.004, 1e-6))
    time = TIME_STEP * np.arange(4000, dtype=float)
    result = simulate(rig, 0 * time, np.full(4000, SPEED), 0 * time, weight_on_bit=0.0)
    assert np.abs(result.torque_on_bit).max() < 1e-9


def test_steady_blades_cut_the_depth_of_a_revolution() -> None:
    blades = RegenerativeBit(5, 1e5, 0.004, 1.0)
    result = drilled(NonlinearRig(STIFF, regenerative=blades), 15.0, 4.0)
    np.testing.assert_allclose(result.torque_on_bit, 1e5 * 0.004 * 2 * np.pi / 15.0, rtol=1e-6)


def test_blades_cut_deeper_where_the_bit_was_slow() -> None:
    """On slow speed changes the torque is inverse to the speed; it follows one blade time late on quick ones."""
    blades = RegenerativeBit(5, 1e5, 0.004, 1.0)
    time = TIME_STEP * np.arange(steps_in(120.0), dtype=float)
    slow = 15 + 3 * np.sin(2 * np.pi * time / 60)
    result = simulate(
        NonlinearRig(STIFF, regenerative=blades), 0 * time, slow, 0 * time, weight_on_bit=WEIGHT, top_speed=slow
    )
    late = result.time > 20
    expected = 1e5 * 0.004 * 2 * np.pi / result.bit_speed[late]
    np.testing.assert_allclose(result.torque_on_bit[late], expected, rtol=0.01)


def test_a_standing_bit_with_blades_is_loaded_up_to_its_stalling_torque() -> None:
    """The cut deepens at the rate of penetration until it takes all the weight; the drive then breaks it free."""
    blades = RegenerativeBit(5, 2e6, 0.004, 5e-8)
    rig = NonlinearRig(STIFF, cutting=Cutting(0.02, 0.02), regenerative=blades)
    result = drilled(rig, 8.0, 100.0)
    stall = WEIGHT * (0.02 + 2e6 * 5e-8)
    greatest = result.torque_on_bit[result.time > 6].max()
    assert 0.98 * stall < greatest <= stall * (1 + 1e-9)
    assert np.mean(result.bit_speed == 0) > 0.05
    assert closure(result) < 1e-9


def test_a_motor_twists_by_the_torque_over_its_stiffness() -> None:
    motor = Motor(2e4, 200.0, 15.0)
    rig = NonlinearRig(replace(STIFF, motor=motor), cutting=Cutting(0.05, 0.05))
    time = TIME_STEP * np.arange(steps_in(140.0), dtype=float)
    weight = WEIGHT * np.interp(time, [5, 60], [0.0, 1.0])
    stiff, soft = (
        simulate(
            variant, 0 * time, np.full(time.size, SPEED), 0 * time, weight_on_bit=weight, sample_interval=TIME_STEP
        )
        for variant in (NonlinearRig(STIFF, cutting=Cutting(0.05, 0.05)), rig)
    )
    behind = TIME_STEP * np.cumsum(stiff.bit_speed - soft.bit_speed)
    assert behind[time > 100].mean() == pytest.approx(WEIGHT * 0.05 / 2e4, rel=0.02)


def test_weightless_cutting_changes_no_bit() -> None:
    kick = 200.0
    bare = drilled(NonlinearRig(STIFF), SPEED, 20.0, kick)
    idle = drilled(
        NonlinearRig(STIFF, cutting=Cutting(0.0, 0.0), regenerative=RegenerativeBit(4, 0.0, 0.0, 0.0)),
        SPEED,
        20.0,
        kick,
    )
    assert bare.speed.tobytes() == idle.speed.tobytes()
    assert bare.bit_speed.tobytes() == idle.bit_speed.tobytes()


def test_a_straight_law_is_a_damper() -> None:
    speed = np.linspace(-5.0, 30.0, 8)
    free = replace(STIFF, bit=replace(STIFF.bit, damping=0.0))
    by_law = drilled(NonlinearRig(free, law=SpeedLaw(speed, 40.0 * speed)), 10.0, 20.0)
    by_damper = drilled(NonlinearRig(replace(free, bit=replace(free.bit, damping=40.0))), 10.0, 20.0)
    np.testing.assert_allclose(by_law.bit_speed, by_damper.bit_speed, atol=2e-3 * np.ptp(by_damper.bit_speed))


def test_a_law_that_bends_holds_its_torque_and_the_energies_close() -> None:
    speed = np.linspace(0.0, 20.0, 201)
    result = drilled(NonlinearRig(STIFF, law=SpeedLaw(speed, 3.0 * speed**2)), 10.0, 20.0)
    assert result.torque_on_bit[0] == pytest.approx(300.0)
    assert closure(result) < 1e-3


@pytest.mark.parametrize("speeds", [np.array([1.0]), np.array([0.0, 1.0, 3.0]), np.array([1.0, 0.0])])
def test_a_law_without_regular_rising_speeds_is_refused(speeds: Floats) -> None:
    with pytest.raises(SettingsError, match="equal rising steps"):
        SpeedLaw(speeds, 0.0 * speeds)


def test_a_law_too_steep_for_the_time_step_is_refused() -> None:
    steep = SpeedLaw(np.array([0.0, 20.0]), np.array([0.0, 2e6]))
    with pytest.raises(SettingsError, match="too steep"):
        drilled(NonlinearRig(STIFF, law=steep), 10.0, 1.0)
