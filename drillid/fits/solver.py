"""Levenberg–Marquardt within bounds on the eight parameters, and on the control's gains where these are free, compiled.

A parameter at a bound is held there while the gradient pushes it outwards, so that the others converge at the same
speed as without bounds. Damping is scaled by the Hessian's diagonal and follows `drillid.fits.damped.WINDOW`.
"""

import math

import numpy as np

from drillid.arrays import Booleans, Floats
from drillid.fits.damped import LEAST_CURVATURE, WINDOW, lowered, raised
from drillid.fits.likelihood import Data, compiled, curvature
from drillid.physics.parameters import LENGTH

_lowered, _raised = compiled(lowered), compiled(raised)
_TOLERANCE = 1e-7
"""Expected fall in cost below which a step is the last."""
_FIRST_STEPS, _MORE_STEPS, _STEPS = np.array([4, 25, 100])
"""As NumPy integers: numba compiles a function anew for every Python integer that it is called with."""
_PROMISING = 30.0
"""Cost above the best after the first steps, within which a start is followed further."""
_AS_GOOD = 10.0
"""Cost on the thinned data above the best, within which an optimum may be the best on all of the data."""
_LIKELY = 5.0
"""Cost on all of the data above the best, within which an optimum is followed to its end."""
_SHIFTS = (-0.04, -0.015, 0.015, 0.04)
"""Relative changes of the best length that are tried as well."""
_HELD_STEPS, _FREE_STEPS = np.array([2, 6])
_SAME_COST = 0.1
_SAME_LENGTH = 0.003
"""Relative difference of length below which two points lead to the same optimum."""


@compiled
def solve_free(matrix: Floats, right: Floats, free: Booleans, solution: Floats) -> bool:
    """Solve the symmetric system (n, n) for the free unknowns, by Cholesky's factors; the others keep their values.

    The contribution of the others is moved to the right-hand side. False if the matrix is not positive definite.
    """
    size = right.size
    factor, work = np.empty((size, size)), np.empty(size)
    for i in range(size):
        if not free[i]:
            continue
        rest = right[i]
        for j in range(size):
            if not free[j]:
                rest -= matrix[i, j] * solution[j]
        for j in range(i + 1):
            if not free[j]:
                continue
            total = matrix[i, j]
            for k in range(j):
                if free[k]:
                    total -= factor[i, k] * factor[j, k]
            if i == j:
                if not total > 0.0:
                    return False
                factor[i, i] = math.sqrt(total)
            else:
                factor[i, j] = total / factor[j, j]
                rest -= factor[i, j] * work[j]
        work[i] = rest / factor[i, i]
    for i in range(size - 1, -1, -1):
        if free[i]:
            total = work[i]
            for k in range(i + 1, size):
                if free[k]:
                    total -= factor[k, i] * solution[k]
            solution[i] = total / factor[i, i]
    return True


@compiled
def bounded_step(
    point: Floats, gradient: Floats, matrix: Floats, low: Floats, high: Floats, held: Booleans, step: Floats
) -> bool:
    """Minimum within the bounds of a quadratic model about the point, as a step (n,); False if the model has none.

    A parameter that the step would carry over a bound goes to the bound, and the step of the others is found again.
    Held parameters take the step that is given.
    """
    size = point.size
    free = np.empty(size, np.bool_)
    right = np.empty(size)
    for i in range(size):
        right[i] = -gradient[i]
        outwards = (point[i] <= low[i] and gradient[i] > 0.0) or (point[i] >= high[i] and gradient[i] < 0.0)
        free[i] = not (held[i] or outwards)
        if not held[i]:
            step[i] = 0.0
    for _ in range(size):
        if not solve_free(matrix, right, free, step):
            return False
        inside = True
        for i in range(size):
            if free[i] and not low[i] <= point[i] + step[i] <= high[i]:
                step[i] = min(max(step[i], low[i] - point[i]), high[i] - point[i])
                free[i] = inside = False
        if inside:
            break
    return True


@compiled
def minimise(
    point: Floats,
    data: Data,
    robust: bool,
    low: Floats,
    high: Floats,
    held: Booleans,
    iterations: int,
    tolerance: float,
    gradient: Floats,
    hessian: Floats,
) -> float:
    """Move the point (n,) to the minimum of its cost, which is returned; gradient and Hessian are those at the end.

    Parameters
    ----------
    robust : as in `curvature`
    low, high : bounds, (n,)
    held : parameters that keep their values, (n,)
    tolerance : expected fall in cost below which a step is the last
    """
    size = point.size
    cost = curvature(point, data, robust, gradient, hessian)
    damping, growth = WINDOW.first, WINDOW.growth
    trial, step, damped = np.empty(size), np.zeros(size), np.empty((size, size))
    trial_gradient, trial_hessian = np.empty(size), np.empty((size, size))
    for _ in range(iterations):
        damped[:] = hessian
        for i in range(size):
            damped[i, i] += damping * max(hessian[i, i], LEAST_CURVATURE)
        step[:] = 0.0
        solved = bounded_step(point, gradient, damped, low, high, held, step)
        expected = 0.0
        for i in range(size):
            trial[i] = min(max(point[i] + step[i], low[i]), high[i])
            expected -= gradient[i] * step[i]
            for j in range(size):
                expected -= 0.5 * step[i] * hessian[i, j] * step[j]
        if solved and abs(expected) <= tolerance and damping < 1.0:
            break
        trial_cost = curvature(trial, data, robust, trial_gradient, trial_hessian) if solved else math.inf
        if trial_cost < cost:
            gain = min(max((cost - trial_cost) / max(expected, 1e-300), -1.0), 1.0)
            point[:], gradient[:], hessian[:] = trial, trial_gradient, trial_hessian
            cost = trial_cost
            damping, growth = _lowered(WINDOW, damping, gain)
        else:
            damping, growth = _raised(WINDOW, damping, growth)
            if damping > WINDOW.largest:
                break
    return cost


@compiled
def _neighbours(best: Floats, thin: Data, low: Floats, high: Floats, points: Floats, costs: Floats) -> None:
    """Points (_SHIFTS, n) a few steps from strings a little shorter and longer than the best, with their costs.

    Where the sweep reaches few modes, strings whose resonances fall together explain a window nearly as well.
    """
    size = best.size
    held, none = np.zeros(size, np.bool_), np.zeros(size, np.bool_)
    held[LENGTH] = True
    gradient, hessian = np.empty(size), np.empty((size, size))
    for row in range(len(_SHIFTS)):
        points[row] = best
        points[row, LENGTH] = min(max(best[LENGTH] * (1.0 + _SHIFTS[row]), low[LENGTH]), high[LENGTH])
        minimise(points[row], thin, False, low, high, held, _HELD_STEPS, 1e-1, gradient, hessian)
        costs[row] = minimise(points[row], thin, False, low, high, none, _FREE_STEPS, 1e-2, gradient, hessian)


@compiled
def follow(starts: Floats, thin: Data, data: Data, low: Floats, high: Floats, points: Floats, costs: Floats) -> int:
    """Optima (kept, n) of the starts (start, n), with their costs (kept,); returns their number.

    In rounds: a few steps of all starts on the thinned data; the better of them, and strings a little shorter and
    longer than the best, to their optimum there; and distinct optima about as good as the best, on all of the data,
    to their optimum if that may be the best.
    """
    size = starts.shape[1]
    none = np.zeros(size, np.bool_)
    gradient, hessian = np.empty(size), np.empty((size, size))
    first = starts.shape[0]
    every, rough = np.empty((first + len(_SHIFTS), size)), np.empty(first + len(_SHIFTS))
    every[:first] = starts
    for row in range(first):
        rough[row] = minimise(every[row], thin, False, low, high, none, _FIRST_STEPS, 1e-1, gradient, hessian)
    promising = rough[:first].min() + _PROMISING
    for row in range(first):
        if rough[row] < promising:
            rough[row] = minimise(every[row], thin, False, low, high, none, _MORE_STEPS, 1e-2, gradient, hessian)
    _neighbours(every[rough[:first].argmin()], thin, low, high, every[first:], rough[first:])
    order = np.argsort(rough)
    count = 0
    for row in order:
        apart = rough[row] < rough[order[0]] + _AS_GOOD and count < points.shape[0]
        for other in range(count):
            difference = abs(every[row, LENGTH] / points[other, LENGTH] - 1.0)
            apart = apart and (difference > _SAME_LENGTH or rough[row] > costs[other] + _SAME_COST)
        if apart:
            points[count], costs[count] = every[row], rough[row]
            count += 1
    for row in range(count):
        costs[row] = minimise(points[row], data, True, low, high, none, _FIRST_STEPS, 1e-1, gradient, hessian)
    likely = costs[:count].min() + _LIKELY
    for row in range(count):
        if costs[row] < likely:
            costs[row] = minimise(points[row], data, True, low, high, none, _STEPS, _TOLERANCE, gradient, hessian)
    return count
