"""The base model of a set: with its windows' own deviation, at the likeliest interval of its control."""

from dataclasses import replace

import numpy as np

from drillid.discrepancy.evidence import Evidence
from drillid.discrepancy.inference.control_intervals import Usual, usual_intervals
from drillid.discrepancy.inference.coordinates import DEVIATION, INTERVAL, Extension, Point
from drillid.discrepancy.inference.set_fit import SetFit, expanded, fit_set, without_outlier_windows
from drillid.discrepancy.inference.set_model import SetModel
from drillid.discrepancy.rules import OUT_OF_REACH

_LEAST_WINDOWS, _USUAL_WINDOWS, _ROUNDS = 4, 2.0, 3
"""Fewest windows from which a set's own deviation is estimated, windows that its prior is worth, and rounds."""


def with_own_deviation(model: SetModel, fit: SetFit) -> tuple[SetModel, SetFit]:
    """The model with the standard deviation of windows estimated from the set itself, and its fit.

    Expectation and maximisation under Student's t (Dempster, Laird and Rubin 1977, Journal of the Royal Statistical
    Society B 39, 1-38), with the usual deviation as a prior worth _USUAL_WINDOWS windows.
    """
    if model.evidence.windows < _LEAST_WINDOWS:
        return model, fit
    for _ in range(_ROUNDS):
        normal = expanded(model, fit.point, ()).normal
        variance = np.diagonal(np.linalg.inv(normal.corner), axis1=1, axis2=2)
        weight = normal.local_precision * model.deviation**2
        squares = np.sum(weight * (fit.point.local**2 + variance), axis=0)
        deviation = np.sqrt((_USUAL_WINDOWS * DEVIATION**2 + squares) / (_USUAL_WINDOWS + model.evidence.windows))
        model = SetModel(model.evidence, np.minimum(deviation, DEVIATION))
        fit = fit_set(model, fit.point)
    return model, fit


def fit_base(evidence: Evidence, *further: Point) -> tuple[SetModel, SetFit]:
    """The model of a set without extensions, and of its fits from all starts that of most mass, outlier windows brought
    back: a narrow optimum that follows the noise holds little mass however low its cost.

    Where the interval of the control is not known, the likeliest of those usual for speed controls is taken.

    Parameters
    ----------
    further : other starts
    """
    model = SetModel(evidence)
    starts = (model.start(), model.expected(), *(at_interval_of(model, point) for point in further))
    base = max((fit_set(model, start) for start in starts), key=lambda fit: fit.mass)
    if not evidence.data_sheet.tells_control_interval:
        model, base = at_likeliest_interval(model, base)
    model, base = with_own_deviation(model, base)
    return model, without_outlier_windows(model, base)


def _evidence_at(evidence: Evidence, usual: Usual) -> Evidence:
    """The evidence with a data sheet that states the interval of the control."""
    sheet = evidence.data_sheet
    stated = replace(
        sheet,
        control_interval=usual.interval,
        control_interval_relative=usual.relative,
        control_interval_is_taken=True,
    )
    return replace(evidence, data_sheet=stated)


def at_likeliest_interval(
    model: SetModel, fit: SetFit, extensions: tuple[Extension, ...] = (), least: float = np.inf
) -> tuple[SetModel, SetFit]:
    """The model and its fit at the likeliest interval of the control, among the usual ones and the model's own.

    Parameters
    ----------
    least : cost, with that of the interval, from which on another interval is of interest
    """
    best, least = (model, fit), min(least, fit.cost + interval_cost(model))
    for usual in usual_intervals(model.evidence.data_sheet):
        other, again = _fit_at(usual, model, best[1], extensions, least)
        if again.cost + interval_cost(other) < least:
            best, least = (other, again), again.cost + interval_cost(other)
    return best


def fits_at_intervals(model: SetModel, fit: SetFit, extensions: tuple[Extension, ...]) -> list[tuple[SetFit, float]]:
    """The fit, and where the interval of the control is not known those at other usual ones that are not far less
    likely, each with the logarithm of its posterior mass, to which the odds of its interval against the fit's own are
    added.
    """
    sheet, own, found = model.evidence.data_sheet, _nearest_usual(model), [(fit, fit.mass)]
    for usual in () if sheet.tells_control_interval else usual_intervals(sheet):
        if usual is not own:
            odds = own.cost - usual.cost
            enough = fit.cost + odds + OUT_OF_REACH
            _, again = _fit_at(usual, model, fit, extensions, enough)
            if again.cost < enough:
                found.append((again, again.mass + odds))
    return found


def _fit_at(
    usual: Usual, model: SetModel, fit: SetFit, extensions: tuple[Extension, ...], enough: float
) -> tuple[SetModel, SetFit]:
    """The model and its fit at another interval of the control, from the optimum at the model's own."""
    other = model.with_evidence(_evidence_at(model.evidence, usual))
    return other, fit_set(other, at_interval_of(other, fit.point), extensions, enough)


def at_interval_of(model: SetModel, point: Point) -> Point:
    """The point at the interval that a model's data sheet states."""
    shared = point.shared.copy()
    shared[INTERVAL] = model.prior_mean[INTERVAL]
    return replace(point, shared=shared)


def log_mass(model: SetModel, fit: SetFit) -> float:
    """Logarithm of the posterior mass of a base model, up to a constant of all that are fitted to the same windows."""
    # the priors of the windows' deviations are the narrower, and so the higher, the less the windows scatter
    return fit.mass - model.evidence.windows * float(np.log(model.deviation).sum()) - interval_cost(model)


def interval_cost(model: SetModel) -> float:
    """Prior cost of an interval that is not known, relative to that of no interval: each stands for the intervals near
    it, and fewer controls have such an interval than one that is practically none.
    """
    return _nearest_usual(model).cost


def _nearest_usual(model: SetModel) -> Usual:
    usual = usual_intervals(model.evidence.data_sheet)
    return min(usual, key=lambda each: abs(each.interval - model.control_interval))
