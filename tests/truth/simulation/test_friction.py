"""Wall contact in the simulator: true sticking, the soft-string integral, breaking away, energy."""

from dataclasses import replace

import numpy as np
import pytest

from drillid.physics.equipment import Bit, Controller, DrillingSystem, TopDrive
from drillid.physics.nonlinear import NonlinearRig, WallContact, Weakening
from drillid.physics.responses import command_mobility, laplace
from drillid.physics.soft_string import Pipe, Survey, side_forces, wall_contact
from drillid.simulation.simulate import SAMPLE_INTERVAL, TIME_STEP, Simulation, simulate
from tests.truth.rigs import (
    COLLARS,
    FREQUENCIES,
    PERIOD,
    PIPE,
    SPEED,
    SYSTEM,
    TOP_DRIVE,
    closure,
    lines_of,
    multisine,
    steps_in,
)

SURVEY = Survey.from_degrees([0, 300, 700, 1500, 3000], [0, 0, 40, 40, 40], [0, 0, 0, 30, 30])
TALLY = [Pipe(2900.0, 0.1397, 0.1214, 0.168), Pipe(100.0, 0.1651, 0.0714, 0.1651)]
FORCES = side_forces(SURVEY, TALLY, 1200.0)
FREE = replace(SYSTEM, top_drive=TopDrive(1100.0, 0.0413, Controller(0.0)))
STEADIED = replace(SYSTEM, top_drive=replace(TOP_DRIVE, controller=Controller(3000.0, 1500.0)))


def torques(contact: WallContact) -> tuple[float, float]:
    """Static and dynamic torque of the whole string."""
    widths = np.diff(contact.edges)
    return float(np.sum(contact.static * widths)), float(np.sum(contact.dynamic * widths))


def started(contact: WallContact | None, seconds: float, system: DrillingSystem = STEADIED) -> Simulation:
    """Off bottom, from standstill to full speed within 5 s."""
    time = TIME_STEP * np.arange(steps_in(seconds), dtype=float)
    return simulate(
        NonlinearRig(system, contact=contact),
        0 * time,
        SPEED * np.minimum(time / 5, 1),
        0 * time,
        energies=True,
    )


def test_rotating_off_bottom_takes_the_torque_of_the_soft_string() -> None:
    contact = wall_contact(FORCES, 0.3, 0.2, Weakening(1.0))
    result = started(contact, 120.0)
    viscous = SPEED * (sum(s.kappa * s.polar_moment * s.length for s in (PIPE, COLLARS)) + SYSTEM.bit.damping)
    assert result.string_torque[-1] == pytest.approx(torques(contact)[1] + viscous, rel=1e-4)
    assert result.bit_speed[-1] == pytest.approx(SPEED, rel=1e-3)
    assert closure(result) < 1e-9


def test_the_friction_at_a_speed_is_the_weakened_level() -> None:
    contact = wall_contact(FORCES, 0.3, 0.2, Weakening(SPEED, 2.0))
    level = torques(contact)[1] + (torques(contact)[0] - torques(contact)[1]) / np.e
    steady = np.full(400, SPEED)
    result = simulate(NonlinearRig(SYSTEM, contact=contact), 0 * steady, steady, 0 * steady)
    viscous = SPEED * (sum(s.kappa * s.polar_moment * s.length for s in (PIPE, COLLARS)) + SYSTEM.bit.damping)
    np.testing.assert_allclose(result.drive_torque, level + viscous, rtol=1e-9)
    np.testing.assert_allclose(result.bit_speed, SPEED, rtol=1e-9)


@pytest.mark.parametrize("direction", [1.0, -1.0])
def test_a_slow_torque_breaks_the_string_away_at_its_static_level(direction: float) -> None:
    """Without weakening the slip runs down the string as the torque grows, and reaches the bit at the whole torque."""
    contact = wall_contact(FORCES, 0.3, 0.3)
    static, _ = torques(contact)
    time = TIME_STEP * np.arange(steps_in(170.0), dtype=float)
    ramp = direction * static * time / 150
    result = simulate(NonlinearRig(FREE, contact=contact), ramp, 0 * time, 0 * time, energies=True)
    first = int(np.flatnonzero(result.bit_speed)[0])
    assert abs(result.drive_torque[first]) == pytest.approx(static, rel=2e-3)
    assert np.sign(result.bit_speed[first]) == direction
    assert closure(result) < 1e-9


def test_a_string_that_has_rested_breaks_away_at_a_torque_greater_by_its_share() -> None:
    """A run that starts turning has none of it left."""
    contact = wall_contact(FORCES, 0.3, 0.3)
    rested = replace(contact, rest=0.4, rest_angle=1e6)
    static, _ = torques(contact)
    time = TIME_STEP * np.arange(steps_in(115.0), dtype=float)
    ramp = static * time / 75
    result = simulate(NonlinearRig(FREE, contact=rested), ramp, 0 * time, 0 * time, energies=True)
    first = int(np.flatnonzero(result.bit_speed)[0])
    assert result.drive_torque[first] == pytest.approx(1.4 * static, rel=5e-3)
    assert closure(result) < 1e-9
    steady = np.full(400, SPEED)
    turning = [simulate(NonlinearRig(SYSTEM, contact=law), 0 * steady, steady, 0 * steady) for law in (contact, rested)]
    assert turning[0].drive_torque.tobytes() == turning[1].drive_torque.tobytes()


def test_rest_is_lost_exponentially_with_the_angle_of_slip() -> None:
    """A rigid body: torque of the sliding wall against the angle that it has turned."""
    level, share, angle = 4e3, 0.5, 5.0
    short = replace(STEADIED, string=(replace(PIPE, length=30.0),))
    grip = WallContact(
        np.array([0.0, 30.0]), np.array([level / 30]), np.array([level / 30]), rest=share, rest_angle=angle
    )
    step = 0.0025
    time = step * np.arange(8000, dtype=float)
    led = np.minimum(0.2 * time, 1.0)
    result = simulate(NonlinearRig(short, contact=grip), 0 * time, 0 * time, 0 * time, top_speed=led, time_step=step)
    turned = np.interp(result.time, time, np.cumsum(led) * step)
    viscous = sum(s.kappa * s.polar_moment * s.length for s in short.string) + short.bit.damping
    expected = level * (1 + share * np.exp(-turned / angle)) + viscous * 1.0
    late = result.time > 8
    np.testing.assert_allclose(result.string_torque[late], expected[late], rtol=3e-3)


def test_a_string_below_its_static_level_stands_exactly_still() -> None:
    """Half of the uppermost element grips 7.9 N m, so that nothing may creep."""
    grip = WallContact(np.array([0.0, 3000.0]), np.array([2.0]), np.array([1.0]))
    time = TIME_STEP * np.arange(steps_in(60.0), dtype=float)
    shaking = 7.0 * np.sin(time)
    clamped = replace(FREE, top_drive=replace(FREE.top_drive, inertia=1.0))
    result = simulate(NonlinearRig(clamped, contact=grip), shaking, 0 * time, 0 * time)
    assert not result.bit_speed.any()
    assert not result.speed.any()


def test_stopping_leaves_torque_in_the_string_and_the_bit_at_rest() -> None:
    contact = wall_contact(FORCES, 0.3, 0.2)
    time = TIME_STEP * np.arange(steps_in(120.0), dtype=float)
    speed = SPEED * np.interp(time, [0, 5, 30, 40], [0, 1, 1, 0])
    result = simulate(NonlinearRig(STEADIED, contact=contact), 0 * time, speed, 0 * time)
    assert not result.bit_speed[result.time > 60].any()
    still = result.string_torque[result.time > 110]
    assert np.abs(result.speed[result.time > 110]).max() < 1e-3
    assert 0.01 * torques(contact)[0] < abs(still.mean()) < torques(contact)[0]


def test_weakening_along_the_string_is_negative_damping_at_small_amplitude() -> None:
    """A slope of friction spread over the string acts like κ IP per length of the same size."""
    law, static, dynamic = Weakening(6.0), 3.0, 2.0
    contact = WallContact(np.array([0.0, 3000.0]), np.array([static]), np.array([dynamic]), law)
    slope = law.slope(static, dynamic, SPEED)
    weakened = tuple(replace(s, kappa=s.kappa + slope / s.polar_moment) for s in (PIPE, COLLARS))
    sweep = multisine(steps_in(PERIOD), 2.0)
    steady = np.ones(5 * sweep.size)
    rig = NonlinearRig(SYSTEM, contact=contact)
    result = simulate(rig, np.tile(sweep, 5), SPEED * steady, 4e3 * steady, mean_bit_torque=4e3)
    samples = result.speed.size // 5
    measured = lines_of(result.speed, samples) / lines_of(sweep[:: round(SAMPLE_INTERVAL / TIME_STEP)], samples)
    s = laplace(FREQUENCIES)
    expected, without = (command_mobility(replace(SYSTEM, string=string), s) for string in (weakened, SYSTEM.string))
    assert np.max(np.abs(measured - expected) / np.abs(expected)) < 3e-3
    assert np.max(np.abs(without - expected) / np.abs(expected)) > 3e-2


def test_a_top_drive_made_to_follow_a_speed_shows_the_torque_that_takes() -> None:
    """The recorded motion of one run, imposed on the next, needs the same torque and turns the bit alike."""
    contact = wall_contact(FORCES, 0.3, 0.2)
    time = TIME_STEP * np.arange(steps_in(60.0), dtype=float)
    wanted = SPEED * np.minimum(time / 5, 1)
    rig = NonlinearRig(STEADIED, contact=contact)
    free = simulate(rig, 0 * time, wanted, 0 * time, sample_interval=TIME_STEP)
    led = simulate(rig, 0 * time, wanted, 0 * time, top_speed=free.speed, sample_interval=TIME_STEP, energies=True)
    np.testing.assert_allclose(led.bit_speed, free.bit_speed, atol=0.02 * SPEED)
    scale = np.abs(free.drive_torque).max()
    np.testing.assert_allclose(led.drive_torque[:-1], free.drive_torque[:-1], atol=0.02 * scale)
    assert closure(led) < 1e-9


def test_contact_that_takes_no_torque_changes_no_bit() -> None:
    nothing = WallContact(np.array([0.0, 3000.0]), np.zeros(1), np.zeros(1))
    bare, touched = started(None, 20.0), started(nothing, 20.0)
    assert bare.speed.tobytes() == touched.speed.tobytes()
    assert bare.bit_speed.tobytes() == touched.bit_speed.tobytes()


def test_motion_with_sliding_friction_converges_with_the_square_of_the_step() -> None:
    """Sections that are whole numbers of steps long at every step, a weakening that is smooth, no reversal."""
    distance = np.sqrt(PIPE.shear_modulus / PIPE.density) * 0.01 * (1 + 1e-9)
    system = replace(SYSTEM, string=(replace(PIPE, length=40 * distance), replace(COLLARS, length=3 * distance)))
    contact = WallContact(np.array([0.0, 43 * distance]), np.array([4.0]), np.array([1.0]), Weakening(8.0))

    def bit_speed(step: float) -> np.ndarray:
        time = step * (np.arange(round(40 / step), dtype=float) + 0.5)
        kick = 500 * np.exp(-(((time - 5) / 0.5) ** 2))
        steady = np.full(time.size, SPEED)
        rig = NonlinearRig(system, contact=contact)
        return simulate(rig, 0 * time, steady, kick, time_step=step).bit_speed

    finest = bit_speed(0.00125)
    coarse, middle, fine = (np.abs(bit_speed(step) - finest).max() for step in (0.01, 0.005, 0.0025))
    assert 3.4 < coarse / middle < 4.6
    assert 4.0 < middle / fine < 6.0


def test_same_input_gives_the_same_bits() -> None:
    contact = wall_contact(FORCES, 0.3, 0.2)
    assert started(contact, 15.0).bit_speed.tobytes() == started(contact, 15.0).bit_speed.tobytes()


def test_bit_has_no_inertia_of_its_own() -> None:
    """A string that ends bare, in contact, starts and turns like any other."""
    result = started(wall_contact(FORCES, 0.3, 0.2), 60.0, replace(STEADIED, bit=Bit(0.0)))
    assert result.bit_speed[-1] == pytest.approx(SPEED, rel=0.02)
    assert closure(result) < 1e-9
