"""What control that samples and holds adds to the variance of a delay, against the exact response at its readings."""

import numpy as np
import pytest

from drillid.physics.equipment import Controller, TopDrive
from drillid.physics.held_control import LONGEST, hold_variance, hold_variance_prior, reading_variance_prior
from drillid.physics.responses import laplace
from drillid.physics.top_drive import drive


@pytest.mark.parametrize("interval", [0.01, 0.04])
@pytest.mark.parametrize("part", [0.0, 0.3, 0.5, 0.9])
def test_an_inertia_under_held_torque_moves_as_by_a_delay_of_that_variance(interval: float, part: float) -> None:
    # up to half a radian an interval
    s, whole = laplace(np.linspace(0.01, 0.08, 15) / interval), 2
    delay = (whole + part + 0.5) * interval
    z = np.exp(s * interval)
    exact = z**-whole * (1 - part + part / z) * interval / (z - 1)
    held = TopDrive(1.0, delay, Controller(0.0), hold_variance=float(hold_variance(interval, delay)))
    np.testing.assert_allclose(drive(held, s) / s, exact, rtol=3e-3)


def test_the_prior_of_a_known_interval_is_that_of_its_delays() -> None:
    interval, delay = 0.03, 0.05
    mean, deviation = hold_variance_prior(interval, delay, 1e-6)
    assert mean == pytest.approx(float(hold_variance(interval, delay)), rel=1e-3)
    assert deviation < 1e-3 * interval**2
    mean, deviation = hold_variance_prior(interval, delay, np.inf)
    assert mean == pytest.approx(interval**2 / 12, rel=0.1)
    assert deviation == pytest.approx(interval**2 / np.sqrt(180), rel=0.1)


def test_an_unknown_interval_may_be_any_up_to_the_longest() -> None:
    mean, deviation = hold_variance_prior(np.nan, 0.05, np.inf)
    assert 0 < mean < LONGEST**2 / 12
    assert mean + 4 * deviation > LONGEST**2 / 6
    assert reading_variance_prior(1e-4, 0.002)[1] < 1e-8 < reading_variance_prior(np.nan, 0.002)[1]
