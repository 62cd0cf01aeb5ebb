"""What control that samples and holds adds to the cumulants of a delay, against the exact response at its readings."""

import numpy as np
import pytest

from drillid.physics.equipment import Controller, TopDrive
from drillid.physics.held_control import (
    LONGEST,
    hold_skewness,
    hold_variance,
    hold_variance_prior,
    reading_skewness,
    reading_variance_prior,
)
from drillid.physics.responses import laplace
from drillid.physics.sensor import Recording
from drillid.physics.top_drive import drive


@pytest.mark.parametrize("interval", [0.01, 0.04])
@pytest.mark.parametrize("part", [0.0, 0.3, 0.5, 0.9])
def test_an_inertia_under_held_torque_moves_as_by_a_delay_of_these_cumulants(interval: float, part: float) -> None:
    # up to half a radian an interval
    s, whole = laplace(np.linspace(0.01, 0.08, 15) / interval), 2
    delay = (whole + part + 0.5) * interval
    z = np.exp(s * interval)
    exact = z**-whole * (1 - part + part / z) * interval / (z - 1)
    cumulants = float(hold_variance(interval, delay)), float(hold_skewness(interval, delay))
    held = TopDrive(1.0, delay, Controller(0.0), hold_variance=cumulants[0], hold_skewness=cumulants[1])
    np.testing.assert_allclose(drive(held, s) / s, exact, rtol=4e-4)


@pytest.mark.parametrize("offset", [-0.007, 0.004, 0.011])
@pytest.mark.parametrize("part", [0.0, 0.3, 0.8])
def test_a_clock_that_is_late_holds_the_speed_between_two_readings(offset: float, part: float) -> None:
    interval = 0.03
    s, begin = laplace(np.linspace(0.01, 0.08, 15) / interval), (1 + part) * interval
    delay = begin + interval / 2

    def speed(time: float) -> np.ndarray:
        """Of an inertia, while a sinusoid's samples are held one after another from `begin` after they were taken."""
        held = np.floor((time - begin) / interval)
        return np.exp(s * held * interval) * (interval / (np.exp(s * interval) - 1) + time - begin - held * interval)

    record = Recording(
        clock_offset=offset,
        hold_variance=float(hold_variance(interval, delay + offset) - hold_variance(interval, delay)),
        hold_skewness=float(reading_skewness(interval, delay, offset)),
    )
    np.testing.assert_allclose(record.transfer(s), speed(-offset) / speed(0.0), rtol=6e-4)


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
    short, unknown = (reading_variance_prior(interval, 0.05, np.inf, 0.002) for interval in (1e-4, np.nan))
    assert short[1] < 1e-8 < unknown[1]
