"""Detections in a window's record of causes that its linear response does not show, or only when they are large.

Every detection tests what a cause would add to the record against the noise measured in it. Causes with similar
effects are distinguished by a greedy search: the strongest first, then the others conditionally on it.
"""

from collections.abc import Mapping
from dataclasses import replace
from graphlib import TopologicalSorter

import numpy as np

from drillid.arrays import Floats
from drillid.discrepancy.catalogue import CATALOGUE, SYMPTOMS
from drillid.discrepancy.detectors.detection import Detection
from drillid.discrepancy.detectors.detector import Detector, Inspection, is_clear
from drillid.discrepancy.detectors.residual_record import ResidualRecord, WindowRecord, without_steps
from drillid.discrepancy.detectors.score import Candidate, Score, score, whitened, without


def detectors() -> dict[str, Detector]:
    """The detectors of all causes and symptoms that have one, by name."""
    causes = {name: cause.detector for name, cause in CATALOGUE.items() if cause.detector is not None}
    return causes | {name: symptom.detector for name, symptom in SYMPTOMS.items()}


def detect(record: WindowRecord, window: int = 0) -> tuple[Detection, ...]:
    """Detections of all causes and symptoms that this window's record can show, at most one of each.

    A cause has no detection where its detector lacks the channels or periods that it needs.

    Parameters
    ----------
    window : number of the window in its set
    """
    samples = record.released()
    residual = without_steps(ResidualRecord(samples))
    inspection = Inspection(residual, None if samples is record else ResidualRecord(record))
    applicable = {name: detector for name, detector in detectors().items() if detector.can_inspect(residual)}
    offered = [detector.candidate(name, inspection) for name, detector in applicable.items()]
    candidates = [candidate for candidate in offered if candidate is not None]
    scores = _compete([whitened(candidate, residual) for candidate in candidates], residual)
    inspection.scores = _reviewed(applicable, scores, inspection)
    for candidate in candidates:
        inspection.explained = inspection.explained + _explained(candidate, inspection)
    _score_alone(applicable, inspection)
    return tuple(
        Detection(
            name,
            window,
            score.normal,
            score.size,
            score.size_error,
            score.log_ratio,
            score.misfit,
            score.by_shape,
            score.separation,
            score.lines,
        )
        for name, score in inspection.scores.items()
    )


def _compete(candidates: list[Candidate], residual: ResidualRecord) -> dict[str, Score]:
    """Scores by cause; each clear one is projected out of the record and of the other candidates before they are
    scored.
    """
    error, remaining = residual.error, list(candidates)
    scores: dict[str, Score] = {}
    while remaining:
        tested = [(candidate, score(candidate, error, residual)) for candidate in remaining]
        scored = [(candidate, value) for candidate, value in tested if value is not None]
        if not scored:
            break
        strongest, best = max(scored, key=lambda pair: pair[1].normal)
        if not is_clear(best):
            return scores | {candidate.cause: value for candidate, value in scored}
        scores[strongest.cause] = best
        columns = strongest.columns if strongest.together else strongest.columns[best.amplitudes != 0]
        error = without(error[None], columns)[0]
        remaining = [
            replace(candidate, columns=without(candidate.columns, columns))
            for candidate in remaining
            if candidate is not strongest
        ]
    return scores


def _reviewed(applicable: Mapping[str, Detector], scores: dict[str, Score], inspection: Inspection) -> dict[str, Score]:
    """Scores after the competition, as reviewed by the detectors' classes."""
    for kind in dict.fromkeys(type(detector) for detector in applicable.values()):
        own = {name: detector for name, detector in applicable.items() if type(detector) is kind and name in scores}
        scores = kind.reviewed(own, scores, inspection) if own else scores
    return scores


def _explained(candidate: Candidate, inspection: Inspection) -> Floats:
    """Speed (samples,) explained by a clearly detected cause, rad/s."""
    if not inspection.clearly_detected(candidate.cause):
        return np.zeros(candidate.columns.shape[1])
    return np.asarray(inspection.scores[candidate.cause].amplitudes @ candidate.columns, dtype=float)


def _score_alone(applicable: Mapping[str, Detector], inspection: Inspection) -> None:
    """Add the scores of detectors with a separate test, each after those that may exclude it."""
    order = TopologicalSorter({name: detector.excluded_by for name, detector in applicable.items()})
    for name in (name for name in order.static_order() if name in applicable):
        detector = applicable[name]
        if any(inspection.clearly_detected(other) for other in detector.excluded_by):
            continue
        own_score = detector.score(name, inspection)
        if own_score is not None:
            inspection.scores[name] = own_score
