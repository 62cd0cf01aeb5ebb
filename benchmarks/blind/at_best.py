"""What the limits of a block would be for an engine without fault: the bound that the number of its cases sets."""

import numpy as np
import pandas as pd

from benchmarks.blind.limits import lower_limit, resampled, upper_limit
from benchmarks.blind.scores import (
    SHARES,
    TARGETS,
    calibration_error,
    calibration_error_family,
    columns,
    right_by_cause,
)

_COVERAGE = 0.95
"""Share of the intervals that hold the truth, where they do so as often as they state."""
_DRAWS = 9
"""Number of times that the truth of all verdicts is drawn; the median of the limits counts."""
_CALIBRATION = {"calibration_error": calibration_error, "calibration_error_family": calibration_error_family}


def at_best(table: pd.DataFrame) -> dict[str, float]:
    """The limits among TARGETS that an engine without fault would reach on the same cases.

    Every answer is right, intervals hold the truth in 95 %, and verdicts are true as often as their stated probability
    says. The ratio of powers is left out, as an engine may be luckier than the ideal test.
    """
    found = {"causes_right": float(len(right_by_cause(table)))}
    of_shares = columns(table)
    for name in SHARES:
        cases = int(of_shares[name].notna().sum())
        right = round(_COVERAGE * cases) if name == "coverage95" else cases
        found[f"{name}_low"] = lower_limit(right, cases)
        found[f"{name}_high"] = upper_limit(right if name == "coverage95" else 0, cases)
    tables = [_with_true_probabilities(table, seed) for seed in range(_DRAWS)]
    for name, score in _CALIBRATION.items():
        found[f"{name}_high"] = float(np.median([resampled(drawn, score)[1] for drawn in tables]))
    return {name: value for name, value in found.items() if name in TARGETS}


def _with_true_probabilities(table: pd.DataFrame, seed: int) -> pd.DataFrame:
    """The same verdicts, each true at random with the probability that it states."""
    generator = np.random.default_rng(seed)
    claims = [
        tuple((kind, family, stated, generator.random() < stated) for kind, family, stated, _ in row)
        for row in table["claims"]
    ]
    return table.assign(claims=claims)
