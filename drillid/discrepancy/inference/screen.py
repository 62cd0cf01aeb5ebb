"""A first look at all causes at once: linear evidence about the fitted model, and its p-value."""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from scipy.special import log_ndtr, logsumexp

from drillid.arrays import Booleans, Floats, Indices
from drillid.discrepancy.catalogue import Cause
from drillid.discrepancy.inference import unknown
from drillid.discrepancy.inference.projection import Projection, candidates, columns, project, secants
from drillid.discrepancy.inference.set_fit import SetFit
from drillid.discrepancy.inference.set_model import Extension, SetModel
from drillid.discrepancy.rules import STRAIGHT, TAIL, WIDE_PRIOR

_DRAWS = 4000
_SHARES = (1.0, 0.125)
"""Of their usual sizes, at which causes are looked for that are not linear in their size."""


@dataclass(frozen=True, eq=False)
class Screen:
    """Linear evidence for every cause."""

    candidates: tuple[Extension, ...]
    log_evidence: Floats
    """(K,) log Bayes factor against the model as it is."""
    unknown: dict[str, float]
    """The same for a disturbance of unknown shape at each port, and for data sheets that do not fit."""
    p_value: float
    """Of so much evidence for any of them where nothing is wrong."""
    projection: Projection
    """Of the candidates alone."""

    def of(self, cause: str) -> float:
        """Log Bayes factor of a cause, averaged over its shapes."""
        own = [value for one, value in zip(self.candidates, self.log_evidence, strict=True) if one.cause.name == cause]
        return float(logsumexp(own) - np.log(len(own)))

    @property
    def by_cause(self) -> dict[str, float]:
        """Log Bayes factor of every cause."""
        return {name: self.of(name) for name in dict.fromkeys(one.cause.name for one in self.candidates)}

    @property
    def unknown_evidence(self) -> float:
        """Log Bayes factor of something unknown, averaged over where it may show."""
        return float(logsumexp(list(self.unknown.values())) - np.log(len(self.unknown)))


def screen(
    model: SetModel,
    fit: SetFit,
    extensions: tuple[Extension, ...],
    catalogue: Sequence[Cause],
    generator: np.random.Generator,
) -> Screen:
    """Look at all linear causes and at what is unknown beyond the model as it is.

    The p-value of the total evidence comes from draws of the score under the model as it is, whose covariance is
    the projected information: the maximum over a catalogue needs no other correction. A cause whose first order
    nuisance figures absorb, such as a lag beside a delay, is looked for at its usual size and a small one as well.
    """
    chosen = [one for one in candidates(catalogue) if not one.cause.size.fixed]
    pieces = [columns(model, fit, extensions, chosen)]
    pieces += [secants(model, fit, extensions, chosen, share) for share in _SHARES]
    off = [unknown.directions(model, fit, extensions, channel) for channel in unknown.CHANNELS]
    pieces += off
    whole = project(model, fit, extensions, np.concatenate(pieces, axis=1))
    curved = _curved(whole.information, len(chosen))
    projection = whole.without(len(chosen) + np.flatnonzero(~curved))
    groups = _Groups(
        chosen, np.flatnonzero(curved) % len(chosen), [one.shape[1] for one in off], projection.information
    )
    # estimated variances make scores a little larger than the information says
    spread = _dispersion(model)
    each, channels, total = groups.evidence(projection.score[None] / np.sqrt(spread))
    draws = generator.standard_normal((_DRAWS, projection.score.size)) @ _root(projection.information).T
    p_value = tail_p_value(float(total[0]), groups.evidence(draws)[2])
    count = len(chosen)
    own = Projection(projection.score[:count], projection.information[:count, :count])
    return Screen(tuple(chosen), each[0], dict(zip(unknown.CHANNELS, channels[0], strict=True)), p_value, own)


def _curved(information: Floats, count: int) -> Booleans:
    """Which steps of K candidates to sizes, (shares · K,), go another way beyond nuisances than small ones do."""
    small, sized = np.tile(np.arange(count), len(_SHARES)), count + np.arange(len(_SHARES) * count)
    scale = np.sqrt(information[small, small] * information[sized, sized])
    return np.asarray(np.abs(information[small, sized]) < STRAIGHT * scale, dtype=bool)


class _Groups:
    """Candidates, further steps of those that are curved, and channels of what is unknown, of so many directions each,
    and the evidence for all of them from scores.
    """

    def __init__(
        self, chosen: Sequence[Extension], curved: Indices, counts: Sequence[int], information: Floats
    ) -> None:
        self.chosen, self.curved, self.information = chosen, curved, information
        first = len(chosen) + curved.size + np.cumsum([0, *counts])
        self.blocks = [slice(*ends) for ends in pairwise(first)]
        self.typical = np.array([one.cause.size.typical for one in chosen])
        self.one_sided = np.array([one.cause.size.low >= 0 for one in chosen])
        names = [one.cause.name for one in chosen]
        self.log_prior = -np.log([names.count(name) for name in names])

    def evidence(self, score: Floats) -> tuple[Floats, Floats, Floats]:
        """Log Bayes factors of candidates (..., K), of channels (..., 8) and of all together (...)."""
        curved, every = self.curved, np.append(np.arange(len(self.chosen)), self.curved)
        count = every.size
        both = gaussian_evidence(
            score[..., :count], np.diag(self.information)[:count], self.typical[every], self.one_sided[every]
        )
        each = both[..., : len(self.chosen)]
        for step, place in enumerate(curved, len(self.chosen)):
            each[..., place] = np.logaddexp(each[..., place], both[..., step])
        each -= np.log1p(np.bincount(curved, minlength=len(self.chosen)))
        channels = np.stack(
            [
                unknown.log_evidence(channel, score[..., block], self.information[block, block])
                for channel, block in zip(unknown.CHANNELS, self.blocks, strict=True)
            ],
            axis=-1,
        )
        weighted = np.concatenate([each + self.log_prior, channels - np.log(len(self.blocks))], axis=-1)
        return each, channels, np.asarray(logsumexp(weighted, axis=-1), dtype=float)


def gaussian_evidence(score: Floats, information: Floats, typical: Floats, one_sided: Booleans) -> Floats:
    """Log Bayes factor of a size with a usual or a wide normal prior, or half of one where it cannot be negative."""
    each = []
    for deviation in (typical, WIDE_PRIOR * typical):
        precision = information + deviation**-2.0
        whole = 0.5 * score**2 / precision - 0.5 * np.log(precision * deviation**2)
        positive = np.log(2.0) + log_ndtr(score / np.sqrt(precision))
        each.append(whole + np.where(one_sided, positive, 0.0))
    return np.asarray(np.logaddexp(*each) - np.log(2.0), dtype=float)


def tail_p_value(value: float, draws: Floats) -> float:
    """Share of draws above a value; beyond them the exponential tail that their largest show."""
    above = int(np.count_nonzero(draws >= value))
    largest = np.sort(draws)[-max(int(TAIL * draws.size), 20) :]
    if above >= largest.size:
        return above / draws.size
    scale = float(np.mean(largest - largest[0]))
    return float(largest.size / draws.size * np.exp(-max(value - largest[0], 0.0) / max(scale, 1e-12)))


def _dispersion(model: SetModel) -> float:
    """Variance of a score per information where every weight is one over an estimated variance of ν freedoms."""
    freedom = np.maximum(model.evidence.degrees_of_freedom[model.weight > 0], 3.0)
    return float(np.mean((freedom - 1) / (freedom - 2)))


def _root(information: Floats) -> Floats:
    """Factor R of R Rᵀ, exact in each direction however small it is beside others, whose units differ."""
    scale = np.sqrt(np.maximum(np.diag(information), np.finfo(float).tiny))
    values, vectors = np.linalg.eigh(information / np.outer(scale, scale))
    root: Floats = scale[:, None] * vectors * np.sqrt(np.maximum(values, 0.0))
    return root
