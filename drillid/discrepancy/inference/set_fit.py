"""Gauss–Newton fits of a set's model with the windows' deviations eliminated: effort is linear in the windows."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np

from drillid.arrays import Complex, Floats, Indices
from drillid.discrepancy.inference.coordinates import (
    DAMPING_BIT,
    DATA_SHEET,
    FURTHEST_SHAPE,
    HIGHEST,
    LOCAL,
    LOWEST,
    PASSIVE,
    SHARED,
    STATED,
    Extension,
    Point,
    fitted_shapes,
)
from drillid.discrepancy.inference.priors import Priors
from drillid.discrepancy.inference.rows import Products, real_rows
from drillid.discrepancy.inference.set_model import SetModel
from drillid.discrepancy.rules import OUTLIER_IMPROVEMENT, STUDENT_TAIL, WIDE_PRIOR
from drillid.fits.damped import DEVIATIONS, LEAST_CURVATURE, SET, SET_END, descend
from drillid.statistics import TWO_SIDED, student

_ROUNDS = 3
"""Rounds in which each window is restarted from the set's values."""
_CLOSE = 2.0
"""Cost above that of an optimum within which a point counts as there: two standard errors."""
_HEAVY = student(TWO_SIDED, STUDENT_TAIL) / TWO_SIDED
"""Standard deviation of the normal distribution whose central 95 % interval is that of Student's t of unit scale."""
_PLACES, _UNIT = list(LOCAL), np.eye(len(LOCAL))
"""Indices of the windows' deviations among the shared coordinates, and the unit matrix of their size."""


@dataclass(frozen=True, eq=False)
class Normal:
    """Normal equations of a set about a point, for its P shared coordinates, sizes and parameters of shapes."""

    total: Floats
    """(P, P) of all windows' rows."""
    border: Floats
    """(W, 4, P) of each window's rows, between its deviations and all coordinates."""
    own: Floats
    """(W, P) right-hand sides."""
    prior: Floats
    """(P,) precision of the priors."""
    pull: Floats
    """(P,) right-hand side of the priors."""
    local_precision: Floats
    """(W, 4) precision of the windows' deviations."""
    local: Floats
    """(W, 4) the deviations."""
    below: Floats
    """(W,) how far the damping at the bit lies below zero, in standard deviations PASSIVE; negative or 0."""

    @property
    def corner(self) -> Floats:
        """(W, 4, 4) of the windows' deviations, with their prior and bound."""
        return self._corner(self._bounded_border)

    @property
    def unbounded(self) -> "Normal":
        """The same without the bound of the damping, whose curvature is not part of the likelihood's."""
        return replace(self, below=np.zeros_like(self.below))

    @property
    def _bounded_border(self) -> Floats:
        """(W, 4, P) the border including the bound of the damping."""
        border = self.border.copy()
        border[:, _PLACES.index(DAMPING_BIT), DAMPING_BIT] += _bound(self.below)[0]
        return border

    def eliminated(self, damping: float = 0.0) -> tuple[Floats, Floats, Floats, Floats]:
        """The equations with the windows' deviations eliminated.

        Returns
        -------
        matrix, vector : (P, P), (P,) of all but the windows' deviations
        own, border : (W, 4), (W, 4, P); the deviations are own − border @ step
        """
        border, total, each = self._bounded_border, self.total.copy(), self.own.copy()
        corner = self._corner(border) * (1 + damping * _UNIT)
        curvature, pull = _bound(self.below)
        total[DAMPING_BIT, DAMPING_BIT] += curvature.sum()
        each[:, DAMPING_BIT] += pull
        right = each[:, _PLACES] - self.local_precision * self.local
        solved = np.linalg.solve(corner, np.concatenate([border, right[..., None]], axis=-1))
        known = self.prior.size
        fallen = border.reshape(-1, known).T @ solved.reshape(-1, known + 1)
        matrix = total + np.diag(self.prior) - fallen[:, :-1]
        vector = each.sum(0) + self.pull - fallen[:, -1]
        return matrix, vector, solved[..., -1], solved[..., :-1]

    def _corner(self, border: Floats) -> Floats:
        own: Floats = border[:, :, _PLACES] + self.local_precision[:, :, None] * _UNIT
        return own


@dataclass(frozen=True, eq=False)
class SetFit:
    """Optimum of a set's model."""

    point: Point
    cost: float
    """Half the sum of squares of residuals and prior pulls."""
    chi2: float
    """Sum of squared residuals of the mobilities, two for each used frequency."""
    information: Floats
    """(P, P), curvature of the cost in shared coordinates, sizes and shapes, the windows' deviations eliminated."""
    windows_information: float
    """Log determinant of the curvature in the windows' deviations with all else held."""
    off_data_sheet: Floats
    """(14,) offsets of the shared coordinates from their prior means, in prior standard deviations."""
    priors: Priors
    """Priors of the shared coordinates."""

    @property
    def mass(self) -> float:
        """Logarithm of the posterior mass about the optimum, up to a constant of all fits with as many parameters, by
        Laplace's approximation.
        """
        return float(-self.cost - 0.5 * (np.linalg.slogdet(self.information)[1] + self.windows_information))

    @property
    def pulls(self) -> Floats:
        """(14 + W,) the same offsets as normal variables of equal log density relative to its peak, and how far each
        window's damping at the bit lies below zero: half the sum of their squares is part of the cost.
        """
        return np.append(np.sign(self.off_data_sheet) * np.sqrt(2 * self._off_costs), below_zero(self.point))

    @property
    def data_sheet_cost(self) -> float:
        """Part of the cost due to coordinates off their data sheets."""
        return float(np.sum(self._off_costs[list(STATED)]))

    @property
    def _off_costs(self) -> Floats:
        return self.priors.cost(self.off_data_sheet)

    @property
    def size_errors(self) -> Floats:
        """Standard errors of the sizes from the curvature, for 95 % intervals.

        Errors of data-sheet values have heavy tails, which the curvature does not reflect: the 95 % interval of
        Student's t is that of a normal distribution half as wide again as its scale.
        """
        documented, sizes = list(DATA_SHEET), slice(SHARED, SHARED + self.point.sizes.size)
        precision = self.priors.precision(self.off_data_sheet)
        wide = (_HEAVY * self.priors.error[documented]) ** -2.0
        information = self.information.copy()
        information[documented, documented] -= np.maximum(precision[documented] - wide, 0.0)
        return np.asarray(np.sqrt(np.diag(np.linalg.inv(information))[sizes]), dtype=float)


def fit_set(
    model: SetModel,
    start: Point,
    extensions: tuple[Extension, ...] = (),
    enough: float = np.inf,
    found: Sequence[SetFit] = (),
) -> SetFit:
    """Minimise the cost from a start; sizes stay within their physical bounds.

    Parameters
    ----------
    enough : cost of interest; a fit whose cost falls too slowly to reach it is stopped early
    found : fits of the same model from other starts; a fit that comes close to the optimum of one is stopped there
    """

    def is_known(about: Expansion) -> bool:
        return any(_is_close(about, other, extensions) for other in found)

    def steps_from(about: Expansion) -> Callable[[float], Expansion]:
        return lambda damping: expanded(model, moved(about, extensions, damping), extensions)

    best = descend(expanded(model, within(start, extensions), extensions), steps_from, SET, SET_END, enough, is_known)
    point = best.point
    off_data_sheet = (point.shared - model.prior_mean) / model.priors.error
    normal = best.normal.unbounded
    windows = float(np.linalg.slogdet(normal.corner)[1].sum())
    information = normal.eliminated()[0]
    return SetFit(point, best.cost, best.chi2, information, windows, off_data_sheet, model.priors)


def fit_local(
    model: SetModel, point: Point, extensions: tuple[Extension, ...] = (), windows: Indices | None = None
) -> Point:
    """Fit the deviations of each window separately, with shared coordinates and sizes held fixed.

    Parameters
    ----------
    windows : rows of the windows that are fitted, all where not given
    """
    count, places = model.evidence.windows, list(LOCAL)
    local, damping, least = point.local, np.full(count, DEVIATIONS.first), np.full(count, np.inf)
    best, each, own = local, np.zeros((count, 4, 4)), np.zeros((count, 4))
    open_rows = np.isin(np.arange(count), np.arange(count) if windows is None else windows)
    for _ in range(SET_END.trials):
        trial = replace(point, local=local)
        sums, precision = model.products(trial, extensions, np.flatnonzero(open_rows)), _precision(model, trial)
        cost = _window_costs(model, trial, sums.squares)
        better = open_rows & (cost < least)
        each[better] = sums.each[better][:, places][:, :, places] + precision[better][:, :, None] * np.eye(4)
        own[better] = sums.own[better][:, places] - precision[better] * local[better]
        curvature, pull = _bound(below_zero(trial)[better])
        damping_bit = places.index(DAMPING_BIT)
        each[better, damping_bit, damping_bit] += curvature
        own[better, damping_bit] += pull
        fallen = np.where(better, least - cost, 0.0)
        best, least = np.where(better[:, None], local, best), np.where(better, cost, least)
        damping = damping * np.where(better, DEVIATIONS.reduction, DEVIATIONS.growth)
        open_rows = open_rows & ~((better & (fallen < SET_END.fall)) | (damping > DEVIATIONS.largest))
        if not open_rows.any():
            break
        damped = each[open_rows] * (1 + damping[open_rows][:, None, None] * np.eye(4))
        local = best.copy()
        local[open_rows] += np.linalg.solve(damped, own[open_rows][..., None])[..., 0]
        local = _within_bounds(local, point.shared)
    return replace(point, local=best)


def without_outlier_windows(model: SetModel, fit: SetFit, extensions: tuple[Extension, ...] = ()) -> SetFit:
    """The fit after each window has also been restarted from the set's values: with Student's t the cost has a minimum
    near the set and others far from it, and a window may have ended at one of those.
    """
    for _ in range(_ROUNDS):
        point = fit.point
        near = fit_local(model, replace(point, local=np.zeros_like(point.local)), extensions)
        costs = (
            _window_costs(model, trial, np.sum(np.abs(model.residual(trial, extensions)) ** 2, axis=1))
            for trial in (near, point)
        )
        better = np.less(*costs)
        local = np.where(better[:, None], near.local, point.local)
        again = fit_set(model, replace(point, local=local), extensions)
        if not again.cost < fit.cost:
            break
        fall, fit = fit.cost - again.cost, again
        if fall < OUTLIER_IMPROVEMENT:
            break
    return fit


def _window_costs(model: SetModel, point: Point, squares: Floats) -> Floats:
    """Cost (W,) of each window's squared residuals (W,), of its deviations by Student's t and of a negative damping."""
    pulls = (STUDENT_TAIL + 1) * np.sum(np.log1p((point.local / model.deviation) ** 2 / STUDENT_TAIL), axis=1)
    return np.asarray(0.5 * (squares + pulls + below_zero(point) ** 2), dtype=float)


def below_zero(point: Point) -> Floats:
    """(W,) how far each window's damping at the bit lies below zero, in standard deviations PASSIVE; never positive."""
    damping = point.shared[DAMPING_BIT] + point.local[:, _PLACES.index(DAMPING_BIT)]
    return np.asarray(np.minimum(damping, 0.0) / PASSIVE, dtype=float)


def _bound(below: Floats) -> tuple[Floats, Floats]:
    """Curvature of the cost of a negative damping at the bit, and its right-hand side, each (W,)."""
    return np.where(below < 0, PASSIVE**-2.0, 0.0), -below / PASSIVE


def within(point: Point, extensions: tuple[Extension, ...]) -> Point:
    """The point with coordinates, sizes and shapes within their bounds."""
    return point.moved(np.clip(point.coordinates(extensions), *_bounds(extensions)), point.local, extensions)


@lru_cache(maxsize=1000)
def _bounds(extensions: tuple[Extension, ...]) -> tuple[Floats, Floats]:
    """Bounds of shared coordinates, sizes and shapes."""
    sizes = [extension.cause.size for extension in extensions]
    furthest = np.full(len(fitted_shapes(extensions)), FURTHEST_SHAPE)
    low = np.concatenate([LOWEST, [size.low for size in sizes], -furthest])
    return low, np.concatenate([HIGHEST, [size.high for size in sizes], furthest])


def normal_equations(
    model: SetModel,
    point: Point,
    extensions: tuple[Extension, ...],
    further: Complex,
    lines: slice = slice(None),
    bias: Complex | float = 0.0,
) -> Normal:
    """Normal equations of some rows about a point, with further columns (W, K, rows) that have no priors.

    Parameters
    ----------
    bias : mean of the residuals where the model is right, (W, rows)
    """
    linear = model.linearised(point, extensions)
    residual = linear.residual - bias
    off, priors = _priors(model, point, extensions)
    prior, pull = priors.precision_and_pull(off)
    known, windows = prior.size, model.evidence.windows
    count = known + further.shape[1]
    total, border, own = np.zeros((count, count)), np.empty((windows, len(LOCAL), count)), np.empty((windows, count))
    # window by window, as there may be hundreds of columns
    columns = np.empty((count, len(range(*lines.indices(further.shape[2])))), dtype=complex)
    rows = real_rows(columns)
    for window in range(windows):
        columns[:known], columns[known:] = linear.jacobian[window][:, lines], further[window][:, lines]
        total += rows @ rows.T
        border[window] = rows[list(LOCAL)] @ rows.T
        own[window] = rows @ real_rows(residual[window, lines])
    more = np.zeros(further.shape[1])
    precision = _precision(model, point)
    below = below_zero(point)
    return Normal(total, border, own, np.append(prior, more), np.append(pull, more), precision, point.local, below)


def _priors(model: SetModel, point: Point, extensions: tuple[Extension, ...]) -> tuple[Floats, Priors]:
    """Offsets (P,) of coordinates, sizes and shapes from the means of their priors, in errors, and the priors."""
    priors = _extended(model.priors, extensions)
    off = point.coordinates(extensions)
    off[:SHARED] -= model.prior_mean
    off /= priors.error
    return off, priors


@lru_cache(maxsize=1000)
def _extended(priors: Priors, extensions: tuple[Extension, ...]) -> Priors:
    """Priors followed by those of sizes and shapes."""
    typical = np.array([WIDE_PRIOR * extension.cause.size.typical for extension in extensions])
    return priors.and_normal(np.append(typical, np.ones(len(fitted_shapes(extensions)))))


def _precision(model: SetModel, point: Point) -> Floats:
    """Precision of Student's t at the deviations: a window in another formation or hole may lie far from the set."""
    return np.asarray((STUDENT_TAIL + 1) / (STUDENT_TAIL * model.deviation**2 + point.local**2), dtype=float)


@dataclass(frozen=True, eq=False)
class Expansion:
    """A set's model expanded about a point."""

    point: Point
    cost: float
    normal: Normal
    sums: Products

    @property
    def chi2(self) -> float:
        """Sum of squared residuals of the mobilities."""
        return self.sums.mobility_chi2


def _is_close(about: Expansion, found: SetFit, extensions: tuple[Extension, ...]) -> bool:
    """Whether a point lies within two standard errors of an optimum, and its cost as little above the optimum's."""
    if not 0 <= about.cost - found.cost < _CLOSE:
        return False
    off = about.point.coordinates(extensions) - found.point.coordinates(extensions)
    return bool(0.5 * off @ found.information @ off < _CLOSE)


def expanded(model: SetModel, point: Point, extensions: tuple[Extension, ...]) -> Expansion:
    """The model linearised about a point, with its cost there."""
    sums = model.products(point, extensions)
    off, priors = _priors(model, point, extensions)
    prior, pull = priors.precision_and_pull(off)
    cost = float(np.sum(priors.cost(off))) + float(np.sum(_window_costs(model, point, sums.squares)))
    normal = Normal(
        *(sums.each.sum(0), sums.each[:, list(LOCAL)], sums.own),
        *(prior, pull, _precision(model, point), point.local, below_zero(point)),
    )
    return Expansion(point, cost, normal, sums)


def moved(about: Expansion, extensions: tuple[Extension, ...], damping: float) -> Point:
    """The damped step; a coordinate that it would carry over a bound goes to the bound and the rest is solved again."""
    point, (low, high) = about.point, _bounds(extensions)
    matrix, vector, own, border = about.normal.eliminated(damping)
    diagonal = matrix.diagonal()
    np.fill_diagonal(matrix, diagonal + damping * np.maximum(diagonal, LEAST_CURVATURE))
    now = point.coordinates(extensions)
    step, held = np.linalg.solve(matrix, vector), np.zeros(vector.size, dtype=bool)
    for _ in range(low.size):
        over = ((now + step < low) | (now + step > high)) & ~held
        if not over.any():
            break
        step = np.where(over, np.clip(now + step, low, high) - now, step)
        held |= over
        free = ~held
        rows = matrix[free]
        step[free] = np.linalg.solve(rows[:, free], vector[free] - rows[:, held] @ step[held])
    local = point.local + own - border @ step
    return point.moved(now + step, _within_bounds(local, point.shared + step[:SHARED]), extensions)


def _within_bounds(local: Floats, shared: Floats) -> Floats:
    """Deviations (W, 4) clipped so that each window's own values keep within the bounds of the set's."""
    places = list(LOCAL)
    return np.clip(local, LOWEST[places] - shared[places], HIGHEST[places] - shared[places])
