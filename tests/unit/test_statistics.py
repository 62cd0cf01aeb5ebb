"""Distributions of ratios to an estimated variance, against their limits."""

import numpy as np
import pytest
from scipy.spatial.distance import pdist
from scipy.stats import binom, chi2

from drillid.statistics import expected_ratio, pairwise_distance, sum_of_ratios_probability, to_normal


def test_many_degrees_of_freedom_are_chi_squared() -> None:
    freedom = np.full(50, 1e7)
    result = sum_of_ratios_probability(60.0, freedom, np.ones(50), fitted=0.0)
    assert result == pytest.approx(chi2.sf(120.0, 100), rel=1e-4)
    np.testing.assert_allclose(expected_ratio([1.0, 2.0, 18.0]), [np.inf, 2.0, 18 / 17])
    ratios = np.array([-2.0, 0.0, 1.5])
    np.testing.assert_allclose(to_normal(ratios, np.full(3, 1e8)), ratios, atol=1e-6)


@pytest.mark.parametrize(("freedom", "shared"), [(6, 1), (10, 1), (15, 2)])
@pytest.mark.parametrize("rate", [0.01, 0.05])
def test_sums_exceed_their_quantiles_at_the_rate(freedom: int, shared: int, rate: float) -> None:
    rng, terms, draws = np.random.default_rng(3), 240, 4000
    errors = rng.exponential(size=(draws, terms))
    variances = np.repeat(rng.gamma(freedom, 1 / freedom, size=(draws, terms // shared)), shared, axis=1)
    totals = np.sum(errors / variances, axis=1)
    every = np.full(terms, float(freedom)), np.full(terms, float(shared))
    beyond = sum(sum_of_ratios_probability(float(total), *every, fitted=0.0) < rate for total in totals)
    # matched by its mean and variance, the distribution's tail is off by a tenth of the rate
    assert binom.sf(beyond - 1, draws, 1.1 * rate) > 1e-3


@pytest.mark.parametrize("seed", range(20))
def test_the_distance_at_a_place_is_that_among_all_pairs(seed: int) -> None:
    draw = np.random.default_rng(seed)
    values = draw.standard_normal(int(draw.integers(2, 80))) * 10.0 ** draw.integers(-8, 8)
    # ties, and values that are all equal
    values = np.round(values, 1) if seed % 3 == 0 else np.full_like(values, values[0]) if seed == 1 else values
    ordered = np.sort(values)
    distances = np.sort(pdist(ordered[:, None], "cityblock"))
    places = range(1, distances.size + 1, max(distances.size // 7, 1))
    assert [pairwise_distance(ordered, place) for place in places] == [distances[place - 1] for place in places]
