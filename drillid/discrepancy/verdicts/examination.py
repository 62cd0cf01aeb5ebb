"""The engine's examination of a set of windows."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np
from scipy.special import logsumexp

from drillid.discrepancy.base_rates import BaseRates
from drillid.discrepancy.detectors.pooling import PooledDetection
from drillid.discrepancy.inference.coordinates import Extension
from drillid.discrepancy.inference.screen import Screen
from drillid.discrepancy.inference.set_fit import SetFit
from drillid.discrepancy.inference.set_model import SetModel
from drillid.discrepancy.verdicts.naming import Posterior
from drillid.discrepancy.verdicts.verdict import UNKNOWN, UNPROVED, Verdict

if TYPE_CHECKING:
    from drillid.discrepancy.learning.fingerprint import Fingerprint
    from drillid.discrepancy.learning.law import LearntLaw

NO_SURE_GAIN = "its predictive gain on held-out data is not significant"


@dataclass(frozen=True, eq=False)
class Examination:
    """Verdicts on a set of windows, with the models and evidence that they follow from."""

    verdicts: tuple[Verdict, ...]
    model: SetModel
    base: SetFit
    extended: SetFit
    extensions: tuple[Extension, ...]
    """Causes in the extended model."""
    before: Screen
    after: Screen
    """The screen of the extended model; that of the base model where nothing was named."""
    posterior: Posterior | None
    """Posterior of one cause of the linear responses, even where it leaves too much unexplained."""
    detections: tuple[PooledDetection, ...]
    base_rates: BaseRates
    p_value: float
    """p-value of the base model: that of its screen, or a bound where it is so far off that linear theory is not valid.
    """
    fingerprint: Fingerprint | None = None
    """Fingerprint of what was learnt, where that is offered."""
    law: LearntLaw | None = None
    """The learnt law, where one is offered."""
    law_p_value: float = 1.0
    """p-value of the model against a law of any kind; 1 where none is looked for."""


def unextended(examination: Examination) -> Examination:
    """The same examination before any cause was named."""
    return replace(examination, verdicts=(), extended=examination.base, extensions=(), after=examination.before)


def remaining_evidence(after: Screen) -> float:
    """Log Bayes factor that something more is wrong, averaged over the causes; at least 0."""
    values = [*after.by_cause.values(), after.unknown_evidence]
    return max(float(logsumexp(values) - np.log(len(values))), 0.0)


def unproved_names(unproved: tuple[Verdict, ...], reason: str = NO_SURE_GAIN) -> str:
    """Clause with the names that would fit, and the reason why they are not given; empty without any."""
    names = ", ".join(verdict.verdict for verdict in unproved)
    return f"; {names} {UNPROVED}: {reason}" if names else ""


def as_unknown(verdict: Verdict, reason: str = NO_SURE_GAIN) -> Verdict:
    """The verdict unknown in place of one whose name is not given."""
    evidence = f"{verdict.evidence}{unproved_names((verdict,), reason)}"
    return Verdict(
        UNKNOWN,
        verdict.family,
        verdict.probability,
        verdict.from_m,
        verdict.to_m,
        evidence_nats=verdict.evidence_nats,
        evidence=evidence,
    )
