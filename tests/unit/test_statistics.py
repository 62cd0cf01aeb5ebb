"""Distributions of ratios to an estimated variance, against their limits."""

import numpy as np
import pytest
from scipy.stats import chi2

from drillid.statistics import expected_ratio, sum_of_ratios_probability, to_normal


def test_many_degrees_of_freedom_are_chi_squared() -> None:
    freedom = np.full(50, 1e7)
    result = sum_of_ratios_probability(60.0, freedom, np.ones(50), fitted=0.0)
    assert result == pytest.approx(chi2.sf(120.0, 100), rel=1e-4)
    np.testing.assert_allclose(expected_ratio([1.0, 2.0, 18.0]), [np.inf, 2.0, 18 / 17])
    ratios = np.array([-2.0, 0.0, 1.5])
    np.testing.assert_allclose(to_normal(ratios, np.full(3, 1e8)), ratios, atol=1e-6)
