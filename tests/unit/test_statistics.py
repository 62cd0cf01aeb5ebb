"""Widths of mixtures against closed form and sampling."""

import numpy as np
import pytest
from scipy.stats import chi2, norm

from drillid.statistics import expected_ratio, mixture_half_width, sum_of_ratios_probability, to_normal


def test_one_component_is_its_own_deviation() -> None:
    means, deviations = np.array([[3.0, -1e5, 0.0]]), np.array([[0.2, 40.0, 1e-9]])
    np.testing.assert_allclose(mixture_half_width(np.ones(1), means, deviations), deviations[0], rtol=1e-6)


def test_components_alike_are_one() -> None:
    weights = np.array([0.2, 0.5, 0.3])
    found = mixture_half_width(weights, np.full((3, 1), 7.0), np.full((3, 1), 2.0))
    np.testing.assert_allclose(found, 2.0, rtol=1e-9)


def test_two_narrow_components_span_their_distance() -> None:
    found = mixture_half_width(np.full(2, 0.5), np.array([[-1.0], [1.0]]), np.full((2, 1), 1e-6))
    np.testing.assert_allclose(found, 1 / norm.ppf(0.975), rtol=1e-5)


@pytest.mark.parametrize("apart", [0.5, 2.0, 6.0])
def test_mixtures_against_samples(apart: float) -> None:
    random = np.random.default_rng(1)
    weights, means, deviations = np.array([0.5, 0.5]), np.array([0.0, apart]), np.array([1.0, 0.3])
    chosen = random.integers(0, 2, 400_000)
    samples = means[chosen] + deviations[chosen] * random.standard_normal(chosen.size)
    low, high = np.quantile(samples, [0.025, 0.975])
    found = mixture_half_width(weights, means[:, None], deviations[:, None])
    np.testing.assert_allclose(found, (high - low) / 2 / norm.ppf(0.975), rtol=0.01)


def test_many_degrees_of_freedom_are_chi_squared() -> None:
    freedom = np.full(50, 1e7)
    found = sum_of_ratios_probability(60.0, freedom, np.ones(50), fitted=0.0)
    assert found == pytest.approx(chi2.sf(120.0, 100), rel=1e-4)
    np.testing.assert_allclose(expected_ratio([1.0, 2.0, 18.0]), [np.inf, 2.0, 18 / 17])
    ratios = np.array([-2.0, 0.0, 1.5])
    np.testing.assert_allclose(to_normal(ratios, np.full(3, 1e8)), ratios, atol=1e-6)
