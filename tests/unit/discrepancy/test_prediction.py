"""The mean period of a noisy series, and its error."""

import numpy as np
import pytest

from drillid.discrepancy.products.prediction import PHASES, mean_period


@pytest.mark.parametrize("periods", [4, 25])
def test_the_error_of_the_mean_period_falls_with_the_root_of_the_periods(periods: int) -> None:
    rate = 50.0
    noise = 0.3 * np.random.default_rng(periods).standard_normal(periods * PHASES)
    mean, error = mean_period(noise, rate, PHASES / rate)
    assert error == pytest.approx(0.3 / np.sqrt(periods), rel=0.03)
    assert np.std(mean) == pytest.approx(0.3 / np.sqrt(periods), rel=0.05)
