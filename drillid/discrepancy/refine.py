"""Causes one by one at their best: non-linear fits, and their evidence by Laplace's approximation."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.special import log_ndtr

from drillid.discrepancy.causes import Cause
from drillid.discrepancy.causes.base import WIDE
from drillid.discrepancy.screen import Screen
from drillid.discrepancy.set_fit import SetFit, fit_set
from drillid.discrepancy.set_model import Extension, Point, SetModel

Floats = NDArray[np.float64]

_WITHIN = 8.0
"""Causes whose linear evidence is so far from the best, in units of log-likelihood, are still refined."""
_OBVIOUS = 15.0
"""Where linear evidence is so large, the linear order of the causes is not to be trusted: all are refined."""
_CONTENDER = 0.5
"""Share of the best evidence from which a cause is tried from other sizes too, where the misfit is obvious."""
_SHAPES_WITHIN = 2.0
_MOST_SHAPES = 2
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


def refine(
    model: SetModel,
    base: SetFit,
    extensions: tuple[Extension, ...],
    screened: Screen,
    catalogue: Sequence[Cause],
    *,
    plain: bool = False,
) -> list[Refined]:
    """Fit every cause that may explain what is seen; best evidence first.

    Where the misfit is `plain`, or the linear evidence says so, every cause is tried from several sizes.
    """
    linear = {cause.name: screened.of(cause.name) for cause in {one.cause for one in screened.candidates}}
    best = max(linear.values(), default=-np.inf)
    plain = plain or best > _OBVIOUS
    taken = {one.cause.name for one in extensions}
    names = [name for name, value in linear.items() if name not in taken and (plain or value >= best - _WITHIN)]
    found = [_best_shape(model, base, extensions, _shapes(screened, name, _MOST_SHAPES), False) for name in names]
    if plain:
        fixed = [cause for cause in catalogue if cause.is_linear and cause.size.fixed and cause.name not in taken]
        found += [
            _best_shape(model, base, extensions, _fixed_shapes(model, base, extensions, one), True) for one in fixed
        ]
        bound = _CONTENDER * max(one.log_evidence for one in found)
        found = [
            one
            if one.log_evidence < bound or one.extension.cause.size.fixed
            else max(
                one,
                _best_shape(model, base, extensions, _shapes(screened, one.name, None), True),
                key=lambda entry: entry.log_evidence,
            )
            for one in found
        ]
    return sorted(found, key=lambda one: -one.log_evidence)


def _shapes(screened: Screen, name: str, most: int | None) -> list[Extension]:
    """The most likely shapes of a cause; all where no number is given."""
    own = [
        (value, one)
        for one, value in zip(screened.candidates, screened.log_evidence, strict=True)
        if one.cause.name == name
    ]
    own.sort(key=lambda entry: -entry[0])
    return [one for value, one in own[:most] if most is None or value >= own[0][0] - _SHAPES_WITHIN]


def _fixed_shapes(model: SetModel, base: SetFit, extensions: tuple[Extension, ...], cause: Cause) -> list[Extension]:
    """The shapes of a cause without a size that come nearest as the papers and the base fit have the rest."""
    own = [Extension(cause, shape) for shape in cause.shapes]
    sizes = np.append(base.point.sizes, cause.size.high)
    origins = (base.point, model.expected())
    misfit = {
        one: min(model.misfit(Point(origin.shared, origin.local, sizes), (*extensions, one)) for origin in origins)
        for one in own
    }
    return sorted(own, key=lambda one: misfit[one])[:_MOST_FIXED]


def _best_shape(
    model: SetModel, base: SetFit, extensions: tuple[Extension, ...], shapes: Iterable[Extension], obvious: bool
) -> Refined:
    found = [with_cause(model, base, extensions, one, obvious) for one in shapes]
    best = max(found, key=lambda one: one.log_evidence)
    step = best.extension.cause.shape_step
    places = best.extension.cause.shapes
    while step > 0:
        near = [
            with_cause(model, base, extensions, Extension(best.extension.cause, place), obvious)
            for place in (best.extension.shape - step, best.extension.shape + step)
            if min(places) <= place <= max(places)
        ]
        top = max(near, key=lambda one: one.log_evidence, default=best)
        if top.log_evidence <= best.log_evidence:
            break
        best = top
    return best


def with_cause(
    model: SetModel, base: SetFit, extensions: tuple[Extension, ...], further: Extension, obvious: bool = True
) -> Refined:
    """The model with a further cause; where the misfit is obvious, from several sizes and from the papers as well."""
    size = further.cause.size
    starts = (size.typical, -size.typical) if obvious else (0.0,)
    sizes = {float(np.clip(start, size.low, size.high)) for start in starts}
    origins = [base.point, model.expected()] if obvious else [base.point]
    every = (*extensions, further)
    points = [
        Point(origin.shared, origin.local, np.append(base.point.sizes, one)) for origin in origins for one in sizes
    ]
    fit = min((fit_set(model, point, every) for point in points), key=lambda one: one.cost)
    return Refined(further, fit, _evidence(base, fit, further.cause))


def _evidence(base: SetFit, fit: SetFit, cause: Cause) -> float:
    """Laplace's approximation with the size's normal prior, or half of one (Kass and Raftery 1995)."""
    rest = np.linalg.slogdet(base.information)[1]
    if cause.size.fixed:
        own = np.linalg.slogdet(fit.information[:-1, :-1])[1]
        return float(base.cost - fit.cost - 0.5 * (own - rest) - np.log(len(cause.shapes)))
    own = np.linalg.slogdet(fit.information)[1]
    wide = WIDE * cause.size.typical
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
