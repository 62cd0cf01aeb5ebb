"""What control that samples and holds adds to the cumulants of a delay, against the exact response at its readings."""

from typing import Any

import numpy as np
import pytest

from drillid.physics.dual_numbers import Dual
from drillid.physics.equipment import Controller, TopDrive
from drillid.physics.held_control import NO_FILTERS, Cumulants, Filters, Held, read_and_kept
from drillid.physics.responses import laplace
from drillid.physics.sensor import Recording
from drillid.physics.top_drive import drive


def cumulants(interval: Any, delay: Any, filters: Filters = NO_FILTERS) -> Cumulants:
    """What a command adds to its delay that is held and then read."""
    return read_and_kept(interval, delay, 0.0, filters)[0]


def top_drive(delay: float, held: Cumulants) -> TopDrive:
    """A top drive of 1 kg m² with the cumulants of held control."""
    variance, skewness, *higher = held
    return TopDrive(
        1.0, delay, Controller(0.0), hold_variance=variance, hold_skewness=skewness, hold_higher=tuple(higher)
    )


@pytest.mark.parametrize("interval", [0.01, 0.04])
@pytest.mark.parametrize("part", [0.0, 0.3, 0.5, 0.9])
def test_an_inertia_under_held_torque_moves_as_by_a_delay_of_these_cumulants(interval: float, part: float) -> None:
    # up to 4 Hz at an interval of 45 ms
    s, whole = laplace(np.linspace(0.01, 0.18, 15) / interval), 2
    delay = (whole + part + 0.5) * interval
    z = np.exp(s * interval)
    exact = z**-whole * (1 - part + part / z) * interval / (z - 1)
    np.testing.assert_allclose(drive(top_drive(delay, cumulants(interval, delay)), s) / s, exact, rtol=1e-3)


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

    variance, skewness, *higher = read_and_kept(interval, delay, offset)[1]
    record = Recording(clock_offset=offset, hold_variance=variance, hold_skewness=skewness, hold_higher=tuple(higher))
    np.testing.assert_allclose(record.transfer(s), speed(-offset) / speed(0.0), rtol=6e-4)


@pytest.mark.parametrize("part", [0.0, 0.3, 0.5, 0.9])
@pytest.mark.parametrize("relative", [0.1, 0.4])
def test_a_filter_before_the_reading_moves_and_weakens_what_is_folded(part: float, relative: float) -> None:
    interval, whole = 0.03, 2
    s, time_constant = laplace(np.linspace(0.01, 0.05, 9) / interval), relative * interval
    delay = (whole + part + 0.5) * interval
    z = np.exp(s * interval)

    def ramp(time: float) -> float:
        """Speed of an inertia, filtered, at a time after a unit torque on it begins."""
        return 0.0 if time <= 0 else time - time_constant * (1 - np.exp(-time / time_constant))

    begin = delay - interval / 2
    pulse = [ramp(k * interval - begin) - ramp((k - 1) * interval - begin) for k in range(60)]
    response = sum(value * z**-k for k, value in enumerate(pulse))
    # from there on the pulse has its final value, less what the filter still holds back
    last = z**-59.0 / (1 - 1 / z)
    exact = response + (pulse[-1] * last / z)
    held = top_drive(delay, cumulants(interval, delay, Filters(lag=time_constant)))
    np.testing.assert_allclose(drive(held, s) / (1 + s * time_constant) / s, exact, rtol=5e-4)


@pytest.mark.parametrize("order", [1, 2, 3, 4])
@pytest.mark.parametrize("filters", [(0.0,) * 5, (0.008, 0.003, 1e-5, 5e-6, 0.006)])
@pytest.mark.parametrize("delay", [0.047, 0.061])
def test_the_derivatives_of_the_cumulants_are_their_differences(
    delay: float, filters: tuple[float, ...], order: int
) -> None:
    at, steps = np.array([0.03, delay, 0.004, *filters]), np.array([1e-7] * 5 + [1e-9] * 2 + [1e-7])

    def of(interval: Any, delay: Any, offset: Any, *filters: Any) -> tuple[Any, ...]:
        read, later = read_and_kept(interval, delay, offset, Filters(*filters, order))
        return *read[:2], *later[:2]

    slopes = of(*(Dual(value, direction) for value, direction in zip(at, np.eye(at.size), strict=True)))
    sides = [np.subtract(of(*(at + step)), of(*(at - step))) for step in np.diag(steps)]
    for cumulant, expected in zip(slopes, np.array(sides).T / (2 * steps), strict=True):
        found = cumulant.full_tangents()
        np.testing.assert_allclose(found, expected, rtol=1e-5, atol=1e-6 * np.abs(expected).max())


def test_the_cumulants_have_no_steps() -> None:
    interval = 0.03
    for whole in (1, 2):
        ends = [(whole + 0.5) * interval + side for side in (-1e-12, 1e-12)]
        below, above = (cumulants(interval, end) for end in ends)
        np.testing.assert_allclose(below, above, atol=1e-12)


@pytest.mark.parametrize("interval", [0.01, 0.05, 0.2])
@pytest.mark.parametrize("filters", [NO_FILTERS, Filters(0.05, 0.02, 1e-5, 1e-5, 0.03, 3)])
def test_what_is_folded_is_the_same_at_many_frequencies_as_at_each(interval: float, filters: Filters) -> None:
    # many are interpolated where the control's rate is far above them; 5 Hz is the rate itself at the longest interval
    s, inertia, admittance = laplace(np.linspace(0.05, 4.9, 300)), 1500.0, 400.0
    held = Held.of(interval, 2.3 * interval, 0.004, filters, read_and_kept(interval, 2.3 * interval, 0.004, filters))
    together = np.stack(held.images(s, inertia, admittance))
    each = np.concatenate([np.stack(held.images(one[None], inertia, admittance)) for one in s], axis=-1)
    np.testing.assert_allclose(together * (inertia * s + admittance), each * (inertia * s + admittance), atol=1e-9)
