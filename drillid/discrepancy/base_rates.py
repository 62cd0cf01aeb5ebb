"""How often something is wrong, and how often each cause, before any data are looked at.

A verdict's evidence is a Bayes factor, which no base rate enters; its probability is the posterior with these.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from difflib import get_close_matches
from typing import TYPE_CHECKING

import numpy as np
from scipy.special import expit, logit

from drillid.discrepancy.catalogue import CATALOGUE
from drillid.discrepancy.verdicts.verdict import UNKNOWN
from drillid.errors import SettingsError

if TYPE_CHECKING:
    from drillid.config.settings import DiscrepancySettings


@dataclass(frozen=True)
class BaseRates:
    """Prior probabilities of causes; see the settings of the discrepancy stage for their source."""

    wrong: float = 0.5
    """Probability of something wrong in a set."""
    second: float = 1 / 9
    """Probability of a further cause in a set that has one."""
    weights: Mapping[str, float] = field(default_factory=dict)
    """How common causes are relative to each other; 1 where not given."""
    causes: Sequence[str] = tuple(CATALOGUE)
    """All that may be wrong."""

    def among(self, causes: Iterable[str]) -> BaseRates:
        """The same where only some causes may be wrong."""
        return replace(self, causes=tuple(dict.fromkeys(causes)))

    def log_weight(self, name: str) -> float:
        """Logarithm of how common a cause is, or something `unknown`, relative to the mean of all causes."""
        mean = float(np.mean([self.weights.get(cause, 1.0) for cause in self.causes]))
        return float(np.log(self.weights.get(name, 1.0) / mean))

    def log_prior_odds(self, names: Iterable[str]) -> float:
        """Log prior odds that one of some causes is present, against nothing wrong."""
        share = sum(np.exp(self.log_weight(name)) for name in names) / len(self.causes)
        return float(logit(self.wrong) + np.log(share))

    def probability(self, names: Iterable[str], log_evidence: float) -> float:
        """Posterior probability of some causes against nothing wrong, from their log Bayes factor."""
        return float(expit(log_evidence + self.log_prior_odds(names)))

    def probability_beside(self, log_evidence: float) -> float:
        """Posterior probability of a certain second cause beside a first, from its log Bayes factor against none."""
        return float(expit(log_evidence - self.pair_penalty))

    @property
    def pair_penalty(self) -> float:
        """Log odds against a certain second cause beside a first: any other of the catalogue may be the second."""
        return float(np.log(len(self.causes) - 1) - logit(self.second))


def stated_base_rates(settings: DiscrepancySettings) -> BaseRates:
    """The base rates of the settings.

    Raises
    ------
    SettingsError
        If a weight is given for something that is no cause.
    """
    known = [*CATALOGUE, UNKNOWN]
    for name in settings.cause_weights:
        if name not in known:
            close = get_close_matches(name, known, n=1)
            remedy = f"Did you mean '{close[0]}'?" if close else f"Causes are {', '.join(known)}"
            raise SettingsError("discrepancy", f"'cause_weights.{name}': no cause is called {name}", remedy)
    return BaseRates(settings.base_rate, settings.second_cause_rate, settings.cause_weights)
