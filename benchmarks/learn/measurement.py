"""Where every part of `make learn` writes its results, and shares of cases with their limits."""

from pathlib import Path

import numpy as np

from benchmarks.result import Result

FILE = Path("results/learn.json")
FOLDER = Path("results/learn")
"""Where parts keep what they simulate."""


def share(
    key: str, meaning: str, count: int, cases: int, *, least: float = -np.inf, most: float = np.inf
) -> list[Result]:
    """A share of cases, and its 95 % limits by Wilson (1927, J. Am. Stat. Assoc. 22, 209–212) under the key with _low
    and _high; NaN without any case.

    Parameters
    ----------
    least, most : target of the share
    """
    from scipy.stats import binomtest

    low, high, value = np.nan, np.nan, np.nan
    if cases:
        low, high = binomtest(count, cases).proportion_ci(method="wilson")
        value = count / cases
    of = f" of {cases}"
    return [
        Result(key, meaning + of, value, least, most),
        Result(f"{key}_low", f"{meaning}, lower limit", float(low)),
        Result(f"{key}_high", f"{meaning}, upper limit", float(high)),
    ]
