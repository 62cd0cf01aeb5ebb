"""The measured motor: its mobility is as documented, and the documented model does not fit it."""

from pathlib import Path

import numpy as np
import pytest

from benchmarks.discoveries.motor_fit import (
    CANDIDATES,
    DATA,
    MotorFit,
    MotorMobility,
    draw,
    fit_motor,
    halves,
    motor_mobility,
    read_motor,
)
from drillid.physics.responses import laplace
from tests.drawn import check_visible, kept_figures, line

NAMES = ("two inertias, delay", "+ loss factor of the coupling", "+ first-order lag", "+ lag, second lag")


@pytest.fixture(scope="module")
def measured() -> tuple[MotorMobility, MotorMobility]:
    if not DATA.is_file():
        pytest.skip(f"the motor's record is not at {DATA}")
    return halves()


@pytest.fixture(scope="module")
def fits(measured: tuple[MotorMobility, MotorMobility]) -> dict[str, MotorFit]:
    return {name: fit_motor(name, *measured) for name in NAMES}


def test_the_mobility_has_its_known_extremes_and_repeats_from_period_to_period(
    measured: tuple[MotorMobility, MotorMobility],
) -> None:
    odd, even = measured
    size = np.abs(odd.mobility)
    assert odd.frequency[np.argmin(np.where(odd.frequency < 70, size, np.inf))] == pytest.approx(53, abs=1)
    assert odd.frequency[np.argmax(np.where(odd.frequency > 60, size, 0))] == pytest.approx(77, abs=1)
    spread = np.sqrt(odd.deviation**2 + even.deviation**2)
    assert np.mean(np.abs((odd.mobility - even.mobility) / spread) ** 2) < 1


def test_the_spread_between_all_periods_is_the_documented_one(
    measured: tuple[MotorMobility, MotorMobility],
) -> None:
    current, speed = read_motor(DATA)
    whole = motor_mobility(current[1:], speed[1:])
    assert np.median(whole.deviation / np.abs(whole.mobility)) == pytest.approx(0.004, rel=0.1)


def test_two_inertias_with_a_delay_do_not_fit(fits: dict[str, MotorFit]) -> None:
    plain = fits["two inertias, delay"]
    assert plain.misfit > 1000
    assert plain.held_out > 1000


def test_an_extension_never_fits_worse_than_what_it_extends(fits: dict[str, MotorFit]) -> None:
    plain, loss, lag, second = (fits[name].misfit for name in NAMES)
    assert loss <= plain * (1 + 1e-6)
    assert second <= lag * (1 + 1e-6) <= plain


def test_the_figure_is_drawn(
    measured: tuple[MotorMobility, MotorMobility], fits: dict[str, MotorFit], tmp_path: Path
) -> None:
    with kept_figures() as figures:
        draw(measured[1], list(fits.values()), tmp_path / "motor.png")
    size, phase, misfit = figures[0].axes
    labels = [axis.get_ylabel() for axis in (size, phase, misfit)]
    assert labels == ["mobility, rad/s per A", "phase, °", "relative misfit"]
    assert misfit.get_xlabel() == "frequency, Hz"
    frequency, drawn = line(size, "measured, even periods")
    np.testing.assert_allclose(frequency, measured[1].frequency)
    np.testing.assert_allclose(drawn, np.abs(measured[1].mobility))
    for name, fit, drawn_misfit in zip(fits, fits.values(), misfit.lines[1:], strict=True):
        modelled = CANDIDATES[name][0](fit.parameters, laplace(measured[1].frequency))
        np.testing.assert_allclose(line(size, name)[1], np.abs(modelled))
        rms = np.sqrt(np.mean(np.square(np.asarray(drawn_misfit.get_ydata(), dtype=float))))
        assert rms == pytest.approx(fit.relative, rel=1e-6)
    check_visible(figures[0])
