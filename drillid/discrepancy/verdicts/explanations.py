"""Explanations of the linear responses: the likeliest cause, another one, or two."""

from dataclasses import dataclass, replace

import numpy as np

from drillid.discrepancy.catalogue import CATALOGUE, Cause
from drillid.discrepancy.detectors.pooling import PooledDetection
from drillid.discrepancy.inference.coordinates import Extension
from drillid.discrepancy.inference.screen import Screen, screen
from drillid.discrepancy.inference.search import FittedCause, at_best_shape, search
from drillid.discrepancy.inference.set_fit import SetFit, fit_set
from drillid.discrepancy.inference.set_model import SetModel
from drillid.discrepancy.inference.unknown import leaves_rough_residuals
from drillid.discrepancy.rules import (
    CLOSURE_RATE,
    LEFT_UNEXPLAINED,
    PAIR_FIRST_WITHIN,
    REJECTED_PULLS,
    SHAPE_RESOLVED,
)
from drillid.discrepancy.verdicts.examination import Examination
from drillid.discrepancy.verdicts.naming import Posterior, cause_posterior, may_be_trace

_MOST_FIRSTS = 3
"""Number of the likeliest causes beside which a second one is tried."""

Chosen = list[tuple[Posterior, FittedCause]]
"""One cause or two that explain the linear responses, each with the posterior that it is taken from."""


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
        rejected=model_rejected(model, base),
    )
    most, nearest = (fitted_causes[0].log_evidence, fitted_causes[0].name) if fitted_causes else (0.0, "")
    fitted_causes = [fit for fit in fitted_causes if not fit.at_bound and not _refuted(examination, fit.name)]
    if not fitted_causes or fitted_causes[0].log_evidence < most - LEFT_UNEXPLAINED:
        return Likeliest(None, most, nearest)
    detected = _with_own_detections(fitted_causes, examination.detections)
    return Likeliest(cause_posterior(detected, before.unknown_evidence, examination.base_rates), most, nearest)


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


def model_rejected(model: SetModel, fit: SetFit) -> bool:
    """Whether a model, extended or not, is so wrong that a linearisation about it is not valid."""
    return fit.data_sheet_cost > REJECTED_PULLS or leaves_rough_residuals(model, fit)


def _with_own_detections(
    fitted_causes: list[FittedCause], detections: tuple[PooledDetection, ...]
) -> list[FittedCause]:
    """Causes with the evidence of their own detections added, for or against; a cause without one in its favour gets
    that for another cause's detection which it would explain as well. It need not show there: images of a held record
    may lie above the band.
    """
    found = {detection.cause: detection for detection in detections if detection.cause in CATALOGUE}
    own = {
        fit.name: found[fit.name].evidence_for(float(fit.fit.point.sizes[-1]), fit.size_error)
        for fit in fitted_causes
        if fit.name in found
    }
    added = {
        fit.name: max(
            (0.0, *(evidence for name, evidence in own.items() if not CATALOGUE[fit.name].allows(CATALOGUE[name])))
        )
        for fit in fitted_causes
    }
    evidence = {name: own[name] if own.get(name, 0.0) > 0 else own.get(name, 0.0) + added[name] for name in added}
    return [replace(fit, log_evidence=fit.log_evidence + evidence[fit.name]) for fit in fitted_causes]


def own_detection(cause: str, detections: tuple[PooledDetection, ...]) -> str:
    """The cause whose detection counts for a cause: itself, or where it has none in its favour the strongest that it
    would explain as well; empty without any.
    """
    found = {detection.cause: detection.log_evidence for detection in detections if detection.cause in CATALOGUE}
    if found.get(cause, 0.0) > 0:
        return cause
    explained = [name for name in found if not CATALOGUE[cause].allows(CATALOGUE[name]) and found[name] > 0]
    return max(explained, key=lambda name: found[name], default=cause if cause in found else "")


def total_evidence(examination: Examination, chosen: Chosen) -> float:
    """Log Bayes factor of one cause or two."""
    penalty = examination.base_rates.pair_penalty * (len(chosen) - 1)
    return sum(cause.log_evidence for _, cause in chosen) - penalty


def leaves_more(model: SetModel, fit: SetFit, after: Screen) -> bool:
    """Whether an extended model leaves something in its residuals or off the data sheets, in linear theory or so much
    that this does not see it.
    """
    return after.p_value < CLOSURE_RATE or model_rejected(model, fit)


def alternative(
    examination: Examination, first: Posterior, residual: Screen, causes: list[Cause], generator: np.random.Generator
) -> tuple[Chosen, Screen] | None:
    """A better explanation where the likeliest cause leaves too much: another likely cause, or two causes.

    Parameters
    ----------
    residual : screen of the model extended by the likeliest cause
    """
    model, pair_penalty = examination.model, examination.base_rates.pair_penalty
    best: tuple[Chosen, Screen] | None = None
    # a cause without evidence of its own is not tried as one of two
    least = max(first.best.log_evidence - PAIR_FIRST_WITHIN, 0.0)
    for cause in [fit for fit in first.fitted_causes[:_MOST_FIRSTS] if fit.log_evidence > least]:
        after = residual if cause is first.best else screen(model, cause.fit, (cause.extension,), causes, generator)
        if leaves_more(model, cause.fit, after):
            # what another shape of it explains is no second cause
            moved = at_best_shape(model, examination.base, (), cause)
            if moved.fit.cost < cause.fit.cost - SHAPE_RESOLVED:
                cause, after = moved, screen(model, moved.fit, (moved.extension,), causes, generator)
        own = with_first(first, cause)
        option: tuple[Chosen, Screen] = ([(own, cause)], after)
        left = leaves_more(model, cause.fit, after)
        seconds = _second_causes(examination, cause.fit, cause.extension, after, causes) if left else []
        if max((fit.log_evidence for fit in seconds), default=-np.inf) >= pair_penalty:
            second = cause_posterior(seconds, after.unknown_evidence, examination.base_rates)
            after = screen(model, second.best.fit, (cause.extension, second.best.extension), causes, generator)
            option = ([(own, cause), (second, second.best)], after)
        elif after.p_value < CLOSURE_RATE:
            continue
        if best is None or total_evidence(examination, option[0]) > total_evidence(examination, best[0]):
            best = option
    if best is None:
        return None
    chosen, after = best
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
    detections = tuple(each for each in examination.detections if _is_of_another(each.cause, given.cause))
    sizes, rejected = _time_varying_sizes(detections), model_rejected(examination.model, fit)
    fitted_causes = search(examination.model, fit, (given,), screened, causes, time_varying=sizes, rejected=rejected)
    return _with_own_detections(fitted_causes, detections)


def _is_of_another(detected: str, given: Cause) -> bool:
    """Whether a detection is evidence for another cause beside a given one."""
    is_valid = detected not in CATALOGUE or given.allows(CATALOGUE[detected])
    return is_valid and not may_be_trace(detected, given)


def _posterior_given(
    examination: Examination,
    first: FittedCause,
    other: FittedCause,
    causes: list[Cause],
    generator: np.random.Generator,
) -> Posterior | None:
    """Posterior of the first of two causes given the second, so that what the second explains supports no rival."""
    model, pair = examination.model, other.fit.point
    fit = fit_set(model, pair.without(0), (other.extension,))
    screened = screen(model, fit, (other.extension,), causes, generator)
    fitted_causes = _second_causes(examination, fit, other.extension, screened, causes)
    own = [candidate for candidate in fitted_causes if candidate.name == first.name]
    if not own:
        return None
    return with_first(cause_posterior(fitted_causes, screened.unknown_evidence, examination.base_rates), own[0])


def with_first(posterior: Posterior, chosen: FittedCause) -> Posterior:
    """The posterior with the shares of the likeliest and the chosen cause exchanged, and the chosen one first."""
    rest = tuple(fit for fit in posterior.fitted_causes if fit.name != chosen.name)
    share = dict(posterior.share)
    share[posterior.best.name], share[chosen.name] = share[chosen.name], share[posterior.best.name]
    return Posterior((chosen, *rest), share)
