"""Verdicts from the linear responses: one cause, two, or unknown."""

from dataclasses import replace

import numpy as np

from drillid.discrepancy.catalogue import CATALOGUE, Cause
from drillid.discrepancy.detectors.pooling import detection_gain
from drillid.discrepancy.inference.base_fit import fits_at_intervals
from drillid.discrepancy.inference.coordinates import Extension
from drillid.discrepancy.inference.held_out_gain import held_out_gain
from drillid.discrepancy.inference.localisation import contiguous_windows, fits_at_shapes, place_probability
from drillid.discrepancy.inference.screen import Screen, screen
from drillid.discrepancy.inference.search import FittedCause
from drillid.discrepancy.inference.set_fit import SetFit, fit_set
from drillid.discrepancy.inference.set_model import SetModel
from drillid.discrepancy.inference.size_posterior import fitted_size_interval, size_interval
from drillid.discrepancy.inference.unknown import ON_DATA_SHEET, furthest_off_data_sheet, leaves_rough_residuals
from drillid.discrepancy.predictive_gain import PredictiveGain
from drillid.discrepancy.rules import (
    CLOSURE_RATE,
    DISTINCT,
    EVEN_ODDS,
    LEFT_CHI2,
    LEFT_UNEXPLAINED,
    OUT_OF_REACH,
    PLACE_CONFIDENCE,
)
from drillid.discrepancy.verdicts.examination import Examination, remaining_evidence, unproved_names
from drillid.discrepancy.verdicts.explanations import (
    Chosen,
    Likeliest,
    alternative,
    leaves_more,
    own_detection,
    total_evidence,
    with_first,
)
from drillid.discrepancy.verdicts.naming import Posterior, class_evidence, class_name, distinguishable, separator
from drillid.discrepancy.verdicts.verdict import UNKNOWN, Verdict
from drillid.statistics import TWO_SIDED


def explain_responses(
    examination: Examination, likeliest: Likeliest, causes: list[Cause], generator: np.random.Generator
) -> Examination:
    """Explain the linear responses by the likeliest cause, by another one, by two, or as unknown."""
    model, before, first = examination.model, examination.before, likeliest.posterior
    if first is None:
        nearest = likeliest.nearest if likeliest.evidence > 0 else ""
        return _unknown(examination, max(before.unknown_evidence, likeliest.evidence), nearest=nearest)
    best = first.best
    after = screen(model, best.fit, (best.extension,), causes, generator)
    chosen: Chosen = [(first, best)]
    if leaves_more(model, best.fit, after):
        better = alternative(examination, first, after, causes, generator)
        if better is not None and (
            _is_incomplete(model, best.fit, after) or total_evidence(examination, better[0]) > best.log_evidence
        ):
            chosen, after = better
    total, fit = total_evidence(examination, chosen), chosen[-1][1].fit
    is_incomplete = _is_incomplete(model, fit, after)
    if before.unknown_evidence > total or is_incomplete or any(cause.at_bound for _, cause in chosen):
        nearest = class_name([cause.name for _, cause in chosen]) if is_incomplete else ""
        examination = replace(examination, posterior=first)
        return _unknown(examination, max(before.unknown_evidence, total), nearest=nearest)
    result = _named(examination, first, chosen, after)
    if len(result.verdicts) > 1 and min(verdict.probability for verdict in result.verdicts) < EVEN_ODDS:
        return _likelier_alone(examination, first, result, causes, generator)
    return _with_sure_gains(examination, result)


def _is_incomplete(model: SetModel, fit: SetFit, after: Screen) -> bool:
    """Whether an extended model leaves more than noise, or leaves no more only by disbelieving data sheets."""
    above_noise = fit.chi2 > LEFT_CHI2 * model.measured.residuals
    leaves_more = after.p_value < CLOSURE_RATE and (remaining_evidence(after) > LEFT_UNEXPLAINED or above_noise)
    return leaves_more or leaves_rough_residuals(model, fit) or fit.data_sheet_cost > OUT_OF_REACH


def _named(examination: Examination, first: Posterior, chosen: Chosen, after: Screen) -> Examination:
    """The model extended by the chosen causes, with a verdict for each."""
    names = tuple(fit.extension for _, fit in chosen)
    extensions, extended = _bounded_in_depth(examination.model, names, chosen[-1][1].fit)
    result = replace(examination, extended=extended, extensions=extensions, after=after, posterior=first)
    fits = fits_at_intervals(result.model, extended, extensions)
    verdicts = tuple(_linear_verdict(result, fits, place, *pair) for place, pair in enumerate(chosen))
    return replace(result, verdicts=verdicts)


def _with_sure_gains(examination: Examination, result: Examination) -> Examination:
    """The verdicts that surely predict better; unknown without any."""
    kept = tuple(verdict for verdict in result.verdicts if verdict.predictive_gain_low > 0)
    if kept:
        return replace(result, verdicts=kept)
    return _unknown(examination, _unnamed_evidence(examination, result), result.verdicts)


def _unnamed_evidence(examination: Examination, found: Examination) -> float:
    """Log Bayes factor of something wrong where what was found is not named."""
    return max(examination.before.unknown_evidence, *(verdict.evidence_nats for verdict in found.verdicts))


def _likelier_alone(
    examination: Examination, first: Posterior, pair: Examination, causes: list[Cause], generator: np.random.Generator
) -> Examination:
    """Where one of two causes is likelier wrong than right, the other one if it leaves no more than noise by itself;
    else unknown, as what it explains beside the wrong one is no evidence for it.
    """
    likelier = max(pair.verdicts, key=lambda verdict: verdict.probability)
    alone = next((fit for fit in first.fitted_causes if fit.name == likelier.cause), None)
    if alone is not None:
        after = screen(examination.model, alone.fit, (alone.extension,), causes, generator)
        if not _is_incomplete(examination.model, alone.fit, after):
            own = with_first(first, alone)
            return _with_sure_gains(examination, _named(examination, first, [(own, alone)], after))
    nearest = class_name([verdict.cause for verdict in pair.verdicts])
    unexplained = replace(examination, posterior=first)
    return _unknown(unexplained, _unnamed_evidence(examination, pair), nearest=nearest)


def _bounded_in_depth(
    model: SetModel, extensions: tuple[Extension, ...], fit: SetFit
) -> tuple[tuple[Extension, ...], SetFit]:
    """The extensions, restricted to the windows in which each is present where it begins or ends within the set."""
    for place in range(len(extensions)):
        rows = contiguous_windows(model, fit, extensions, place, CLOSURE_RATE)
        if rows is not None:
            bounded = replace(extensions[place], windows=rows)
            extensions = (*extensions[:place], bounded, *extensions[place + 1 :])
            fit = fit_set(model, fit.point, extensions)
    return extensions, fit


def _linear_verdict(
    result: Examination, fits: list[tuple[SetFit, float]], place: int, posterior: Posterior, fit: FittedCause
) -> Verdict:
    evidence = result.model.evidence
    cause, rows = fit.extension.cause, result.extensions[place].windows
    at_shapes = [] if cause.size.fixed else fits_at_shapes(result.model, result.extended, result.extensions, place)
    size, low, high = _size(result, [*fits, *((other, other.mass) for _, other in at_shapes[1:])], place)
    depth = evidence.operating_points.hole_depth if rows is None else evidence.operating_points.hole_depth[list(rows)]
    without = tuple(other for number, other in enumerate(result.extensions) if number != place)
    detected = own_detection(cause.name, result.detections)
    gain = _gain(result, place, without).joined(
        detection_gain([detection for detection in evidence.detections if detection.cause == detected])
    )
    # of each of two causes beside the other
    rates, own = result.base_rates, posterior.best.log_evidence
    present = rates.probability_beside(own) if without else rates.probability([cause.name], own)
    members = _members(result, posterior, without, present)
    own_evidence = {one.name: one.log_evidence for one in posterior.fitted_causes}
    return Verdict(
        verdict=class_name(members),
        family=cause.family,
        probability=sum(posterior.share[name] for name in members) * present,
        from_m=float(depth.min()),
        to_m=float(depth.max()),
        cause=cause.name,
        size=size,
        size_low=low,
        size_high=high,
        unit=cause.size.unit,
        location_m=_location(result, place, members, at_shapes),
        predictive_gain=gain.value,
        predictive_gain_low=gain.low,
        predictive_gain_high=gain.high,
        held_out_windows=gain.windows,
        what_would_separate=separator(members, evidence),
        evidence_nats=class_evidence({name: own_evidence[name] for name in members}, result.base_rates),
        evidence=f"linear responses, log Bayes factor {own:.1f}",
    )


def _location(
    result: Examination, place: int, members: tuple[str, ...], at_places: list[tuple[float, SetFit]]
) -> float:
    """Measured depth of an extension along the string, m; NaN where the data do not determine it, or the class has a
    member without a place.
    """
    model, extensions = result.model, result.extensions
    if not all(CATALOGUE[name].is_place for name in members):
        return float("nan")
    if place_probability(at_places) < PLACE_CONFIDENCE:
        return float("nan")
    return extensions[place].shape * float(np.mean(model.length))


def _size(result: Examination, fits: list[tuple[SetFit, float]], place: int) -> tuple[float, float, float]:
    """Size of an extension and its interval; from a detection in its favour where it varies within the window, as the
    mean response hardly determines it, or where the detection determines it better.
    """
    cause, size = result.extensions[place].cause, float(result.extended.point.sizes[place])
    if cause.size.fixed:
        return size, size, size
    low, high = fitted_size_interval(fits, result.extensions, place)
    own = [each for each in result.detections if each.cause == cause.name and each.tells_size]
    if own and (cause.time_varying or 2 * TWO_SIDED * own[0].size_error < high - low):
        return own[0].size, *size_interval(own[0].size, own[0].size_error, cause.size)
    return size, low, high


def _members(
    result: Examination, posterior: Posterior, others: tuple[Extension, ...], present: float
) -> tuple[str, ...]:
    """The likeliest causes that cannot be distinguished from the best if they are likelier right than wrong, else all
    of the likeliest.

    Parameters
    ----------
    present : probability that one of the posterior's causes is present
    """
    first, likely = posterior.best, posterior.members
    fits = [fit for fit in posterior.fitted_causes if fit.name in likely]
    alike = tuple(fit.name for fit in fits if fit is first or not _distinguishable(result, first, fit, others))
    return alike if present * sum(posterior.share[name] for name in alike) >= EVEN_ODDS else likely


def _distinguishable(
    result: Examination, first: FittedCause, second: FittedCause, others: tuple[Extension, ...]
) -> bool:
    """Whether two causes can be distinguished by their detections, or by their predictions beside the others."""
    detections = [detection for detection in result.detections if detection.cause in (first.name, second.name)]
    by_detections = len(detections) > 1 and distinguishable(*detections)
    return by_detections or _distance(result.model, first, second, others) >= DISTINCT


def _distance(model: SetModel, first: FittedCause, second: FittedCause, others: tuple[Extension, ...]) -> float:
    """Standard deviations between the predictions of two fitted causes, parameters of the data sheet included.

    Parameters
    ----------
    others : named beside them; those that they were fitted with are taken
    """
    others = others[: first.fit.point.sizes.size - 1]
    left, right = (model.residual(cause.fit.point, (*others, cause.extension)) for cause in (first, second))
    shared = first.fit.pulls - second.fit.pulls
    local = (first.fit.point.local - second.fit.point.local) / model.deviation
    return float(np.sqrt(np.sum(np.abs(left - right) ** 2) + np.sum(shared**2) + np.sum(local**2)))


def _gain(result: Examination, place: int, without: tuple[Extension, ...]) -> PredictiveGain:
    """Predictive gain of one extension over the others on held-out data."""
    point = result.extended.point
    reduced = point.without(place)
    start = result.base.point if not without else reduced
    return held_out_gain(result.model, (start, without), (point, result.extensions))


def _unknown(
    examination: Examination, log_evidence: float, unproved: tuple[Verdict, ...] = (), nearest: str = ""
) -> Examination:
    """The verdict unknown: something is wrong, and no cause of the catalogue explains it with a significant predictive
    gain on held-out data; the `nearest` leaves residuals above the noise.
    """
    channel = max(examination.before.unknown, key=lambda name: examination.before.unknown[name])
    operating_points = examination.model.evidence.operating_points
    verdict = Verdict(
        verdict=UNKNOWN,
        family=channel,
        probability=examination.base_rates.probability([UNKNOWN], log_evidence),
        from_m=float(operating_points.hole_depth.min()),
        to_m=float(operating_points.hole_depth.max()),
        evidence=(
            f"linear responses, p-value {examination.before.p_value:.2g} where nothing is wrong"
            f"{unproved_names(unproved)}{f'; the nearest known effect is {nearest}' if nearest else ''}"
        ),
        what_would_separate=_localised(examination, channel),
        evidence_nats=log_evidence,
    )
    return replace(examination, verdicts=(verdict,))


def _localised(examination: Examination, channel: str) -> str:
    """Where an unknown disturbance acts, in words."""
    if channel == ON_DATA_SHEET:
        return furthest_off_data_sheet(examination.base)
    return "the unknown disturbance acts as one " + _PLACES[channel]


_PLACES = {
    "record": "in sensors or recorder",
    "drive": "in the drive",
    "control": "in the speed control",
    "top": "at the top of the string",
    "upper string": "in the upper half of the string",
    "lower string": "in the lower half of the string",
    "bit": "at the bottom-hole assembly",
    "pipe": "along the pipe, as polar moments that the tally does not state",
}
