"""Verdicts from the linear responses: one cause, two, or unknown."""

from dataclasses import replace

import numpy as np

from drillid.discrepancy.catalogue import CATALOGUE, Cause
from drillid.discrepancy.detectors.pooling import PooledDetection, detection_gain
from drillid.discrepancy.inference.held_out_gain import held_out_gain
from drillid.discrepancy.inference.localisation import contiguous_windows, place_probability
from drillid.discrepancy.inference.screen import Screen, screen
from drillid.discrepancy.inference.search import FittedCause, search
from drillid.discrepancy.inference.set_fit import SetFit, fit_set
from drillid.discrepancy.inference.set_model import Extension, Point, SetModel
from drillid.discrepancy.inference.unknown import ON_DATA_SHEET, furthest_off_data_sheet
from drillid.discrepancy.predictive_gain import PredictiveGain
from drillid.discrepancy.rules import (
    CLOSURE_RATE,
    LEFT_UNEXPLAINED,
    PAIR_FIRST_WITHIN,
    PAIR_PRICE,
    PLACED,
    REJECTED_CHI2,
    REJECTED_PULLS,
    SAME,
    SHADOW_OF_EVIDENCE,
)
from drillid.discrepancy.verdicts.examination import Examination, doubt, evidence_left, surely
from drillid.discrepancy.verdicts.naming import Posterior, class_name, posterior, separator, told_apart
from drillid.discrepancy.verdicts.verdict import UNKNOWN, Verdict
from drillid.statistics import TWO_SIDED

_FIRSTS = 3
"""Causes with which a second one is tried."""


def explained(examination: Examination, causes: list[Cause], generator: np.random.Generator) -> Examination:
    """Name what the linear responses show: one cause, two, or unknown."""
    model, base, before = examination.model, examination.base, examination.before
    moving = _moving(examination)
    fitted_causes = search(
        model, base, (), before, causes, moving=moving, all_causes=True, rejected=base_model_rejected(model, base)
    )
    most = fitted_causes[0].log_evidence if fitted_causes else 0.0
    fitted_causes = [one for one in fitted_causes if not one.at_bound and not _refuted(examination, one.name)]
    if not fitted_causes or fitted_causes[0].log_evidence < most - LEFT_UNEXPLAINED:
        return _unknown(examination, max(before.unknown_evidence, most))
    first = posterior(_with_own_detections(fitted_causes, examination.detections), before.unknown_evidence)
    best = first.best
    after = screen(model, best.fit, (best.extension,), causes, generator)
    chosen: list[tuple[Posterior, FittedCause]] = [(first, best)]
    if after.p_value < CLOSURE_RATE:
        other = _other(examination, first, after, causes, generator)
        if other is not None:
            chosen, after = other
    total = sum(one.log_evidence for _, one in chosen) - PAIR_PRICE * (len(chosen) - 1)
    open_still = after.p_value < CLOSURE_RATE and evidence_left(after) > max(
        LEFT_UNEXPLAINED, SHADOW_OF_EVIDENCE * total
    )
    if any(one.at_bound for _, one in chosen):
        return _unknown(examination, max(before.unknown_evidence, total))
    if before.unknown_evidence > total or open_still:
        return _unknown(examination, max(before.unknown_evidence, 0.0))
    extensions, extended = _bounded_in_depth(model, tuple(one.extension for _, one in chosen), chosen[-1][1].fit)
    result = replace(examination, extended=extended, extensions=extensions, after=after, posterior=first)
    verdicts = tuple(_linear_verdict(result, place, *one) for place, one in enumerate(chosen))
    kept = tuple(one for one in verdicts if one.predictive_gain_low > 0)
    if kept:
        return replace(result, verdicts=kept)
    return _unknown(examination, before.unknown_evidence, verdicts)


def _moving(examination: Examination) -> dict[str, float]:
    """Sizes of causes that move, where their detections are in sight."""
    detections = (one for one in examination.detections if one.cause in CATALOGUE and CATALOGUE[one.cause].moves)
    return {one.cause: one.size for one in detections if one.log_evidence > 0}


def _refuted(examination: Examination, cause: str) -> bool:
    """Whether a cause's own detection leaves more in the record than it may where that cause is what is there."""
    return any(
        one.cause == cause and one.log_evidence > 0 and one.closure < CLOSURE_RATE for one in examination.detections
    )


def base_model_rejected(model: SetModel, base: SetFit) -> bool:
    """Whether the base model is so far off that nothing linear about it can be trusted."""
    rows = 2 * int(np.count_nonzero(model.weight))
    return base.pulls > REJECTED_PULLS or base.chi2 > REJECTED_CHI2 * rows


def _with_own_detections(fitted_causes: list[FittedCause], detections: tuple[PooledDetection, ...]) -> list[FittedCause]:
    """Causes that also have a detection of their own carry its evidence as well, for or against."""
    own = {one.cause: one for one in detections}
    return [
        replace(one, log_evidence=one.log_evidence + own[one.name].evidence_for(float(one.fit.point.sizes[-1])))
        if one.name in own
        else one
        for one in fitted_causes
    ]


def _bounded_in_depth(
    model: SetModel, extensions: tuple[Extension, ...], fit: SetFit
) -> tuple[tuple[Extension, ...], SetFit]:
    """The extensions with the windows in which each is present, where it begins or ends within the set."""
    for place in range(len(extensions)):
        rows = contiguous_windows(model, fit, extensions, place, CLOSURE_RATE)
        if rows is not None:
            bounded = replace(extensions[place], windows=rows)
            extensions = (*extensions[:place], bounded, *extensions[place + 1 :])
            fit = fit_set(model, fit.point, extensions)
    return extensions, fit


def _other(
    examination: Examination, first: Posterior, left: Screen, causes: list[Cause], generator: np.random.Generator
) -> tuple[list[tuple[Posterior, FittedCause]], Screen] | None:
    """What explains more where the likeliest cause leaves too much: a likely rival that does not, or two causes.

    Parameters
    ----------
    left : the screen beside the likeliest cause
    """
    model = examination.model
    best: tuple[float, list[tuple[Posterior, FittedCause]], Screen] | None = None
    # what explains nothing by itself is no half of a pair
    least = max(first.best.log_evidence - PAIR_FIRST_WITHIN, 0.0)
    firsts = [one for one in first.fitted_causes[:_FIRSTS] if one.log_evidence > least]
    for one in firsts:
        seen = left if one is first.best else screen(model, one.fit, (one.extension,), causes, generator)
        own = _with_first(first, one)
        if seen.p_value >= CLOSURE_RATE:
            option = (one.log_evidence, [(own, one)], seen)
        else:
            seconds = _seconds(examination, one.fit, one.extension, seen, causes)
            if max((other.log_evidence for other in seconds), default=0.0) < PAIR_PRICE:
                continue
            second = posterior(seconds, seen.unknown_evidence)
            after = screen(model, second.best.fit, (one.extension, second.best.extension), causes, generator)
            total = one.log_evidence + second.best.log_evidence - PAIR_PRICE
            option = (total, [(own, one), (second, second.best)], after)
        if best is None or option[0] > best[0]:
            best = option
    if best is None:
        return None
    _, chosen, after = best
    if len(chosen) > 1:
        (own, one), (_, other) = chosen
        chosen[0] = _beside(examination, one, other, causes, generator) or own, one
    return chosen, after


def _seconds(
    examination: Examination, fit: SetFit, beside: Extension, seen: Screen, causes: list[Cause]
) -> list[FittedCause]:
    """Further causes beside one, with their own detections; in the order of the responses' evidence."""
    fitted_causes = search(examination.model, fit, (beside,), seen, causes, moving=_moving(examination))
    return _with_own_detections(fitted_causes, examination.detections)


def _beside(
    examination: Examination, one: FittedCause, other: FittedCause, causes: list[Cause], generator: np.random.Generator
) -> Posterior | None:
    """Posterior of the first of two causes beside the second: what that one explains is no rival of the first."""
    model, pair = examination.model, other.fit.point
    fit = fit_set(model, Point(pair.shared, pair.local, pair.sizes[-1:]), (other.extension,))
    seen = screen(model, fit, (other.extension,), causes, generator)
    fitted_causes = _seconds(examination, fit, other.extension, seen, causes)
    own = [candidate for candidate in fitted_causes if candidate.name == one.name]
    return _with_first(posterior(fitted_causes, seen.unknown_evidence), own[0]) if own else None


def _with_first(found: Posterior, chosen: FittedCause) -> Posterior:
    """The posterior with another cause first, as one beside which a second was found."""
    rest = tuple(one for one in found.fitted_causes if one is not chosen)
    share = dict(found.share)
    share[found.best.name], share[chosen.name] = share[chosen.name], share[found.best.name]
    return Posterior((chosen, *rest), share)


def _linear_verdict(result: Examination, place: int, found: Posterior, one: FittedCause) -> Verdict:
    evidence = result.model.evidence
    size, error = _size(result, place)
    limits, cause, rows = one.extension.cause.size, one.extension.cause, result.extensions[place].windows
    depth = evidence.operating_points.hole_depth if rows is None else evidence.operating_points.hole_depth[list(rows)]
    without = tuple(other for number, other in enumerate(result.extensions) if number != place)
    gain = _gain(result, place, without).joined(
        detection_gain([detection for detection in evidence.detections if detection.cause == cause.name])
    )
    members = _members(result, found, without)
    return Verdict(
        verdict=class_name(members),
        family=cause.family,
        probability=sum(found.share[name] for name in members) * surely(one.log_evidence),
        from_m=float(depth.min()),
        to_m=float(depth.max()),
        cause=cause.name,
        size=size,
        size_low=max(size - TWO_SIDED * error, limits.low),
        size_high=min(size + TWO_SIDED * error, limits.high),
        unit=limits.unit,
        location_m=_location(result, place, members),
        predictive_gain=gain.value,
        predictive_gain_low=gain.low,
        predictive_gain_high=gain.high,
        held_out_windows=gain.windows,
        what_would_separate=separator(members),
        evidence=f"linear responses, log Bayes factor {one.log_evidence:.1f}",
    )


def _location(result: Examination, place: int, members: tuple[str, ...]) -> float:
    """Where along the string an extension sits, m; NaN where the data do not tell.

    A class with a cause that is everywhere says of no place that it is there.
    """
    model, extensions = result.model, result.extensions
    if not all(CATALOGUE[name].is_place for name in members):
        return float("nan")
    if place_probability(model, result.extended, extensions, place) < PLACED:
        return float("nan")
    return extensions[place].shape * float(np.mean(model.length))


def _size(result: Examination, place: int) -> tuple[float, float]:
    """Size of an extension and its error; of one that moves by its sign, as the mean response hardly tells it."""
    if result.extensions[place].cause.moves:
        own = [detection for detection in result.detections if detection.cause == result.extensions[place].cause.name]
        if own and np.isfinite(own[0].size_error):
            return own[0].size, own[0].size_error
    return float(result.extended.point.sizes[place]), float(result.extended.size_errors[place])


def _members(result: Examination, found: Posterior, beside: tuple[Extension, ...]) -> tuple[str, ...]:
    """Of the likeliest causes those that cannot be told from the best: told apart, the likelier one is the name."""
    first, likely = found.best, found.members
    members = (one for one in found.fitted_causes if one.name in likely)
    return tuple(one.name for one in members if one is first or not _apart(result, first, one, beside))


def _apart(result: Examination, one: FittedCause, other: FittedCause, beside: tuple[Extension, ...]) -> bool:
    """Whether two causes are told apart by their detections, or by what they predict."""
    detections = [detection for detection in result.detections if detection.cause in (one.name, other.name)]
    by_detections = len(detections) > 1 and told_apart(*detections)
    return by_detections or _distance(result.model, one, other, beside) >= SAME


def _distance(model: SetModel, one: FittedCause, other: FittedCause, beside: tuple[Extension, ...]) -> float:
    """Standard deviations between what two causes at their best predict, the data sheets' figures among it."""
    left, right = (model.residual(fitted.fit.point, (*beside, fitted.extension)) for fitted in (one, other))
    shared = one.fit.off_data_sheet - other.fit.off_data_sheet
    local = (one.fit.point.local - other.fit.point.local) / model.deviation
    return float(np.sqrt(np.sum(np.abs(left - right) ** 2) + np.sum(shared**2) + np.sum(local**2)))


def _gain(result: Examination, place: int, without: tuple[Extension, ...]) -> PredictiveGain:
    """What one extension adds to the others on held-out data."""
    point = result.extended.point
    lesser = replace(point, sizes=np.delete(point.sizes, place))
    start = result.base.point if not without else lesser
    return held_out_gain(result.model, (start, without), (point, result.extensions))


def _unknown(examination: Examination, log_evidence: float, unproved: tuple[Verdict, ...] = ()) -> Examination:
    """Something is wrong, and nothing in the catalogue explains it in a way that held-out data bear out."""
    channel = max(examination.before.unknown, key=lambda name: examination.before.unknown[name])
    operating_points = examination.model.evidence.operating_points
    verdict = Verdict(
        verdict=UNKNOWN,
        family=channel,
        probability=surely(log_evidence),
        from_m=float(operating_points.hole_depth.min()),
        to_m=float(operating_points.hole_depth.max()),
        evidence=f"linear responses, p-value {examination.before.p_value:.2g} where nothing is wrong{doubt(unproved)}",
        what_would_separate=_localised(examination, channel),
    )
    return replace(examination, verdicts=(verdict,))


def _localised(examination: Examination, channel: str) -> str:
    """Where something unknown acts, in words."""
    if channel == ON_DATA_SHEET:
        return furthest_off_data_sheet(examination.base)
    return "the unknown disturbance acts as one " + _AT[channel]


_AT = {
    "record": "in sensors or recorder",
    "drive": "in the drive",
    "control": "in the speed control",
    "top": "at the top of the string",
    "upper string": "in the upper half of the string",
    "lower string": "in the lower half of the string",
    "bit": "at the bottom-hole assembly",
}
