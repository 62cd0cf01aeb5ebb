"""Score test of all causes at once: linear evidence about the fitted model, and its p-value."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
from scipy.special import log_ndtr, logsumexp

from drillid.arrays import Booleans, Floats, Indices
from drillid.discrepancy.catalogue import Cause
from drillid.discrepancy.inference import unknown
from drillid.discrepancy.inference.coordinates import Extension
from drillid.discrepancy.inference.most_mass import of_most_mass
from drillid.discrepancy.inference.projection import Projection, candidates, columns, project, secants
from drillid.discrepancy.inference.set_fit import SetFit
from drillid.discrepancy.inference.set_model import SetModel
from drillid.discrepancy.rules import LINEARITY, TAIL, WIDE_PRIOR

_DRAWS = 4000
_SHARES = (1.0, 0.125)
"""Shares of their usual sizes at which causes that are not linear in their size are tested."""


@dataclass(frozen=True, eq=False)
class Screen:
    """Linear evidence for every cause."""

    candidates: tuple[Extension, ...]
    log_evidence: Floats
    """(K,) log Bayes factor against the fitted model."""
    unknown: dict[str, float]
    """The same for a disturbance of unknown shape at each port, and for parameters off their data sheets."""
    p_value: float
    """Probability of at least as much evidence for any of them where nothing is wrong."""
    projection: Projection
    """Projection of the candidates alone."""

    def shapes(self, cause: str) -> list[tuple[float, Extension]]:
        """Log Bayes factor of every shape of a cause, with the shape."""
        pairs = zip(self.log_evidence.tolist(), self.candidates, strict=True)
        return [(value, candidate) for value, candidate in pairs if candidate.cause.name == cause]

    def of(self, cause: str) -> float:
        """Log Bayes factor of a cause, averaged over its shapes."""
        values = [value for value, _ in self.shapes(cause)]
        return float(logsumexp(values) - np.log(len(values)))

    @property
    def by_cause(self) -> dict[str, float]:
        """Log Bayes factor of every cause."""
        names = dict.fromkeys(candidate.cause.name for candidate in self.candidates)
        return {name: self.of(name) for name in names}

    @property
    def unknown_evidence(self) -> float:
        """Log Bayes factor of something unknown, averaged over the channels in which it may show."""
        return float(logsumexp(list(self.unknown.values())) - np.log(len(self.unknown)))


def screen(
    model: SetModel,
    fit: SetFit,
    extensions: tuple[Extension, ...],
    catalogue: Sequence[Cause],
    generator: np.random.Generator,
) -> Screen:
    """Test all linear causes, and disturbances of unknown shape, against the fitted model.

    The p-value of the total evidence comes from draws of the score under the fitted model, whose covariance is the
    projected information: the maximum over a catalogue needs no other correction. A cause whose first order the
    nuisance parameters absorb, such as a lag beside a delay, is also tested at its usual size and at a small one.
    Everything is linearised about the point at which the windows' posteriors have most mass.
    """
    fit = replace(fit, point=of_most_mass(model, fit, extensions))
    chosen = [candidate for candidate in candidates(catalogue) if not candidate.cause.size.fixed]
    pieces = [columns(model, fit, extensions, chosen)]
    pieces += [secants(model, fit, extensions, chosen, share) for share in _SHARES]
    disturbances = [unknown.directions(model, fit, extensions, channel) for channel in unknown.CHANNELS]
    pieces += disturbances
    everything = project(model, fit, extensions, np.concatenate(pieces, axis=1))
    curved = _curved(everything.information, len(chosen))
    projection = everything.without(len(chosen) + np.flatnonzero(~curved))
    counts = [directions.shape[1] for directions in disturbances]
    groups = _Groups(chosen, np.flatnonzero(curved) % len(chosen), counts, projection.information)
    # estimated variances inflate scores a little beyond the projected information
    inflated = dispersion(model)
    by_candidate, by_channel, total = groups.evidence(projection.score[None] / np.sqrt(inflated))
    draws = generator.standard_normal((_DRAWS, projection.score.size)) @ root(projection.information).T
    p_value = tail_p_value(float(total[0]), groups.evidence(draws)[2])
    count = len(chosen)
    of_candidates = Projection(projection.score[:count], projection.information[:count, :count])
    channels = dict(zip(unknown.CHANNELS, by_channel[0], strict=True))
    return Screen(tuple(chosen), by_candidate[0], channels, p_value, of_candidates)


def _curved(information: Floats, count: int) -> Booleans:
    """Which finite steps of K candidates, (shares · K,), differ in projected direction from infinitesimal ones."""
    small, finite = np.tile(np.arange(count), len(_SHARES)), count + np.arange(len(_SHARES) * count)
    scale = np.sqrt(information[small, small] * information[finite, finite])
    return np.asarray(np.abs(information[small, finite]) < LINEARITY * scale, dtype=bool)


class _Groups:
    """Evidence from scores for candidates, for finite steps of the curved ones, and for unknown disturbances.

    Parameters
    ----------
    curved : index of the candidate that each finite step belongs to
    counts : number of directions of each channel of unknown disturbances
    information : of all these directions, in this order
    """

    def __init__(
        self, chosen: Sequence[Extension], curved: Indices, counts: Sequence[int], information: Floats
    ) -> None:
        self.chosen, self.curved, self.information = chosen, curved, information
        first = len(chosen) + curved.size + np.cumsum([0, *counts])
        self.blocks = [slice(*ends) for ends in pairwise(first)]
        self.typical = np.array([candidate.cause.size.typical for candidate in chosen])
        self.one_sided = np.array([candidate.cause.size.low >= 0 for candidate in chosen])
        names = [candidate.cause.name for candidate in chosen]
        self.log_prior = -np.log([names.count(name) for name in names])

    def evidence(self, score: Floats) -> tuple[Floats, Floats, Floats]:
        """Log Bayes factors of candidates (..., K), of channels (..., 8) and of all together (...)."""
        curved, owner = self.curved, np.append(np.arange(len(self.chosen)), self.curved)
        count = owner.size
        by_step = gaussian_evidence(
            score[..., :count], np.diag(self.information)[:count], self.typical[owner], self.one_sided[owner]
        )
        by_candidate = by_step[..., : len(self.chosen)]
        for step, candidate in enumerate(curved, len(self.chosen)):
            by_candidate[..., candidate] = np.logaddexp(by_candidate[..., candidate], by_step[..., step])
        by_candidate -= np.log1p(np.bincount(curved, minlength=len(self.chosen)))
        by_channel = np.stack(
            [
                unknown.log_evidence(channel, score[..., block], self.information[block, block])
                for channel, block in zip(unknown.CHANNELS, self.blocks, strict=True)
            ],
            axis=-1,
        )
        weighted = np.concatenate([by_candidate + self.log_prior, by_channel - np.log(len(self.blocks))], axis=-1)
        return by_candidate, by_channel, np.asarray(logsumexp(weighted, axis=-1), dtype=float)


def gaussian_evidence(score: Floats, information: Floats, typical: Floats, one_sided: Booleans) -> Floats:
    """Log Bayes factor of a size with a usual or a wide normal prior, half-normal where it cannot be negative."""
    by_prior = []
    for deviation in (typical, WIDE_PRIOR * typical):
        precision = information + deviation**-2.0
        two_sided = 0.5 * score**2 / precision - 0.5 * np.log(precision * deviation**2)
        positive = np.log(2.0) + log_ndtr(score / np.sqrt(precision))
        by_prior.append(two_sided + np.where(one_sided, positive, 0.0))
    return np.asarray(np.logaddexp(*by_prior) - np.log(2.0), dtype=float)


def tail_p_value(value: float, draws: Floats) -> float:
    """Share of draws above a value; beyond the draws, the exponential tail fitted to the largest of them."""
    above = int(np.count_nonzero(draws >= value))
    largest = np.sort(draws)[-max(int(TAIL * draws.size), 20) :]
    if above >= largest.size:
        return above / draws.size
    scale = float(np.mean(largest - largest[0]))
    return float(largest.size / draws.size * np.exp(-max(value - largest[0], 0.0) / max(scale, 1e-12)))


def dispersion(model: SetModel) -> float:
    """Variance of a score per information where weights use variances estimated with ν degrees of freedom."""
    freedom = np.maximum(model.evidence.degrees_of_freedom[model.measured.weight > 0], 3.0)
    return float(np.mean((freedom - 1) / (freedom - 2)))


def root(information: Floats) -> Floats:
    """Factor R of R Rᵀ, accurate in every direction however much their units, and so their scales, differ."""
    scale = np.sqrt(np.maximum(np.diag(information), np.finfo(float).tiny))
    values, vectors = np.linalg.eigh(information / np.outer(scale, scale))
    root: Floats = scale[:, None] * vectors * np.sqrt(np.maximum(values, 0.0))
    return root
