"""Verdicts from detections in the record, beside or in place of those from the linear responses."""

from dataclasses import replace

import numpy as np
from scipy.special import logsumexp

from drillid.discrepancy.catalogue import CATALOGUE, SYMPTOMS
from drillid.discrepancy.detectors.pooling import PooledDetection, detection_gain
from drillid.discrepancy.rules import (
    CLASS_MASS,
    CLOSURE_RATE,
    NAMELESS_EVIDENCE,
    SHADOW_OF_DETECTION,
    SHADOW_OF_EVIDENCE,
)
from drillid.discrepancy.verdicts.examination import (
    NO_SURE_GAIN,
    Examination,
    as_unknown,
    remaining_evidence,
    unextended,
)
from drillid.discrepancy.verdicts.explanations import own_detection
from drillid.discrepancy.verdicts.naming import (
    class_evidence,
    class_name,
    distinguishable,
    look_alike,
    may_be_trace,
    separator,
)
from drillid.discrepancy.verdicts.verdict import UNKNOWN, Verdict
from drillid.statistics import TWO_SIDED

_MISFIT = "something similar fits better"


def combine_with_detections(
    examination: Examination, significant: list[PooledDetection], error_rate: float
) -> Examination:
    """Verdicts from detections beside, or in place of, those from the linear responses; possibly none at all.

    A symptom counts only where there is no other verdict: the verdict is then unknown.
    """
    symptoms = [_of_symptom(examination, detection) for detection in significant if detection.cause in SYMPTOMS]
    significant = [detection for detection in significant if detection.cause not in SYMPTOMS]
    chosen = _strongest_of_alike(_admissible(examination, significant))
    by_cause = {detection.cause: _detection_verdict(examination, detection, significant) for detection in chosen}
    reasons = {detection.cause: _reason_not_named(detection, by_cause[detection.cause]) for detection in chosen}
    if _distorts_responses(
        examination, [detection for detection in chosen if reasons[detection.cause] in ("", _MISFIT)]
    ):
        examination = unextended(examination)
    linear = examination.verdicts
    if linear:
        chosen = [
            detection
            for detection in chosen
            if detection.p_value < error_rate * CLOSURE_RATE / len(examination.detections)
        ]
    # beside a strong cause a weak detection is more likely a side effect of it than a second cause
    own = {own_detection(verdict.cause, examination.detections) for verdict in linear if verdict.cause}
    strong = [*chosen, *(detection for detection in examination.detections if detection.cause in own)]
    least = SHADOW_OF_DETECTION * max((detection.log_evidence for detection in strong), default=0.0)
    least = max(least, SHADOW_OF_EVIDENCE * (examination.base.cost - examination.extended.cost))
    chosen = [
        detection
        for place, detection in enumerate(chosen)
        if detection.log_evidence >= max(least, examination.base_rates.pair_penalty if place else 0.0)
    ]
    # where the strongest is no cause of the catalogue, weaker detections may be side effects of it too
    in_catalogue = not chosen or reasons[chosen[0].cause] != _MISFIT
    named = [by_cause[detection.cause] for detection in chosen if in_catalogue and not reasons[detection.cause]]
    explains_unknown = any(CATALOGUE[verdict.cause].may_explain_unknown for verdict in named)
    if explains_unknown and all(verdict.verdict == UNKNOWN for verdict in linear):
        linear = ()
    unproved = [
        as_unknown(by_cause[detection.cause], reasons[detection.cause])
        for detection in chosen
        if by_cause[detection.cause].predictive_gain > 0 or detection.log_evidence > NAMELESS_EVIDENCE
    ]
    return replace(examination, verdicts=(*linear, *named) or tuple([*unproved, *symptoms][:1]))


def _admissible(examination: Examination, detections: list[PooledDetection]) -> list[PooledDetection]:
    """Detections of causes that are possible and not named yet."""
    named = [CATALOGUE[name] for verdict in examination.verdicts for name in verdict.members]
    possible = [
        (CATALOGUE[detection.cause], detection)
        for detection in detections
        if all(cause.name != detection.cause and not may_be_trace(detection.cause, cause) for cause in named)
        and CATALOGUE[detection.cause].admits_size(detection.size, detection.size_error)
    ]
    # a detection that another cause explains does not rule out a third one either
    detected = [detection for _, detection in possible]
    possible = [(cause, detection) for cause, detection in possible if not _is_explained(detection, detected)]
    return [
        detection
        for cause, detection in possible
        if all(other.allows(cause) for other in named)
        and not any(_takes_the_place(stronger, detection) for _, stronger in possible)
    ]


def _takes_the_place(detection: PooledDetection, of: PooledDetection) -> bool:
    """Whether a detection displaces another: it is stronger and only one is valid, or as strong and disallows it."""
    own, other = CATALOGUE[detection.cause], CATALOGUE[of.cause]
    if detection.log_evidence == of.log_evidence:
        return not own.allows(other)
    return detection.log_evidence > of.log_evidence and not (own.allows(other) and other.allows(own))


def _is_explained(detection: PooledDetection, detected: list[PooledDetection]) -> bool:
    """Whether a cause that its detector mistakes for it is detected too, and not as a side effect of it."""
    detector = CATALOGUE[detection.cause].detector
    makers = detector.excluded_by if detector else ()
    least = SHADOW_OF_DETECTION * detection.log_evidence
    return any(other.cause in makers and other.log_evidence >= least for other in detected)


def _distorts_responses(examination: Examination, detections: list[PooledDetection]) -> bool:
    """Whether the verdicts from the linear responses result from a rig that changes or saturates within a window, for
    which there is more evidence than for them.
    """
    linear = examination.verdicts
    distorting = [detection for detection in detections if CATALOGUE[detection.cause].distorts_responses]
    if not linear or not distorting:
        return False
    if all(verdict.verdict == UNKNOWN for verdict in linear):
        return True
    # no linear cause explains a distorted response, unless it looks like what distorts it, as less gain does like a
    # limit; one that does must have the evidence of a second cause
    unscreened = [verdict.evidence_nats for verdict in linear if verdict.cause and CATALOGUE[verdict.cause].size.fixed]
    evidence = max(remaining_evidence(examination.before), *unscreened, 0.0)
    causes = [CATALOGUE[verdict.cause] for verdict in linear if verdict.cause]
    is_alike = any(look_alike(CATALOGUE[detection.cause], cause) for detection in distorting for cause in causes)
    is_second = evidence > examination.base_rates.pair_penalty and examination.after.p_value >= CLOSURE_RATE
    stands = is_second and not is_alike
    own = {own_detection(verdict.cause, examination.detections) for verdict in linear if verdict.cause}
    detected = sum(detection.log_evidence for detection in examination.detections if detection.cause in own)
    return not stands and sum(detection.log_evidence for detection in distorting) > max(evidence, detected)


def _reason_not_named(detection: PooledDetection, verdict: Verdict) -> str:
    """Why a detected cause is not named; empty where it is."""
    if not verdict.predictive_gain_low > 0:
        return NO_SURE_GAIN
    if verdict.size_low <= 0 <= verdict.size_high:
        return "the windows do not agree that it has a size"
    return _MISFIT if detection.closure < CLOSURE_RATE else ""


def _strongest_of_alike(detections: list[PooledDetection]) -> list[PooledDetection]:
    """The strongest of those detections whose causes look alike, in order of evidence."""
    chosen: list[PooledDetection] = []
    for detection in sorted(detections, key=lambda candidate: -candidate.log_evidence):
        if not any(look_alike(CATALOGUE[detection.cause], CATALOGUE[other.cause]) for other in chosen):
            chosen.append(detection)
    return chosen


def _of_symptom(examination: Examination, detection: PooledDetection) -> Verdict:
    """The verdict unknown, from a symptom that is not specific to a cause of the catalogue."""
    symptom, depth = SYMPTOMS[detection.cause], examination.model.evidence.operating_points.hole_depth
    return Verdict(
        verdict=UNKNOWN,
        family=symptom.family,
        probability=examination.base_rates.probability([UNKNOWN], detection.log_evidence),
        from_m=float(depth.min()),
        to_m=float(depth.max()),
        evidence_nats=detection.log_evidence,
        evidence=f"{symptom.meaning}, p-value {detection.p_value:.2g} where nothing is wrong",
        what_would_separate=symptom.separated_by,
    )


def _detection_verdict(
    examination: Examination, detection: PooledDetection, significant: list[PooledDetection]
) -> Verdict:
    cause, evidence = CATALOGUE[detection.cause], examination.model.evidence
    alike = [other for other in significant if other is detection or look_alike(cause, CATALOGUE[other.cause])]
    rivals = [detection] if cause.stands_alone else alike
    base_rates = examination.base_rates
    logs = np.array([other.log_evidence + base_rates.log_weight(other.cause) for other in rivals])
    shares = np.exp(logs - logsumexp(logs))
    likely = {
        other.cause: share
        for other, share in zip(rivals, shares, strict=True)
        if other is detection or (share > 1 - CLASS_MASS and not distinguishable(detection, other))
    }
    members = list(likely)
    own_evidence = {other.cause: other.log_evidence for other in rivals}
    gain = detection_gain([own for own in evidence.detections if own.cause == detection.cause])
    low, high = _interval(detection, _error_factor(examination))
    return Verdict(
        verdict=class_name(members),
        family=cause.family,
        probability=base_rates.probability([cause.name], detection.log_evidence) * float(sum(likely.values())),
        from_m=float(evidence.operating_points.hole_depth.min()),
        to_m=float(evidence.operating_points.hole_depth.max()),
        cause=detection.cause,
        size=detection.size,
        size_low=low,
        size_high=high,
        unit=cause.size.unit,
        predictive_gain=gain.value,
        predictive_gain_low=gain.low,
        predictive_gain_high=gain.high,
        held_out_windows=gain.windows,
        what_would_separate=separator(members, evidence),
        evidence_nats=class_evidence({name: own_evidence[name] for name in members}, base_rates),
        evidence=f"a detection of its own in the record, p-value {detection.p_value:.2g} where it is absent",
    )


def _interval(detection: PooledDetection, factor: float) -> tuple[float, float]:
    """95 % interval of a detected size, whose error is enlarged by a factor.

    The effect of a very large cause hardly grows with its size, so that an error may be as large as the size although
    zero is excluded; the interval is then one of the logarithm. Where several windows have such an error of their mean,
    they do not agree. Where the law of the cause is not known, its size may be as much larger as the detection may show
    of it.
    """
    half_width = TWO_SIDED * detection.size_error * factor
    if detection.windows == 1 and half_width >= abs(detection.size) > 0:
        ratio = float(np.exp(half_width / abs(detection.size)))
        low, high = sorted((detection.size / ratio, detection.size * ratio))
    else:
        low, high = detection.size - half_width, detection.size + half_width
    return low, max(high, high / detection.least_shown)


def _error_factor(examination: Examination) -> float:
    """Birge ratio: factor on errors from a model that does not fit (Birge 1932, Physical Review 40, 207–227)."""
    return float(np.sqrt(max(examination.extended.chi2 / examination.model.measured.residuals, 1.0)))
