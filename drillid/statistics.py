"""Distributions of quantities divided by an estimated noise variance, and distances between pairs of values.

The squared magnitude of a complex Gaussian error over its estimated variance, with ν complex degrees of
freedom, follows F(2, 2ν); sums of such terms are matched by moments.
"""

import numpy as np
from numpy.typing import ArrayLike
from scipy.special import chdtrc, fdtri, ndtr, ndtri, stdtr, stdtrit

from drillid.arrays import Floats

TWO_SIDED = 1.96
"""Half-width of a 95 % interval in standard errors."""
ONE_SIDED = 1.645
"""Distance to a one-sided 95 % limit in standard errors; the half-width of a 90 % interval."""
_BISECTIONS = 60
"""Number of bisections after which distances are equal in double precision."""


def student(normal: float, degrees_of_freedom: float) -> float:
    """Value of Student's t with the same probability of more as one of the normal distribution."""
    return float(stdtrit(degrees_of_freedom, ndtr(normal)))


def expected_ratio(degrees_of_freedom: ArrayLike) -> Floats:
    """Mean of |error|²/estimated variance, ν/(ν − 1); infinite up to ν = 1."""
    freedom = np.asarray(degrees_of_freedom, dtype=float)
    return np.where(freedom > 1, freedom / np.maximum(freedom - 1, 1e-9), np.inf)


def sharing(degrees_of_freedom: Floats, averages: Floats) -> Floats:
    """Number of frequencies that share a noise line: ν of the estimate over the n − 1 lines of each frequency."""
    return np.maximum(degrees_of_freedom / np.maximum(averages - 1, 1e-9), 1.0)


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
    variance = float(np.sum(individual * per_ratio + sharing * common * per_ratio**2)) * kept
    scale = variance / (2 * mean)
    return float(chdtrc(mean / scale, total / scale))


def mean_ratio_quantile(degrees_of_freedom: Floats, sharing: Floats, p_value: float) -> float:
    """Mean of |error|²/estimated variance over neighbours that Gaussian errors exceed with probability `p_value`.

    One ratio follows F(2, 2ν), and the mean of n with a common estimate F(2n, 2ν). Other means are matched in mean and
    variance by a scaled F(2n, 2μ). Estimates from sliding averages are correlated by the share of the averages that
    two neighbours have in common.

    Parameters
    ----------
    degrees_of_freedom : (neighbour,) ν, complex, of each estimated variance
    sharing : (neighbour,) distance at which two neighbours have independent estimates, in neighbours
    """
    count, freedom = degrees_of_freedom.size, np.maximum(degrees_of_freedom, 2.1)
    means = expected_ratio(freedom)
    common = means / np.sqrt(freedom - 2)
    distance = np.abs(np.subtract.outer(np.arange(count), np.arange(count)))
    overlap = np.maximum(1 - distance / sharing.mean(), 0.0)
    variance = np.sum(means**2 + common**2) + common @ overlap @ common
    # n times the squared coefficient of variation, which F(2n, 2μ) has as (n + μ − 1)/(μ − 2)
    relative = count * float(variance / np.sum(means) ** 2)
    matched = (count - 1 + 2 * relative) / max(relative - 1, np.finfo(float).eps)
    return float(np.mean(means) / expected_ratio(matched) * fdtri(2 * count, 2 * matched, 1 - p_value))


def to_normal(ratio: Floats, degrees_of_freedom: Floats) -> Floats:
    """Real errors over their estimated deviation (Student's t with 2ν degrees of freedom) as standard normal values."""
    return np.asarray(ndtri(np.clip(stdtr(2 * degrees_of_freedom, ratio), 1e-300, 1 - 1e-16)), dtype=float)


def pairwise_distance(ordered: Floats, place: int) -> float:
    """The `place`-th smallest distance, counted from 1, among those of all pairs of the values in ascending order.

    The pairs, whose number grows with the square of that of the values, are only listed once bisection has left few of
    them; Johnson and Mizoguchi (1978), SIAM Journal on Computing 7, 147–153, use medians instead of bisection.
    """
    size, low, high = ordered.size, 0.0, float(ordered[-1] - ordered[0])
    itself = np.arange(1, size + 1)
    first, behind = itself, np.full(size, size)
    for _ in range(_BISECTIONS):
        if np.sum(behind - first) <= 2 * size:
            break
        middle = (low + high) / 2
        # pairs at most this far apart, each counted once, at its smaller value
        reached = np.maximum(np.searchsorted(ordered, ordered + middle, side="right"), itself)
        if np.sum(reached - itself) < place:
            low, first = middle, reached
        else:
            high, behind = middle, reached
    rows = np.repeat(np.arange(size), behind - first)
    others = np.arange(rows.size) + np.repeat(first - np.cumsum(behind - first) + (behind - first), behind - first)
    rank = place - 1 - int(np.sum(first - itself))
    return float(np.partition(ordered[others] - ordered[rows], rank)[rank])
