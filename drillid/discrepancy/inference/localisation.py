"""Where along the well a cause begins and ends."""

from dataclasses import replace

import numpy as np
from scipy.special import softmax

from drillid.arrays import Floats
from drillid.discrepancy.inference.projection import project
from drillid.discrepancy.inference.set_fit import SetFit, fit_set
from drillid.discrepancy.inference.set_model import Extension, SetModel
from drillid.discrepancy.rules import INTERVAL_EVIDENCE, PLACE_NEGLIGIBLE, PLACE_TOLERANCE

_LEAST_WINDOWS = 6
"""Windows of a set below which a beginning or an end is not looked for."""

_STEP = PLACE_TOLERANCE / 2


def contiguous_windows(
    model: SetModel, fit: SetFit, extensions: tuple[Extension, ...], place: int, error_rate: float
) -> tuple[int, ...] | None:
    """Rows between which a cause is present; None where it may be present in all.

    About the extended model each window's own size is a linear direction. Of all runs of successive windows the one is
    taken in which a common size explains most, if it explains more than the whole set by what chance and search allow.

    Parameters
    ----------
    place : number of the extension
    """
    windows = model.evidence.windows
    if windows < _LEAST_WINDOWS:
        return None
    order = np.argsort(model.evidence.operating_points.hole_depth, kind="stable")
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
    price = INTERVAL_EVIDENCE + np.log(windows * (windows + 1) / 2) - np.log(error_rate)
    if value - whole < price:
        return None
    return tuple(sorted(int(row) for row in order[best[0] : best[1]]))


def _explained(score: Floats, information: Floats, mask: Floats) -> float:
    """Log-likelihood that a common size in the masked windows explains."""
    return float((mask @ score) ** 2) / max(float(mask @ information @ mask), 1e-300) / 2


def surely_placed(model: SetModel, fit: SetFit, extensions: tuple[Extension, ...], place: int) -> float:
    """Probability that a cause sits near its best fit's place, all places being as likely beforehand.

    Near is within `PLACE_TOLERANCE`.

    At each place all other figures are fitted, from where those of its neighbour came to, and integrated by Laplace's
    approximation (Kass and Raftery 1995).

    Parameters
    ----------
    place : number of the extension whose shape is its place along the pipe
    """
    beliefs = {0: _log_belief(fit)}
    for side in (-1, 1):
        steps, near = side, fit
        while (elsewhere := _moved(extensions, place, steps * _STEP)) is not None:
            near = fit_set(model, near.point, elsewhere, fit.cost + PLACE_NEGLIGIBLE)
            beliefs[steps] = _log_belief(near)
            steps += side
    near_enough = np.abs(list(beliefs)) * _STEP <= PLACE_TOLERANCE
    return float(softmax(list(beliefs.values()))[near_enough].sum())


def _moved(extensions: tuple[Extension, ...], place: int, by: float) -> tuple[Extension, ...] | None:
    """The extensions with one of them further along the string; None beyond its ends."""
    one = extensions[place]
    shape = one.shape + by
    if not min(one.cause.shapes) <= shape <= max(one.cause.shapes):
        return None
    return (*extensions[:place], replace(one, shape=shape), *extensions[place + 1 :])


def _log_belief(fit: SetFit) -> float:
    """Log of the integral over all figures about an optimum, up to a constant."""
    return float(-fit.cost - 0.5 * np.linalg.slogdet(fit.information)[1])
