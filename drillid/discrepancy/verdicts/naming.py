"""From evidence to names: the posterior over causes, and the smallest class that holds most of it."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.special import logsumexp

from drillid.discrepancy.catalogue import CATALOGUE, Cause
from drillid.discrepancy.detectors.pooling import PooledDetection
from drillid.discrepancy.inference.search import Refined
from drillid.discrepancy.rules import CLASS_MASS, SAME
from drillid.discrepancy.verdicts.verdict import UNKNOWN


@dataclass(frozen=True, eq=False)
class Posterior:
    """Causes with their posterior, given that one of them, or something unknown, is there."""

    refined: tuple[Refined, ...]
    """Most likely first."""
    share: dict[str, float]
    """Posterior of each cause and of `unknown`."""

    @property
    def best(self) -> Refined:
        """The most likely cause."""
        return self.refined[0]

    @property
    def members(self) -> tuple[str, ...]:
        """The most likely causes that together hold most of what causes hold."""
        named = [(one.name, self.share[one.name]) for one in self.refined]
        total = sum(share for _, share in named)
        members: list[str] = []
        held = 0.0
        for name, share in named:
            members.append(name)
            held += share
            if held >= CLASS_MASS * total:
                break
        return tuple(members)


def posterior(refined: Sequence[Refined], unknown: float) -> Posterior:
    """Equal prior for every cause and for something unknown.

    Parameters
    ----------
    refined : at least one
    unknown : log Bayes factor of a disturbance of unknown shape
    """
    order = sorted(refined, key=lambda one: -one.log_evidence)
    logs = np.array([*(one.log_evidence for one in order), unknown])
    shares = np.exp(logs - logsumexp(logs))
    return Posterior(tuple(order), dict(zip([*(one.name for one in order), UNKNOWN], shares.tolist(), strict=True)))


def told_apart(one: PooledDetection, other: PooledDetection) -> bool:
    """Whether two ways of one change say so different things that the likelier is the name."""
    return min(one.apart, other.apart) >= SAME


def class_name(members: Sequence[str]) -> str:
    """Members in alphabetical order, joined as verdicts write them."""
    return "|".join(sorted(members))


def separator(members: Sequence[str], catalogue: dict[str, Cause] | None = None) -> str:
    """What would tell the members of a class, or a cause from what looks like it."""
    known = catalogue or CATALOGUE
    said = dict.fromkeys(known[name].separated_by for name in members if name in known)
    return "; ".join(said)
