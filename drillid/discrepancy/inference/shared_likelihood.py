"""What a set's data say of causes that it may have in common with other wells, as sufficient statistics.

For each cause, at some of its sizes, the set's model is fitted with the cause held there, and its log-likelihood
expanded to second order in the coordinates that belong to the rig; all that belongs to the set alone is eliminated. One
expansion would not do: a delay and a lag of the drive differ in second order only. The priors of the rig's coordinates
are not in it: wells of a rig have the same data sheets, which err alike in all of them and must be counted once.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from drillid.arrays import Floats
from drillid.discrepancy.catalogue import CATALOGUE, Size
from drillid.discrepancy.inference.screen import dispersion
from drillid.discrepancy.inference.set_fit import SetFit, fit_set, normal_equations
from drillid.discrepancy.inference.set_model import LOCAL, SHARED, Extension, Point, SetModel

RIG = np.delete(np.arange(SHARED), LOCAL)
"""Indices of the coordinates that belong to the rig."""
_SIGNED, _ONE_SIDED = (-1.0, -0.7071, 0.0, 0.7071, 1.0), (0.0, 0.1464, 0.5, 0.8536, 1.0)
"""Sizes relative to the largest: Chebyshev's points, between which a polynomial does not swing."""
HELD = len(_SIGNED)
_REACH = 0.5
"""Largest size relative to the usual one: what is larger shows in a single set."""
_BEYOND = 1.5
"""The same relative to the size that the set itself has."""
PARTS = 2
"""Of the likelihood: mobilities, and responses of the control, whose errors windows of a rig have partly in common."""


@dataclass(frozen=True, eq=False)
class SharedLikelihood:
    """Log-likelihoods of a set; C candidates, S sizes of each, R coordinates of the rig.

    At a size it is value + scoreᵀ x − ½ xᵀ information x, where x are the rig's coordinates less those of the fit.
    """

    prior_error: Floats
    """(R,) standard uncertainty of the data sheets, scaled."""
    sizes: Floats
    """(C, S)"""
    coordinates: Floats
    """(C, S, R) of the fit, less those of the data sheets, scaled."""
    value: Floats
    """(2, C, S)"""
    score: Floats
    """(2, C, S, R)"""
    information: Floats
    """(2, C, S, R, R)"""
    control_common: float
    """Share of errors in common in the variance of the control's responses."""
    windows: int
    temper: float
    """Factor on likelihoods, below one where residuals are larger than the noise explains."""


def shared_candidates() -> list[Extension]:
    """The causes that wells may share and that linear responses show; those of the bit at one of their shapes."""
    causes = [cause for cause in CATALOGUE.values() if cause.shared_by and cause.is_linear and not cause.size.fixed]
    return [
        Extension(cause, shape)
        for cause in causes
        for shape in (cause.shapes if cause.shared_by == "rig" else cause.shapes[len(cause.shapes) // 2 :][:1])
    ]


def candidate_labels(candidates: Sequence[Extension] | None = None) -> list[str]:
    """Each candidate's cause, with its shape where there are several; of `shared_candidates` where none are given."""
    return [
        each.cause.name if len(each.cause.shapes) == 1 else f"{each.cause.name} {each.shape:g}"
        for each in (shared_candidates() if candidates is None else candidates)
    ]


def held_sizes(size: Size, own: float = 0.0) -> Floats:
    """Sizes (S,) at which a cause is held, ascending, up to beyond the set's own size."""
    reach = max(_REACH * size.typical, _BEYOND * abs(own))
    if size.low < 0:
        return min(reach, size.high, -size.low) * np.array(_SIGNED)
    return min(reach, size.high) * np.array(_ONE_SIDED)


def shared_likelihood(
    model: SetModel, fit: SetFit, extensions: tuple[Extension, ...], candidates: Sequence[Extension] | None = None
) -> SharedLikelihood:
    """Expand the log-likelihood of a set with each candidate held at some sizes, from the model with its own causes.

    A cause of that model is held up to beyond its fitted size; the set's other causes are fitted anew each time.

    Parameters
    ----------
    candidates : `shared_candidates` where not given
    """
    candidates = shared_candidates() if candidates is None else candidates
    shape = (PARTS, len(candidates), HELD)
    sizes, value = np.zeros(shape[1:]), np.zeros(shape)
    score, information = np.zeros((*shape, RIG.size)), np.zeros((*shape, RIG.size, RIG.size))
    coordinates = np.zeros((len(candidates), HELD, RIG.size))
    own = _Expansion.of(model, fit, extensions)
    names = [extension.cause.name for extension in extensions]
    for number, candidate in enumerate(candidates):
        sizes[number] = held_sizes(candidate.cause.size)
        place = names.index(candidate.cause.name) if candidate.cause.name in names else None
        others, point, coordinate = extensions, fit.point, 0.0
        if place is not None:
            candidate = extensions[place]
            sizes[number] = held_sizes(candidate.cause.size, float(point.sizes[place]))
            others = (*extensions[:place], *extensions[place + 1 :])
            point, coordinate = point.without(place), float(point.shapes[place])
        fits: dict[float, SetFit] = {} if place is not None else {0.0: fit}
        for node in np.argsort(np.abs(sizes[number]), kind="stable"):
            size = float(sizes[number, node])
            if place is None and size == 0:
                found = own
            else:
                held = model.holding(candidate, size, coordinate)
                fits[size] = fit_set(held, _start(fits, size, point), others)
                found = _Expansion.of(held, fits[size], others)
            coordinates[number, node], value[:, number, node] = found.coordinates, found.value - own.value
            score[:, number, node], information[:, number, node] = found.score, found.information
    used = 2 * max(int(np.count_nonzero(model.weight)), 1)
    return SharedLikelihood(
        prior_error=model.prior_error[RIG],
        sizes=sizes,
        coordinates=coordinates,
        value=value,
        score=score,
        information=information,
        control_common=model.control_common,
        windows=model.evidence.windows,
        temper=1 / (dispersion(model) * max(fit.chi2 / used, 1.0)),
    )


def _start(fits: dict[float, SetFit], size: float, point: Point) -> Point:
    """Where a fit with a cause held at a size starts: on the line through the fits at the two nearest sizes."""
    near = sorted(fits, key=lambda other: abs(other - size))[:2]
    if len(near) < 2:
        return fits[near[0]].point if near else point
    first, second = (fits[other].point for other in near)
    share = (size - near[0]) / (near[0] - near[1])
    return Point(
        first.shared + share * (first.shared - second.shared),
        first.local + share * (first.local - second.local),
        first.sizes + share * (first.sizes - second.sizes),
        first.shapes + share * (first.shapes - second.shapes),
    )


@dataclass(frozen=True, eq=False)
class _Expansion:
    """Log-likelihood of both parts about a fit, without the data sheets' priors."""

    coordinates: Floats
    """(R,)"""
    value: Floats
    """(2,)"""
    score: Floats
    """(2, R)"""
    information: Floats
    """(2, R, R)"""

    @classmethod
    def of(cls, model: SetModel, fit: SetFit, extensions: tuple[Extension, ...]) -> _Expansion:
        """About a fit."""
        lines, nothing = model.s.size, np.zeros((model.evidence.windows, 0, model.rows), dtype=complex)
        of_mobility = normal_equations(model, fit.point, extensions, nothing, slice(lines))
        of_control = normal_equations(model, fit.point, extensions, nothing, slice(lines, None))
        matrix, vector, _, _ = of_mobility.eliminated()
        matrix[RIG, RIG] -= of_mobility.prior[RIG]
        vector[RIG] -= of_mobility.pull[RIG]
        own = np.setdiff1d(np.arange(vector.size), RIG)
        border = matrix[np.ix_(own, RIG)]
        solved = np.linalg.solve(matrix[np.ix_(own, own)], np.column_stack([border, vector[own]]))
        matrices = [matrix[np.ix_(RIG, RIG)] - border.T @ solved[:, :-1], of_control.total[np.ix_(RIG, RIG)]]
        vectors = [vector[RIG] - border.T @ solved[:, -1], of_control.own.sum(0)[RIG]]
        control = 0.5 * float(np.sum(np.abs(model.residual(fit.point, extensions)[:, lines:]) ** 2))
        mobility = fit.cost - 0.5 * float(np.sum(fit.pulls[RIG] ** 2)) - control
        matrices = [(matrix + matrix.T) / 2 for matrix in matrices]
        at = (fit.point.shared - model.prior_mean)[RIG]
        return cls(at, -np.array([mobility, control]), np.stack(vectors), np.stack(matrices))


def size_weights(size: Floats, sizes: Floats) -> Floats:
    """Weights (G, S) of the polynomial through some sizes (S,), at others (G,) (Lagrange)."""
    weights = []
    for place, held in enumerate(sizes):
        others = np.delete(sizes, place)
        weights.append(np.prod((size[:, None] - others) / (held - others), axis=1))
    return np.asarray(np.stack(weights, axis=-1), dtype=float)
