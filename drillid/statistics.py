"""Distributions of quantities divided by an estimated noise variance.

The squared magnitude of a complex Gaussian error over its estimated variance, with ν complex degrees of
freedom, follows F(2, 2ν); sums of such terms are matched by moments.
"""

import numpy as np
from numpy.typing import ArrayLike
from scipy.special import chdtrc, ndtri, stdtr

from drillid.arrays import Floats

TWO_SIDED = 1.96
"""Half-width of a 95 % interval in standard errors."""
ONE_SIDED = 1.645
"""Distance to a one-sided 95 % limit in standard errors; the half-width of a 90 % interval."""


def expected_ratio(degrees_of_freedom: ArrayLike) -> Floats:
    """Mean of |error|²/estimated variance, ν/(ν − 1); infinite up to ν = 1."""
    freedom = np.asarray(degrees_of_freedom, dtype=float)
    return np.where(freedom > 1, freedom / np.maximum(freedom - 1, 1e-9), np.inf)


def sum_of_ratios_probability(
    total: float, degrees_of_freedom: Floats, sharing: Floats, fitted: float, per_ratio: float = 1.0
) -> float:
    """Probability of a larger sum of |error|²/estimated variance when the errors are Gaussian.

    The sum is matched in mean and variance by a scaled χ². The variance allows for
    `sharing` terms that have one estimated variance in common.

    Parameters
    ----------
    total : sum over complex terms of |error|²/estimated variance
    degrees_of_freedom, sharing : shape (terms,)
    fitted : complex parameters fitted to the data, degrees of freedom that the errors have lost
    per_ratio : mean of one term's |error|²/true variance
    """
    freedom = np.maximum(degrees_of_freedom, 2.1)
    mean_each = expected_ratio(freedom)
    individual = mean_each**2 * (freedom - 1) / (freedom - 2)
    common = mean_each**2 / (freedom - 2)
    kept = max(1 - fitted / (freedom.size * per_ratio), 1e-9)
    mean = float(np.sum(mean_each)) * per_ratio * kept
    variance = float(np.sum(individual * per_ratio + (sharing - 1) * common * per_ratio**2)) * kept
    scale = variance / (2 * mean)
    return float(chdtrc(mean / scale, total / scale))


def to_normal(ratio: Floats, degrees_of_freedom: Floats) -> Floats:
    """Real errors over their estimated deviation (Student's t with 2ν degrees of freedom) as standard normal values."""
    return np.asarray(ndtri(np.clip(stdtr(2 * degrees_of_freedom, ratio), 1e-300, 1 - 1e-16)), dtype=float)
