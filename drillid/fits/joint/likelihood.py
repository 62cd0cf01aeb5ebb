"""Likelihoods of windows as functions of their states, and the states of largest posterior density."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from drillid.arrays import Floats
from drillid.fits.joint.change_points import Track
from drillid.fits.joint.coordinates import LEAST, MOST, SIZE, WALKING, Levels, to_parameters
from drillid.fits.joint.smoother import Gaussian, smoothed
from drillid.fits.window_fit import Measured
from drillid.physics.eight_parameters import KnownEquipment, command_mobility_with_derivatives
from drillid.physics.responses import laplace

_ITERATIONS = 40
_HALVINGS = 12
_SETTLED = 1e-5
"""Fall of half the sum of squares below which the optimum is found."""


class Windows:
    """Windows with what is known of each.

    Parameters
    ----------
    measured, known : of each window
    bit_depth : shape (window,), m
    share : share of each window's samples that no other window counts, shape (window,); 1 where not given
    """

    def __init__(
        self,
        measured: Sequence[Measured],
        known: Sequence[KnownEquipment],
        bit_depth: Floats,
        share: Floats | None = None,
    ) -> None:
        self.measured, self.known = measured, known
        self.bit_depth = np.asarray(bit_depth, dtype=float)
        self.logged_length = self.bit_depth - [equipment.collar_length for equipment in known]
        self.share = np.ones(self.bit_depth.size) if share is None else share

    def terms(self, states: Floats) -> tuple[Floats, Floats, Floats]:
        """Half the sum of squares (window,), its gradient (window, 9) and Gauss–Newton Hessian (window, 9, 9)."""
        values, slopes = to_parameters(states, self.logged_length)
        cost, gradient = np.zeros(len(states)), np.zeros((len(states), SIZE))
        hessian = np.zeros((len(states), SIZE, SIZE))
        for row, (measured, known) in enumerate(zip(self.measured, self.known, strict=True)):
            if not measured.frequency.size:
                continue
            s = laplace(measured.frequency)
            mobility, derivatives = command_mobility_with_derivatives(values[row], known, s)
            error = (mobility - measured.mobility) * measured.weight
            rows = slopes[row].T @ (derivatives * measured.weight)
            stacked = np.concatenate([rows.real, rows.imag], axis=-1)
            cost[row] = 0.5 * np.sum(np.abs(error) ** 2)
            gradient[row] = stacked @ np.concatenate([error.real, error.imag])
            hessian[row] = stacked @ stacked.T
        return self.share * cost, self.share[:, None] * gradient, self.share[:, None, None] * hessian


@dataclass(frozen=True)
class Mode:
    """States (window, 9) with the windows' terms there."""

    states: Floats
    terms: tuple[Floats, Floats, Floats]

    def factors(self, weight: Floats) -> Gaussian:
        """Likelihoods expanded to second order, each raised to its weight (window,)."""
        cost, gradient, hessian = self.terms
        return Gaussian.expanded(
            self.states, weight * cost, weight[:, None] * gradient, weight[:, None, None] * hessian
        )


def posterior_mode(windows: Windows, states: Floats, track: Track, weight: Floats, known_state: Levels) -> Mode:
    """States of largest posterior density, by Gauss–Newton with halved steps from given states."""
    steps = track.steps
    mode = Mode(states, windows.terms(states))
    height = _objective(mode, weight, steps, known_state)
    for _ in range(_ITERATIONS):
        target = smoothed(track.prior, mode.factors(weight), steps).moments()[0]
        target[:, len(WALKING) :] = target[0, len(WALKING) :]
        for halving in range(_HALVINGS):
            trial_states = mode.states + 0.5**halving * (target - mode.states)
            trial_states[:, : len(WALKING)] = np.clip(trial_states[:, : len(WALKING)], LEAST, MOST)
            trial = Mode(trial_states, windows.terms(trial_states))
            fall = height - _objective(trial, weight, steps, known_state)
            if fall > 0:
                mode, height = trial, height - fall
                break
        if fall < _SETTLED:
            break
    return mode


def _objective(mode: Mode, weight: Floats, steps: Floats, known_state: Levels) -> float:
    """Half the sum of squares, of data, walks and prior."""
    walked = np.diff(mode.states[:, : len(WALKING)], axis=0) ** 2 / steps
    pulls = (mode.states[0] - known_state.mean) / known_state.deviation
    return float(weight @ mode.terms[0] + 0.5 * np.sum(walked) + 0.5 * np.sum(pulls**2))
