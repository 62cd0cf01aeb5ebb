"""The fit of a parameter's course within a window."""

import numpy as np
import pytest

from drillid.discrepancy.detectors.course import ChangingWindow
from drillid.discrepancy.detectors.residual_record import ResidualRecord, WindowRecord
from drillid.excitation.torques import SWEEP_PERIOD, exponential_sweeps
from drillid.physics.parameters import DAMPING_BHA, LENGTH, SCALES
from tests.simulated import RATE, SHALLOW

SECONDS = 240.0
STEP = 1e-5
"""Relative, of the finite differences."""


@pytest.fixture(scope="module")
def residual() -> ResidualRecord:
    time = np.arange(round(SECONDS * RATE)) / RATE
    sweep = exponential_sweeps(time, SHALLOW.sweep_amplitude)
    noise = 0.01 * np.random.default_rng(0).standard_normal(time.size)
    missing = np.full(time.size, np.nan)
    return ResidualRecord(
        WindowRecord(sweep, 12 + noise, missing, RATE, SWEEP_PERIOD, SHALLOW.parameters, SHALLOW.known)
    )


@pytest.mark.parametrize("parameter", [DAMPING_BHA, LENGTH])
@pytest.mark.parametrize("shares", [(1.1,), (0.8, 1.4), (0.8, 1.4, 0.43), (0.7, 0.9, 1.3, 1.2, 1.0)])
def test_slopes_of_a_course_are_those_of_its_residual(
    residual: ResidualRecord, parameter: int, shares: tuple[float, ...]
) -> None:
    window = ChangingWindow(parameter, residual)
    course = window.level * np.array(shares)
    if len(shares) == 3:
        course[2] = shares[2]
    values = np.append(course, window.fitted[window.others])
    scale = np.append(course, SCALES[window.others])
    _, slopes = window._residual(values, course.size)
    for place in range(values.size):
        step = np.zeros(values.size)
        step[place] = STEP * scale[place]
        before, after = (window._residual(values + side * step, course.size)[0] for side in (-1, 1))
        expected = (after - before) / (2 * step[place])
        deviation = np.linalg.norm(slopes[:, place] - expected)
        assert deviation < 1e-3 * np.linalg.norm(expected), place
