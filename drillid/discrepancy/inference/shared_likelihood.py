"""Sufficient statistics of a set for causes that it may share with other wells.

The set's model is fitted with each cause held at several sizes, and its log-likelihood expanded about each fit to
second order in the rig's coordinates; all that belongs to the set alone is eliminated. A single expansion would not do:
a delay and a lag of the drive differ in second order only. The priors of the rig's coordinates are left out: wells of
a rig have the same data sheets, whose errors are the same in all of them and must be counted once.

Causes that wells may share by the same rig, section or tool are rivals: those that the set's own verdict names are left
out of all these models, so that every candidate is compared with the same one. The set's other causes stay in the
models, and their sizes are fitted again each time.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from drillid.arrays import Complex, Floats, Indices
from drillid.discrepancy.catalogue import CATALOGUE, Size
from drillid.discrepancy.inference.coordinates import DATA_SHEET, LOCAL, SHARED, Extension, Point
from drillid.discrepancy.inference.screen import Screen, dispersion
from drillid.discrepancy.inference.set_fit import (
    Expansion,
    Normal,
    SetFit,
    expanded,
    fit_set,
    moved,
    normal_equations,
    within,
)
from drillid.discrepancy.inference.set_model import SetModel

RIG = np.array(DATA_SHEET)
"""Indices of the coordinates that wells of a rig have in common. The control interval is not one of them: each set has
found its own likeliest one, and no expansion holds far from it.
"""
HELD = 7
"""Number of sizes at which a cause is held. The likelihood of a second-order filter falls with the sixth power of its
time constant; a polynomial through fewer sizes would bend up near zero, in all wells alike.
"""
_SIGNED = np.sin(np.pi * np.linspace(-0.5, 0.5, HELD))
_ONE_SIDED = (1 + _SIGNED) / 2
"""Sizes relative to the largest: Chebyshev points, between which an interpolating polynomial does not oscillate."""
_REACH = (0.1, 0.5, 1.5)
"""Minimum, first trial and maximum of the largest size held, relative to the usual size."""
_DECISIVE = 12.5
"""Fall of the log-likelihood aimed at for the largest size held: a set would name such a cause by itself."""
_BEYOND = 1.5
"""Lower limit of the largest size held, relative to the cause's size in the set itself."""
_FALL = 100.0
"""Fall of the log-likelihood at the largest size above which the sizes held are reduced."""
PARTS = 2
"""Parts of the likelihood: mobilities, and responses of the control, whose errors are partly common within a rig."""
DIRECTIONS = 2
"""Directions of each candidate: changes of the responses at the smallest non-zero size held and at the largest, or at
both ends where sizes are signed.
"""
_SETTLED = 1.0
"""Fall of the cost in a Gauss–Newton step below which that step is the last."""


@dataclass(frozen=True, eq=False)
class SharedLikelihood:
    """Log-likelihoods of a set; C candidates, S sizes of each, R coordinates of the rig.

    At each size it is value + scoreᵀ x − ½ xᵀ information x, where x are the rig's coordinates less those of the fit.
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
    directions: Floats
    """(2, R + 2 C, R + 2 C) information of the rig's coordinates and of two changes of the responses by each candidate;
    zero between candidates of different groups."""
    control_common: float
    """Share of common errors in the variance of the control's responses."""
    windows: int
    temper: float
    """Factor on likelihoods, below one where residuals are larger than the noise explains."""


def shared_candidates() -> list[Extension]:
    """The causes that wells may share and that linear responses show: those of a rig at all shapes, others at one."""
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


def held_sizes(size: Size, reach: float = _REACH[1]) -> Floats:
    """Sizes (S,) at which a cause is held, ascending, up to a reach relative to the usual size."""
    largest = min(reach * size.typical, size.high)
    if size.low < 0:
        return min(largest, -size.low) * _SIGNED
    return largest * _ONE_SIDED


def shared_likelihood(
    model: SetModel,
    fit: SetFit,
    extensions: tuple[Extension, ...],
    before: Screen,
    candidates: Sequence[Extension] | None = None,
) -> SharedLikelihood:
    """Expand the log-likelihood of a set with each candidate held at some sizes.

    Parameters
    ----------
    fit : of the model with the set's own causes
    extensions : these causes
    before : the screen of the model without them
    candidates : `shared_candidates` where not given
    """
    candidates = shared_candidates() if candidates is None else candidates
    # as the rig's priors are where wells are combined
    model = model.with_normal_priors()
    count, rig = len(candidates), RIG.size
    kept = SharedLikelihood(
        prior_error=model.priors.error[RIG],
        sizes=np.zeros((count, HELD)),
        coordinates=np.zeros((count, HELD, rig)),
        value=np.zeros((PARTS, count, HELD)),
        score=np.zeros((PARTS, count, HELD, rig)),
        information=np.zeros((PARTS, count, HELD, rig, rig)),
        directions=np.zeros((PARTS, rig + DIRECTIONS * count, rig + DIRECTIONS * count)),
        control_common=model.measured.control_common,
        windows=model.evidence.windows,
        temper=1
        / (dispersion(model) * max(fit.chi2 / (2 * max(int(np.count_nonzero(model.measured.weight)), 1)), 1.0)),
    )
    errors = _standard_errors(candidates, before)
    for group in dict.fromkeys(each.cause.shared_by for each in candidates):
        rivals = [place for place, each in enumerate(extensions) if each.cause.shared_by == group]
        own = _own_size(fit, extensions, rivals, candidates, errors)
        others = tuple(each for each in extensions if each.cause.shared_by != group)
        point = fit.point
        for place in reversed(rivals):
            point = point.without(place)
        base = expanded(model, fit_set(model, point, others).point, others)
        held = {
            number: _HeldCause(model, base, others, each)
            for number, each in enumerate(candidates)
            if each.cause.shared_by == group
        }
        _fill(kept, held, errors, own)
    return kept


def _standard_errors(candidates: Sequence[Extension], before: Screen) -> Floats:
    """Standard errors (C,) of candidates' sizes in the set, relative to the usual ones; infinite if not screened."""
    known = {
        (each.cause.name, each.shape): float(information) ** -0.5 / each.cause.size.typical
        for each, information in zip(before.candidates, np.diag(before.projection.information), strict=True)
    }
    return np.array([known.get((each.cause.name, each.shape), np.inf) for each in candidates])


def _own_size(
    fit: SetFit, extensions: tuple[Extension, ...], rivals: list[int], candidates: Sequence[Extension], errors: Floats
) -> Floats:
    """Size (C,) that a candidate may have in place of the set's own causes, relative to its usual size: as many usual
    sizes as these have, or as many standard errors if that is less.
    """
    own = np.zeros(errors.size)
    for place in rivals:
        cause, size = extensions[place].cause, abs(float(fit.point.sizes[place]))
        of_cause = [error for error, each in zip(errors, candidates, strict=True) if each.cause.name == cause.name]
        usual = size / cause.size.typical
        own = np.maximum(own, usual * np.minimum(1.0, errors / min(of_cause, default=np.inf)))
    return own


class _HeldCause:
    """The model of a set with one cause held at given sizes, refitted at each.

    Parameters
    ----------
    base : expansion of the model without the cause
    others : causes of the set whose sizes are fitted
    """

    def __init__(self, model: SetModel, base: Expansion, others: tuple[Extension, ...], candidate: Extension) -> None:
        self.model, self.base, self.others, self.candidate = model, base, others, candidate
        self._points, self._found = {0.0: base.point}, {0.0: _Quadratic.of(model, base)}

    def at(self, size: float) -> _Quadratic:
        """The log-likelihood with the cause at a size."""
        if size not in self._found:
            held = self.model.holding(self.candidate, size)
            about = _settled(held, _start(self._points, size), self.others)
            self._points[size], self._found[size] = about.point, _Quadratic.of(held, about)
        return self._found[size]

    def values(self, sizes: Floats) -> Floats:
        """Log-likelihood ratios (sizes, 2) against size zero, computed from the smallest size upwards."""
        for size in sizes[np.argsort(np.abs(sizes), kind="stable")].tolist():
            self.at(size)
        return np.array([self.at(size).value - self.at(0.0).value for size in sizes.tolist()])

    def sizes(self, error: float, own: float) -> Floats:
        """Sizes (S,) at which the cause is held, up to where the set's likelihood has fallen decisively.

        Parameters
        ----------
        error : standard error of the size from the derivatives at size zero, relative to the usual size
        own : lower limit of the largest size, relative to the usual size
        """
        size = self.candidate.cause.size
        least, first, most = _REACH
        by_slopes = float(np.clip(np.sqrt(2 * _DECISIVE) * error, least, most))
        reach = by_slopes if size.low < 0 else self._decisive(first)
        sizes = held_sizes(size, max(reach, own))
        while sizes[-1] > least * size.typical and self._too_far(sizes):
            sizes = sizes * np.abs(sizes[-3] / sizes[-1])
        return sizes

    def _decisive(self, reach: float) -> float:
        """Reach at which the likelihood has fallen decisively, extrapolated from a trial one: the fall goes with about
        the third power, as the rig's coordinates absorb the first order of the effect, or with a higher one.
        """
        power, (least, _, most) = 3.0, _REACH
        log_reach, log_fall = np.log(reach), self._log_fall(reach)
        reach = float(np.clip(np.exp(log_reach + (np.log(_DECISIVE) - log_fall) / power), least, most))
        further = self._log_fall(reach)
        if np.log(reach) != log_reach:
            power = float(np.clip((further - log_fall) / (np.log(reach) - log_reach), 1.0, 8.0))
        return float(np.clip(reach * np.exp((np.log(_DECISIVE) - further) / power), least, most))

    def _log_fall(self, reach: float) -> float:
        """Logarithm of the fall of the log-likelihood at the largest size of a reach, approached by smaller sizes."""
        trial = _HeldCause(self.model, self.base, self.others, self.candidate)
        fall = -float(trial.values(held_sizes(self.candidate.cause.size, reach)[HELD // 2 - 1 :: 2])[-1].sum())
        return float(np.log(max(fall, 1e-3)))

    def _too_far(self, sizes: Floats) -> bool:
        """Whether the likelihood falls so far at an end that a polynomial no longer holds near the likeliest size."""
        value = self.values(sizes).sum(axis=1)
        best, fall = int(np.argmax(value)), value.max() - value
        above, below = best < HELD - 2 and fall[-1] > _FALL, best > 1 and fall[0] > _FALL
        return above or (sizes[0] < 0 and below)

    def change(self, size: float) -> Complex:
        """Change (W, rows) of the whitened responses by the cause at a size."""
        without = self.model.residual(self.base.point, self.others)
        return without - self.model.holding(self.candidate, size).residual(self._points[size], self.others)


def _fill(kept: SharedLikelihood, held: dict[int, _HeldCause], errors: Floats, own: Floats) -> None:
    """Enter the expansions and the directions of the candidates of a group, by their numbers."""
    changes, places = [], [*range(RIG.size)]
    for number, cause in held.items():
        sizes = kept.sizes[number] = cause.sizes(float(errors[number]), _BEYOND * float(own[number]))
        kept.value[:, number] = cause.values(sizes).T
        for node, size in enumerate(sizes.tolist()):
            found = cause.at(size)
            kept.coordinates[number, node], kept.score[:, number, node] = found.coordinates, found.score
            kept.information[:, number, node] = found.information
        changes += [cause.change(float(size)) for size in (sizes[0] or sizes[1], sizes[-1])]
        places += range(RIG.size + DIRECTIONS * number, RIG.size + DIRECTIONS * (number + 1))
    first = next(iter(held.values()))
    information = _information(first.model, first.base.point, first.others, np.stack(changes, axis=1))
    kept.directions[np.ix_(np.arange(PARTS), np.array(places), np.array(places))] = information


def _settled(model: SetModel, start: Point, extensions: tuple[Extension, ...]) -> Expansion:
    """Expansion near the optimum: after one Gauss–Newton step if the start is close to it, after a fit otherwise."""
    about = expanded(model, within(start, extensions), extensions)
    there = expanded(model, moved(about, extensions, 0.0), extensions)
    if 0 <= about.cost - there.cost < _SETTLED:
        return there
    return expanded(model, fit_set(model, about.point, extensions).point, extensions)


def _start(points: dict[float, Point], size: float) -> Point:
    """Where a fit with a cause held at a size starts: on the line through the fits at the two next smaller sizes."""
    smaller = [other for other in points if abs(other) < abs(size) and other * size >= 0]
    near = sorted(smaller, key=lambda other: abs(other - size))[:2]
    if len(near) < 2:
        return points[near[0]]
    first, second = (points[other] for other in near)
    share = (size - near[0]) / (near[0] - near[1])
    return Point(
        first.shared + share * (first.shared - second.shared),
        first.local + share * (first.local - second.local),
        first.sizes + share * (first.sizes - second.sizes),
        first.shapes + share * (first.shapes - second.shapes),
    )


@dataclass(frozen=True, eq=False)
class _Quadratic:
    """Log-likelihood of both parts about a point, without the data sheets' priors."""

    coordinates: Floats
    """(R,)"""
    value: Floats
    """(2,)"""
    score: Floats
    """(2, R)"""
    information: Floats
    """(2, R, R)"""

    @classmethod
    def of(cls, model: SetModel, about: Expansion) -> _Quadratic:
        """From an expansion in all coordinates."""
        sums, normal, mobilities = about.sums, about.normal, about.sums.of_mobilities
        of_mobility = replace(
            normal,
            total=mobilities[:, :-1, :-1].sum(0),
            border=mobilities[:, list(LOCAL), :-1],
            own=mobilities[:, :-1, -1],
        )
        matrix, vector, step, _ = of_mobility.eliminated()
        # what the deviations of the windows still gain, integrated over them
        gained = 0.5 * float(np.einsum("wl,wlm,wm->", step, of_mobility.corner, step))
        gained -= 0.5 * float(np.linalg.slogdet(of_mobility.unbounded.corner)[1].sum())
        matrix[RIG, RIG] -= normal.prior[RIG]
        vector[RIG] -= normal.pull[RIG]
        matrix, vector, more = _eliminated(matrix, vector, RIG)
        rest, pull, of_control = _of_control(
            (sums.each - mobilities[:, :-1, :-1]).sum(0),
            (sums.own - mobilities[:, :-1, -1]).sum(0),
            normal,
        )
        at = about.point.shared - model.prior_mean
        control = 0.5 * (float(sums.squares.sum()) - sums.mobility_chi2)
        mobility = about.cost - float(np.sum(model.priors.cost(at / model.priors.error)[RIG])) - control
        return cls(
            at[RIG],
            np.array([gained + more - mobility, of_control - control]),
            np.stack([vector, pull]),
            np.stack([matrix, rest]),
        )


def _information(model: SetModel, point: Point, extensions: tuple[Extension, ...], further: Complex) -> Floats:
    """Information (2, R + K, R + K) of the rig's coordinates and of directions (W, K, rows), in both parts."""
    lines = model.s.size
    of_mobility = normal_equations(model, point, extensions, further, slice(lines))
    of_control = normal_equations(model, point, extensions, further, slice(lines, None))
    known = of_mobility.prior.size - further.shape[1]
    wanted = np.append(RIG, np.arange(known, of_mobility.prior.size))
    matrix, vector, _, _ = of_mobility.eliminated()
    matrix[RIG, RIG] -= of_mobility.prior[RIG]
    control = _of_control(of_control.total, of_control.own.sum(0), of_control, further.shape[1])[0]
    return np.stack([_eliminated(matrix, vector, wanted)[0], control])


def _of_control(matrix: Floats, vector: Floats, normal: Normal, further: int = 0) -> tuple[Floats, Floats, float]:
    """The part of the control's responses, which depend on the rig's coordinates, on further directions that come last,
    and perhaps on the set's own causes, whose sizes are eliminated as if the mobilities did not depend on them.
    """
    sizes = np.arange(SHARED, vector.size - further)
    matrix, vector = matrix.copy(), vector.copy()
    matrix[sizes, sizes] += normal.prior[sizes]
    vector[sizes] += normal.pull[sizes]
    shown = np.append(RIG, np.arange(SHARED, vector.size))
    places = np.append(np.arange(RIG.size), RIG.size + sizes.size + np.arange(further))
    return _eliminated(matrix[np.ix_(shown, shown)], vector[shown], places)


def _eliminated(matrix: Floats, vector: Floats, wanted: Indices) -> tuple[Floats, Floats, float]:
    """A quadratic with all but the wanted coordinates at their optimum, and its gain from moving these there."""
    own = np.setdiff1d(np.arange(vector.size), wanted)
    border = matrix[np.ix_(own, wanted)]
    solved = np.linalg.solve(matrix[np.ix_(own, own)], np.column_stack([border, vector[own]]))
    left = matrix[np.ix_(wanted, wanted)] - border.T @ solved[:, :-1]
    gained = 0.5 * float(vector[own] @ solved[:, -1])
    return (left + left.T) / 2, vector[wanted] - border.T @ solved[:, -1], gained


def size_weights(size: Floats, sizes: Floats) -> Floats:
    """Lagrange weights (..., G, S) for interpolation from sizes (..., S) to other sizes (..., G)."""
    away = size[..., None] - sizes[..., None, :]
    between = sizes[..., :, None] - sizes[..., None, :]
    weights = [
        np.prod(np.delete(away, place, axis=-1), axis=-1)
        / np.prod(np.delete(between[..., place, :], place, axis=-1), axis=-1)[..., None]
        for place in range(sizes.shape[-1])
    ]
    return np.stack(weights, axis=-1)
