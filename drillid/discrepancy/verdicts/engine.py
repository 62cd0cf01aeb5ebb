"""The engine: from a set of windows to verdicts."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from scipy.special import expit, logit, logsumexp

from drillid.discrepancy.base_rates import BaseRates
from drillid.discrepancy.catalogue import CATALOGUE, SYMPTOMS, Cause
from drillid.discrepancy.detectors.pooling import PooledDetection, detection_gain, pool
from drillid.discrepancy.evidence import Evidence
from drillid.discrepancy.inference.base_fit import (
    at_interval_of,
    at_likeliest_interval,
    fit_base,
    interval_cost,
    log_mass,
)
from drillid.discrepancy.inference.far_off_data_sheet import chance_of_evidence
from drillid.discrepancy.inference.screen import Screen, screen
from drillid.discrepancy.inference.set_fit import SetFit, fit_set, without_outlier_windows
from drillid.discrepancy.inference.set_model import SetModel
from drillid.discrepancy.inference.unknown import (
    ON_DATA_SHEET,
    ROUGH,
    evidence_of_roughness,
    evidence_off_data_sheet,
    leaves_rough_residuals,
)
from drillid.discrepancy.rules import (
    CLOSURE_RATE,
    DATA_SHEET_SHARE,
    DETECTIONS_SHARE,
    EVEN_ODDS,
    REJECTED_PULLS,
    RESPONSES_SHARE,
    SHAPE_RESOLVED,
)
from drillid.discrepancy.verdicts.examination import Examination, unextended
from drillid.discrepancy.verdicts.explanations import Likeliest, likeliest_cause, model_rejected
from drillid.discrepancy.verdicts.from_detections import combine_with_detections
from drillid.discrepancy.verdicts.from_responses import explain_responses
from drillid.discrepancy.verdicts.naming import Posterior
from drillid.discrepancy.verdicts.verdict import NONE, Verdict, calibrated
from drillid.errors import EstimationError


def examine(
    evidence: Evidence,
    *,
    catalogue: Sequence[Cause] | None = None,
    error_rate: float = 0.05,
    seed: int = 0,
    base_rates: BaseRates | None = None,
) -> Examination:
    """Test the base model, name causes of its misfit, extend the model by them and measure the predictive gain.

    Parameters
    ----------
    evidence : a set of windows
    catalogue : causes that may be named; all where not given
    error_rate : chance that a set in which nothing is wrong gets another verdict than none
    seed : of the draws that give p-values
    base_rates : of causes, before the data are looked at; those of the default settings where not given

    Raises
    ------
    EstimationError
        If no window has a fit of its own.
    """
    if not np.isfinite(evidence.fitted).all(axis=1).any():
        raise EstimationError(
            "evidence",
            "no window has a fit of its own",
            "Take windows in which more passes the coherence gate",
        )
    causes = list(CATALOGUE.values()) if catalogue is None else list(catalogue)
    generator = np.random.default_rng(seed)
    names = {*(cause.name for cause in causes), *SYMPTOMS}
    detections = tuple(detection for detection in pool(evidence.detections) if detection.cause in names)
    begun = _begun(*fit_base(evidence), detections, causes, generator, base_rates or BaseRates())
    examination = _by_responses(evidence, begun, causes, generator, error_rate * RESPONSES_SHARE)
    threshold = error_rate * DETECTIONS_SHARE / max(len(detections), 1)
    detected = [detection for detection in detections if detection.p_value < threshold]
    if detected and not any(verdict.probability >= EVEN_ODDS for verdict in examination.verdicts):
        # what is likelier wrong than right does not stand in the way of what is detected
        examination = unextended(examination)
    if not examination.verdicts:
        examination = _with_makers(examination, detected, causes, generator)
    return at_even_odds(combine_with_detections(examination, detected, error_rate))


def _begun(
    model: SetModel,
    base: SetFit,
    detections: tuple[PooledDetection, ...],
    causes: list[Cause],
    generator: np.random.Generator,
    base_rates: BaseRates,
) -> Examination:
    """An examination whose base model has been tested."""
    before = screen(model, base, (), causes, generator)
    if base.data_sheet_cost > REJECTED_PULLS:
        share = RESPONSES_SHARE / DATA_SHEET_SHARE
        before = _with_evidence(before, ON_DATA_SHEET, evidence_off_data_sheet(model, base), share)
    if leaves_rough_residuals(model, base):
        before = _with_evidence(before, ROUGH, evidence_of_roughness(model, base))
    return Examination((), model, base, base, (), before, before, None, detections, base_rates, before.p_value)


def _with_evidence(before: Screen, channel: str, evidence: float, share: float = 1.0) -> Screen:
    """A screen with the evidence of something unknown that linear theory does not see: values far off their data
    sheets, or residuals above the noise that are no smooth function of frequency, such as images of other lines.

    Where nothing is wrong a Bayes factor exceeds any value x with probability at most 1/x (Markov's inequality).

    Parameters
    ----------
    share : of the error rate of the responses, per that of this channel
    """
    known, p_value = max(before.unknown[channel], evidence), float(np.exp(-max(evidence, 0.0))) * share
    return replace(before, unknown={**before.unknown, channel: known}, p_value=min(before.p_value, p_value))


def _by_responses(
    evidence: Evidence, begun: Examination, causes: list[Cause], generator: np.random.Generator, rate: float
) -> Examination:
    """The examination with what explains its linear responses, where something is wrong with them.

    Parameters
    ----------
    evidence : as it was given, without the likeliest interval of the control in its data sheet
    rate : chance that something is found where nothing is wrong
    """
    rejected = model_rejected(begun.model, begun.base)
    if begun.p_value >= rate and not rejected:
        return begun
    likeliest = likeliest_cause(begun, causes)
    lower = _at_lower_base(evidence, begun, likeliest, causes, generator)
    if lower is not None:
        return _by_responses(evidence, lower, causes, generator, rate)
    found = _explained(begun, likeliest, causes, generator)
    p_value = min(begun.p_value, _bounded_p_value(found)) if rejected else begun.p_value
    if p_value >= rate and begun.base.data_sheet_cost > REJECTED_PULLS and likeliest.evidence > 0:
        chance = chance_of_evidence(begun.model, begun.base, causes, likeliest.evidence, generator)
        p_value = min(p_value, chance * RESPONSES_SHARE / DATA_SHEET_SHARE)
    return replace(found if p_value < rate else begun, p_value=p_value)


def _with_makers(
    examination: Examination, detected: list[PooledDetection], causes: list[Cause], generator: np.random.Generator
) -> Examination:
    """The examination of responses that show no misfit by themselves, with another cause in place of a detected one
    where they tell the two apart: it would make the same detection, and has none of its own.
    """
    shown = [CATALOGUE[detection.cause] for detection in detected if detection.cause in CATALOGUE]
    for own in shown:
        makers = [cause for cause in causes if cause.is_linear and cause not in shown and not cause.allows(own)]
        if not (makers and own.is_linear):
            continue
        few, parts = [own, *makers], (examination.model, examination.base, examination.detections)
        begun = _begun(*parts, few, generator, examination.base_rates)
        found = explain_responses(begun, likeliest_cause(begun, few), few, generator)
        if found.extensions and not any(own.name in verdict.members for verdict in found.verdicts):
            return replace(found, before=examination.before, p_value=examination.p_value)
    return examination


def _at_lower_base(
    evidence: Evidence, begun: Examination, likeliest: Likeliest, causes: list[Cause], generator: np.random.Generator
) -> Examination | None:
    """The examination restarted where the base model's posterior has more mass about the coordinates fitted
    beside the likeliest cause, as it has several modes; None where it does not.
    """
    if likeliest.posterior is None:
        return None
    start = likeliest.posterior.best.fit.point.without(0)
    if fit_set(begun.model, start).mass <= begun.base.mass + SHAPE_RESOLVED:
        return None
    model, base = fit_base(evidence, start)
    if log_mass(model, base) <= log_mass(begun.model, begun.base) + SHAPE_RESOLVED:
        return None
    return _begun(model, base, begun.detections, causes, generator, begun.base_rates)


def _explained(
    examination: Examination, likeliest: Likeliest, causes: list[Cause], generator: np.random.Generator
) -> Examination:
    """What explains the linear responses, at the likeliest interval of the control where the data sheet states none."""
    again, posterior = None, likeliest.posterior
    if posterior is not None and not examination.model.evidence.data_sheet.tells_control_interval:
        again = _at_likeliest_interval(examination, examination, posterior, causes, generator)
        if again is not None and _cost(again) <= posterior.best.fit.cost + interval_cost(examination.model):
            return again
    found = explain_responses(examination, likeliest, causes, generator)
    return found if again is None or (found.extensions and _cost(found) < _cost(again)) else again


def _at_likeliest_interval(
    begun: Examination,
    now: Examination,
    posterior: Posterior,
    causes: list[Cause],
    generator: np.random.Generator,
    least: float = np.inf,
) -> Examination | None:
    """What is named at the control interval that is likeliest beside one of the likely causes, as the base model's
    interval may have absorbed part of that cause's effect; None where the interval is the same, or nothing is named.

    Beside what is likely there another interval may be likelier still, which is followed first.

    Parameters
    ----------
    begun : at the base model's own interval
    now : at the interval that has been followed so far
    posterior : of one cause, there
    least : cost found so far, with that of the interval
    """
    model, least = _model_at_likeliest_interval(now.model, posterior, least)
    if model is now.model:
        return None
    base = without_outlier_windows(model, fit_set(model, at_interval_of(model, begun.base.point)))
    # evidence is against the base model at its own likeliest interval
    against = replace(base, cost=base.cost + log_mass(model, base) - log_mass(begun.model, begun.base))
    anew = replace(begun, model=model, base=against, extended=against)
    there = likeliest_cause(anew, causes)
    if there.posterior is not None:
        further = _at_likeliest_interval(begun, anew, there.posterior, causes, generator, least)
        if further is not None:
            return further
    again = explain_responses(anew, there, causes, generator)
    return replace(again, base=base) if again.extensions else None


def _model_at_likeliest_interval(model: SetModel, posterior: Posterior, least: float) -> tuple[SetModel, float]:
    """The model at the interval that is likeliest beside one of the likely causes, and the cost of both: the model
    itself where no other interval costs less than that, nor than what was found so far.
    """
    likely = [each for each in posterior.fitted_causes if each.log_evidence > 0]
    own = interval_cost(model)
    best, least = model, min([least, *(each.fit.cost + own for each in likely)]) - SHAPE_RESOLVED
    for each in likely:
        other, fit = at_likeliest_interval(model, each.fit, (each.extension,), least)
        if fit.cost + interval_cost(other) < least:
            best, least = other, fit.cost + interval_cost(other)
    return best, least


def _cost(examination: Examination) -> float:
    """Cost of what was found, with that of the control's interval and of a second cause."""
    more = len(examination.extensions) - 1
    return examination.extended.cost + interval_cost(examination.model) + more * examination.base_rates.pair_penalty


def _bounded_p_value(found: Examination) -> float:
    """Bound on the probability of as much evidence where nothing is wrong, also where linear theory is not valid: the
    mean Bayes factor of all causes exceeds any value x with probability at most 1/x (Markov's inequality).
    """
    total = sum(verdict.evidence_nats for verdict in found.verdicts)
    tried = max(len(found.before.by_cause), 1) ** max(len(found.verdicts), 1)
    return float(min(tried * np.exp(-total), 1.0))


def decisions(misfit: float, detections: Sequence[float], error_rate: float) -> list[bool]:
    """Everything that the error rate decides in an examination: the same evidence and decisions give the same result.

    Parameters
    ----------
    misfit : p-value of an examination
    detections : p-values of the pooled detections
    """
    count = max(len(detections), 1)
    bounds = error_rate * DETECTIONS_SHARE / count, error_rate * CLOSURE_RATE / count
    return [misfit < error_rate * RESPONSES_SHARE, *(p_value < bound for bound in bounds for p_value in detections)]


def at_even_odds(examination: Examination) -> Examination:
    """Verdicts with calibrated probabilities; those that are likelier wrong than right are not given, and none is the
    verdict without any.
    """
    stated = tuple(calibrated(verdict) for verdict in examination.verdicts)
    # the calibration of names holds from even odds of the posterior on
    kept = tuple(
        verdict
        for verdict, before in zip(stated, examination.verdicts, strict=True)
        if min(verdict.probability, before.probability) >= EVEN_ODDS
    )
    if kept:
        return replace(examination, verdicts=kept)
    nothing = calibrated(_none(examination))
    # what is not something else is nothing
    probability = max(nothing.probability, 1 - max((verdict.probability for verdict in stated), default=1.0))
    return replace(unextended(examination), verdicts=(replace(nothing, probability=probability),))


def _none(examination: Examination) -> Verdict:
    """The verdict none, with its posterior probability; all that may be wrong has equal weight, and counts once more
    where it gave a verdict. A detection counts for no more than its gain on windows that it was not taken from.
    """
    operating_points, before = examination.model.evidence.operating_points, examination.before
    logs = [
        *before.by_cause.values(),
        before.unknown_evidence,
        *(_predictive_evidence(examination, detection) for detection in examination.detections),
        *(verdict.evidence_nats for verdict in examination.verdicts),
    ]
    log_evidence = float(logsumexp(logs) - np.log(len(logs)))
    return Verdict(
        verdict=NONE,
        family="",
        probability=float(expit(-log_evidence - logit(examination.base_rates.wrong))),
        from_m=float(operating_points.hole_depth.min()),
        to_m=float(operating_points.hole_depth.max()),
        evidence_nats=-log_evidence,
        evidence=f"p-value {before.p_value:.2g} of the misfit where nothing is wrong",
    )


def _predictive_evidence(examination: Examination, detection: PooledDetection) -> float:
    """Log evidence of a detection, at most its predictive gain where that is lower."""
    if detection.log_evidence <= 0:
        return detection.log_evidence
    own = [each for each in examination.model.evidence.detections if each.cause == detection.cause]
    return min(detection.log_evidence, max(detection_gain(own).value, 0.0))
