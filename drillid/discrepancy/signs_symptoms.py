"""Signs of symptoms: a line in the record, and a response that changes in any smooth way while the window lasts."""

import numpy as np
from numpy.typing import NDArray
from scipy.fft import irfft, rfft

from drillid.discrepancy.signs_record import Remainder
from drillid.discrepancy.signs_score import Candidate, Score, score, whitened
from drillid.discrepancy.signs_sensor import strongest_line
from drillid.discrepancy.unknown import smooth_functions

Floats = NDArray[np.float64]

_FUNCTIONS = 6
"""Smooth functions over the sweep's band that a change of the response is made of, with real and imaginary part."""


def symptom_scores(remainder: Remainder) -> dict[str, Score | None]:
    """Scores by symptom; None where a record cannot tell it."""
    line = strongest_line(remainder, remainder.left)
    return {"line": None if line is None else line.score, "change": _change_score(remainder)}


def _change_score(remainder: Remainder) -> Score | None:
    """Score of a response to the sweep that drifts by any smooth function of frequency; None without periods."""
    if not remainder.periods:
        return None
    band = remainder.frequency[remainder.repeating]
    inside = (remainder.frequency >= band.min()) & (remainder.frequency <= band.max())
    shapes = np.zeros((_FUNCTIONS, remainder.frequency.size))
    shapes[:, inside] = smooth_functions(remainder.frequency[inside], _FUNCTIONS)
    answer = rfft(remainder.sweep - remainder.sweep.mean()) * remainder.mobility
    parts = irfft(np.concatenate([shapes * answer, 1j * shapes * answer]), remainder.samples)
    passed = (np.arange(remainder.samples) + 0.5) / remainder.samples - 0.5
    candidate = whitened(Candidate("change", np.asarray(passed * parts, dtype=float), together=True), remainder)
    return score(candidate, remainder.error, remainder)
