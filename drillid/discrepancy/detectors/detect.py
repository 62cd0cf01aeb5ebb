"""Detections in a window's own record of causes that its linear response does not show, or shows late.

Every detection is a test of what a cause would add to the record, against noise as it is there. Causes that add alike
are told apart by taking them up one after the other: the plainest first, the others then beside it.
"""

from dataclasses import replace

import numpy as np

from drillid.arrays import Floats
from drillid.discrepancy.detectors.change import along_the_way, time_candidates, trend_candidate
from drillid.discrepancy.detectors.detection import Detection
from drillid.discrepancy.detectors.drive import drive_candidates, jitter_score
from drillid.discrepancy.detectors.motion import Motion, backlash_score, standing_score, string_candidates
from drillid.discrepancy.detectors.recorder import (
    beside_neighbours,
    control_scores,
    quantisation_score,
    revolution_candidate,
)
from drillid.discrepancy.detectors.residual_record import ResidualRecord, WindowRecord, without_steps
from drillid.discrepancy.detectors.score import Candidate, Score, score, whitened, without
from drillid.discrepancy.detectors.tone import strongest_line, tone_score

_PLAIN = 4.0
"""Score from which a cause is taken up before the others are judged."""


def read_detections(record: WindowRecord, window: int = 0) -> tuple[Detection, ...]:
    """Detections of all causes and symptoms that this window's record can tell, at most one of each.

    A cause that the record cannot tell, as where it has no place in it, has no detection.

    Parameters
    ----------
    window : number of the window in its set
    """
    residual = without_steps(ResidualRecord(record))
    motion = Motion(residual)
    candidates = [
        *drive_candidates(residual),
        *time_candidates(residual),
        *string_candidates(residual, motion),
        revolution_candidate(residual),
    ]
    scores = _one_after_the_other([whitened(one, residual) for one in candidates], residual)
    if "once_per_revolution" in scores:
        scores["once_per_revolution"] = beside_neighbours(residual, scores["once_per_revolution"])
    scores = along_the_way(scores, residual)
    explained = sum((_explained(one, scores) for one in candidates), np.zeros(residual.samples))
    left = residual.left - residual.without_sweep(explained)
    line = strongest_line(residual)
    tone, trend = tone_score(residual, line), trend_candidate(residual)
    # the torque of a rig that swings in a limit cycle has turning points that look like play
    cycles = line is not None and _is_plain(line.score) and tone is None
    rounded, loose = quantisation_score(residual), None if cycles else backlash_score(residual, motion)
    alone = {
        **(control_scores(residual) if record.has_command else {}),
        "trend": None if trend is None else score(whitened(trend, residual), residual.error, residual),
        "aliased_tone": tone_score(residual, strongest_line(residual, explained)) if explained.any() else tone,
        "line": None if line is None else line.score,
        "quantisation": rounded,
        # coarse steps and teeth that meet are noise that grows with the sweep, as jitter is
        "delay_jitter": None if rounded or _is_plain(loose) else jitter_score(residual, left),
        "gear_backlash": loose,
        "stuck_slip_regimes": standing_score(residual, motion),
    }
    scores |= {cause: found for cause, found in alone.items() if found is not None}
    return tuple(
        Detection(
            cause,
            window,
            found.normal,
            found.size,
            found.size_error,
            found.log_ratio,
            found.misfit,
            found.by_shape,
            found.apart,
            found.lines,
        )
        for cause, found in scores.items()
    )


def _is_plain(found: Score | None) -> bool:
    return found is not None and found.normal >= _PLAIN


def _explained(candidate: Candidate, scores: dict[str, Score]) -> Floats:
    """Speed (samples,) that a plain cause accounts for, rad/s."""
    found = scores.get(candidate.cause)
    if found is None or not _is_plain(found):
        return np.zeros(candidate.columns.shape[1])
    return np.asarray(found.amplitudes @ candidate.columns, dtype=float)


def _one_after_the_other(candidates: list[Candidate], residual: ResidualRecord) -> dict[str, Score]:
    """Scores by cause; each plain one is taken out of the record and of the others before those are judged."""
    error, waiting = residual.error, list(candidates)
    scores: dict[str, Score] = {}
    while waiting:
        found = [(one, score(one, error, residual)) for one in waiting]
        told = [(one, value) for one, value in found if value is not None]
        if not told:
            break
        first, best = max(told, key=lambda pair: pair[1].normal)
        if best.normal < _PLAIN:
            return scores | {one.cause: value for one, value in told}
        scores[first.cause] = best
        taken = first.columns if first.together else first.columns[best.amplitudes != 0]
        error = without(error[None], taken)[0]
        waiting = [replace(one, columns=without(one.columns, taken)) for one in waiting if one is not first]
    return scores
