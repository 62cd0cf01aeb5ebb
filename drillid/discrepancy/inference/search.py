"""Causes one by one at their best: non-linear fits, and their evidence by Laplace's approximation."""

from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.special import log_ndtr

from drillid.discrepancy.catalogue import Cause
from drillid.discrepancy.inference.screen import Screen
from drillid.discrepancy.inference.set_fit import SetFit, fit_set, without_outlier_windows
from drillid.discrepancy.inference.set_model import Extension, Point, SetModel
from drillid.discrepancy.rules import (
    CONTENDER,
    FOLLOWED_WITHIN,
    OBVIOUS_MISFIT,
    OUT_OF_REACH,
    SHAPE_RESOLVED,
    SHAPES_WITHIN,
    WIDE_PRIOR,
)

_MOST_SHAPES = 2
_SPREAD = 6
"""Of a continuous shape, how many others are tried where the linear order is not to be trusted."""
_FINEST = 0.1
"""Share of its first size that a step of a shape is halved to."""
_MOST_FIXED = 2


@dataclass(frozen=True, eq=False)
class Refined:
    """The model extended by one more cause, at its optimum."""

    extension: Extension
    fit: SetFit
    log_evidence: float
    """Log Bayes factor against the model without the cause."""

    @property
    def name(self) -> str:
        """The cause's identifier."""
        return self.extension.cause.name

    @property
    def at_bound(self) -> bool:
        """Whether its size ran into a bound."""
        return self.extension.cause.size.at_bound(float(self.fit.point.sizes[-1]))


def refine(
    model: SetModel,
    base: SetFit,
    extensions: tuple[Extension, ...],
    screened: Screen,
    catalogue: Sequence[Cause],
    *,
    moving: Mapping[str, float],
    every: bool = False,
    rejected: bool = False,
) -> list[Refined]:
    """Fit the causes that may explain what is seen; best evidence first.

    The linear evidence orders them well where causes are small. Where the misfit is obvious, as where the base model
    is `rejected`, or `every` cause is asked for, all are fitted at their likeliest shapes, from several sizes and from
    the data sheets as well, as a large cause may show by what is not linear in it, and bend the base fit; those that
    come near the best are then fitted at more shapes.

    Parameters
    ----------
    moving : sizes by which causes that move are in sight in the record; the screen does not know these
    """
    linear = screened.by_cause
    best = max(linear.values(), default=-np.inf)
    obvious = rejected or max(best, screened.unknown_evidence) > OBVIOUS_MISFIT
    every = every or obvious
    taken = {one.cause.name for one in extensions}
    names = [name for name, value in linear.items() if name not in taken and (every or value >= best - FOLLOWED_WITHIN)]
    search = _Search(model, base, extensions, starts=every)
    found: list[Refined] = []
    for name in sorted(names, key=lambda one: -linear[one]):
        found.append(search.best(_first_shapes(screened, name, obvious), _least_cost(found)))
    following = [cause for cause in catalogue if cause.name in moving and cause.name not in taken]
    found += [search.following(one, moving[one.name], _least_cost(found)) for one in following]
    if obvious:
        fixed = [cause for cause in catalogue if cause.is_linear and cause.size.fixed and cause.name not in taken]
        found += [search.best(search.nearest(one), _least_cost(found)) for one in fixed]
    # what fits only at a bound of its size is no name, and does not set the standard
    top = max((one.log_evidence for one in found if not one.at_bound), default=-np.inf)
    near = min(top - FOLLOWED_WITHIN, CONTENDER * top)
    most = None if obvious else _MOST_SHAPES
    least = _least_cost(found)
    found = [
        search.settled(one, screened, most, least) if one.log_evidence >= near and one.name in linear else one
        for one in found
    ]
    # the others start beside the best, once no window of it is astray
    best_fit = max(found, key=lambda one: one.log_evidence, default=None)
    found = [search.without_outlier_windows(one) if one is best_fit else one for one in found]
    contenders = [one for one in found if one.log_evidence >= near]
    found = [search.beside(one, contenders) if one in contenders else one for one in found]
    return sorted(found, key=lambda one: -one.log_evidence)


def _least_cost(found: Sequence[Refined]) -> float:
    return min((one.fit.cost for one in found), default=np.inf)


@dataclass(frozen=True, eq=False)
class _Search:
    """Fits of the model with one more cause."""

    model: SetModel
    base: SetFit
    extensions: tuple[Extension, ...]
    starts: bool
    """Whether they start from several sizes, and from the data sheets as well, or from no size at the base fit."""

    def best(self, shapes: Iterable[Extension], least: float = np.inf) -> Refined:
        """The best of some shapes; `least` is the cost of the best that is known."""
        found: list[Refined] = []
        for one in shapes:
            found.append(self._fitted(one, min(least, _least_cost(found))))
        return max(found, key=lambda one: one.log_evidence)

    def following(self, cause: Cause, size: float, least: float) -> Refined:
        """The best shape of a cause that moves, from a size."""
        points = self._sized([self.base.point, self.model.expected()], [size])
        found = [self._from(Extension(cause, shape), points, least) for shape in cause.shapes]
        return max(found, key=lambda one: one.log_evidence)

    def settled(self, found: Refined, screened: Screen, most: int | None, least: float) -> Refined:
        """The best of the likeliest shapes, and a continuous one followed from there by steps as small as data tell."""
        shapes = _shapes(screened, found.name, most)
        best = max(found, self.best(shapes, least), key=lambda one: one.log_evidence)
        step, places = best.extension.cause.shape_step, best.extension.cause.shapes
        while step > 0:
            near = [
                self._near(best, place)
                for place in (best.extension.shape - step, best.extension.shape + step)
                if min(places) <= place <= max(places)
            ]
            values = [one.log_evidence for one in near]
            if max(values, default=-np.inf) > best.log_evidence:
                best = near[int(np.argmax(values))]
            elif best.log_evidence - min(values) < SHAPE_RESOLVED or step < _FINEST * best.extension.cause.shape_step:
                break
            else:
                step /= 2
        return best

    def beside(self, found: Refined, others: Sequence[Refined]) -> Refined:
        """The same, or a better fit from where the best of the others has come; the rest may have several optima."""
        rivals = [one for one in others if one is not found]
        if not rivals:
            return found
        best = min(rivals, key=lambda one: one.fit.cost)
        point = replace(best.fit.point, sizes=np.append(self.base.point.sizes, found.fit.point.sizes[-1]))
        return max(found, self._from(found.extension, [point], found.fit.cost), key=lambda one: one.log_evidence)

    def without_outlier_windows(self, found: Refined) -> Refined:
        """The same, where no window is left at an optimum far from the set that is not its best."""
        fit = without_outlier_windows(self.model, found.fit, (*self.extensions, found.extension))
        return Refined(found.extension, fit, _evidence(self.base, fit, found.extension.cause))

    def nearest(self, cause: Cause) -> list[Extension]:
        """The shapes of a cause without a size that come nearest as the data sheets and the base fit have the rest."""
        own = [Extension(cause, shape) for shape in cause.shapes]
        sizes = np.append(self.base.point.sizes, cause.size.high)
        origins = (self.base.point, self.model.expected())
        misfit = {
            one: min(
                self.model.misfit(Point(origin.shared, origin.local, sizes), (*self.extensions, one))
                for origin in origins
            )
            for one in own
        }
        return sorted(own, key=lambda one: misfit[one])[:_MOST_FIXED]

    def _fitted(self, further: Extension, least: float) -> Refined:
        size = further.cause.size
        # a large size may not be reached from a usual one
        large = np.sqrt(size.typical * size.high)
        starts = (size.typical, large if size.low >= 0 else -size.typical) if self.starts else (0.0,)
        sizes = {float(np.clip(start, size.low, size.high)) for start in starts}
        origins = [self.base.point, self.model.expected()] if self.starts else [self.base.point]
        return self._from(further, self._sized(origins, sizes), least)

    def _sized(self, origins: Iterable[Point], sizes: Collection[float]) -> list[Point]:
        """Each of some points with each of some sizes of a further cause."""
        beside = self.base.point.sizes
        return [Point(one.shared, one.local, np.append(beside, size)) for one in origins for size in sizes]

    def _near(self, found: Refined, shape: float) -> Refined:
        return self._from(Extension(found.extension.cause, shape), [found.fit.point], found.fit.cost)

    def _from(self, further: Extension, points: Iterable[Point], least: float) -> Refined:
        every, fits = (*self.extensions, further), []
        for point in points:
            fits.append(fit_set(self.model, point, every, least + OUT_OF_REACH))
            least = min(least, fits[-1].cost)
        fit = min(fits, key=lambda one: one.cost)
        return Refined(further, fit, _evidence(self.base, fit, further.cause))


def _first_shapes(screened: Screen, name: str, obvious: bool) -> list[Extension]:
    """The likeliest of a continuous shape, and some others where the misfit is obvious; or each of a few."""
    own = [one for one in screened.candidates if one.cause.name == name]
    if own[0].cause.shape_step == 0:
        return own
    likeliest = _shapes(screened, name, 1)
    spread = own[:: max(len(own) // _SPREAD, 1)] if obvious else []
    return [*likeliest, *(one for one in spread if one not in likeliest)]


def _shapes(screened: Screen, name: str, most: int | None) -> list[Extension]:
    """The most likely shapes of a cause; all where no number is given."""
    own = [
        (value, one)
        for one, value in zip(screened.candidates, screened.log_evidence, strict=True)
        if one.cause.name == name
    ]
    own.sort(key=lambda entry: -entry[0])
    return [one for value, one in own[:most] if most is None or value >= own[0][0] - SHAPES_WITHIN]


def _evidence(base: SetFit, fit: SetFit, cause: Cause) -> float:
    """Laplace's approximation with the size's normal prior, or half of one (Kass and Raftery 1995)."""
    rest = np.linalg.slogdet(base.information)[1]
    if cause.size.fixed:
        own = np.linalg.slogdet(fit.information[:-1, :-1])[1]
        return float(base.cost - fit.cost - 0.5 * (own - rest) - np.log(len(cause.shapes)))
    own = np.linalg.slogdet(fit.information)[1]
    wide = WIDE_PRIOR * cause.size.typical
    evidence = base.cost - fit.cost - 0.5 * (own - rest) - np.log(wide)
    precision = 1 / np.linalg.inv(fit.information)[-1, -1]
    if cause.size.low >= 0:
        evidence += np.log(2.0) + log_ndtr(fit.point.sizes[-1] * np.sqrt(precision))
    # the data alone give the size this estimate and variance; from the wide prior to the usual one
    alone = max(precision - wide**-2.0, 1e-12 * precision)
    estimate, variance = fit.point.sizes[-1] * precision / alone, 1 / alone
    usual = _log_normal(estimate, cause.size.typical**2 + variance) - _log_normal(estimate, wide**2 + variance)
    return float(evidence + np.logaddexp(0.0, usual) - np.log(2.0))


def _log_normal(value: float, variance: float) -> float:
    """Log density of a normal variable of mean zero, up to a constant."""
    return float(-0.5 * value**2 / variance - 0.5 * np.log(variance))
