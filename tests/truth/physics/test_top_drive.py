"""Controllers against their block diagram, solved as equations, and against their closed forms."""

import numpy as np
import pytest

from drillid.physics.equipment import (
    Bit,
    Controller,
    DrillingSystem,
    ImpedanceMatching,
    Section,
    TopDrive,
    polar_moment,
)
from drillid.physics.responses import command_mobility, laplace, string_admittance, top_reflection, torque_mobility
from drillid.physics.top_drive import control, top_admittance, torque_transfers

S = laplace(np.geomspace(0.05, 5.0, 61))
PIPE = Section(3000.0, polar_moment(0.1397, 0.1214), kappa=100.0, delta=2e8)
BIT = Bit(60.0, 20.0)
Y0 = PIPE.characteristic_admittance
MATCHING = ImpedanceMatching(1 / Y0, 1080.0, low_pass=0.03, high_pass=8.0)
CONTROLLERS = {
    "P": Controller(1500.0),
    "PI": Controller(1500.0, 800.0),
    "filters": Controller(1500.0, 800.0, 0.06, 0.03),
    "inertia compensation": Controller(1500.0, 800.0, 0.02, 0.01, 600.0, 0.1),
    "matching": Controller(40e3, 20e3, 0.01, 0.02, matching=MATCHING),
    "all": Controller(9e3, 4e3, 0.05, 0.02, 300.0, 0.2, ImpedanceMatching(1 / Y0, 1000.0)),
}


@pytest.mark.parametrize("controller", CONTROLLERS.values(), ids=CONTROLLERS.keys())
def test_block_diagram(controller: Controller) -> None:
    """Speed, command, motor torque and estimated string torque as unknowns of the diagram's own equations."""
    top_drive = TopDrive(1100.0, 0.04, controller, lag=0.02, gain=0.95)
    system = DrillingSystem(top_drive, (PIPE,), BIT)
    matching = controller.matching or ImpedanceMatching(0.0, 0.0)
    expected = []
    for s, below in zip(S, string_admittance(system, S), strict=True):
        filtered = 1 / (1 + s * matching.low_pass)
        if matching.high_pass is not None:
            filtered *= s * matching.high_pass / (1 + s * matching.high_pass)
        acceleration = controller.compensated_inertia * s / (1 + s * controller.compensation_filter)
        gain = controller.proportional + controller.integral / s - acceleration
        shaped = gain / (1 + s * controller.torque_filter)
        driven = 0.95 * np.exp(-0.04 * s) / (1 + 0.02 * s)
        # unknowns: speed, command, motor torque, string torque
        equations = np.array(
            [
                [1100.0 * s + below, 0, -1, 0],
                [shaped / (1 + s * controller.speed_filter), 1, 0, shaped * matching.impedance * filtered],
                [0, -driven, 1, 0],
                [matching.inertia * s, 0, -1, 1],
            ]
        )
        speed, command, _, _ = np.linalg.solve(equations, [0, 1, 0, 0])
        expected.append((speed, speed / command))
    np.testing.assert_allclose(command_mobility(system, S), [row[0] for row in expected], rtol=1e-10)
    np.testing.assert_allclose(torque_mobility(system, S), [row[1] for row in expected], rtol=1e-10)


def test_the_logged_command_gives_the_controller() -> None:
    """1/M − A H e^(−sT_d)/D equals the controller-free inverse mobility."""
    system = DrillingSystem(TopDrive(1100.0, 0.04, CONTROLLERS["filters"], 0.02), (PIPE,), BIT)
    difference = 1 / command_mobility(system, S) - 1 / torque_mobility(system, S)
    np.testing.assert_allclose(difference, control(CONTROLLERS["filters"], S), rtol=1e-9)


def test_compensation_takes_inertia_off_a_prompt_drive() -> None:
    compensated = TopDrive(1100.0, 0.0, Controller(1500.0, 800.0, compensated_inertia=700.0))
    lighter = TopDrive(400.0, 0.0, Controller(1500.0, 800.0))
    np.testing.assert_allclose(top_admittance(compensated, S), top_admittance(lighter, S), rtol=1e-12)


def test_stiff_matching_hides_the_inertia() -> None:
    """A very stiff controller, a prompt drive and the right inertia: the pipe sees its own admittance."""
    top_drive = TopDrive(1100.0, 0.0, Controller(1e9, matching=ImpedanceMatching(1 / Y0, 1100.0)))
    np.testing.assert_allclose(top_admittance(top_drive, S), Y0, rtol=1e-4)
    lossless = DrillingSystem(top_drive, (Section(PIPE.length, PIPE.polar_moment),), BIT)
    assert np.max(np.abs(top_reflection(lossless, S))) < 1e-4


def test_each_control_reflects_less_than_the_one_before() -> None:
    """Stiff speed control, soft torque, inertia compensation, matching: power sent back near the first mode."""
    s = laplace(np.linspace(0.2, 0.4, 41))
    controls = {
        "stiff": Controller(40e3, 20e3),
        "soft": Controller(1500.0, 800.0),
        "compensated": Controller(700.0, 300.0, compensated_inertia=700.0, compensation_filter=0.05),
        "matched": Controller(40e3, 20e3, matching=ImpedanceMatching(1 / Y0, 1100.0, 0.03, 8.0)),
    }
    power = [
        np.mean(np.abs(top_reflection(DrillingSystem(TopDrive(1100.0, 0.02, control), (PIPE,), BIT), s)) ** 2)
        for control in controls.values()
    ]
    assert power == sorted(power, reverse=True)
    assert power[0] > 0.9
    assert power[-1] < 0.1


def test_reflection_limits() -> None:
    clamped = DrillingSystem(TopDrive(1e12, 0.0, Controller(0.0)), (PIPE,), BIT)
    free = DrillingSystem(TopDrive(0.0, 0.0, Controller(0.0)), (PIPE,), BIT)
    np.testing.assert_allclose(top_reflection(clamped, S), -1, rtol=1e-6)
    np.testing.assert_allclose(top_reflection(free, S), 1, rtol=1e-12)


def test_without_feedback_of_the_string_torque_the_drive_alone_carries_the_sweep() -> None:
    top_drive = TopDrive(1100.0, 0.04, Controller(1500.0), lag=0.02, gain=0.9)
    command_transfer, feedback = torque_transfers(top_drive, S)
    np.testing.assert_allclose(command_transfer, 0.9 * np.exp(-0.04 * S) / (1 + 0.02 * S), rtol=1e-14)
    np.testing.assert_allclose(feedback, 1500.0 * command_transfer, rtol=1e-14)
