"""Smooth functions of frequency."""

import numpy as np

from drillid.arrays import Floats


def smooth_functions(frequency: Floats, count: int) -> Floats:
    """Cubic B-splines over log frequency, (count, F)."""
    from scipy.interpolate import BSpline

    position = np.log(frequency / frequency[0]) / np.log(frequency[-1] / frequency[0])
    inner = np.linspace(0.0, 1.0, count - 2)
    knots = np.concatenate([[0.0] * 3, inner, [1.0] * 3])
    return np.asarray(BSpline.design_matrix(np.clip(position, 0.0, 1.0), knots, 3).toarray().T, dtype=float)
