"""Limits of a drive, sample by sample."""

import numpy as np

from drillid.arrays import Floats
from drillid.physics.kernel import compiled


@compiled
def rate_limited(series: Floats, steps: Floats) -> Floats:
    """A series (samples,) limited to each of several largest changes a sample (steps,); shape (steps, samples)."""
    limited = np.empty((steps.size, series.size))
    for row in range(steps.size):
        current, step = series[0], steps[row]
        for sample in range(series.size):
            current = min(max(series[sample], current - step), current + step)
            limited[row, sample] = current
    return limited
