"""The measured motor: what its simulation lacks is a first-order lag, found on half of the periods."""

from pathlib import Path

import numpy as np
import pytest

from benchmarks.discoveries.motor_fit import CANDIDATES, DATA, MotorFit, MotorMobility, draw, fit_motor, halves
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
    assert np.median(odd.deviation / size) < 0.01
    spread = np.sqrt(odd.deviation**2 + even.deviation**2)
    assert np.median(np.abs(odd.mobility - even.mobility) / spread) < 1.5


def test_the_lag_alone_explains_nearly_all_on_periods_that_had_no_part_in_the_fit(fits: dict[str, MotorFit]) -> None:
    plain, loss, lag, second = (fits[name] for name in NAMES)
    assert lag.held_out < plain.held_out / 100
    assert lag.relative < 0.12 < plain.relative
    assert loss.held_out > 0.9 * plain.held_out
    assert second.held_out > 0.9 * lag.held_out
    assert lag.figures["lag"] == pytest.approx(0.008, rel=0.1)


def test_an_extension_never_fits_worse_than_what_it_extends(fits: dict[str, MotorFit]) -> None:
    plain, loss, lag, second = (fits[name].misfit for name in NAMES)
    assert loss <= plain * (1 + 1e-6)
    assert second <= lag * (1 + 1e-6) <= plain


def test_what_is_left_is_far_above_the_spread_and_is_said_to_be(fits: dict[str, MotorFit]) -> None:
    assert fits["+ first-order lag"].misfit > 10
    assert fits["+ first-order lag"].rough > 0.02


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
        modelled = CANDIDATES[name][0](fit.figures, laplace(measured[1].frequency))
        np.testing.assert_allclose(line(size, name)[1], np.abs(modelled))
        rms = np.sqrt(np.mean(np.square(np.asarray(drawn_misfit.get_ydata(), dtype=float))))
        assert rms == pytest.approx(fit.relative, rel=1e-6)
    check_visible(figures[0])
