"""One-sided 95 % limits of scores, and the number of cases that a block needs for its limits to hold."""

import math
from collections.abc import Callable

import numpy as np
import pandas as pd
from scipy.stats import beta, binom

CONFIDENCE = 0.95
_DRAWS = 300
POWER = 0.9
"""Chance that a block of the computed size holds a limit, if the true rate is as assumed."""


def lower_limit(count: int, cases: int) -> float:
    """Lower limit of a share by Clopper and Pearson (1934), Biometrika 26, 404–413, one-sided; 0 without cases."""
    return float(beta.ppf(1 - CONFIDENCE, count, cases - count + 1)) if count else 0.0


def upper_limit(count: int, cases: int) -> float:
    """The upper one; 1 without cases."""
    return float(beta.ppf(CONFIDENCE, count + 1, cases - count)) if count < cases else 1.0


def resampled(table: pd.DataFrame, score: Callable[[pd.DataFrame], float]) -> tuple[float, float]:
    """Limits of a score that is no share: quantiles over cases drawn with replacement (percentile bootstrap)."""
    generator = np.random.default_rng(0)
    values = [score(table.iloc[generator.integers(len(table), size=len(table))]) for _ in range(_DRAWS)]
    return float(np.nanquantile(values, 1 - CONFIDENCE)), float(np.nanquantile(values, CONFIDENCE))


def cases_needed(rate: float, limit: float, power: float = POWER) -> int:
    """Fewest cases for which a limit holds with a power.

    Parameters
    ----------
    rate : assumed true share
    limit : that the lower limit must reach where it is below the rate, and that the upper one must not exceed else

    Raises
    ------
    ValueError
        If rate and limit are equal: no number of cases tells them apart.
    """
    if rate == limit:
        raise ValueError(f"a rate of {rate} is the limit itself")
    at_most = limit > rate
    low, high = 1, 2
    while not _holds(high, rate, limit, at_most, power):
        low, high = high, 2 * high
    while high - low > 1:
        middle = (low + high) // 2
        low, high = (low, middle) if _holds(middle, rate, limit, at_most, power) else (middle, high)
    # the discrete limit does not hold for every larger number: the next that does, and a twentieth in reserve
    return math.ceil(1.05 * high)


def _holds(cases: int, rate: float, limit: float, at_most: bool, power: float) -> bool:
    counts = np.arange(cases + 1)
    if at_most:
        passing = [count for count in counts if upper_limit(int(count), cases) <= limit]
        return bool(passing) and float(binom.cdf(passing[-1], cases, rate)) >= power
    passing = [count for count in counts if lower_limit(int(count), cases) >= limit]
    return bool(passing) and float(binom.sf(passing[0] - 1, cases, rate)) >= power
