"""Where along the well a cause begins and ends."""

import numpy as np
from numpy.typing import NDArray

from drillid.discrepancy.distinguish import project
from drillid.discrepancy.set_fit import SetFit
from drillid.discrepancy.set_model import Extension, SetModel

Floats = NDArray[np.float64]

_LEAST_WINDOWS = 6
"""Windows of a set below which a beginning or an end is not looked for."""
_LEAST_GAIN = 3.0
"""Units of log-likelihood that a beginning and an end must bring, beside the logarithm of the places tried."""


def stretch(
    model: SetModel, fit: SetFit, extensions: tuple[Extension, ...], place: int, error_rate: float
) -> tuple[int, ...] | None:
    """Rows between which a cause is present; None where it may be present in all.

    About the extended model each window's own size is a linear direction. Of all stretches the one is taken in
    which a common size explains most, if it explains more than the whole set by what chance and search allow.

    Parameters
    ----------
    place : number of the extension
    """
    windows = model.evidence.windows
    if windows < _LEAST_WINDOWS:
        return None
    order = np.argsort(model.evidence.conditions.hole_depth, kind="stable")
    response = model.linearised(fit.point, extensions).jacobian[:, -len(extensions) + place]
    each = np.zeros((windows, windows, response.shape[-1]), dtype=complex)
    each[np.arange(windows), np.arange(windows)] = response
    projection = project(model, fit, extensions, each, without=place)
    information = projection.information
    score = projection.score + information @ np.full(windows, fit.point.sizes[place])
    best, value, whole = (0, windows), -np.inf, _explained(score, information, np.ones(windows))
    for first in range(windows):
        for last in range(first + 1, windows + 1):
            mask = np.zeros(windows)
            mask[order[first:last]] = 1.0
            explained = _explained(score, information, mask)
            if explained > value:
                best, value = (first, last), explained
    price = _LEAST_GAIN + np.log(windows * (windows + 1) / 2) - np.log(error_rate)
    if value - whole < price:
        return None
    return tuple(sorted(int(row) for row in order[best[0] : best[1]]))


def _explained(score: Floats, information: Floats, mask: Floats) -> float:
    """Log-likelihood that a common size in the masked windows explains."""
    return float((mask @ score) ** 2) / max(float(mask @ information @ mask), 1e-300) / 2
