"""The window from which a law is learnt: which of its samples count."""

from typing import Any

import numpy as np
import pytest

from drillid.discrepancy.learning.law_kinds import CouplingLaw
from drillid.discrepancy.learning.law_spline import LawSpline
from drillid.discrepancy.learning.law_window import LawWindow
from drillid.discrepancy.products.extended_model import less_tangent


def test_every_whole_period_of_the_record_counts() -> None:
    """Though 603 samples at 10 Hz over 20.1 s are 2.9999999999999996 in floating point."""
    periods, samples, rate = 3, 201, 10.0
    sweep = np.tile(np.sin(2 * np.pi * np.arange(samples) / samples), periods)
    speed = np.repeat([1.0, 1.0, 4.0], samples)
    no_model: Any = None
    window = LawWindow.of(no_model, (sweep, speed), rate, samples / rate, (0.05, 3.0))
    assert window is not None
    assert abs(window.mean_speed - speed.mean()) < 0.01


@pytest.mark.parametrize("mean", [7.0, 8.0, 9.3, 12.5])
def test_a_law_about_a_mean_is_zero_there_with_no_slope_within_its_range_or_beyond(mean: float) -> None:
    spline = LawSpline(np.array([8.0, 9.0, 10.0]), np.array([20.0, 60.0, 40.0]), 8.0, 10.0)
    grid, law = spline.drawn(mean)
    whole = 30.0 * (grid - 9.0) ** 2
    for about in (law, less_tangent(grid, whole, mean)):
        near = np.clip(mean, grid[0], grid[-1])
        value, slope = (np.interp(near, grid, curve) for curve in (about, np.gradient(about, grid)))
        # differences at the ends of a curve are of first order
        assert value + slope * (mean - near) == pytest.approx(0.0, abs=4.0)


def test_a_coupling_whose_mean_torque_is_not_logged_has_a_range_about_its_mean() -> None:
    knots = np.array([0.0])
    about_mean, logged = (LawSpline(knots, knots, low, low + 800.0) for low in (-400.0, 9600.0))
    assert "from -0.4 to 0.4 kN m about its mean, a cubic spline" in CouplingLaw(at=0.5).words("1", about_mean)
    assert "from 9.6 to 10.4 kN m, a cubic spline" in CouplingLaw(at=0.5).words("1", logged)
