"""Where along the well a cause begins and ends."""

from collections.abc import Sequence
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


def fits_at_shapes(
    model: SetModel, fit: SetFit, extensions: tuple[Extension, ...], index: int
) -> list[tuple[float, SetFit]]:
    """The fit, and those with one of its causes at other shapes, each with the distance from the fit's own shape.

    At each shape all other coordinates are fitted: at places along the pipe, and shapes as continuous, from the optimum
    at the neighbouring one, else from that of the fit.

    Parameters
    ----------
    index : of the extension
    """
    cause, own = extensions[index].cause, extensions[index].shape
    enough, found = fit.cost + PLACE_NEGLIGIBLE, [(0.0, fit)]
    if cause.shape_step == 0:
        for shape in cause.shapes:
            if shape != own:
                found.append((shape - own, fit_set(model, fit.point, _at(extensions, index, shape), enough)))
        return found
    for step in (-_STEP, _STEP):
        shape, neighbour = own + step, fit
        while min(cause.shapes) <= shape <= max(cause.shapes):
            neighbour = fit_set(model, neighbour.point, _at(extensions, index, shape), enough)
            found.append((shape - own, neighbour))
            shape += step
    return found


def _at(extensions: tuple[Extension, ...], index: int, shape: float) -> tuple[Extension, ...]:
    return (*extensions[:index], replace(extensions[index], shape=shape), *extensions[index + 1 :])


def place_probability(at_places: Sequence[tuple[float, SetFit]]) -> float:
    """Posterior probability that a cause sits within `PLACE_TOLERANCE` of its best fit's place, with a uniform prior;
    all other coordinates are integrated out by Laplace's approximation (Kass and Raftery 1995).

    Parameters
    ----------
    at_places : fits with the cause at all places along the pipe, each with the distance from the best fit's own
    """
    within = np.array([abs(distance) <= PLACE_TOLERANCE + _STEP / 2 for distance, _ in at_places])
    return float(softmax([fit.mass for _, fit in at_places])[within].sum())
