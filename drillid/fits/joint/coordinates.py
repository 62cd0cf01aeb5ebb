"""What a joint fit estimates, and how the eight parameters of each window follow from it.

Four coordinates are random walks of depth: κ, δ, and damping and inertia of the BHA. Seven are the same in
all windows: delay, top-drive inertia, polar moment of the pipe, the factor and offset that turn the logged length of
the pipe into the one seen by waves, and both gains of the control, in standard uncertainties about the known values.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from drillid.arrays import Floats
from drillid.fits.joint.smoother import Gaussian
from drillid.physics.parameters import (
    BOUNDS,
    DAMPING_BHA,
    DELAY,
    DELTA,
    INERTIA_BHA,
    INERTIA_TD,
    KAPPA,
    LENGTH,
    PARAMETERS,
    POLAR_MOMENT,
    SCALES,
)

WALKING = (KAPPA, DELTA, DAMPING_BHA, INERTIA_BHA)
"""Parameters that walk with depth, in the order of the state."""
ONCE = (DELAY, INERTIA_TD, POLAR_MOMENT)
"""Parameters that all windows share, in the order of the state, after those that walk."""
SHARED = ("delay", "inertia_td", "polar_moment", "length_factor", "length_offset")
"""Shared coordinates in the order of the state, before the gains."""
GAINS = ("proportional", "integral")
"""Gains of the control, the last coordinates of the state."""
SIZE = len(WALKING) + len(SHARED) + len(GAINS)
FIRST_GAIN = len(WALKING) + len(SHARED)
"""Place of the first gain in the state."""
_FACTOR, _OFFSET = len(WALKING) + 3, len(WALKING) + 4
_OFFSET_SCALE = 10.0
"""m."""
_FROM_ZERO = np.array([1.0, 0.0, 1.0, 0.0])
"""κ and Y_bha may vanish: ln(1 + value/usual) is linear below the usual size and logarithmic above."""
LOGARITHMIC = (DELTA, INERTIA_BHA)
"""Parameters that walk in their logarithm."""
_BELOW_ZERO = 0.5
"""Share of its usual size that κ or Y_bha may go below zero, so that noise about zero has no bias."""
_WALKING_SCALES = SCALES[list(WALKING)]
LEAST = np.log(np.where(_FROM_ZERO > 0, 1 - _BELOW_ZERO, BOUNDS[0, list(WALKING)] / _WALKING_SCALES))
"""Lower bounds of the walking coordinates, shape (4,)."""
MOST = np.log(_FROM_ZERO + BOUNDS[1, list(WALKING)] / _WALKING_SCALES)
"""Upper bounds of the walking coordinates, shape (4,)."""


@dataclass(frozen=True)
class Levels:
    """Prior knowledge: value and standard uncertainty of the state of the first window, shape (11,)."""

    mean: Floats
    deviation: Floats

    def density(self) -> Gaussian:
        """The prior as a Gaussian factor of the first state."""
        return Gaussian.normal(self.mean, self.deviation)


def levels(value: Floats, error: Floats, factor_error: float, offset_error: float) -> Levels:
    """Prior of the state from the data sheets.

    Internal damping is known within a factor of three, κ, Y_bha and J_bha within a factor of
    ten of their usual sizes.

    Parameters
    ----------
    value, error : shape (8,), SI, as `drillid.fits.window_fit.Prior`; of those that are shared
        once, NaN where the data sheets are silent
    factor_error : standard uncertainty of the length's factor about 1
    offset_error : that of its offset about 0, m
    """
    mean, deviation = np.zeros(SIZE), np.full(SIZE, np.inf)
    mean[: len(WALKING)] = np.log(1 + _FROM_ZERO)
    deviation[: len(WALKING)] = np.log(np.where(np.array(WALKING) == DELTA, 3.0, 10.0))
    for place, index in enumerate(ONCE, start=len(WALKING)):
        if np.isfinite(value[index]):
            mean[place], deviation[place] = value[index] / SCALES[index], error[index] / SCALES[index]
    mean[_FACTOR], deviation[_FACTOR] = 1.0, factor_error
    deviation[FIRST_GAIN:] = 1.0
    deviation[_OFFSET] = offset_error / _OFFSET_SCALE
    return Levels(mean, deviation)


def to_state(values: Floats, factor: float, offset: float) -> Floats:
    """State (..., 11) of parameters (..., 8) in SI and the length's factor and offset (m), with the known gains."""
    state = np.zeros((*values.shape[:-1], SIZE))
    sized = np.maximum(values[..., WALKING] / _WALKING_SCALES, np.where(_FROM_ZERO > 0, -_BELOW_ZERO, 1e-12))
    state[..., : len(WALKING)] = np.clip(np.log(_FROM_ZERO + sized), LEAST, MOST)
    state[..., len(WALKING) : _FACTOR] = values[..., ONCE] / SCALES[list(ONCE)]
    state[..., _FACTOR], state[..., _OFFSET] = factor, offset / _OFFSET_SCALE
    return state


def to_parameters(state: Floats, logged_length: Floats) -> tuple[Floats, Floats]:
    """Parameters (..., 8) in SI and their derivatives (..., 8, 11) to the state (..., 11).

    Parameters
    ----------
    logged_length : bit depth less the collars, shape (...), m
    """
    values = np.empty((*state.shape[:-1], len(PARAMETERS)))
    slopes = np.zeros((*values.shape, SIZE))
    grown = np.exp(state[..., : len(WALKING)])
    for place, index in enumerate(WALKING):
        values[..., index] = (grown[..., place] - _FROM_ZERO[place]) * SCALES[index]
        slopes[..., index, place] = grown[..., place] * SCALES[index]
    for place, index in enumerate(ONCE, start=len(WALKING)):
        values[..., index] = state[..., place] * SCALES[index]
        slopes[..., index, place] = SCALES[index]
    values[..., LENGTH] = logged_length * state[..., _FACTOR] + _OFFSET_SCALE * state[..., _OFFSET]
    slopes[..., LENGTH, _FACTOR], slopes[..., LENGTH, _OFFSET] = logged_length, _OFFSET_SCALE
    return values, slopes


def shared_figures(state: Floats) -> Floats:
    """Shared coordinates in SI (delay s, inertia kg m², polar moment m⁴, factor, offset m) of states (..., 11)."""
    return np.asarray(state[..., len(WALKING) : FIRST_GAIN] * SHARED_SCALES)


SHARED_SCALES = np.array([*SCALES[list(ONCE)], 1.0, _OFFSET_SCALE])
"""Shared coordinates in SI per unit of the state, shape (5,)."""
OWN = np.delete(np.arange(FIRST_GAIN), _FACTOR)
"""Directions of the state that one window alone can identify: its length counts once, the gains are the control's."""
