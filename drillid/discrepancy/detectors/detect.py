"""Signs in a window's own record of causes that its linear response does not show, or shows late.

Every sign is a test of what a cause would add to the record, against noise as it is there. Causes that add alike are
told apart by taking them up one after the other: the plainest first, the others then beside it.
"""

from dataclasses import replace

import numpy as np

from drillid.arrays import Floats
from drillid.discrepancy.detectors.change import along_the_way, time_candidates, trend_candidate
from drillid.discrepancy.detectors.detection import Sign
from drillid.discrepancy.detectors.drive import drive_candidates, jitter_score
from drillid.discrepancy.detectors.motion import Motion, backlash_score, standing_score, string_candidates
from drillid.discrepancy.detectors.recorder import (
    beside_neighbours,
    control_scores,
    quantisation_score,
    revolution_candidate,
)
from drillid.discrepancy.detectors.residual_record import Remainder, WindowRecord, without_steps
from drillid.discrepancy.detectors.score import Candidate, Score, score, whitened, without
from drillid.discrepancy.detectors.tone import strongest_line, tone_score

__all__ = ["WindowRecord", "read_signs"]


_PLAIN = 4.0
"""Score from which a cause is taken up before the others are judged."""


def read_signs(record: WindowRecord, window: int = 0) -> tuple[Sign, ...]:
    """Signs of all causes and symptoms that this window's record can tell, at most one of each.

    A cause that the record cannot tell, as where it has no place in it, has no sign.

    Parameters
    ----------
    window : number of the window in its set
    """
    remainder = without_steps(Remainder(record))
    motion = Motion(remainder)
    candidates = [
        *drive_candidates(remainder),
        *time_candidates(remainder),
        *string_candidates(remainder, motion),
        revolution_candidate(remainder),
    ]
    scores = _one_after_the_other([whitened(one, remainder) for one in candidates], remainder)
    if "once_per_revolution" in scores:
        scores["once_per_revolution"] = beside_neighbours(remainder, scores["once_per_revolution"])
    scores = along_the_way(scores, remainder)
    explained = sum((_explained(one, scores) for one in candidates), np.zeros(remainder.samples))
    left = remainder.left - remainder.without_sweep(explained)
    line = strongest_line(remainder)
    tone, trend = tone_score(remainder, line), trend_candidate(remainder)
    # the torque of a rig that swings in a limit cycle has turning points that look like play
    cycles = line is not None and _is_plain(line.score) and tone is None
    rounded, loose = quantisation_score(remainder), None if cycles else backlash_score(remainder, motion)
    alone = {
        **(control_scores(remainder) if record.has_command else {}),
        "trend": None if trend is None else score(whitened(trend, remainder), remainder.error, remainder),
        "aliased_tone": tone_score(remainder, strongest_line(remainder, explained)) if explained.any() else tone,
        "line": None if line is None else line.score,
        "quantisation": rounded,
        # coarse steps and teeth that meet are noise that grows with the sweep, as jitter is
        "delay_jitter": None if rounded or _is_plain(loose) else jitter_score(remainder, left),
        "gear_backlash": loose,
        "stuck_slip_regimes": standing_score(remainder, motion),
    }
    scores |= {cause: found for cause, found in alone.items() if found is not None}
    return tuple(
        Sign(
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


def _one_after_the_other(candidates: list[Candidate], remainder: Remainder) -> dict[str, Score]:
    """Scores by cause; each plain one is taken out of the record and of the others before those are judged."""
    error, waiting = remainder.error, list(candidates)
    scores: dict[str, Score] = {}
    while waiting:
        found = [(one, score(one, error, remainder)) for one in waiting]
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
