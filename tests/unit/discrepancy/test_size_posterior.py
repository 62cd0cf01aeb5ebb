"""Intervals of sizes against draws from their prior and their errors."""

import numpy as np
import pytest

from drillid.discrepancy.catalogue import Size
from drillid.discrepancy.inference.size_posterior import size_interval
from drillid.discrepancy.rules import WIDE_PRIOR

ONE_SIDED, TWO_SIDED = Size("lag", "s", 1.0, 0.0, 1e3), Size("gain", "1", 1.0, -1e3, 1e3)


def _fitted(size: float, error: float) -> tuple[float, float]:
    """Estimate and error of a fit whose prior is the wide one, from an estimate by the data alone."""
    precision = error**-2 + WIDE_PRIOR**-2
    return size * error**-2 / precision, precision**-0.5


@pytest.mark.parametrize("size", [ONE_SIDED, TWO_SIDED], ids=["one-sided", "two-sided"])
def test_intervals_hold_95_percent_of_sizes_from_the_prior(size: Size) -> None:
    generator = np.random.default_rng(0)
    drawn = generator.standard_normal(4000) * generator.choice([1.0, WIDE_PRIOR], 4000)
    if size.low == 0:
        drawn = np.abs(drawn)
    seen = drawn + 0.8 * generator.standard_normal(drawn.size)
    if size.low == 0:
        drawn, seen = drawn[seen > 0], seen[seen > 0]
    held = [
        low <= true <= high
        for true, estimate in zip(drawn, seen, strict=True)
        for low, high in [size_interval(*_fitted(estimate, 0.8), size)]
    ]
    assert 0.94 < np.mean(held) < 0.965


def test_a_size_that_the_data_tell_has_the_interval_of_the_data() -> None:
    low, high = size_interval(*_fitted(3.0, 0.01), ONE_SIDED)
    assert (low, high) == pytest.approx((3 - 0.0196, 3 + 0.0196), abs=1e-4)


def test_bounds_end_an_interval() -> None:
    assert size_interval(*_fitted(0.1, 0.5), ONE_SIDED)[0] >= 0
    assert size_interval(*_fitted(9.9, 0.5), Size("lag", "s", 1.0, 0.0, 10.0))[1] == 10.0
