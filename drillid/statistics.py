"""Distributions of what is divided by a noise variance that is itself estimated.

A complex error over its estimated variance, with ν complex degrees of freedom, follows
F(2, 2ν) when doubled shares are counted; sums of such terms are matched by moments.
"""

import numpy as np
from numpy.typing import ArrayLike
from scipy.special import chdtrc, ndtri, stdtr

from drillid.arrays import Floats

TWO_SIDED = 1.96
"""Standard errors to either side of a value that a 95 % interval holds."""
ONE_SIDED = 1.645
"""Standard errors below a value to its 95 % limit; to either side they make a 90 % interval."""


def expected_ratio(degrees_of_freedom: ArrayLike) -> Floats:
    """Mean of |error|²/estimated variance, ν/(ν − 1); infinite up to ν = 1."""
    freedom = np.asarray(degrees_of_freedom, dtype=float)
    return np.where(freedom > 1, freedom / np.maximum(freedom - 1, 1e-9), np.inf)


def sum_of_ratios_probability(
    total: float, degrees_of_freedom: Floats, sharing: Floats, fitted: float, per_ratio: float = 1.0
) -> float:
    """Chance of a larger sum of |error|²/estimated variance when the errors are Gaussian.

    The sum is matched in mean and variance by a scaled χ². The variance counts that one
    estimated variance serves `sharing` terms.

    Parameters
    ----------
    total : sum over complex terms of |error|²/estimated variance
    degrees_of_freedom, sharing : shape (terms,)
    fitted : complex parameters that the errors lost to a fit
    per_ratio : mean of one term's |error|²/true variance
    """
    freedom = np.maximum(degrees_of_freedom, 2.1)
    mean_each = expected_ratio(freedom)
    own = mean_each**2 * (freedom - 1) / (freedom - 2)
    common = mean_each**2 / (freedom - 2)
    kept = max(1 - fitted / (freedom.size * per_ratio), 1e-9)
    mean = float(np.sum(mean_each)) * per_ratio * kept
    variance = float(np.sum(own * per_ratio + (sharing - 1) * common * per_ratio**2)) * kept
    scale = variance / (2 * mean)
    return float(chdtrc(mean / scale, total / scale))


def to_normal(ratio: Floats, degrees_of_freedom: Floats) -> Floats:
    """Real errors over their estimated deviation (Student's t with 2ν degrees of freedom) as standard normal values."""
    return np.asarray(ndtri(np.clip(stdtr(2 * degrees_of_freedom, ratio), 1e-300, 1 - 1e-16)), dtype=float)
