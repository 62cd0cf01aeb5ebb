"""The verdicts of the engine on a set of windows."""

from dataclasses import dataclass, replace
from typing import NamedTuple

from scipy.special import expit, logit

from drillid.discrepancy.rules import LARGEST_LOG_ODDS

NONE = "none"
UNKNOWN = "unknown"
UNPROVED = "would fit, but is not proved"
"""Text between the names that would fit and the reason why they are not given, in the evidence of unknown."""
LEARNT = "; learnt: "
"""Text that precedes what was learnt, in the evidence of a verdict."""


@dataclass(frozen=True)
class Verdict:
    """One verdict; a set with two causes has two."""

    verdict: str
    """none, a cause, a class as its members joined by |, or unknown."""
    family: str
    """Family of the most likely member; of the verdict unknown, the port at which the misfit arises."""
    probability: float
    """Probability that the verdict is right, with the base rates of the settings."""
    from_m: float
    """Hole depth at which the set begins, m."""
    to_m: float
    cause: str = ""
    """The most likely member of the class."""
    size: float = float("nan")
    """Size of the most likely member."""
    size_low: float = float("nan")
    """95 % interval."""
    size_high: float = float("nan")
    unit: str = ""
    location_m: float = float("nan")
    """Measured depth along the string, where the cause has a place and the data determine it."""
    predictive_gain: float = float("nan")
    """Log score of a held-out window, extended less base model."""
    predictive_gain_low: float = float("nan")
    """90 % interval, so that each end holds in 95 % of sets."""
    predictive_gain_high: float = float("nan")
    held_out_windows: int = 0
    what_would_separate: str = ""
    evidence_nats: float = float("nan")
    """Log Bayes factor of the verdict, without any base rate: of something wrong against nothing, of one of several
    causes against its absence, of none against something wrong."""
    evidence: str = ""
    """In words: where it shows, and how strong the evidence is."""

    @property
    def members(self) -> tuple[str, ...]:
        """Causes of the class."""
        return () if self.verdict in (NONE, UNKNOWN) else tuple(self.verdict.split("|"))


class CalibrationLine(NamedTuple):
    """Line from the log odds of the posterior to the log odds of being right (Platt scaling)."""

    intercept: float
    slope: float


CALIBRATION = {
    "none": CalibrationLine(0.67, 1.29),
    "named": CalibrationLine(1.05, 0.14),
    "unknown": CalibrationLine(-1.77, 0.40),
}
"""By kind of verdict, from sealed cases of earlier proofs, up to seed 130699: mean of the lines of 652 and of 697."""


def kind(verdict: Verdict) -> str:
    """Kind of a verdict: none, unknown or named."""
    return verdict.verdict if verdict.verdict in (NONE, UNKNOWN) else "named"


def log_odds(probability: float) -> float:
    """Log odds of a probability, clipped at LARGEST_LOG_ODDS."""
    least = float(expit(-LARGEST_LOG_ODDS))
    return float(logit(min(max(probability, least), 1 - least)))


def calibrated(verdict: Verdict) -> Verdict:
    """The verdict with a calibrated probability in place of its posterior."""
    line = CALIBRATION[kind(verdict)]
    return replace(verdict, probability=float(expit(line.intercept + line.slope * log_odds(verdict.probability))))
