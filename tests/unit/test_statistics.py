"""Distributions of ratios to an estimated variance, against their limits."""

import numpy as np
import pytest
from scipy.spatial.distance import pdist
from scipy.stats import chi2

from drillid.statistics import expected_ratio, pairwise_distance, sum_of_ratios_probability, to_normal


def test_many_degrees_of_freedom_are_chi_squared() -> None:
    freedom = np.full(50, 1e7)
    result = sum_of_ratios_probability(60.0, freedom, np.ones(50), fitted=0.0)
    assert result == pytest.approx(chi2.sf(120.0, 100), rel=1e-4)
    np.testing.assert_allclose(expected_ratio([1.0, 2.0, 18.0]), [np.inf, 2.0, 18 / 17])
    ratios = np.array([-2.0, 0.0, 1.5])
    np.testing.assert_allclose(to_normal(ratios, np.full(3, 1e8)), ratios, atol=1e-6)


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
