"""What the response of a control is known to: noise, and what seldom readings fold into every line."""

import numpy as np
import pytest

from drillid.arrays import Complex, Floats
from drillid.discrepancy.evidence import Evidence, OperatingPoints
from drillid.discrepancy.inference.control_errors import control_errors
from drillid.fits.datasheet import COMMAND_BANDS, DataSheet
from drillid.physics.equipment import Controller
from drillid.physics.responses import laplace
from drillid.physics.top_drive import control

WINDOWS, NOISE, FLOOR = 4, 1e-3, 3e-3
FREQUENCY = np.linspace(0.1, 4.0, 400)
CONTROLLER = Controller(1500.0, 800.0)
STATED = np.asarray(control(CONTROLLER, laplace(FREQUENCY)))
FILTER = 1 / (1 + 0.05 * laplace(FREQUENCY))


def common_variance(folded: Complex) -> Floats:
    """Relative variance (F,) common to the windows of a filtered control with a relative error in every line."""
    generator, shape = np.random.default_rng(1), (WINDOWS, FREQUENCY.size)
    noise = NOISE * (generator.standard_normal((*shape, 2)) @ [1, 1j]) / np.sqrt(2)
    ones, values = np.ones(shape), np.ones(WINDOWS)
    evidence = Evidence(
        FREQUENCY,
        ones + 0j,
        ones,
        5 * ones,
        ones > 0,
        OperatingPoints(values, values, values, values, values),
        DataSheet(CONTROLLER),
        np.ones((WINDOWS, 8)),
        STATED * FILTER * (1 + noise + folded),
        NOISE**2 * np.abs(STATED) ** 2 * ones,
    )
    own, common = control_errors(evidence, STATED, evidence.used)
    np.testing.assert_allclose(own, NOISE**2 * np.abs(STATED) ** 2 * ones)
    return np.asarray((common / np.abs(STATED) ** 2)[0])


def test_a_filter_is_no_error() -> None:
    bands = FREQUENCY.size / COMMAND_BANDS
    np.testing.assert_allclose(common_variance(0 * FILTER), bands * FLOOR**2)


def test_what_is_folded_into_a_line_is_an_error_of_all_windows() -> None:
    angle = np.random.default_rng(2).uniform(0, 2 * np.pi, FREQUENCY.size)
    error = 0.04 * np.where(FREQUENCY > 2.0, FREQUENCY / 4.0, 0.0)
    added = common_variance(error * np.exp(1j * angle)) - FREQUENCY.size / COMMAND_BANDS * FLOOR**2
    high, low = FREQUENCY > 2.3, FREQUENCY < 1.7
    assert np.median(added[high] / np.abs(FILTER[high] * error[high]) ** 2) == pytest.approx(1.4, rel=0.3)
    assert np.abs(added[low]).max() < 1e-12
