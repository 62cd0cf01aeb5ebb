"""How surely a cause sits where along the string its best fit has it."""

from dataclasses import replace

import numpy as np
from scipy.special import softmax

from drillid.discrepancy.set_fit import SetFit, fit_set
from drillid.discrepancy.set_model import Extension, SetModel

WITHIN = 0.05
"""Share of the pipe's length about its true place within which a stated one is to lie."""
_STEP = WITHIN / 2
_NEGLIGIBLE = 12.0
"""Cost above the best place's from which another counts for nothing, in units of log-likelihood."""


def surely_placed(model: SetModel, fit: SetFit, extensions: tuple[Extension, ...], place: int) -> float:
    """Probability that a cause sits within `WITHIN` of its best fit's place, all places being as likely beforehand.

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
            near = fit_set(model, near.point, elsewhere, fit.cost + _NEGLIGIBLE)
            beliefs[steps] = _log_belief(near)
            steps += side
    near_enough = np.abs(list(beliefs)) * _STEP <= WITHIN
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
