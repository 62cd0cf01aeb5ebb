"""From evidence to names: the posterior over causes, and the smallest class that has most of its mass."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.special import logsumexp

from drillid.discrepancy.base_rates import BaseRates
from drillid.discrepancy.catalogue import CATALOGUE, Cause
from drillid.discrepancy.detectors.pooling import PooledDetection
from drillid.discrepancy.evidence import Evidence
from drillid.discrepancy.inference.search import FittedCause
from drillid.discrepancy.rules import CLASS_MASS, DISTINCT
from drillid.discrepancy.verdicts.verdict import UNKNOWN


@dataclass(frozen=True, eq=False)
class Posterior:
    """Posterior over causes, given that one of them, or something unknown, is present."""

    fitted_causes: tuple[FittedCause, ...]
    """Most likely first."""
    share: dict[str, float]
    """Posterior probability of each cause and of `unknown`."""

    @property
    def best(self) -> FittedCause:
        """The most likely cause."""
        return self.fitted_causes[0]

    @property
    def members(self) -> tuple[str, ...]:
        """The most likely causes that together have most of the causes' posterior mass."""
        named = [(fit.name, self.share[fit.name]) for fit in self.fitted_causes]
        total = sum(share for _, share in named)
        members: list[str] = []
        held = 0.0
        for name, share in named:
            members.append(name)
            held += share
            if held >= CLASS_MASS * total:
                break
        return tuple(members)


def look_alike(first: Cause, second: Cause) -> bool:
    """Whether two causes have nearly the same effect."""
    return second.name in first.looks_like or first.name in second.looks_like


def may_be_trace(detected: str, of: Cause) -> bool:
    """Whether the detection of a cause in the record may be a trace of another one, which the linear responses show.

    What distorts the linear responses may itself be why they show something, unless that is a change within a window,
    which has detections of several causes that look like each other.
    """
    if of.time_varying or detected not in CATALOGUE:
        return detected in of.looks_like
    cause = CATALOGUE[detected]
    return not cause.distorts_responses and look_alike(cause, of)


def cause_posterior(fitted_causes: Sequence[FittedCause], unknown: float, base_rates: BaseRates) -> Posterior:
    """Posterior over causes and something unknown.

    Parameters
    ----------
    fitted_causes : at least one
    unknown : log Bayes factor of a disturbance of unknown shape
    """
    log_weight = {fit.name: fit.log_evidence + base_rates.log_weight(fit.name) for fit in fitted_causes}
    order = sorted(fitted_causes, key=lambda fit: -log_weight[fit.name])
    logs = np.array([*(log_weight[fit.name] for fit in order), unknown + base_rates.log_weight(UNKNOWN)])
    shares = np.exp(logs - logsumexp(logs))
    return Posterior(tuple(order), dict(zip([*(fit.name for fit in order), UNKNOWN], shares.tolist(), strict=True)))


def class_evidence(evidence: Mapping[str, float], base_rates: BaseRates) -> float:
    """Log Bayes factor of a class: the mean of its members', weighted by how common they are."""
    weight = [base_rates.log_weight(name) for name in evidence]
    return float(logsumexp(np.add(weight, list(evidence.values()))) - logsumexp(weight))


def distinguishable(first: PooledDetection, second: PooledDetection) -> bool:
    """Whether two courses of one change predict records so different that the likelier one is named."""
    return min(first.separation, second.separation) >= DISTINCT


def class_name(members: Sequence[str]) -> str:
    """Members in alphabetical order, joined as verdicts write them."""
    return "|".join(sorted(members))


def separator(members: Sequence[str], evidence: Evidence | None = None) -> str:
    """Measurements that would distinguish the members of a class, or a cause from those that look like it, less those
    that the evidence has.
    """
    measurements = dict.fromkeys(CATALOGUE[name].separated_by for name in members if name in CATALOGUE)
    stated = {} if evidence is None else _stated(evidence)
    return "; ".join(filter(None, (_lacking(each, stated) for each in measurements)))


def _stated(evidence: Evidence) -> dict[str, bool]:
    """Which of the measurements that a well may have the evidence has."""
    return {
        "the logged torque command": evidence.control is not None,
        "the top drive's inertia": bool(np.isfinite(evidence.data_sheet.inertia_td_error)),
    }


def _lacking(measurement: str, stated: Mapping[str, bool]) -> str:
    """One of the measurements without alternatives that are stated."""
    alternatives = []
    for alternative in measurement.split(", or "):
        parts = [part for part in alternative.split(" together with ") if not stated.get(part, False)]
        alternatives += [" together with ".join(parts)] if parts else []
    return ", or ".join(alternatives)
