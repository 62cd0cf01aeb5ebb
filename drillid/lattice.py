"""Steps of a recorded channel: the last digit that its recorder writes."""

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

_REPEATED = 3
"""Times that a value must occur to count as a step and not as chance."""
_TOLERANCE = 0.02
"""Of a step."""
_ON_LATTICE = 0.8
"""Share of samples that must lie on whole steps; interpolated rows do not."""


def lattice_step(values: Floats) -> float | None:
    """Step of which nearly all values are whole multiples, from a common origin; None where there is none."""
    found, counts = np.unique(values, return_counts=True)
    often = found[counts >= _REPEATED]
    if often.size < 2 or counts[counts >= _REPEATED].sum() < _ON_LATTICE * values.size:
        return None
    apart = np.diff(often)
    apart = apart[apart > 1e-9 * np.abs(often).max()]
    if apart.size == 0:
        return None
    least = float(apart.min())
    step = float(np.sum(apart) / np.sum(np.rint(apart / least)))
    place = (values - often[0]) / step
    return step if np.mean(np.abs(place - np.rint(place)) < _TOLERANCE) >= _ON_LATTICE else None
