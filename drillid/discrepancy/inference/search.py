"""Search over causes: the non-linear fit of each, and its evidence by Laplace's approximation."""

from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from scipy.special import log_ndtr

from drillid.arrays import Floats
from drillid.discrepancy.catalogue import Cause, Size
from drillid.discrepancy.inference.coordinates import SHARED, Extension, Point
from drillid.discrepancy.inference.projection import secants
from drillid.discrepancy.inference.screen import Screen
from drillid.discrepancy.inference.set_fit import SetFit, fit_set, normal_equations, within, without_outlier_windows
from drillid.discrepancy.inference.set_model import SetModel
from drillid.discrepancy.rules import (
    CONTENDER,
    FOLLOWED_WITHIN,
    OBVIOUS_MISFIT,
    OUT_OF_REACH,
    REJECTED_CHI2,
    SHAPE_RESOLVED,
    SHAPES_WITHIN,
    WIDE_PRIOR,
)

_MOST_SHAPES = 2
_SPREAD = 6
"""Number of other values of a continuous shape that are tried where the linear evidence is not reliable."""
_FINEST = 0.1
"""Fraction of its initial length down to which the step of a shape is halved."""
_MOST_FACTORS = 2
"""Number of factors that are fitted of a cause without a size."""
_SELDOM, _SMALLER = 0.01, 0.1
"""Control interval, s, from which a fit is also started at a base model moved to make room for the cause, and the
cause's size at that start, relative to the usual size.
"""


@dataclass(frozen=True, eq=False)
class FittedCause:
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
    def size_error(self) -> float:
        """Standard error of its size in the linear responses."""
        return float(_size_precision(self.fit) ** -0.5)

    @property
    def at_bound(self) -> bool:
        """Whether its size lies at a bound."""
        return self.extension.cause.size.at_bound(float(self.fit.point.sizes[-1]))


def search(
    model: SetModel,
    base: SetFit,
    extensions: tuple[Extension, ...],
    screened: Screen,
    catalogue: Sequence[Cause],
    *,
    time_varying: Mapping[str, float],
    all_causes: bool = False,
    rejected: bool = False,
) -> list[FittedCause]:
    """Fit the causes that may explain the misfit; best evidence first.

    The linear evidence orders them well where causes are small. Where the misfit is obvious, as where the base model
    is `rejected`, or `all_causes` are wanted, all are fitted at their likeliest shapes from several sizes, as a large
    cause may act by its non-linear part; those that come near the best are then fitted at more shapes.

    Parameters
    ----------
    time_varying : sizes, from their detections, of causes that vary within a window; the screen does not cover these
    """
    linear = screened.by_cause
    most = max(linear.values(), default=-np.inf)
    obvious = rejected or max(most, screened.unknown_evidence) > OBVIOUS_MISFIT
    all_causes = all_causes or obvious
    taken = {extension.cause.name for extension in extensions}
    near_best = [name for name, value in linear.items() if all_causes or value >= most - FOLLOWED_WITHIN]
    names = [name for name in near_best if name not in taken]
    fitter = _CauseFitter(model, base, extensions, several_starts=all_causes, from_data_sheets=rejected)
    fitted: list[FittedCause] = []
    for name in sorted(names, key=lambda name: -linear[name]):
        best = fitter.best_shape(_first_shapes(screened, name, obvious), _least_cost(fitted))
        if obvious and best.log_evidence < linear[name] - SHAPE_RESOLVED:
            best = fitter.restarted(best)
        fitted.append(best)
    varying = [cause for cause in catalogue if cause.name in time_varying and cause.name not in taken]
    fitted += [fitter.time_varying(cause, time_varying[cause.name], _least_cost(fitted)) for cause in varying]
    if obvious:
        fixed = [cause for cause in catalogue if cause.is_linear and cause.size.fixed and cause.name not in taken]
        fitted += [fitter.best_factor(cause, _least_cost(fitted)) for cause in fixed]
    # a cause that fits only at a bound of its size is never named, and does not set the standard
    top = max((cause.log_evidence for cause in fitted if not cause.at_bound), default=-np.inf)
    near = min(top - FOLLOWED_WITHIN, CONTENDER * top)
    shapes = None if obvious else _MOST_SHAPES
    least = _least_cost(fitted)
    fitted = [
        fitter.resolved(cause, screened, shapes, least)
        if cause.log_evidence >= near and cause.name in linear
        else cause
        for cause in fitted
    ]
    # the others start from the best fit, once it is free of outlier windows
    best_fit = max(fitted, key=lambda cause: cause.log_evidence, default=None)
    fitted = [fitter.without_outlier_windows(cause) if cause is best_fit else cause for cause in fitted]
    contenders = [cause for cause in fitted if cause.log_evidence >= near]
    fitted = [fitter.from_best_rival(cause, contenders) if cause in contenders else cause for cause in fitted]
    fitted = [replace(cause, log_evidence=cause.log_evidence - _price(cause, screened)) for cause in fitted]
    return sorted(fitted, key=lambda cause: -cause.log_evidence)


def _price(cause: FittedCause, screened: Screen) -> float:
    """By how much the log evidence of the best of a cause's shapes exceeds that of the mean of all, which are as likely
    in advance; at most the logarithm of their number.
    """
    if cause.extension.cause.size.fixed:
        # the evidence of one shape is its share of that of all
        return 0.0
    values = [value for value, _ in screened.shapes(cause.name)]
    return max(values) - screened.of(cause.name) if values else float(np.log(len(cause.extension.cause.shapes)))


def at_best_shape(model: SetModel, base: SetFit, extensions: tuple[Extension, ...], cause: FittedCause) -> FittedCause:
    """The cause at the best of all its shapes, each fitted from the cause's optimum.

    Parameters
    ----------
    base : fit of the model with the `extensions` but without the cause
    """
    fitter = _CauseFitter(model, base, extensions, several_starts=False)
    again = fitter.at_shape(cause, cause.extension.shape)
    shapes = [fitter.at_shape(cause, shape) for shape in cause.extension.cause.shapes]
    best = fitter.refined(max(again, *shapes, key=lambda shape: shape.log_evidence))
    # evidence of detections remains in it
    return replace(best, log_evidence=cause.log_evidence + best.log_evidence - again.log_evidence)


def _least_cost(fitted: Sequence[FittedCause]) -> float:
    return min((cause.fit.cost for cause in fitted), default=np.inf)


@dataclass(frozen=True, eq=False)
class _CauseFitter:
    """Fits of the model with one more cause."""

    model: SetModel
    base: SetFit
    extensions: tuple[Extension, ...]
    several_starts: bool
    """Whether fits also start from usual sizes, and not only from size zero."""
    from_data_sheets: bool = False
    """Whether they do so at the data sheets too, as a base model that is rejected may have taken the cause for anything
    else.
    """
    known: dict[tuple[str, float], FittedCause] = field(default_factory=dict)
    """Fits so far, by cause and shape."""

    def best_shape(self, shapes: Iterable[Extension], least: float = np.inf) -> FittedCause:
        """The best of some shapes; `least` is the lowest cost of other fits so far."""
        fitted: list[FittedCause] = []
        for shape in shapes:
            fitted.append(self._fit_shape(shape, min(least, _least_cost(fitted))))
        return max(fitted, key=lambda cause: cause.log_evidence)

    def time_varying(self, cause: Cause, size: float, least: float) -> FittedCause:
        """The best shape of a cause that varies within a window, from the size of its detection."""
        points = self._sized([self.base.point, self.model.expected()], [size])
        fitted = [self._fit_from(Extension(cause, shape), points, least) for shape in cause.shapes]
        return max(fitted, key=lambda shape: shape.log_evidence)

    def resolved(self, cause: FittedCause, screened: Screen, most: int | None, least: float) -> FittedCause:
        """The best of the likeliest shapes, refined."""
        shapes = _shapes(screened, cause.name, most)
        return self.refined(max(cause, self.best_shape(shapes, least), key=lambda shape: shape.log_evidence))

    def refined(self, best: FittedCause) -> FittedCause:
        """The cause at a continuous shape moved by steps as small as the data resolve."""
        step, tabulated = best.extension.cause.shape_step, best.extension.cause.shapes
        while step > 0:
            near = [
                self.at_shape(best, shape)
                for shape in (best.extension.shape - step, best.extension.shape + step)
                if min(tabulated) <= shape <= max(tabulated)
            ]
            values = [neighbour.log_evidence for neighbour in near]
            if max(values, default=-np.inf) > best.log_evidence:
                best = near[int(np.argmax(values))]
            elif best.log_evidence - min(values) < SHAPE_RESOLVED or step < _FINEST * best.extension.cause.shape_step:
                break
            else:
                step /= 2
        return best

    def from_best_rival(self, cause: FittedCause, contenders: Sequence[FittedCause]) -> FittedCause:
        """The cause, or a better fit of it from the optimum of its best rival, as the cost may have several minima."""
        rivals = [contender for contender in contenders if contender is not cause]
        if not rivals:
            return cause
        best = min(rivals, key=lambda rival: rival.fit.cost)
        own, shapes = cause.fit.point, np.append(self.base.point.shapes, cause.fit.point.shapes[-1])
        point = replace(best.fit.point, sizes=np.append(self.base.point.sizes, own.sizes[-1]), shapes=shapes)
        again = self._fit_from(cause.extension, [point], cause.fit.cost)
        return max(cause, again, key=lambda fitted: fitted.log_evidence)

    def restarted(self, cause: FittedCause) -> FittedCause:
        """The cause, or a better fit of it from a large size and all else as the data sheets state it: what has less
        evidence than linear theory tells may be at a local minimum, with a part of its effect in the base model.
        """
        points = self._sized([self.model.expected()], [_large(cause.extension.cause.size)])
        return max(cause, self._fit_from(cause.extension, points, np.inf), key=lambda fitted: fitted.log_evidence)

    def without_outlier_windows(self, cause: FittedCause) -> FittedCause:
        """The cause with no window left at a local minimum far from the set."""
        fit = without_outlier_windows(self.model, cause.fit, (*self.extensions, cause.extension))
        return FittedCause(cause.extension, fit, _evidence(self.base, fit, cause.extension.cause))

    def best_factor(self, cause: Cause, least: float) -> FittedCause:
        """The best of the closest factors of a cause without a size, each fitted from the optimum of the best one too,
        with the impedances that give the same record.
        """
        closest = self._closest_factors(cause)
        best = self.best_shape(closest, least)
        again = [
            self._fit_from(other, [best.fit.point.at_impedances(other.shape / best.extension.shape)], best.fit.cost)
            for other in closest
            if other.shape / best.extension.shape > 0 and other is not best.extension
        ]
        return max([best, *again], key=lambda fitted: fitted.log_evidence)

    def _closest_factors(self, cause: Cause) -> list[Extension]:
        """The factors that fit best with all else as in the data sheets or the base fit."""
        shapes = [Extension(cause, shape) for shape in cause.shapes]
        sizes, present = np.append(self.base.point.sizes, cause.size.high), self.base.point.shapes
        origins = (self.base.point, self.model.expected())
        misfit = {
            shape: min(
                self.model.misfit(replace(origin, sizes=sizes, shapes=present), (*self.extensions, shape))
                for origin in origins
            )
            for shape in shapes
        }
        return sorted(shapes, key=lambda shape: misfit[shape])[:_MOST_FACTORS]

    def _fit_shape(self, further: Extension, least: float) -> FittedCause:
        """The fit at a shape, made once; `least` falls from call to call, so that the first is followed longest."""
        key = further.cause.name, further.shape
        if key not in self.known:
            self.known[key] = self._fit_from(further, self._starts(further), least)
        return self.known[key]

    def _starts(self, further: Extension) -> list[Point]:
        size = further.cause.size
        large = _large(size)
        near = self._sized([self.base.point], [float(np.clip(0.0, size.low, size.high))])
        if not self.several_starts:
            return near
        starts = (size.typical, large if size.low >= 0 else -size.typical)
        sizes = {float(np.clip(start, size.low, size.high)) for start in starts}
        origins = [self.base.point, self.model.expected()] if self.from_data_sheets else [self.base.point]
        points = [*near, *self._sized(origins, sizes)]
        if size.low < 0 and self.base.chi2 > REJECTED_CHI2 * self.model.measured.residuals:
            # so wrong a base model says nothing of the rest of the rig
            both = {float(np.clip(sign * large, size.low, size.high)) for sign in (-1, 1)}
            points += self._sized([self.model.expected()], both)
        if further.cause.is_linear and not size.fixed and self.model.control_interval >= _SELDOM:
            points.append(self._given_room(further))
        return points

    def _given_room(self, further: Extension) -> Point:
        """Start with the cause at a small size and all else moved to compensate for it to first order.

        What a slowly sampling control adds to its delay has a kink wherever the delay is a whole number of intervals
        and a half; a fit from size zero, or without room for the delay that comes with the cause, stops before the next
        kink.
        """
        direction = secants(self.model, self.base, self.extensions, (further,), _SMALLER)
        size = _SMALLER * further.cause.size.typical
        matrix = normal_equations(self.model, self.base.point, self.extensions, direction).eliminated()[0]
        moved = -size * np.linalg.solve(matrix[:-1, :-1], matrix[:-1, -1])
        point = self.base.point
        sizes = np.append(point.sizes + moved[SHARED : SHARED + point.sizes.size], size)
        return within(replace(point, shared=point.shared + moved[:SHARED], sizes=sizes), (*self.extensions, further))

    def _sized(self, origins: Iterable[Point], sizes: Collection[float]) -> list[Point]:
        """Every combination of the given points with the given sizes of a further cause."""
        own = self.base.point
        return [
            replace(origin, sizes=np.append(own.sizes, size), shapes=own.shapes) for origin in origins for size in sizes
        ]

    def at_shape(self, cause: FittedCause, shape: float) -> FittedCause:
        """The cause at another shape, fitted from its optimum."""
        return self._fit_from(Extension(cause.extension.cause, shape), [cause.fit.point], cause.fit.cost)

    def _fit_from(self, further: Extension, points: Iterable[Point], least: float) -> FittedCause:
        extensions = (*self.extensions, further)
        fits: list[SetFit] = []
        for point in points:
            fits.append(fit_set(self.model, point, extensions, least + OUT_OF_REACH, fits))
            least = min(least, fits[-1].cost)
        best = min(fits, key=lambda fit: fit.cost)
        return FittedCause(further, best, _evidence(self.base, best, further.cause))


def _large(size: Size) -> float:
    """A size between the usual and the largest one, as what is large may not be reached from a usual size."""
    return float(np.sqrt(size.typical * size.high))


def _first_shapes(screened: Screen, name: str, obvious: bool) -> list[Extension]:
    """All of a few discrete shapes; of a continuous one the likeliest, and some others where the misfit is obvious."""
    shapes = [candidate for _, candidate in screened.shapes(name)]
    if shapes[0].cause.shape_step == 0:
        return shapes
    likeliest = _shapes(screened, name, 1)
    spread = shapes[:: max(len(shapes) // _SPREAD, 1)] if obvious else []
    return [*likeliest, *(shape for shape in spread if shape not in likeliest)]


def _shapes(screened: Screen, name: str, most: int | None) -> list[Extension]:
    """The most likely shapes of a cause; all where no number is given."""
    ranked = sorted(screened.shapes(name), key=lambda entry: -entry[0])
    return [shape for value, shape in ranked[:most] if most is None or value >= ranked[0][0] - SHAPES_WITHIN]


def _evidence(base: SetFit, fit: SetFit, cause: Cause) -> float:
    """Laplace's approximation with the size's normal or half-normal prior (Kass and Raftery 1995)."""
    place = SHARED + fit.point.sizes.size - 1
    fall, of_base = base.cost - fit.cost, np.linalg.slogdet(base.information)[1] + base.windows_information
    if cause.size.fixed:
        others = np.delete(np.arange(len(fit.information)), place)
        of_fit = np.linalg.slogdet(fit.information[np.ix_(others, others)])[1] + fit.windows_information
        return float(fall - 0.5 * (of_fit - of_base) - np.log(len(cause.shapes)))
    of_fit = np.linalg.slogdet(fit.information)[1] + fit.windows_information
    return float(evidence_of_size(fall, of_fit - of_base, fit.point.sizes[-1], _size_precision(fit), cause.size))


def _size_precision(fit: SetFit) -> float:
    """Precision of the last size from the curvature."""
    place = SHARED + fit.point.sizes.size - 1
    return float(1 / np.linalg.inv(fit.information)[place, place])


def evidence_of_size(
    fall: Floats | float, volume: Floats | float, size: Floats | float, precision: Floats | float, prior: Size
) -> Floats:
    """Log Bayes factors of a cause with a size, against none, by Laplace's approximation.

    Parameters
    ----------
    fall : reduction of the cost by the cause
    volume : log determinant of the cost's curvature with the cause, minus that without it
    size, precision : its estimate with the wide prior, and the precision of this
    """
    wide = WIDE_PRIOR * prior.typical
    evidence = fall - 0.5 * np.asarray(volume) - np.log(wide)
    if prior.low >= 0:
        evidence += np.log(2.0) + log_ndtr(size * np.sqrt(precision))
    # estimate and variance of the size by the data alone, to replace the wide prior by the usual one
    data_precision = np.maximum(precision - wide**-2.0, 1e-12 * precision)
    estimate, variance = size * precision / data_precision, 1 / data_precision
    usual = _log_normal(estimate, prior.typical**2 + variance) - _log_normal(estimate, wide**2 + variance)
    return np.asarray(evidence + np.logaddexp(0.0, usual) - np.log(2.0), dtype=float)


def _log_normal(value: Floats | float, variance: Floats | float) -> Floats:
    """Log density of normal variables of mean zero, up to a constant."""
    return np.asarray(-0.5 * np.square(value) / variance - 0.5 * np.log(variance), dtype=float)
