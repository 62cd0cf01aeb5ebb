"""A law as a cubic spline: its curvature, and its slope at the mean beyond that which the base model has."""

from dataclasses import dataclass

import numpy as np
from scipy.integrate import cumulative_trapezoid

from drillid.arrays import Floats

POINTS = 41
"""Places at which a law is drawn; odd, so that one is in the middle."""


@dataclass(frozen=True, eq=False)
class LawSpline:
    """A law over a range of speeds (rad/s), of speed errors (rad/s), or of torques (N m); straight beyond it."""

    knots: Floats
    """(K,)."""
    values: Floats
    """(K,) second derivatives, between which they are linear, N m s²/rad² or rad/(N m)²."""
    low: float
    high: float
    slope: float = 0.0
    """At the mean, beyond that of the base model, N m s/rad or rad/(N m)."""

    @property
    def span(self) -> float:
        """Width of the range."""
        return self.high - self.low

    def drawn(self, mean: float) -> tuple[Floats, Floats]:
        """Places (POINTS,) in the range, and the law about a mean, less what the base model has of it."""
        grid = np.linspace(self.low, self.high, POINTS)
        second = np.interp(grid, self.knots, self.values)
        slope = cumulative_trapezoid(second, grid, initial=0)
        value = cumulative_trapezoid(slope, grid, initial=0)
        # beyond its range the law is straight
        at = min(max(mean, self.low), self.high)
        tangent = np.interp(at, grid, value) + np.interp(at, grid, slope) * (grid - at)
        return grid, value - tangent + self.slope * (grid - mean)

    @property
    def slopes(self) -> Floats:
        """Factors (K, POINTS) of the values in the slope over the range less that at its lower end."""
        grid = np.linspace(self.low, self.high, POINTS)
        seconds = np.stack([np.interp(grid, self.knots, row) for row in np.eye(self.knots.size)])
        return np.asarray(cumulative_trapezoid(seconds, grid, initial=0), dtype=float)

    @property
    def rise(self) -> Floats:
        """Factors (K,) of the values in the slope at the upper end less that at the lower."""
        return np.asarray(self.slopes[:, -1], dtype=float)

    @property
    def growth(self) -> Floats:
        """Factors (K,) of the values in the mean slope at both ends less that in the middle."""
        slopes = self.slopes
        return np.asarray((slopes[:, 0] + slopes[:, -1]) / 2 - slopes[:, POINTS // 2], dtype=float)
