"""Least squares within bounds for many small problems at once: Levenberg–Marquardt on the free parameters."""

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Indices = NDArray[np.intp]
Curvature = Callable[[Floats, Indices], tuple[Floats, Floats, Floats]]
"""(points (problem, parameter), problem numbers) → cost (problem,), gradient (problem, parameter) and
Gauss–Newton Hessian (problem, parameter, parameter) of half the sum of squares."""

_FIRST_DAMPING = 1e-3
_LARGEST_DAMPING = 1e12
_SMALL_CHANGE = 1e-10
_ITERATIONS = 200
_TINY = 1e-300


def solve_bounded(
    curvature: Curvature, starts: Floats, low: Floats, high: Floats, iterations: int = _ITERATIONS
) -> tuple[Floats, Floats]:
    """Minimise all problems from their starts.

    A parameter at a bound is held there while the gradient pushes it outwards, so that the others
    converge at the same speed as without bounds. Damping follows Marquardt's scaling by the
    Hessian's diagonal and Nielsen's rule (1999).

    Parameters
    ----------
    starts : shape (problem, parameter), scaled so that values are of order one
    low, high : bounds, shape (parameter,)

    Returns
    -------
    points : shape (problem, parameter)
    costs : shape (problem,)
    """
    points = np.clip(starts, low, high)
    active = np.arange(points.shape[0])
    costs, gradients, hessians = curvature(points, active)
    damping, growth = np.full(active.size, _FIRST_DAMPING), np.full(active.size, 2.0)
    for _ in range(iterations):
        step, predicted = _step(points[active], gradients[active], hessians[active], damping[active], low, high)
        trial = np.clip(points[active] + step, low, high)
        cost, gradient, hessian = curvature(trial, active)
        better = cost < costs[active]
        gain = np.clip((costs[active] - cost) / np.maximum(predicted, _SMALL_CHANGE * cost + _TINY), -1.0, 1.0)
        settled = (np.abs(predicted) <= _SMALL_CHANGE * costs[active]) & (damping[active] < 1)
        chosen = active[better]
        points[chosen], costs[chosen] = trial[better], cost[better]
        gradients[chosen], hessians[chosen] = gradient[better], hessian[better]
        eased = damping[active] * np.maximum(1 / 3, 1 - (2 * gain - 1) ** 3)
        damping[active] = np.where(better, eased, damping[active] * growth[active])
        growth[active] = np.where(better, 2.0, 2 * growth[active])
        active = active[~settled & (damping[active] < _LARGEST_DAMPING)]
        if active.size == 0:
            break
    return points, costs


def _step(
    points: Floats, gradients: Floats, hessians: Floats, damping: Floats, low: Floats, high: Floats
) -> tuple[Floats, Floats]:
    """Damped step within the bounds and the fall in cost that the quadratic model predicts for it.

    A parameter that the step would carry over a bound goes to the bound, and the step of the
    others is found again with it there.
    """
    diagonal = np.maximum(np.diagonal(hessians, axis1=1, axis2=2), 1e-12)
    damped = hessians + np.eye(points.shape[1]) * (damping[:, None] * diagonal)[:, None, :]
    held = ((points <= low) & (gradients > 0)) | ((points >= high) & (gradients < 0))
    step = np.zeros_like(points)
    for _ in range(points.shape[1]):
        step = _step_of_the_free(damped, gradients, np.where(held, step, 0.0), ~held)
        over = (points + step < low) | (points + step > high)
        step = np.clip(points + step, low, high) - points
        if not over.any():
            break
        held |= over
    change = np.einsum("pi,pi->p", gradients, step) + 0.5 * np.einsum("pi,pij,pj->p", step, hessians, step)
    return step, -change


def _step_of_the_free(damped: Floats, gradients: Floats, fixed: Floats, free: NDArray[np.bool_]) -> Floats:
    """Newton step of the free parameters given the steps of the fixed ones."""
    mask = free.astype(float)
    system = damped * mask[:, :, None] * mask[:, None, :] + np.eye(free.shape[1]) * (1 - mask)[:, None, :]
    slope = (gradients + np.einsum("pij,pj->pi", damped, fixed)) * mask
    step: Floats = fixed - np.linalg.solve(system, slope[..., None])[..., 0]
    return step
