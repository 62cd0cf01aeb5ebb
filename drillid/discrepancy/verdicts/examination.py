"""What the engine has found out about a set of windows, and what it weighs it by."""

from dataclasses import dataclass, replace

import numpy as np
from scipy.special import expit, logsumexp

from drillid.discrepancy.catalogue import CATALOGUE
from drillid.discrepancy.detectors.pooling import PooledDetection
from drillid.discrepancy.inference.screen import Screen
from drillid.discrepancy.inference.set_fit import SetFit
from drillid.discrepancy.inference.set_model import Extension, SetModel
from drillid.discrepancy.verdicts.naming import Posterior
from drillid.discrepancy.verdicts.verdict import UNKNOWN, UNPROVED, Verdict

NO_SURE_GAIN = "its gain on held-out data is not sure"


@dataclass(frozen=True, eq=False)
class Examination:
    """Verdicts of a set with what they are made of."""

    verdicts: tuple[Verdict, ...]
    model: SetModel
    base: SetFit
    extended: SetFit
    extensions: tuple[Extension, ...]
    """Causes that stay in the model."""
    before: Screen
    after: Screen
    """The screen of the extended model; that of the base model where nothing was named."""
    posterior: Posterior | None
    detections: tuple[PooledDetection, ...]


def unextended(examination: Examination) -> Examination:
    """The same before anything was named."""
    return replace(examination, verdicts=(), extended=examination.base, extensions=(), after=examination.before)


def evidence_left(after: Screen) -> float:
    """Log Bayes factor of all that may still be wrong, averaged over causes."""
    values = [*after.by_cause.values(), after.unknown_evidence]
    return max(float(logsumexp(values) - np.log(len(values))), 0.0)


def surely(log_evidence: float) -> float:
    """Posterior that a cause is there, of as many as the catalogue holds and even odds that there is one."""
    return float(expit(log_evidence - np.log(len(CATALOGUE))))


def doubt(unproved: tuple[Verdict, ...], reason: str = NO_SURE_GAIN) -> str:
    """Names that were in sight, in words, and why they are not given."""
    names = ", ".join(one.verdict for one in unproved)
    return f"; {names} {UNPROVED}: {reason}" if names else ""


def nameless(one: Verdict, reason: str = NO_SURE_GAIN) -> Verdict:
    """What is left of a name that is not given."""
    said = f"{one.evidence}{doubt((one,), reason)}"
    return Verdict(UNKNOWN, one.family, one.probability, one.from_m, one.to_m, evidence=said)
