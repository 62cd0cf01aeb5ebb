"""Likelihoods of windows as functions of their states, and the states of largest posterior density."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from drillid.arrays import Floats
from drillid.fits.damped import HALVING, JOINT_END, descend
from drillid.fits.joint.change_points import Track
from drillid.fits.joint.coordinates import FIRST_GAIN, LEAST, MOST, SIZE, WALKING, Levels, to_parameters
from drillid.fits.joint.smoother import Gaussian, smoothed
from drillid.fits.likelihood import Data, curvature
from drillid.fits.search import to_scaled
from drillid.fits.window_fit import Measured, Prior, likelihood
from drillid.physics.eight_parameters import KnownEquipment
from drillid.physics.parameters import DELTA, SCALES


class Windows:
    """Windows with what is known of each; those without frequencies, or with some that have no noise, say nothing.

    Parameters
    ----------
    measured, known : of each window
    bit_depth : shape (window,), m
    share : share with which each window counts, overlaps being split among windows, shape (window,); 1 by default
    gains : relative standard uncertainty of the control's P and I, (2,); exact by default
    """

    def __init__(
        self,
        measured: Sequence[Measured],
        known: Sequence[KnownEquipment],
        bit_depth: Floats,
        share: Floats | None = None,
        gains: Floats | None = None,
    ) -> None:
        self.measured, self.known = measured, known
        self.gains = np.zeros(2) if gains is None else gains
        self.bit_depth = np.asarray(bit_depth, dtype=float)
        self.logged_length = self.bit_depth - [equipment.collar_length for equipment in known]
        self.share = np.ones(self.bit_depth.size) if share is None else share
        prior = replace(Prior.silent(), gains=self.gains)
        self._data = [
            _data(each, equipment, prior) if each.informs else None
            for each, equipment in zip(measured, known, strict=True)
        ]

    def terms(self, states: Floats) -> tuple[Floats, Floats, Floats]:
        """Half the sum of squares (window,), its gradient (window, 11) and Gauss–Newton Hessian (window, 11, 11)."""
        values, slopes = to_parameters(states, self.logged_length)
        points, slopes = to_scaled(values), slopes / SCALES[:, None]
        # internal damping is a logarithm here as in the solver
        slopes[:, DELTA] = np.eye(SIZE)[WALKING.index(DELTA)]
        if self.gains.any():
            by_gains = np.eye(SIZE)[FIRST_GAIN:]
            points = np.concatenate([points, states[:, FIRST_GAIN:]], axis=1)
            slopes = np.concatenate([slopes, np.broadcast_to(by_gains, (len(states), *by_gains.shape))], axis=1)
        cost, gradient = np.zeros(len(states)), np.zeros(points.shape)
        hessian = np.zeros((*points.shape, points.shape[1]))
        for row, data in enumerate(self._data):
            if data is not None:
                cost[row] = curvature(points[row], data, False, gradient[row], hessian[row])
        turned = np.swapaxes(slopes, 1, 2)
        return (
            self.share * cost,
            self.share[:, None] * np.matvec(turned, gradient),
            self.share[:, None, None] * (turned @ hessian @ slopes),
        )


def _data(measured: Measured, known: KnownEquipment, prior: Prior) -> Data:
    """Data for the compiled likelihood, without priors; errors with one degree of freedom or less do not count."""
    data = likelihood(measured, known, prior)
    variance = np.where(data.freedom > 1, data.variance, np.inf)
    return data._replace(variance=variance, prior_weight=np.zeros(data.prior_weight.size))


@dataclass(frozen=True)
class Mode:
    """States (window, 11) with the terms of the windows' likelihoods there."""

    states: Floats
    terms: tuple[Floats, Floats, Floats]
    cost: float
    """Half the sum of squares, of data, walks and prior."""

    def factors(self, weight: Floats) -> Gaussian:
        """Likelihoods expanded to second order, each raised to its weight (window,)."""
        cost, gradient, hessian = self.terms
        return Gaussian.expanded(
            self.states, weight * cost, weight[:, None] * gradient, weight[:, None, None] * hessian
        )


def posterior_mode(windows: Windows, states: Floats, track: Track, weight: Floats, known_state: Levels) -> Mode:
    """States of largest posterior density, by Gauss–Newton steps from given states, halved until the cost falls.

    Walking coordinates stay within their bounds.
    """
    variances = track.steps

    def cost(states: Floats, misfits: Floats) -> float:
        walked = np.diff(states[:, : len(WALKING)], axis=0) ** 2 / variances
        pulls = (states[0] - known_state.mean) / known_state.deviation
        return float(weight @ misfits + 0.5 * np.sum(walked) + 0.5 * np.sum(pulls**2))

    def steps_from(mode: Mode) -> Callable[[float], Mode]:
        target = smoothed(track.prior, mode.factors(weight), variances).moments()[0]
        target[:, len(WALKING) :] = target[0, len(WALKING) :]
        step = target - mode.states

        def shortened(divisor: float) -> Mode:
            moved = mode.states + step / divisor
            moved[:, : len(WALKING)] = np.clip(moved[:, : len(WALKING)], LEAST, MOST)
            terms = windows.terms(moved)
            fall = mode.cost - cost(moved, terms[0])  # which gives the new cost below
            return Mode(moved, terms, mode.cost - fall)

        return shortened

    terms = windows.terms(states)
    return descend(Mode(states, terms, cost(states, terms[0])), steps_from, HALVING, JOINT_END)
