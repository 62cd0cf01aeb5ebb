"""The line of calibration is found again from verdicts that follow it."""

import numpy as np
import pytest
from scipy.special import expit

from benchmarks.blind.calibrate import calibration_line, main
from drillid.errors import SettingsError


def test_a_line_is_found_again_from_verdicts_that_follow_it() -> None:
    random = np.random.default_rng(5)
    posterior = random.uniform(-6, 10, 20000)
    right = (random.random(posterior.size) < expit(-0.7 + 0.4 * posterior)).astype(float)
    found = calibration_line(posterior, right)
    assert found.intercept == pytest.approx(-0.7, abs=0.1)
    assert found.slope == pytest.approx(0.4, abs=0.03)


def test_a_few_verdicts_leave_the_line_near_the_posterior() -> None:
    found = calibration_line(np.array([2.0]), np.array([1.0]))
    assert 0.5 < found.slope < 2


def test_seeds_of_a_block_are_not_calibrated_on() -> None:
    with pytest.raises(SettingsError, match="seeds 140000 to 140699"):
        main(first=139_990, cases=20)
