"""Verdicts from the linear responses: one cause, two, or unknown."""

from dataclasses import dataclass, replace

import numpy as np

from drillid.discrepancy.catalogue import CATALOGUE, Cause
from drillid.discrepancy.detectors.pooling import PooledDetection, detection_gain
from drillid.discrepancy.inference.coordinates import Extension
from drillid.discrepancy.inference.held_out_gain import held_out_gain
from drillid.discrepancy.inference.localisation import contiguous_windows, place_probability
from drillid.discrepancy.inference.screen import Screen, screen
from drillid.discrepancy.inference.search import FittedCause, at_best_shape, search
from drillid.discrepancy.inference.set_fit import SetFit, fit_set
from drillid.discrepancy.inference.set_model import SetModel
from drillid.discrepancy.inference.size_posterior import size_interval
from drillid.discrepancy.inference.unknown import ON_DATA_SHEET, furthest_off_data_sheet
from drillid.discrepancy.predictive_gain import PredictiveGain
from drillid.discrepancy.rules import (
    CLOSURE_RATE,
    DISTINCT,
    LEFT_CHI2,
    LEFT_UNEXPLAINED,
    OUT_OF_REACH,
    PAIR_FIRST_WITHIN,
    PLACE_CONFIDENCE,
    REJECTED_CHI2,
    REJECTED_PULLS,
    SHAPE_RESOLVED,
)
from drillid.discrepancy.verdicts.examination import (
    Examination,
    remaining_evidence,
    unproved_names,
)
from drillid.discrepancy.verdicts.naming import (
    Posterior,
    cause_posterior,
    class_evidence,
    class_name,
    distinguishable,
    may_be_trace,
    separator,
)
from drillid.discrepancy.verdicts.verdict import UNKNOWN, Verdict

_MOST_FIRSTS = 3
"""Number of the likeliest causes beside which a second one is tried."""


@dataclass(frozen=True, eq=False)
class Likeliest:
    """The cause that explains the linear responses best by itself."""

    posterior: Posterior | None
    """Of one cause; None where none of those that may be named comes near the best."""
    evidence: float
    """Log Bayes factor of the best, whether or not it may be named."""
    nearest: str
    """Its name."""


def likeliest_cause(examination: Examination, causes: list[Cause]) -> Likeliest:
    """Search for one cause of the linear responses."""
    model, base, before = examination.model, examination.base, examination.before
    time_varying = _time_varying_sizes(examination.detections)
    fitted_causes = search(
        model,
        base,
        (),
        before,
        causes,
        time_varying=time_varying,
        all_causes=True,
        rejected=base_model_rejected(model, base),
    )
    most, nearest = (fitted_causes[0].log_evidence, fitted_causes[0].name) if fitted_causes else (0.0, "")
    fitted_causes = [fit for fit in fitted_causes if not fit.at_bound and not _refuted(examination, fit.name)]
    if not fitted_causes or fitted_causes[0].log_evidence < most - LEFT_UNEXPLAINED:
        return Likeliest(None, most, nearest)
    detected = _with_own_detections(fitted_causes, examination.detections)
    return Likeliest(cause_posterior(detected, before.unknown_evidence, examination.base_rates), most, nearest)


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
    chosen: list[tuple[Posterior, FittedCause]] = [(first, best)]
    if after.p_value < CLOSURE_RATE:
        alternative = _alternative(examination, first, after, causes, generator)
        if alternative is not None:
            chosen, after = alternative
    total = sum(fit.log_evidence for _, fit in chosen) - examination.base_rates.pair_penalty * (len(chosen) - 1)
    above_noise = chosen[-1][1].fit.chi2 > LEFT_CHI2 * _residuals(model)
    is_incomplete = after.p_value < CLOSURE_RATE and (remaining_evidence(after) > LEFT_UNEXPLAINED or above_noise)
    # residuals may be at the noise because data sheets are not believed
    is_incomplete = is_incomplete or chosen[-1][1].fit.data_sheet_cost > OUT_OF_REACH
    if any(fit.at_bound for _, fit in chosen):
        return _unknown(examination, max(before.unknown_evidence, total))
    if before.unknown_evidence > total or is_incomplete:
        nearest = class_name([fit.name for _, fit in chosen]) if is_incomplete else ""
        examination = replace(examination, posterior=first)
        return _unknown(examination, max(before.unknown_evidence, 0.0), nearest=nearest)
    extensions, extended = _bounded_in_depth(model, tuple(fit.extension for _, fit in chosen), chosen[-1][1].fit)
    result = replace(examination, extended=extended, extensions=extensions, after=after, posterior=first)
    verdicts = tuple(_linear_verdict(result, place, *pair) for place, pair in enumerate(chosen))
    kept = tuple(verdict for verdict in verdicts if verdict.predictive_gain_low > 0)
    if kept:
        return replace(result, verdicts=kept)
    return _unknown(examination, before.unknown_evidence, verdicts)


def _time_varying_sizes(detections: tuple[PooledDetection, ...]) -> dict[str, float]:
    """Detected sizes of causes that vary within a window, where there is evidence for them."""
    return {
        detection.cause: detection.size
        for detection in detections
        if detection.cause in CATALOGUE and CATALOGUE[detection.cause].time_varying and detection.log_evidence > 0
    }


def _refuted(examination: Examination, cause: str) -> bool:
    """Whether a cause's own detection leaves more misfit in the record than the true cause would."""
    return any(
        detection.cause == cause and detection.log_evidence > 0 and detection.closure < CLOSURE_RATE
        for detection in examination.detections
    )


def base_model_rejected(model: SetModel, base: SetFit) -> bool:
    """Whether the base model is so wrong that a linearisation about it is not valid."""
    return base.data_sheet_cost > REJECTED_PULLS or base.chi2 > REJECTED_CHI2 * _residuals(model)


def _residuals(model: SetModel) -> int:
    """Number of residuals of the mobilities, real and imaginary parts."""
    return 2 * int(np.count_nonzero(model.measured.weight))


def _with_own_detections(
    fitted_causes: list[FittedCause], detections: tuple[PooledDetection, ...]
) -> list[FittedCause]:
    """Causes with the evidence of their own detections added, for or against."""
    own = {detection.cause: detection for detection in detections}
    return [
        replace(fit, log_evidence=fit.log_evidence + own[fit.name].evidence_for(float(fit.fit.point.sizes[-1])))
        if fit.name in own
        else fit
        for fit in fitted_causes
    ]


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


def _alternative(
    examination: Examination, first: Posterior, residual: Screen, causes: list[Cause], generator: np.random.Generator
) -> tuple[list[tuple[Posterior, FittedCause]], Screen] | None:
    """A better explanation where the likeliest cause leaves too much: another likely cause, or two causes.

    Parameters
    ----------
    residual : screen of the model extended by the likeliest cause
    """
    model, pair_penalty = examination.model, examination.base_rates.pair_penalty
    best: tuple[float, list[tuple[Posterior, FittedCause]], Screen] | None = None
    # a cause without evidence of its own is not tried as one of two
    least = max(first.best.log_evidence - PAIR_FIRST_WITHIN, 0.0)
    for cause in [fit for fit in first.fitted_causes[:_MOST_FIRSTS] if fit.log_evidence > least]:
        after = residual if cause is first.best else screen(model, cause.fit, (cause.extension,), causes, generator)
        if after.p_value < CLOSURE_RATE:
            # what another shape of it explains is no second cause
            moved = at_best_shape(model, examination.base, (), cause)
            if moved.fit.cost < cause.fit.cost - SHAPE_RESOLVED:
                cause, after = moved, screen(model, moved.fit, (moved.extension,), causes, generator)
        own = _with_first(first, cause)
        if after.p_value >= CLOSURE_RATE:
            option = (cause.log_evidence, [(own, cause)], after)
        else:
            seconds = _second_causes(examination, cause.fit, cause.extension, after, causes)
            if max((fit.log_evidence for fit in seconds), default=0.0) < pair_penalty:
                continue
            second = cause_posterior(seconds, after.unknown_evidence, examination.base_rates)
            after = screen(model, second.best.fit, (cause.extension, second.best.extension), causes, generator)
            total = cause.log_evidence + second.best.log_evidence - pair_penalty
            option = (total, [(own, cause), (second, second.best)], after)
        if best is None or option[0] > best[0]:
            best = option
    if best is None:
        return None
    _, chosen, after = best
    if len(chosen) > 1:
        (own, cause), (second, other) = chosen
        given = _posterior_given(examination, cause, other, causes, generator)
        if given is not None and given.best.fit.cost < other.fit.cost - SHAPE_RESOLVED:
            cause = replace(cause, extension=given.best.extension)
            other = _fitted_after(model, given.best, other)
            after = screen(model, other.fit, (cause.extension, other.extension), causes, generator)
        chosen = [(given or own, cause), (second, other)]
    return chosen, after


def _fitted_after(model: SetModel, first: FittedCause, second: FittedCause) -> FittedCause:
    """The second of two causes, fitted after the first, from a fit of the first after the second."""
    point, turned = first.fit.point, [1, 0]
    start = replace(point, sizes=point.sizes[turned], shapes=point.shapes[turned])
    return replace(second, fit=fit_set(model, start, (first.extension, second.extension)))


def _second_causes(
    examination: Examination, fit: SetFit, given: Extension, screened: Screen, causes: list[Cause]
) -> list[FittedCause]:
    """Second causes given a first, with the evidence of their own detections, in order of the responses' evidence."""
    detections = tuple(each for each in examination.detections if not may_be_trace(each.cause, given.cause))
    sizes = _time_varying_sizes(detections)
    fitted_causes = search(examination.model, fit, (given,), screened, causes, time_varying=sizes)
    return _with_own_detections(fitted_causes, detections)


def _posterior_given(
    examination: Examination,
    first: FittedCause,
    other: FittedCause,
    causes: list[Cause],
    generator: np.random.Generator,
) -> Posterior | None:
    """Posterior of the first of two causes given the second, whose share of the misfit then supports no rival."""
    model, pair = examination.model, other.fit.point
    fit = fit_set(model, pair.without(0), (other.extension,))
    screened = screen(model, fit, (other.extension,), causes, generator)
    fitted_causes = _second_causes(examination, fit, other.extension, screened, causes)
    own = [candidate for candidate in fitted_causes if candidate.name == first.name]
    if not own:
        return None
    return _with_first(cause_posterior(fitted_causes, screened.unknown_evidence, examination.base_rates), own[0])


def _with_first(posterior: Posterior, chosen: FittedCause) -> Posterior:
    """The posterior with the shares of the likeliest and the chosen cause exchanged, and the chosen one first."""
    rest = tuple(fit for fit in posterior.fitted_causes if fit.name != chosen.name)
    share = dict(posterior.share)
    share[posterior.best.name], share[chosen.name] = share[chosen.name], share[posterior.best.name]
    return Posterior((chosen, *rest), share)


def _linear_verdict(result: Examination, place: int, posterior: Posterior, fit: FittedCause) -> Verdict:
    evidence = result.model.evidence
    size, error = _size(result, place)
    low, high = (size, size) if fit.extension.cause.size.fixed else size_interval(size, error, fit.extension.cause.size)
    cause, rows = fit.extension.cause, result.extensions[place].windows
    depth = evidence.operating_points.hole_depth if rows is None else evidence.operating_points.hole_depth[list(rows)]
    without = tuple(other for number, other in enumerate(result.extensions) if number != place)
    gain = _gain(result, place, without).joined(
        detection_gain([detection for detection in evidence.detections if detection.cause == cause.name])
    )
    members = _members(result, posterior, without)
    own_evidence = {one.name: one.log_evidence for one in (*posterior.fitted_causes, fit)}
    return Verdict(
        verdict=class_name(members),
        family=cause.family,
        probability=sum(posterior.share[name] for name in members)
        * result.base_rates.probability([cause.name], fit.log_evidence),
        from_m=float(depth.min()),
        to_m=float(depth.max()),
        cause=cause.name,
        size=size,
        size_low=low,
        size_high=high,
        unit=cause.size.unit,
        location_m=_location(result, place, members),
        predictive_gain=gain.value,
        predictive_gain_low=gain.low,
        predictive_gain_high=gain.high,
        held_out_windows=gain.windows,
        what_would_separate=separator(members),
        evidence_nats=class_evidence({name: own_evidence[name] for name in members}, result.base_rates),
        evidence=f"linear responses, log Bayes factor {fit.log_evidence:.1f}",
    )


def _location(result: Examination, place: int, members: tuple[str, ...]) -> float:
    """Measured depth of an extension along the string, m; NaN where the data do not determine it, or the class has a
    member without a place.
    """
    model, extensions = result.model, result.extensions
    if not all(CATALOGUE[name].is_place for name in members):
        return float("nan")
    if place_probability(model, result.extended, extensions, place) < PLACE_CONFIDENCE:
        return float("nan")
    return extensions[place].shape * float(np.mean(model.length))


def _size(result: Examination, place: int) -> tuple[float, float]:
    """Size of an extension and its error; from its detection where it varies within the window, as the mean response
    hardly determines it.
    """
    if result.extensions[place].cause.time_varying:
        own = [detection for detection in result.detections if detection.cause == result.extensions[place].cause.name]
        if own and np.isfinite(own[0].size_error):
            return own[0].size, own[0].size_error
    return float(result.extended.point.sizes[place]), float(result.extended.size_errors[place])


def _members(result: Examination, posterior: Posterior, others: tuple[Extension, ...]) -> tuple[str, ...]:
    """The likeliest causes that cannot be distinguished from the best; of two that can, the likelier is the name."""
    first, likely = posterior.best, posterior.members
    members = (fit for fit in posterior.fitted_causes if fit.name in likely)
    return tuple(fit.name for fit in members if fit is first or not _distinguishable(result, first, fit, others))


def _distinguishable(
    result: Examination, first: FittedCause, second: FittedCause, others: tuple[Extension, ...]
) -> bool:
    """Whether two causes can be distinguished by their detections, or by their predictions beside the others."""
    detections = [detection for detection in result.detections if detection.cause in (first.name, second.name)]
    by_detections = len(detections) > 1 and distinguishable(*detections)
    return by_detections or _distance(result.model, first, second, others) >= DISTINCT


def _distance(model: SetModel, first: FittedCause, second: FittedCause, others: tuple[Extension, ...]) -> float:
    """Standard deviations between the predictions of two fitted causes, parameters of the data sheet included."""
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
}
