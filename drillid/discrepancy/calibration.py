"""From the engine's posterior to probabilities that are right as often as they say.

The posterior knows nothing of what the engine itself gets wrong: shapes that are tried in steps, curvature in place of
an integral, causes that come in twos. So its log odds are put on a line that sealed cases give, a line for each kind
of verdict (Platt 1999, Advances in Large Margin Classifiers, 61-74).
"""

from dataclasses import replace
from typing import NamedTuple

from scipy.special import expit, logit

from drillid.discrepancy.verdict import NONE, UNKNOWN, Verdict


class Line(NamedTuple):
    """Log odds of being right, from log odds of the posterior."""

    intercept: float
    slope: float


LINES = {"none": Line(0.67, 1.29), "named": Line(1.05, 0.14), "unknown": Line(-1.77, 0.40)}
"""By kind of verdict, from sealed cases of former proofs, up to seed 130699: mean of the lines of 652 and of 697."""
_SUREST = 12.0
"""Largest log odds that are told apart."""


def kind(verdict: Verdict) -> str:
    """Kind of a verdict: none, unknown or named."""
    return verdict.verdict if verdict.verdict in (NONE, UNKNOWN) else "named"


def log_odds(probability: float) -> float:
    """Log odds of a probability, within what is told apart."""
    least = float(expit(-_SUREST))
    return float(logit(min(max(probability, least), 1 - least)))


def calibrated(verdict: Verdict) -> Verdict:
    """The verdict with its posterior made a calibrated probability."""
    line = LINES[kind(verdict)]
    return replace(verdict, probability=float(expit(line.intercept + line.slope * log_odds(verdict.probability))))
