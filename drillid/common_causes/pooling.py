"""Likelihoods of one cause's size in the wells of a group, with what belongs to their rigs integrated out.

The rig's coordinates have one prior, that of the data sheets, for all its wells: an error of a data sheet does not
average out over wells. Each well may also deviate from its rig a little.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from drillid.arrays import Floats, Indices
from drillid.discrepancy.inference.coordinates import COORDINATES
from drillid.discrepancy.inference.shared_likelihood import DIRECTIONS, PARTS, RIG, SharedLikelihood, size_weights
from drillid.discrepancy.rules import LENGTH_DEVIATION, WELL_DEVIATION

DEVIATION = np.where(COORDINATES.index("length") == RIG, LENGTH_DEVIATION, WELL_DEVIATION)
"""(R,) standard deviations of a well from its rig, relative to the tolerances of the data sheet."""
_ABSORBED = 1e-9
"""Share of a direction's information below which what is left of it is rounding."""


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

    def with_sizes(self, other: Quadratic, order: Indices) -> Quadratic:
        """The same joined with another one at further sizes, in a new order."""
        pairs = ((self.value, other.value), (self.score, other.score), (self.information, other.information))
        return Quadratic(*(np.concatenate(pair, axis=1)[:, order] for pair in pairs))


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

    def of(self, names: Iterable[str]) -> Wells:
        """Some of them, by their names."""
        kept = set(names)
        return Wells([each for each in self.sets if each.well in kept])

    def at(self, candidate: int, size: Floats) -> Quadratic:
        """The wells with a cause at sizes (G,), with each well's deviation from its rig integrated out.

        Beyond the sizes that a well holds, its fitted coordinates follow a line, and its likelihood rises no more.
        """
        sizes = np.stack([each.sizes[candidate] for each in self.sets])
        weight, coordinates = np.stack(self._weight), np.stack([each.coordinates[candidate] for each in self.sets])
        values, scores, matrices = (
            np.einsum("mp,mps...->ms...", weight, np.stack([getattr(each, name)[:, candidate] for each in self.sets]))
            for name in ("value", "score", "information")
        )
        inside = np.clip(size, sizes[:, :1], sizes[:, -1:])
        curve, slopes = size_weights(inside, sizes), _end_slopes(size - inside, sizes)
        place, slope = (curve + slopes) @ coordinates, curve @ scores
        count = self.prior.shape[1]
        # on lines, so that no information is negative
        lines = _linear_weights(inside, sizes)
        matrix = (lines @ matrices.reshape(*sizes.shape, -1)).reshape(*inside.shape, count, count)
        pull = (matrix @ place[..., None])[..., 0]
        value = (curve @ values[..., None])[..., 0] + np.minimum((slopes @ values[..., None])[..., 0], 0.0)
        value -= np.sum((slope + 0.5 * pull) * place, axis=-1)
        return _deviating(Quadratic(*(self._by_well(part) for part in (value, slope + pull, matrix))), self.error)

    def _by_well(self, of_sets: Floats) -> Floats:
        """Sums over the sets of each well."""
        if len(self.names) == len(self.sets):
            return of_sets
        total = np.zeros((len(self.names), *of_sets.shape[1:]))
        np.add.at(total, self._row, of_sets)
        return total

    def correlation(self, candidates: Indices) -> Floats:
        """Correlation (K, K) of scores along two directions of each candidate where no well has any cause."""
        count = self.prior.shape[1]
        further = [count + DIRECTIONS * number + place for number in candidates for place in range(DIRECTIONS)]
        kept = np.append(np.arange(count), further)
        block = np.ix_(np.arange(PARTS), kept, kept)
        pairs = zip(self._weight, self.sets, strict=True)
        wells = self._by_well(np.stack([np.tensordot(weight, each.directions[block], 1) for weight, each in pairs]))
        shown, border = wells, wells[:, :count]
        own = wells[:, :count, :count] + ((DEVIATION * self.error) ** -2.0)[:, :, None] * np.eye(count)
        wells = wells - np.swapaxes(border, 1, 2) @ np.linalg.solve(own, border)
        total = np.zeros((len(further), len(further)))
        for rig, prior in enumerate(self.prior):
            of_rig = wells[self.rig == rig].sum(0)
            of_rig[:count, :count] += np.diag(prior)
            border = of_rig[:count, count:]
            total += of_rig[count:, count:] - border.T @ np.linalg.solve(of_rig[:count, :count], border)
        left, whole = np.diag(total), np.einsum("nkk->k", shown)[count:]
        # what the rig's coordinates absorb has no score
        scale = np.where(left > _ABSORBED * whole, left, np.inf) ** -0.5
        return np.asarray(total * np.outer(scale, scale), dtype=float)


def _linear_weights(size: Floats, sizes: Floats) -> Floats:
    """Weights (M, G, S) of linear interpolation between ascending sizes (M, S), at others (M, G) within."""
    beyond = np.full((*sizes.shape[:1], 1), np.inf)
    ends = np.concatenate([-beyond, sizes, beyond], axis=1)[:, None]
    low, middle, high = ends[..., :-2], ends[..., 1:-1], ends[..., 2:]
    away = size[..., None] - middle
    return np.asarray(np.maximum(1 - np.maximum(-away / (middle - low), away / (high - middle)), 0.0), dtype=float)


def _end_slopes(distance: Floats, sizes: Floats) -> Floats:
    """Weights (M, G, S) of what linear extrapolation adds at distances (M, G) beyond the ends of some sizes (M, S)."""
    ends = sizes[:, [0, -1]]
    step = 1e-3 * (ends[:, 1] - ends[:, 0])
    near = size_weights(ends + step[:, None] * np.array([1.0, -1.0]), sizes)
    outwards = (np.eye(sizes.shape[1])[[0, -1]] - near) / step[:, None, None]
    return np.asarray(
        np.where(distance[..., None] < 0, outwards[:, :1], outwards[:, 1:]) * np.abs(distance)[..., None], dtype=float
    )


def _weight(each: SetStatistics, windows: float) -> Floats:
    """Weights (2,) of a set's likelihoods, by its misfit and by the errors that its rig's windows have in common."""
    shared = 1 / (1 - each.control_common + each.control_common * windows / each.windows)
    weight = np.ones(PARTS)
    weight[1] = shared
    return each.temper * weight


def _deviating(wells: Quadratic, error: Floats) -> Quadratic:
    """Integrate out each well's own deviation from its rig's coordinates."""
    count, precision = error.shape[1], (DEVIATION * error) ** -2.0
    own = wells.information + precision[:, None, :, None] * np.eye(count)
    both = np.concatenate([wells.information, wells.score[..., None]], axis=-1)
    solved = np.linalg.solve(own, both)
    gained = 0.5 * np.einsum("ngr,ngr->ng", wells.score, solved[..., -1])
    gained -= 0.5 * (np.linalg.slogdet(own)[1] - np.log(precision).sum(axis=1)[:, None])
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
