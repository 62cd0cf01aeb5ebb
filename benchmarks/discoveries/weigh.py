"""Causes weighed against each other, against none of them and against something unknown; and what they gain."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from benchmarks.discoveries.jackknife import jackknife_error
from benchmarks.discoveries.response import Candidate, Fit, Response, extended, log_evidence, with_distortion
from benchmarks.discoveries.unknown import average, unknown_evidence
from drillid.arrays import Complex
from drillid.discrepancy.verdicts.naming import class_name
from drillid.discrepancy.verdicts.verdict import NONE, UNKNOWN
from drillid.statistics import ONE_SIDED

_CLASS_MASS = 0.9
_PAIR_PRICE = np.log(20.0)
"""Log odds against a second cause beside a first."""
_BLOCK = 16
"""Neighbouring lines whose gains are taken together."""


@dataclass(frozen=True, eq=False)
class Weighed:
    """Causes with their evidence and their posterior, given that one of them or something unknown is there."""

    base: Fit
    fits: dict[str, Fit]
    """Each cause at its best shape."""
    evidence: dict[str, float]
    """Log Bayes factors of the causes against the base."""
    disturbed: float
    """Log Bayes factor of an unknown disturbance of the base."""
    left: dict[str, float]
    """The same beside the most likely cause, by port."""

    @property
    def cause(self) -> str:
        """Most likely cause."""
        return max(self.evidence, key=lambda name: self.evidence[name])

    @property
    def share(self) -> dict[str, float]:
        """Posterior at equal prior odds of the causes, and of something unknown without any of them.

        Beside a cause that has evidence of its own there may be something unknown as well: else the unknown alone
        would win by what is wrong beyond the cause.
        """
        from scipy.special import softmax

        beside = max(average(self.left), 0.0) if self.evidence[self.cause] > _PAIR_PRICE else 0.0
        logs = [*(value + beside for value in self.evidence.values()), self.disturbed]
        return dict(zip([*self.evidence, UNKNOWN], softmax(logs).tolist(), strict=True))

    @property
    def verdict(self) -> str:
        """A class of causes, unknown, or none where the base is the most likely."""
        if max(*self.evidence.values(), self.disturbed) <= 0:
            return NONE
        return UNKNOWN if self.share[UNKNOWN] > self.share[self.cause] else class_name(self.members())

    def members(self) -> tuple[str, ...]:
        """The most likely causes that together hold nine tenths of what causes hold, as the engine's classes do."""
        order = sorted(self.fits, key=lambda name: -self.evidence[name])
        held = np.cumsum([self.share[name] for name in order])
        return tuple(order[: int(np.searchsorted(held, _CLASS_MASS * held[-1])) + 1])


def weigh(base: Fit, candidates: Sequence[Candidate]) -> Weighed:
    """Fit every candidate beside what the base has already; shapes of one cause share its prior odds."""
    from scipy.special import logsumexp

    fits: dict[str, Fit] = {}
    evidence: dict[str, float] = {}
    for name in dict.fromkeys(one.cause for one in candidates):
        tried = [extended(base, one) for one in candidates if one.cause == name]
        logs = [log_evidence(base, one) for one in tried]
        fits[name] = tried[int(np.argmax(logs))]
        evidence[name] = float(logsumexp(logs) - np.log(len(logs)))
    best = fits[max(evidence, key=lambda name: evidence[name])]
    return Weighed(base, fits, evidence, average(unknown_evidence(base)), unknown_evidence(best))


def held_out_gain(base: Complex, more: Complex, held: Response) -> tuple[float, float, float]:
    """Log score a line, extended less base model, on lines that were not fitted, with its 90 % interval."""
    each = (np.abs(held.value - base) ** 2 - np.abs(held.value - more) ** 2) / held.deviation**2
    blocks = np.add.reduceat(each, np.arange(0, each.size, _BLOCK))
    error = ONE_SIDED * float(np.sqrt(blocks.size) * blocks.std(ddof=1))
    total = float(each.sum())
    return total / each.size, (total - error) / each.size, (total + error) / each.size


def look(base: Callable[[Response], Fit], measured: Response, candidates: Sequence[Candidate]) -> Weighed:
    """Weigh the causes at the noise that the best of them leaves, non-linear distortion included."""
    plain = base(measured)
    fits = [plain, *(extended(plain, one) for one in candidates)]
    best = min(fits, key=lambda one: one.cost)
    return weigh(base(with_distortion(measured, best.predicted(measured.frequency))), candidates)


def relative_gain(base: Complex, more: Complex, held: Response) -> tuple[float, float, float]:
    """Share of the rms misfit per response that the extension takes away, with its 90 % interval by a jackknife."""
    before, after = (np.abs(one / held.value - 1) ** 2 for one in (base, more))
    places = np.arange(before.size) // _BLOCK
    shares = [1 - np.sqrt(after[kept].mean() / before[kept].mean()) for kept in (places != one for one in set(places))]
    error = ONE_SIDED * jackknife_error(shares)
    share = float(1 - np.sqrt(after.mean() / before.mean()))
    return share, float(share - error), float(share + error)
