"""Likelihoods of windows as functions of their states, and the states of largest posterior density."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from drillid.arrays import Floats
from drillid.fits.damped import HALVING, JOINT_END, descend
from drillid.fits.joint.change_points import Track
from drillid.fits.joint.coordinates import FIRST_GAIN, LEAST, MOST, SIZE, WALKING, Levels, to_parameters
from drillid.fits.joint.smoother import Gaussian, smoothed
from drillid.fits.window_fit import Measured
from drillid.physics.eight_parameters import KnownEquipment, command_mobility_with_derivatives
from drillid.physics.responses import laplace
from drillid.physics.top_drive import gain_responses


class Windows:
    """Windows with what is known of each.

    Parameters
    ----------
    measured, known : of each window
    bit_depth : shape (window,), m
    share : share of each window's samples that no other window counts, shape (window,); 1 where not given
    gains : relative standard uncertainty of the control's P and I, (2,); exact where not given
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

    def terms(self, states: Floats) -> tuple[Floats, Floats, Floats]:
        """Half the sum of squares (window,), its gradient (window, 11) and Gauss–Newton Hessian (window, 11, 11)."""
        values, slopes = to_parameters(states, self.logged_length)
        cost, gradient = np.zeros(len(states)), np.zeros((len(states), SIZE))
        hessian = np.zeros((len(states), SIZE, SIZE))
        for row, (measured, known) in enumerate(zip(self.measured, self.known, strict=True)):
            if not measured.frequency.size:
                continue
            s = laplace(measured.frequency)
            mobility, derivatives = command_mobility_with_derivatives(values[row], known, s)
            by_gain = gain_responses(known.controller, s) * self.gains[:, None]
            # 1/M = 1/M₀ + ΔA, with M₀ under the known gains
            ratio = 1 / (1 + mobility * (states[row, FIRST_GAIN:] @ by_gain))
            mobility, derivatives = mobility * ratio, derivatives * ratio**2
            error = (mobility - measured.mobility) * measured.weight
            rows = slopes[row].T @ (derivatives * measured.weight)
            rows[FIRST_GAIN:] = -(mobility**2) * by_gain * measured.weight
            stacked = np.concatenate([rows.real, rows.imag], axis=-1)
            cost[row] = 0.5 * np.sum(np.abs(error) ** 2)
            gradient[row] = stacked @ np.concatenate([error.real, error.imag])
            hessian[row] = stacked @ stacked.T
        return self.share * cost, self.share[:, None] * gradient, self.share[:, None, None] * hessian


@dataclass(frozen=True)
class Mode:
    """States (window, 11) with the windows' terms there."""

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

    What walks stays within its bounds.
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
            fall = mode.cost - cost(moved, terms[0])  # which carries the cost on
            return Mode(moved, terms, mode.cost - fall)

        return shortened

    terms = windows.terms(states)
    return descend(Mode(states, terms, cost(states, terms[0])), steps_from, HALVING, JOINT_END)
