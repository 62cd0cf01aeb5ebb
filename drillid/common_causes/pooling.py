"""Likelihoods of one cause's size in the wells of a group, with what belongs to their rigs integrated out.

The rig's coordinates have one prior, that of the data sheets, for all its wells: an error of a data sheet does not
average out over wells. Each well may also deviate from its rig a little.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from drillid.arrays import Floats, Indices
from drillid.discrepancy.inference.shared_likelihood import PARTS, SharedLikelihood, size_weights
from drillid.discrepancy.rules import WELL_DEVIATION


@dataclass(frozen=True, eq=False)
class SetStatistics(SharedLikelihood):
    """What is stored of one set of windows, and whose it is."""

    well: str
    rig: str


@dataclass(frozen=True, eq=False)
class Quadratic:
    """Log-likelihood of each well at each of some sizes, quadratic in the rig's coordinates about the data sheets."""

    value: Floats
    """(N, G)"""
    score: Floats
    """(N, G, R)"""
    information: Floats
    """(N, G, R, R)"""


class Wells:
    """The wells of a group by their sets.

    Parameters
    ----------
    sets : of all wells
    """

    def __init__(self, sets: Sequence[SetStatistics]) -> None:
        self.sets = sets
        self.names = tuple(dict.fromkeys(each.well for each in sets))
        rigs = list(dict.fromkeys(each.rig for each in sets))
        rig_of = {each.well: rigs.index(each.rig) for each in sets}
        windows = np.bincount([rig_of[each.well] for each in sets], [each.windows for each in sets], len(rigs))
        self.rig: Indices = np.array([rig_of[well] for well in self.names])
        """(N,) number of each well's rig."""
        self.error = np.stack([next(each.prior_error for each in sets if each.well == well) for well in self.names])
        """(N, R) tolerances of the data sheets."""
        self.prior = np.stack([self.error[self.rig == number].min(axis=0) ** -2.0 for number in range(len(rigs))])
        """(rigs, R) precision of the data sheets."""
        self._row = [self.names.index(each.well) for each in sets]
        self._weight = [_weight(each, float(windows[rig_of[each.well]])) for each in sets]

    def at(self, candidate: int, size: Floats) -> Quadratic:
        """The wells with a cause at sizes (G,) that all hold; what each deviates from its rig by is integrated out."""
        count, shape = self.prior.shape[1], (len(self.names), size.size)
        value, score, information = np.zeros(shape), np.zeros((*shape, count)), np.zeros((*shape, count, count))
        for row, weight, each in zip(self._row, self._weight, self.sets, strict=True):
            sizes = each.sizes[candidate]
            curve = size_weights(size, sizes)
            place = curve @ each.coordinates[candidate]
            slope = curve @ np.tensordot(weight, each.score[:, candidate], 1)
            matrix = np.tensordot(curve, np.tensordot(weight, each.information[:, candidate], 1), 1)
            pull = np.einsum("grq,gq->gr", matrix, place)
            value[row] += curve @ (weight @ each.value[:, candidate])
            value[row] -= np.sum((slope + 0.5 * pull) * place, axis=1)
            score[row] += slope + pull
            information[row] += matrix
        return _deviating(Quadratic(value, score, information), self.error)


def _weight(each: SetStatistics, windows: float) -> Floats:
    """Weights (2,) of a set's likelihoods, by its misfit and by what errors it has in common with its rig's windows."""
    shared = 1 / (1 - each.control_common + each.control_common * windows / each.windows)
    weight = np.ones(PARTS)
    weight[1] = shared
    return each.temper * weight


def _deviating(wells: Quadratic, error: Floats) -> Quadratic:
    """Integrate each well's own deviation from its rig's coordinates out."""
    count = error.shape[1]
    own = wells.information + ((WELL_DEVIATION * error) ** -2.0)[:, None, :, None] * np.eye(count)
    both = np.concatenate([wells.information, wells.score[..., None]], axis=-1)
    solved = np.linalg.solve(own, both)
    gained = 0.5 * np.einsum("ngr,ngr->ng", wells.score, solved[..., -1])
    score = wells.score - np.einsum("ngrq,ngq->ngr", wells.information, solved[..., -1])
    return Quadratic(wells.value + gained, score, wells.information - wells.information @ solved[..., :-1])


def together(wells: Wells, at: Quadratic) -> Floats:
    """Log-likelihood (G,) of sizes that all wells have, up to a constant."""
    total = np.zeros(at.value.shape[1])
    for rig, prior in enumerate(wells.prior):
        members = wells.rig == rig
        total += at.value[members].sum(0) + _integrated(at.score[members].sum(0), at.information[members].sum(0), prior)
    return total


def apart(wells: Wells, at: Quadratic, zero: Quadratic) -> Floats:
    """Log-likelihood ratio (N, G) of sizes that one well has alone, against none."""
    ratios = np.zeros(at.value.shape)
    for rig, prior in enumerate(wells.prior):
        members = np.flatnonzero(wells.rig == rig)
        score, information = zero.score[members].sum(0), zero.information[members].sum(0)
        of_none = _integrated(score, information, prior)
        for row in members:
            changed = _integrated(
                score + at.score[row] - zero.score[row],
                information + at.information[row] - zero.information[row],
                prior,
            )
            ratios[row] = at.value[row] - zero.value[row] + changed - of_none
    return ratios


def _integrated(score: Floats, information: Floats, prior: Floats) -> Floats:
    """Log integral over a rig's coordinates, (G,)."""
    matrix = information + np.diag(prior)
    mean = np.linalg.solve(matrix, score[..., None])[..., 0]
    return np.asarray(0.5 * np.einsum("gr,gr->g", score, mean) - 0.5 * np.linalg.slogdet(matrix)[1], dtype=float)
