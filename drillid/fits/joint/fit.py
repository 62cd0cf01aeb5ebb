"""All windows of a well fitted together: what cannot change is shared, the rest walks with depth or jumps."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np
from scipy.special import chdtrc, chdtri

from drillid.arrays import Floats
from drillid.errors import EstimationError
from drillid.fits.joint.change_points import Change, Track, dated, probable_walks, strongest_jumps
from drillid.fits.joint.coordinates import (
    FIRST_GAIN,
    LOGARITHMIC,
    OWN,
    SHARED_SCALES,
    WALKING,
    Levels,
    levels,
    shared_figures,
    to_parameters,
    to_state,
)
from drillid.fits.joint.likelihood import Mode, Windows, posterior_mode
from drillid.fits.joint.smoother import Gaussian, smoothed
from drillid.fits.window_fit import Measured, Prior
from drillid.physics.eight_parameters import KnownEquipment
from drillid.physics.parameters import BOUNDS, LENGTH, PARAMETERS
from drillid.statistics import TWO_SIDED, expected_ratio, sum_of_ratios_probability

if TYPE_CHECKING:
    from drillid.config.settings import FitsSettings


_FIRST_WALK = 0.1
_ROUNDS = 12
_MOST_CHANGES = 40


@dataclass(frozen=True)
class JointFit:
    """Result for all windows; values, errors and 95 % bands have shape (window, 8), SI.

    Bands are even in the logarithm for δ and J_bha, and in the value for all others: the response
    is nearly linear in κ and Y_bha, however large their errors.

    shared, shared_error : as `SHARED`, SI, shape (5,)
    gains, gains_error : of the control, P N m s/rad and I N m/rad, shape (2,)
    walks : rms change of the walking coordinates over 100 m, shape (4,)
    weight : share of each window's information that was used; below 1 where it contradicts the others
    agreement : p-value of the window's distance from the common fit
    log_evidence : of the data given the walks and changes, comparable between models of the same windows
    logged_length : bit depth less the collars, shape (window,), m
    track : what the windows say about their states, from which the fit can be continued
    """

    value: Floats
    error: Floats
    lower: Floats
    upper: Floats
    shared: Floats
    shared_error: Floats
    gains: Floats
    gains_error: Floats
    walks: Floats
    changes: tuple[Change, ...]
    weight: Floats
    agreement: Floats
    log_evidence: float
    logged_length: Floats
    track: Track


def joint_fit(
    measured: Sequence[Measured],
    known: Sequence[KnownEquipment],
    bit_depth: Floats,
    prior: Prior,
    starts: Floats,
    settings: FitsSettings,
    share: Floats | None = None,
) -> JointFit:
    """Fit of all windows with shared coordinates, walks with depth and jumps.

    The optimum is found by Gauss–Newton steps over all windows at once, whose systems a
    smoother solves in a time linear in the windows. Walks and jumps follow from the evidence by
    Laplace's approximation at the optimum. A window whose gradient or residuals there are
    larger than the error rate allows is given less weight, as with Huber's function.

    Parameters
    ----------
    measured, known : of each window in order of time
    bit_depth : shape (window,), m
    prior : the rig's data sheets; of the parameters that all windows share
    starts : fits of the single windows, shape (window, 8), SI; NaN where there is none
    share : share with which each window counts, overlaps being split among windows, shape (window,); 1 by default

    Raises
    ------
    EstimationError
        If no window has a fit to start from.
    """
    windows = Windows(measured, known, bit_depth, share, prior.gains)
    known_state = prior_levels(prior, known, settings)
    states = _first_states(windows, starts)
    weight = np.ones(len(states))
    track = Track(
        known_state.density(),
        Gaussian.expanded(states, *windows.terms(states)),
        windows.bit_depth,
        np.full(len(WALKING), _FIRST_WALK),
        (),
    )
    for _ in range(_MOST_CHANGES):
        mode, track, weight = _settled(windows, states, track, weight, known_state, settings.error_rate)
        states = mode.states
        jumps = strongest_jumps(track, settings.change_error_rate)
        if not jumps:
            break
        track = replace(track, jumps=(*track.jumps, *jumps))
    return _result(windows, mode, track, weight, known_state, settings)


def prior_levels(prior: Prior, known: Sequence[KnownEquipment], settings: FitsSettings) -> Levels:
    """Prior of the first window's state; without collars on the data sheets, the offset allows for them too."""
    stated = np.isfinite(prior.value[LENGTH])
    factor_error = prior.error[LENGTH] / prior.value[LENGTH] if stated else settings.length_factor_error
    listed = all(equipment.collar_length > 0 for equipment in known)
    offset = settings.length_offset_m if listed else settings.collars_offset_m
    return levels(prior.value, prior.error, float(factor_error), offset)


def _first_states(windows: Windows, starts: Floats) -> Floats:
    """All windows at the median of their own fits, so that a few bad ones do no harm."""
    fitted = np.isfinite(starts).all(axis=1)
    if not fitted.any():
        raise EstimationError(
            "joint fit", "no window has a fit of its own to start from", "See why the fits were refused"
        )
    factor = float(np.median(starts[fitted, LENGTH] / windows.logged_length[fitted]))
    return np.tile(to_state(np.median(starts[fitted], axis=0), factor, 0.0), (len(starts), 1))


def _settled(
    windows: Windows, states: Floats, track: Track, weight: Floats, known_state: Levels, error_rate: float
) -> tuple[Mode, Track, Floats]:
    """Optimum, walks and weights, found in turn until they settle."""
    mode = posterior_mode(windows, states, track, weight, known_state)
    for _ in range(_ROUNDS):
        track = replace(track, factors=mode.factors(weight))
        walks = probable_walks(track)
        heavier = _weights(windows, mode, known_state, error_rate)[0]
        same = np.array_equal(walks, track.walks) and np.allclose(heavier, weight, atol=1e-3)
        track, weight = replace(track, walks=walks), heavier
        if same:
            break
        mode = posterior_mode(windows, mode.states, track, weight, known_state)
    return mode, replace(track, factors=mode.factors(weight)), weight


def _weights(windows: Windows, mode: Mode, known_state: Levels, error_rate: float) -> tuple[Floats, Floats]:
    """Weight of each window and the p-value of its distance, each (window,).

    The gain that a window would have from coordinates of its own follows χ² with eight degrees of
    freedom at most; its residuals are judged as those of a single fit. Both bounds hold for
    all windows together.
    """
    _, gradient, hessian = mode.terms
    ridge = 1 / np.where(np.isfinite(known_state.deviation), known_state.deviation, 1e3)[OWN] ** 2
    own = hessian[:, OWN[:, None], OWN] + np.diag(ridge)
    gain = np.vecdot(gradient[:, OWN], np.linalg.solve(own, gradient[:, OWN, None])[..., 0]) / windows.share
    bound = float(chdtri(OWN.size, error_rate / len(gain)))
    weight = np.minimum(1.0, bound / np.maximum(gain, 1e-300))
    for row, measured in enumerate(windows.measured):
        ratio = expected_ratio(measured.degrees_of_freedom)
        total = 2 * mode.terms[0][row] / windows.share[row]
        if not measured.frequency.size:
            continue
        p_value = sum_of_ratios_probability(
            float(np.mean(ratio)) * total / 2, measured.degrees_of_freedom, measured.sharing, fitted=0.0
        )
        if p_value < error_rate / len(gain):
            weight[row] *= 2 * measured.frequency.size / total
    return weight, np.asarray(chdtrc(OWN.size, gain), dtype=float)


def _result(
    windows: Windows, mode: Mode, track: Track, weight: Floats, known_state: Levels, settings: FitsSettings
) -> JointFit:
    posterior = smoothed(track.prior, track.factors, track.steps)
    covariance = posterior.moments()[1]
    deviation = np.sqrt(np.diagonal(covariance, axis1=1, axis2=2))
    value, slopes = to_parameters(mode.states, windows.logged_length)
    error = np.sqrt(np.einsum("wis,wst,wit->wi", slopes, covariance, slopes))
    ends = [value - TWO_SIDED * error, value + TWO_SIDED * error]
    for end, sign in zip(ends, (-1, 1), strict=True):
        reached = mode.states + sign * TWO_SIDED * deviation
        end[:, LOGARITHMIC] = to_parameters(reached, windows.logged_length)[0][:, LOGARITHMIC]
    lower, upper = (np.clip(end, *_PHYSICAL) for end in ends)
    controller = windows.known[0].controller
    known_gains = np.array([controller.proportional, controller.integral])
    return JointFit(
        np.clip(value, *_PHYSICAL),
        error,
        lower,
        upper,
        shared_figures(mode.states[0]),
        deviation[0, len(WALKING) : FIRST_GAIN] * SHARED_SCALES,
        known_gains * (1 + windows.gains * mode.states[0, FIRST_GAIN:]),
        known_gains * windows.gains * deviation[0, FIRST_GAIN:],
        track.walks,
        dated(track),
        weight,
        _weights(windows, mode, known_state, settings.error_rate)[1],
        float(posterior[-1].log_integral()),
        windows.logged_length,
        track,
    )


_PHYSICAL = np.where(np.arange(len(PARAMETERS)) == LENGTH, [[0.0], [np.inf]], BOUNDS)
"""Physical limits of all values and bands, shape (2, 8)."""
