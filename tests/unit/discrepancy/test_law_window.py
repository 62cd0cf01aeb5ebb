"""The window from which a law is learnt: which of its samples count."""

from typing import Any

import numpy as np

from drillid.discrepancy.learning.law_kinds import CouplingLaw
from drillid.discrepancy.learning.law_spline import LawSpline
from drillid.discrepancy.learning.law_window import LawWindow


def test_every_whole_period_of_the_record_counts() -> None:
    """Though 603 samples at 10 Hz over 20.1 s are 2.9999999999999996 in floating point."""
    periods, samples, rate = 3, 201, 10.0
    sweep = np.tile(np.sin(2 * np.pi * np.arange(samples) / samples), periods)
    speed = np.repeat([1.0, 1.0, 4.0], samples)
    no_model: Any = None
    window = LawWindow.of(no_model, (sweep, speed), rate, samples / rate, (0.05, 3.0))
    assert window is not None
    assert abs(window.mean_speed - speed.mean()) < 0.01


def test_a_coupling_whose_mean_torque_is_not_logged_has_a_range_about_its_mean() -> None:
    knots = np.array([0.0])
    about_mean, logged = (LawSpline(knots, knots, low, low + 800.0) for low in (-400.0, 9600.0))
    assert "from -0.4 to 0.4 kN m about its mean, a cubic spline" in CouplingLaw(at=0.5).words("1", about_mean)
    assert "from 9.6 to 10.4 kN m, a cubic spline" in CouplingLaw(at=0.5).words("1", logged)
