"""Intervals of the eight parameters by profile likelihood, compiled.

The profile of a parameter is the least cost over all others with that parameter held. A 95 % interval ends where the
profile is 1.96²/2 above its minimum (Wilks 1938), or at the bound if it does not rise so far. The estimate of
a parameter that cannot be negative can err in fewer ways near zero, so a smaller rise ends its interval there (Feldman
and Cousins 1998, Physical Review D 57). With several optima, the interval covers those about each of them.
"""

import math

import numpy as np

from drillid.arrays import Floats
from drillid.fits.likelihood import Data, compiled
from drillid.fits.solver import minimise, solve_free
from drillid.physics.kernel import SIZE

QUANTILE = 1.959963984540054
"""Quantile of the standard normal distribution, two-sided at 95 %."""
_HALVINGS = 24
_CLOSE = 0.02
"""Largest difference at an interval's end between the root of twice the rise in cost and the quantile."""
_TRIALS = 12
_ONE_STEP, _STEPS, _MORE_STEPS, _ALL = np.array([1, 12, 50, -1])
"""As numpy's integers, as in `drillid.fits.solver`."""
_TOLERANCE = 2e-3
_LARGEST_FACTOR = 4.0
"""Largest factor by which a trial may lie farther from the optimum than the one before."""


@compiled
def _spread(point: Floats, gradient: Floats, hessian: Floats, low: Floats, high: Floats, i: int, step: Floats) -> float:
    """Standard deviation of a parameter from the curvature, and the steps of all others per unit step of it, (n,).

    Others that are pushed against a bound stay there.
    """
    size = point.size
    free, nothing = np.ones(size, np.bool_), np.zeros(size)
    for j in range(size):
        pushed = (point[j] <= low[j] and gradient[j] > 0.0) or (point[j] >= high[j] and gradient[j] < 0.0)
        free[j] = j != i and not pushed
        step[j] = 0.0
    step[i] = 1.0
    if not solve_free(hessian, nothing, free, step):
        return math.nan
    rise = 0.0
    for j in range(size):
        for k in range(size):
            rise += step[j] * hessian[j, k] * step[k]
    return 1.0 / math.sqrt(max(rise, 1e-30))


@compiled
def quantile(distance: float) -> float:
    """Rise √(2 (profile − least)) that values at a distance from zero exceed in 5 % of windows.

    An estimate x with a standard deviation of 1 about the distance t, held at zero where x < 0, rises by |x − t|,
    or by √(t² − 2xt) where it is held. Above a rise q > t, 1 − Φ(q) + Φ(−(t² + q²)/2t) of them lie.

    Parameters
    ----------
    distance : t, standard deviations of the parameter
    """
    if distance >= QUANTILE:
        return QUANTILE
    low, high = 1.0, QUANTILE
    for _ in range(_HALVINGS):
        middle = 0.5 * (low + high)
        lower = middle if middle <= distance else (distance * distance + middle * middle) / (2.0 * max(distance, 1e-9))
        if math.erfc(middle / math.sqrt(2.0)) + math.erfc(lower / math.sqrt(2.0)) > 0.1:
            low = middle
        else:
            high = middle
    return 0.5 * (low + high)


@compiled
def interval_end(
    optimum: Floats,
    least: float,
    gradient: Floats,
    hessian: Floats,
    data: Data,
    low: Floats,
    high: Floats,
    i: int,
    direction: float,
) -> float:
    """One end of the interval of parameter i: upwards for a direction of 1, downwards for −1.

    Newton's method on z = √(2 (profile − least)), which is nearly a straight line; its slope follows from that of
    the cost, as the others are at their optimum.
    """
    size = optimum.size
    held = np.zeros(size, np.bool_)
    held[i] = True
    step = np.empty(size)
    point_gradient, point_hessian = np.empty(size), np.empty((size, size))
    bound: float = high[i] if direction > 0 else low[i]
    spread = _spread(optimum, gradient, hessian, low, high, i, step)
    reach = abs(bound - optimum[i])
    if reach == 0.0 or not spread > 0.0:
        return bound
    inner, outer = 0.0, math.inf
    away = min(QUANTILE * spread, reach)
    point = optimum.copy()
    before = 0.0
    for _ in range(_TRIALS):
        for j in range(size):
            if j != i:
                point[j] = min(max(point[j] + step[j] * direction * (away - before), low[j]), high[j])
        point[i] = bound if away == reach else optimum[i] + direction * away
        cost = minimise(point, data, True, low, high, held, _STEPS, _TOLERANCE, point_gradient, point_hessian)
        before = away
        rise = math.sqrt(2.0 * max(cost - least, 0.0))
        limit = quantile(point[i] / spread) if low[i] == 0.0 else QUANTILE
        if abs(rise - limit) < _CLOSE or (rise < limit and away == reach):
            break
        if rise < limit:
            inner = away
        else:
            outer = away
        slope = direction * point_gradient[i]
        trial = away + (limit - rise) * rise / slope if slope > 0.0 and rise > 0.0 else math.inf
        trial = min(trial, _LARGEST_FACTOR * away, reach)
        if not inner < trial < outer:
            trial = 0.5 * (inner + min(outer, reach)) if outer < math.inf else reach
        if outer - inner < 1e-6 * outer:
            break
        away = trial
        _spread(point, point_gradient, point_hessian, low, high, i, step)
    end: float = point[i]
    return end


@compiled
def _widen(optimum: Floats, least: float, data: Data, low: Floats, high: Floats, one: int, ends: Floats) -> None:
    """Widen intervals (2, 8) by those about one optimum: of the parameter `one` or, where that is −1, of all."""
    size = optimum.size
    gradient, hessian = np.empty(size), np.empty((size, size))
    point = optimum.copy()
    minimise(point, data, True, low, high, np.zeros(size, np.bool_), _ONE_STEP, 0.0, gradient, hessian)
    for i in range(SIZE):
        if one < 0 or i == one:
            lower = interval_end(point, least, gradient, hessian, data, low, high, i, -1.0)
            upper = interval_end(point, least, gradient, hessian, data, low, high, i, 1.0)
            ends[0, i], ends[1, i] = min(ends[0, i], lower), max(ends[1, i], upper)


@compiled
def intervals(
    optima: Floats, costs: Floats, data: Data, alone: Data, which: int, low: Floats, high: Floats, ends: Floats
) -> None:
    """Both ends (2, 8) of the intervals of the eight parameters.

    Parameters
    ----------
    optima, costs : (optimum, n) and (optimum,), the best first; those higher than an interval's end are left out
    data : with all priors
    alone : the same without the prior on the parameter `which`, whose interval is the wider of both
    low, high : bounds, (n,)
    """
    size = optima.shape[1]
    none = np.zeros(size, np.bool_)
    gradient, hessian = np.empty(size), np.empty((size, size))
    ends[0], ends[1] = math.inf, -math.inf
    freed, rest = optima.copy(), costs.copy()
    for row in range(costs.size):
        if costs[row] < costs[0] + 0.5 * QUANTILE**2:
            _widen(optima[row], costs[0], data, low, high, _ALL, ends)
        rest[row] = minimise(freed[row], alone, True, low, high, none, _MORE_STEPS, _TOLERANCE, gradient, hessian)
    lowest = rest.min()
    for row in range(costs.size):
        if rest[row] < lowest + 0.5 * QUANTILE**2:
            _widen(freed[row], lowest, alone, low, high, which, ends)
