"""Where every part of `make learn` writes its results, shares of cases with their limits, and pairs of fingerprints."""

from collections.abc import Sequence
from itertools import combinations
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.result import Result
from drillid.discrepancy.learning.fingerprint import SAME, Fingerprint

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


def pairs(offered: Sequence[tuple[int, str, Any]]) -> tuple[list[bool], list[bool]]:
    """Whether pairs of wells of a rig are told to have the same, with the same effect and with different ones.

    Parameters
    ----------
    offered : seed of the well, which begins with the rig's number, its effect, and the content of its fingerprint
    """
    same, different = [], []
    for (one, effect, first), (other, another, second) in combinations(offered, 2):
        if one // 100 == other // 100:
            likeness = Fingerprint.of(first).likeness(Fingerprint.of(second))
            (same if effect == another else different).append(likeness >= SAME)
    return same, different
