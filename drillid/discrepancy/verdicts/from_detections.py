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
    PAIR_PRICE,
    SHADOW_OF_DETECTION,
    SHADOW_OF_EVIDENCE,
)
from drillid.discrepancy.verdicts.examination import (
    NO_SURE_GAIN,
    Examination,
    evidence_left,
    nameless,
    surely,
    unextended,
)
from drillid.discrepancy.verdicts.naming import class_name, separator, told_apart
from drillid.discrepancy.verdicts.verdict import UNKNOWN, Verdict
from drillid.statistics import TWO_SIDED

_UNLIKE = "something like it fits better"


def with_detections(examination: Examination, found: list[PooledDetection], error_rate: float) -> Examination:
    """Verdicts from detections beside, or in place of, those from the linear responses; perhaps none at all.

    A symptom counts only where there is nothing else: the verdict is then unknown.
    """
    symptoms = [_of_symptom(examination, one) for one in found if one.cause in SYMPTOMS]
    found = [one for one in found if one.cause not in SYMPTOMS]
    chosen = _plainest(_possible(examination, found))
    shown = {one.cause: _detection_verdict(examination, one, found) for one in chosen}
    doubts = {one.cause: _doubt(one, shown[one.cause]) for one in chosen}
    if _bent(examination, [one for one in chosen if doubts[one.cause] in ("", _UNLIKE)]):
        examination = unextended(examination)
    linear = examination.verdicts
    if linear:
        chosen = [one for one in chosen if one.p_value < error_rate * CLOSURE_RATE / len(examination.detections)]
    # beside a cause that is plain a faint detection is more likely its shadow than a second cause
    plain = SHADOW_OF_DETECTION * max((one.log_evidence for one in chosen), default=0.0)
    plain = max(plain, SHADOW_OF_EVIDENCE * (examination.base.cost - examination.extended.cost))
    chosen = [one for place, one in enumerate(chosen) if one.log_evidence >= max(plain, PAIR_PRICE if place else 0.0)]
    # where the plainest is no cause of the catalogue, what is fainter may be its shadow too
    known = not chosen or doubts[chosen[0].cause] != _UNLIKE
    named = [shown[one.cause] for one in chosen if known and not doubts[one.cause]]
    if any(CATALOGUE[one.cause].disturbs_responses for one in named) and all(one.verdict == UNKNOWN for one in linear):
        linear = ()
    doubtful = [
        nameless(shown[one.cause], doubts[one.cause])
        for one in chosen
        if shown[one.cause].gain > 0 or one.log_evidence > NAMELESS_EVIDENCE
    ]
    return replace(examination, verdicts=(*linear, *named) or tuple([*doubtful, *symptoms][:1]))


def _possible(examination: Examination, found: list[PooledDetection]) -> list[PooledDetection]:
    """Detections of what may be there and has no name yet."""
    told = {name for one in examination.verdicts for name in one.members}
    # what moves has several detections, each like the others
    told |= {other for name in told if CATALOGUE[name].moves for other in CATALOGUE[name].looks_like}
    causes = {
        one.cause: CATALOGUE[one.cause]
        for one in found
        if one.cause not in told and CATALOGUE[one.cause].can_have(one.size, one.size_error)
    }
    allowed = {name for name, cause in causes.items() if all(other.allows(cause) for other in causes.values())}
    return [one for one in found if one.cause in allowed]


def _bent(examination: Examination, proved: list[PooledDetection]) -> bool:
    """Whether a rig that changes or saturates within a window has bent the linear responses."""
    linear, regimes = examination.verdicts, [one for one in proved if CATALOGUE[one.cause].regime]
    if not linear or not regimes:
        return False
    if all(one.verdict == UNKNOWN for one in linear):
        return True
    # what is left of a rig bent out of shape no linear cause explains; one that does pays for being second
    evidence = evidence_left(examination.before)
    stands = evidence > PAIR_PRICE and examination.after.p_value >= CLOSURE_RATE
    return not stands and sum(one.log_evidence for one in regimes) > evidence


def _doubt(one: PooledDetection, verdict: Verdict) -> str:
    """Why a cause is not named by its sign; nothing where it is."""
    if not verdict.predictive_gain_low > 0:
        return NO_SURE_GAIN
    if verdict.size_low <= 0 <= verdict.size_high:
        return "the windows do not agree that it has a size"
    return _UNLIKE if one.closure < CLOSURE_RATE else ""


def _plainest(detections: list[PooledDetection]) -> list[PooledDetection]:
    """Of detections that look alike the plainest, most certain first."""
    chosen: list[PooledDetection] = []
    for one in sorted(detections, key=lambda detection: -detection.log_evidence):
        if not any(_alike(one.cause, other.cause) for other in chosen):
            chosen.append(one)
    return chosen


def _of_symptom(examination: Examination, one: PooledDetection) -> Verdict:
    """Something is wrong that no cause of the catalogue stands for."""
    symptom, depth = SYMPTOMS[one.cause], examination.model.evidence.operating_points.hole_depth
    return Verdict(
        verdict=UNKNOWN,
        family=symptom.family,
        probability=surely(one.log_evidence),
        from_m=float(depth.min()),
        to_m=float(depth.max()),
        evidence=f"{symptom.meaning}, p-value {one.p_value:.2g} where nothing is wrong",
        what_would_separate=symptom.separated_by,
    )


def _alike(one: str, other: str) -> bool:
    return other in CATALOGUE[one].looks_like or one in CATALOGUE[other].looks_like


def _detection_verdict(examination: Examination, one: PooledDetection, found: list[PooledDetection]) -> Verdict:
    cause, evidence = CATALOGUE[one.cause], examination.model.evidence
    alike = [other for other in found if other is one or _alike(one.cause, other.cause)]
    rivals = [one] if cause.stands_alone else alike
    logs = np.array([other.log_evidence for other in rivals])
    shares = np.exp(logs - logsumexp(logs))
    likely = {
        other.cause: share
        for other, share in zip(rivals, shares, strict=True)
        if other is one or (share > 1 - CLASS_MASS and not told_apart(one, other))
    }
    members = list(likely)
    gain = detection_gain([detection for detection in evidence.detections if detection.cause == one.cause])
    reach = TWO_SIDED * one.size_error * _misfit(examination)
    return Verdict(
        verdict=class_name(members),
        family=cause.family,
        probability=surely(one.log_evidence) * float(sum(likely.values())),
        from_m=float(evidence.operating_points.hole_depth.min()),
        to_m=float(evidence.operating_points.hole_depth.max()),
        cause=one.cause,
        size=one.size,
        size_low=one.size - reach,
        size_high=one.size + reach,
        unit=cause.size.unit,
        predictive_gain=gain.value,
        predictive_gain_low=gain.low,
        predictive_gain_high=gain.high,
        held_out_windows=gain.windows,
        what_would_separate=separator(members),
        evidence=f"a detection of its own in the record, p-value {one.p_value:.2g} where it is absent",
    )


def _misfit(examination: Examination) -> float:
    """Factor on errors that are reckoned with a model that does not fit (Birge 1932, Physical Review 40, 207–227)."""
    residuals = 2 * np.count_nonzero(examination.model.weight)
    return float(np.sqrt(max(examination.extended.chi2 / residuals, 1.0)))
