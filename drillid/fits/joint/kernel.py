"""Compiled steps of the joint fit's filter, for Gaussians in information form.

A Gaussian is information (n, n), vector (n,) and the logarithm of its scale, as in `drillid.fits.joint.smoother`.
"""

import math

import numpy as np

from drillid.arrays import Floats
from drillid.fits.likelihood import compiled


@compiled
def walk(information: Floats, vector: Floats, log_scale: float, variance: Floats) -> float:
    """Let the first coordinates make a random step, in place; returns the logarithm of the scale.

    With M their information and Q = R² the variance, the step subtracts [M v]ᵀ R (I + R M R)⁻¹ R [M v], by the
    Cholesky factor of I + R M R, which exists for steps of any size, even where nothing is known.
    """
    size, walking = vector.size, variance.size
    factor, lost = np.empty((walking, walking)), np.empty((walking, size + 1))
    shift = 0.0
    for i in range(walking):
        root = math.sqrt(variance[i])
        for j in range(i + 1):
            total = root * information[i, j] * math.sqrt(variance[j])
            for k in range(j):
                total -= factor[i, k] * factor[j, k]
            factor[i, j] = math.sqrt(1.0 + total) if i == j else total / factor[j, j]
        shift -= math.log(factor[i, i])
        for column in range(size + 1):
            total = root * (information[i, column] if column < size else vector[i])
            for k in range(i):
                total -= factor[i, k] * lost[k, column]
            lost[i, column] = total / factor[i, i]
        shift += 0.5 * lost[i, size] * lost[i, size]
    for i in range(size):
        for k in range(walking):
            vector[i] -= lost[k, i] * lost[k, size]
        for j in range(i + 1):
            total = information[i, j]
            for k in range(walking):
                total -= lost[k, i] * lost[k, j]
            information[i, j] = information[j, i] = total
    return log_scale + shift


@compiled
def log_integral(information: Floats, vector: Floats, log_scale: float) -> float:
    """Logarithm of the integral over all coordinates; −∞ where the information is not positive definite."""
    size = vector.size
    factor, solved = np.empty((size, size)), np.empty(size)
    total_log = log_scale + 0.5 * size * math.log(2.0 * math.pi)
    for i in range(size):
        for j in range(i + 1):
            total = information[i, j]
            for k in range(j):
                total -= factor[i, k] * factor[j, k]
            if i > j:
                factor[i, j] = total / factor[j, j]
            elif total > 0.0:
                factor[i, i] = math.sqrt(total)
            else:
                return -np.inf
        rest = vector[i]
        for k in range(i):
            rest -= factor[i, k] * solved[k]
        solved[i] = rest / factor[i, i]
        total_log += 0.5 * solved[i] * solved[i] - math.log(factor[i, i])
    return total_log


@compiled
def walk_each(information: Floats, vector: Floats, log_scale: Floats, variance: Floats) -> None:
    """Let each of m Gaussians make its step, of variance (m, walking), in place."""
    for row in range(log_scale.size):
        log_scale[row] = walk(information[row], vector[row], log_scale[row], variance[row])


@compiled
def integrate_each(information: Floats, vector: Floats, log_scale: Floats, found: Floats) -> None:
    """Logarithms of the integrals of m Gaussians, (m,)."""
    for row in range(log_scale.size):
        found[row] = log_integral(information[row], vector[row], log_scale[row])


@compiled
def accumulate(
    information: Floats,
    vector: Floats,
    log_scale: Floats,
    steps: Floats,
    gathered: Floats,
    gathered_vector: Floats,
    gathered_scale: Floats,
) -> None:
    """What each factor and all before it say about its state, under every hypothesis.

    Parameters
    ----------
    information, vector, log_scale : factors (W, n, n), (W, n), (W,)
    steps : variances between successive ones, (W − 1, hypothesis, walking)
    gathered, gathered_vector, gathered_scale : (W, hypothesis, …), filled
    """
    windows, size = vector.shape
    for hypothesis in range(gathered_scale.shape[1]):
        state, pull, scale = information[0].copy(), vector[0].copy(), log_scale[0]
        for window in range(windows):
            if window > 0:
                scale = walk(state, pull, scale, steps[window - 1, hypothesis]) + log_scale[window]
                for i in range(size):
                    pull[i] += vector[window, i]
                    for j in range(size):
                        state[i, j] += information[window, i, j]
            gathered[window, hypothesis], gathered_vector[window, hypothesis] = state, pull
            gathered_scale[window, hypothesis] = scale


@compiled
def _copied(source: Floats, source_vector: Floats, target: Floats, target_vector: Floats) -> None:
    for i in range(source_vector.size):
        target_vector[i] = source_vector[i]
        for j in range(source_vector.size):
            target[i, j] = source[i, j]


@compiled
def _times(target: Floats, target_vector: Floats, factor: Floats, factor_vector: Floats) -> None:
    for i in range(target_vector.size):
        target_vector[i] += factor_vector[i]
        for j in range(target_vector.size):
            target[i, j] += factor[i, j]


@compiled
def interval_evidence(
    ahead: Floats,
    ahead_vector: Floats,
    ahead_scale: Floats,
    behind: Floats,
    behind_vector: Floats,
    behind_scale: Floats,
    information: Floats,
    vector: Floats,
    log_scale: Floats,
    steps: Floats,
    leap: Floats,
    found: Floats,
) -> None:
    """Logarithm of the evidence with a jump below a window and another below one that lies up to L windows deeper.

    Parameters
    ----------
    ahead, behind : what the windows up to each one, and from each one on, say about its state, (W, hypothesis, …)
    information, vector, log_scale : factors of the windows
    steps : (W − 1, hypothesis, walking)
    leap : variance of a jump, (walking,)
    found : (W − 1, L, hypothesis), filled where the second place lies before the last window
    """
    size = vector.shape[1]
    state, pull, met, met_pull = np.empty((size, size)), np.empty(size), np.empty((size, size)), np.empty(size)
    for first in range(steps.shape[0]):
        for hypothesis in range(steps.shape[1]):
            _copied(ahead[first, hypothesis], ahead_vector[first, hypothesis], state, pull)
            scale = walk(state, pull, ahead_scale[first, hypothesis], steps[first, hypothesis] + leap)
            for length in range(min(found.shape[1], steps.shape[0] - 1 - first)):
                inside = first + 1 + length
                _times(state, pull, information[inside], vector[inside])
                scale += log_scale[inside]
                _copied(state, pull, met, met_pull)
                closed = walk(met, met_pull, scale, steps[inside, hypothesis] + leap)
                _times(met, met_pull, behind[inside + 1, hypothesis], behind_vector[inside + 1, hypothesis])
                closed += behind_scale[inside + 1, hypothesis]
                found[first, length, hypothesis] = log_integral(met, met_pull, closed)
                scale = walk(state, pull, scale, steps[inside, hypothesis])
