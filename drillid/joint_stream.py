"""A joint fit carried on night by night: what all windows so far say, and one window more.

The state after a window is all that the following ones need of those before. Carrying it on
costs one window's work however long the well is, and gives what the fit of all windows
together gives for the newest one, at the same walks and changes.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.special import chdtrc

from drillid.change_points import USUAL_JUMP, walked_distance
from drillid.estimation import Measured
from drillid.joint import JointFit
from drillid.joint_coordinates import LEAST, MOST, WALKING, shared_figures, to_parameters
from drillid.joint_likelihood import Windows
from drillid.physics.model import KnownEquipment
from drillid.smoother import Gaussian, forward

Floats = NDArray[np.float64]

_ITERATIONS = 30
_HALVINGS = 12
_SETTLED = 1e-6


@dataclass(frozen=True)
class Latest:
    """What all windows up to the newest say of its state.

    state : normalised density of the state
    walks : rms change of the walking figures over 100 m, shape (4,)
    """

    state: Gaussian
    bit_depth: float
    logged_length: float
    walks: Floats

    @staticmethod
    def of(fit: JointFit) -> Latest:
        """After the last window of a joint fit."""
        track = fit.track
        state = forward(track.prior, track.factors, track.steps)[-1]
        return Latest(normalised(state), float(track.bit_depth[-1]), float(fit.logged_length[-1]), track.walks)

    @property
    def parameters(self) -> tuple[Floats, Floats]:
        """Values and standard errors of the newest window, each (8,), SI."""
        mean, covariance = self.state.moments()
        values, slopes = to_parameters(mean, np.asarray(self.logged_length))
        return values, np.sqrt(np.einsum("is,st,it->i", slopes, covariance, slopes))

    @property
    def shared(self) -> Floats:
        """Shared figures, SI, shape (5,)."""
        return shared_figures(self.state.moments()[0])


@dataclass(frozen=True)
class Carried:
    """The state after one window more.

    log_gains : logarithm of the evidence with a jump of each walking figure above this window over
        that without, shape (4,); more than ln(4/α) has a chance of at most α where nothing jumped
    agreement : chance that a window of the same string is so far from what was expected
    """

    latest: Latest
    log_gains: Floats
    agreement: float


def carried_on(latest: Latest, measured: Measured, known: KnownEquipment, bit_depth: float) -> Carried:
    """Add the next window, found by Gauss–Newton steps from what the windows before let expect.

    Raises nothing; a window that contradicts the others shows in `agreement` and is the caller's to leave out.
    """
    window = Windows([measured], [known], np.array([bit_depth]))
    variance = walked_distance(np.array([latest.bit_depth, bit_depth])) * latest.walks**2
    expected = latest.state.walked(variance)
    mean = expected.moments()[0]
    factor = _factor(window, expected, mean)
    state = expected * factor
    leaps = variance + np.eye(len(WALKING)) * USUAL_JUMP**2
    size = (len(WALKING),)
    before = Gaussian(*(np.broadcast_to(part, (*size, *np.shape(part))) for part in vars(latest.state).values()))
    gains = (before.walked(leaps) * factor).log_integral() - state.log_integral()
    shift = state.moments()[0] - mean
    away = float(np.vecdot(shift, expected.information @ shift))
    carried = Latest(normalised(state), bit_depth, float(window.logged_length[0]), latest.walks)
    return Carried(carried, np.asarray(gains), float(chdtrc(shift.size, away)))


def normalised(state: Gaussian) -> Gaussian:
    """With integral one."""
    return Gaussian(state.information, state.vector, np.asarray(state.log_scale - state.log_integral()))


def _factor(window: Windows, expected: Gaussian, mean: Floats) -> Gaussian:
    """Likelihood of one window expanded about the state of largest posterior density."""

    def height(point: Floats, cost: Floats) -> float:
        away = point - mean
        return float(cost[0] + 0.5 * away @ expected.information @ away)

    point = mean
    terms = window.terms(point[None])
    least = height(point, terms[0])
    for _ in range(_ITERATIONS):
        factor = Gaussian.expanded(point[None], *terms)[0]
        step = (expected * factor).moments()[0] - point
        for halving in range(_HALVINGS):
            trial = point + 0.5**halving * step
            trial[: len(WALKING)] = np.clip(trial[: len(WALKING)], LEAST, MOST)
            trial_terms = window.terms(trial[None])
            fall = least - height(trial, trial_terms[0])
            if fall > 0:
                point, terms, least = trial, trial_terms, least - fall
                break
        if fall < _SETTLED:
            break
    return Gaussian.expanded(point[None], *terms)[0]
