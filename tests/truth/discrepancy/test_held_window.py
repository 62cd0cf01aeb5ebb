"""Responses under control that samples and holds, against sums over multiples of its rate with the string as load."""

import numpy as np
import pytest

from drillid.arrays import Complex
from drillid.discrepancy.catalogue import WindowModel
from drillid.physics.equipment import Bit, Controller, DrillingSystem, Section, TopDrive, polar_moment
from drillid.physics.responses import laplace, string_admittance
from drillid.physics.sensor import Recording

S = laplace(np.linspace(0.05, 5.0, 200))
MULTIPLES = 200
PIPE = Section(3000.0, polar_moment(0.127, 0.1086), 250.0, 4e8)
CONTROLLER = Controller(600.0, 300.0)


def window_model(interval: float, delay: float, lag: float, corner: float, offset: float) -> WindowModel:
    system = DrillingSystem(TopDrive(1000.0, delay, CONTROLLER, lag=lag), (PIPE,), Bit(250.0, 60.0))
    recording = Recording(clock_offset=offset, filter_frequency=corner, filter_order=1)
    return WindowModel(system, recording, control_interval=interval)


def read(model: WindowModel, lag: float, offset: float) -> Complex:
    """Speed at readings per torque commanded, rad/(N m s): the steps of the command at all multiples, each filtered."""
    h, total = model.control_interval, np.zeros_like(S)
    start = model.system.top_drive.delay - h / 2 + offset
    for multiple in range(-MULTIPLES, MULTIPLES + 1):
        s = S + 2j * np.pi * multiple / h
        held = (
            (1 - np.exp(-S * h)) / (s * h) * np.exp(-s * start) / (1 + s * model.system.top_drive.lag) / (1 + s * lag)
        )
        total = total + held / (1000.0 * s + string_admittance(model.system, s))
    return total


@pytest.mark.parametrize("interval", [0.01, 0.03, 0.045])
@pytest.mark.parametrize("part", [0.02, 0.3, 0.5, 0.9])
@pytest.mark.parametrize(("lag", "corner", "offset"), [(0.0, np.inf, 0.0), (0.005, np.inf, 0.012), (0.0, 11.0, -0.004)])
def test_recorded_responses_are_those_of_the_readings(
    interval: float, part: float, lag: float, corner: float, offset: float
) -> None:
    model = window_model(interval, (1.5 + part) * interval, lag, corner, offset)
    # the sum of the errors up to now leads their trapezoidal sum by half an interval
    now = 1 - np.exp(-S * interval)
    control = CONTROLLER.proportional + CONTROLLER.integral * interval * (1 / now - 0.5)
    recorded, own = read(model, 1 / (2 * np.pi * corner), offset), read(model, 0.0, 0.0)
    # the string reflects a little at the multiples, where its characteristic admittance stands for it
    np.testing.assert_allclose(model.mobility(S), recorded / (1 + own * control), rtol=6e-4)
    np.testing.assert_allclose(model.control(S), control * own / recorded, rtol=6e-4)
