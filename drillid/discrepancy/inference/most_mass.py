"""Where the posteriors of windows have most mass, and what the uncertainty of windows adds to residuals there."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from drillid.arrays import Complex, Floats
from drillid.discrepancy.inference.coordinates import LOCAL, Extension, Point
from drillid.discrepancy.inference.set_fit import Expansion, SetFit, expanded, moved
from drillid.discrepancy.inference.set_model import SetModel
from drillid.fits.damped import SET, SET_END, descend

_STEP = 0.05
"""Finite-difference step for the slope of a log determinant, in prior standard deviations of the windows."""


def of_most_mass(model: SetModel, fit: SetFit, extensions: tuple[Extension, ...] = ()) -> Point:
    """Where the likelihood with the windows' deviations integrated out is greatest, rather than the joint one.

    Where damping nearly vanishes a resonance is so sharp that it can follow the noise of single lines: the cost has an
    optimum there that is narrow, so that it holds little of the posterior, yet draws the set to itself. By Laplace's
    method the marginal likelihood of a window also contains the determinant of the curvature (Tierney and Kadane
    1986, Journal of the American Statistical Association 81, 82-86). It is maximised both from the fit and from all
    windows at the set's values.
    """

    def with_volumes(about: Expansion) -> Expansion:
        return replace(about, cost=about.cost + float(_half_log(about.normal.unbounded.corner).sum()))

    def steps_from(about: Expansion) -> Callable[[float], Expansion]:
        own = about.normal.own.copy()
        own[:, list(LOCAL)] -= _volume_slope(model, about, extensions)
        towards = replace(about, normal=replace(about.normal, own=own))
        return lambda damping: with_volumes(expanded(model, moved(towards, extensions, damping), extensions))

    starts = (replace(fit.point, local=np.zeros_like(fit.point.local)), fit.point)
    begun = (with_volumes(expanded(model, start, extensions)) for start in starts)
    return min((descend(each, steps_from, SET, SET_END) for each in begun), key=lambda best: best.cost).point


def _volume_slope(model: SetModel, about: Expansion, extensions: tuple[Extension, ...]) -> Floats:
    """Slope of half the log determinant of each window's curvature in its deviations (W, 4), by central differences."""
    point, places = about.point, list(LOCAL)
    precision = about.normal.local_precision[:, :, None] * np.eye(len(LOCAL))

    def volume(local: Floats) -> Floats:
        each = model.products(replace(point, local=local), extensions).each[:, places][:, :, places]
        return _half_log(each + precision)

    steps = _STEP * np.diag(model.deviation)
    changes = [volume(point.local + step) - volume(point.local - step) for step in steps]
    return np.stack(changes, axis=1) / (2 * _STEP * model.deviation)


def _half_log(curvature: Floats) -> Floats:
    """Half the log determinants (W,) of matrices (W, 4, 4)."""
    return np.asarray(0.5 * np.linalg.slogdet(curvature)[1], dtype=float)


def bias_of_curvature(model: SetModel, point: Point, extensions: tuple[Extension, ...]) -> Complex:
    """Mean of the whitened residuals (W, rows) at the optimum, to second order in the windows' deviations.

    A window's deviations have errors of covariance C, and the responses have the second derivatives H in them: the mean
    residual is −½ tr(H C) (Box 1971, Journal of the Royal Statistical Society B 33, 171-201).
    """
    corner = expanded(model, point, extensions).normal.corner
    values, vectors = np.linalg.eigh(np.linalg.inv(corner))
    errors = vectors * np.sqrt(np.maximum(values, 0.0))[:, None]
    middle = model.residual(point, extensions)
    bias = np.zeros_like(middle)
    for step in np.moveaxis(errors, 2, 0):
        ends = (model.residual(replace(point, local=point.local + each), extensions) for each in (step, -step))
        bias += 0.5 * sum(end - middle for end in ends)
    # where it is more than a standard deviation of a window, the second order is not the last that counts
    small = np.sum(np.abs(bias) ** 2, axis=1, keepdims=True) < 1
    return np.where(small, bias, 0.0)
