"""Where along the well a cause begins and ends."""

from dataclasses import replace

import numpy as np
from scipy.special import softmax

from drillid.arrays import Floats
from drillid.discrepancy.inference.coordinates import SHARED, Extension
from drillid.discrepancy.inference.projection import project
from drillid.discrepancy.inference.set_fit import SetFit, fit_set
from drillid.discrepancy.inference.set_model import SetModel
from drillid.discrepancy.rules import INTERVAL_EVIDENCE, PLACE_NEGLIGIBLE, PLACE_TOLERANCE

_LEAST_WINDOWS = 6
"""Windows of a set below which a beginning or an end is not looked for."""
_STEP = PLACE_TOLERANCE / 2


def contiguous_windows(
    model: SetModel, fit: SetFit, extensions: tuple[Extension, ...], index: int, error_rate: float
) -> tuple[int, ...] | None:
    """Rows of the successive windows in which a cause is present; None where it may be present in all.

    About the extended model the size in each window is a linear direction. Of all sequences of successive windows the
    one in which a common size explains most is chosen, if it explains more than a common size in the whole set by a
    margin for noise and for the number of sequences that are tried.

    Parameters
    ----------
    index : of the extension
    """
    windows = model.evidence.windows
    if windows < _LEAST_WINDOWS:
        return None
    order = np.argsort(model.evidence.operating_points.hole_depth, kind="stable")
    response = model.linearised(fit.point, extensions).jacobian[:, SHARED + index]
    directions = np.zeros((windows, windows, response.shape[-1]), dtype=complex)
    directions[np.arange(windows), np.arange(windows)] = response
    projection = project(model, fit, extensions, directions, without=index)
    information = projection.information
    score = projection.score + information @ np.full(windows, fit.point.sizes[index])
    best, largest, of_all = (0, windows), -np.inf, _explained(score, information, np.ones(windows))
    for first in range(windows):
        for last in range(first + 1, windows + 1):
            mask = np.zeros(windows)
            mask[order[first:last]] = 1.0
            explained = _explained(score, information, mask)
            if explained > largest:
                best, largest = (first, last), explained
    price = INTERVAL_EVIDENCE + np.log(windows * (windows + 1) / 2) - np.log(error_rate)
    if largest - of_all < price:
        return None
    return tuple(sorted(int(row) for row in order[best[0] : best[1]]))


def _explained(score: Floats, information: Floats, mask: Floats) -> float:
    """Log-likelihood that a common size in the masked windows explains."""
    return float((mask @ score) ** 2) / max(float(mask @ information @ mask), 1e-300) / 2


def place_probability(model: SetModel, fit: SetFit, extensions: tuple[Extension, ...], index: int) -> float:
    """Posterior probability that a cause sits within `PLACE_TOLERANCE` of its best fit's place, with a uniform prior.

    At each place all other coordinates are fitted, starting from the optimum of the neighbouring place, and integrated
    out by Laplace's approximation (Kass and Raftery 1995).

    Parameters
    ----------
    index : of the extension, whose shape is its place along the pipe
    """
    log_posterior = {0: fit.mass}
    for side in (-1, 1):
        steps, neighbour = side, fit
        while (elsewhere := _moved(extensions, index, steps * _STEP)) is not None:
            neighbour = fit_set(model, neighbour.point, elsewhere, fit.cost + PLACE_NEGLIGIBLE)
            log_posterior[steps] = neighbour.mass
            steps += side
    within = np.abs(list(log_posterior)) * _STEP <= PLACE_TOLERANCE
    return float(softmax(list(log_posterior.values()))[within].sum())


def _moved(extensions: tuple[Extension, ...], index: int, distance: float) -> tuple[Extension, ...] | None:
    """The extensions with one of them moved along the pipe, by a share of its length; None beyond its ends."""
    extension = extensions[index]
    shape = extension.shape + distance
    if not min(extension.cause.shapes) <= shape <= max(extension.cause.shapes):
        return None
    return (*extensions[:index], replace(extension, shape=shape), *extensions[index + 1 :])
