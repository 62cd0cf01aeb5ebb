"""Information filter and smoother of windows in order of depth: some coordinates are random walks, the others shared.

The state of a window holds the coordinates that walk from one window to the next, then those
that all windows share. A window's likelihood, expanded to second order, is a Gaussian factor of
its state, so filter and smoother are exact for these factors and take a time that grows linearly
with the windows (Särkkä and Svensson, Bayesian Filtering and Smoothing, 2nd ed., chapters 6 and 12;
in information form, so that a factor may leave directions open).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from drillid.arrays import Floats
from drillid.fits.joint.kernel import accumulate, integrate_each, walk_each


@dataclass(frozen=True)
class Gaussian:
    """exp(log_scale + vectorᵀx − xᵀ information x/2) for one state, or for many along leading dimensions.

    information : shape (..., state, state)
    vector : shape (..., state)
    log_scale : shape (...)
    """

    information: Floats
    vector: Floats
    log_scale: Floats

    @staticmethod
    def expanded(point: Floats, cost: Floats, gradient: Floats, hessian: Floats) -> Gaussian:
        """exp(−cost) to second order about points (..., state)."""
        turned = np.matvec(hessian, point)
        log_scale = -cost + np.vecdot(gradient, point) - 0.5 * np.vecdot(point, turned)
        return Gaussian(hessian, turned - gradient, log_scale)

    @staticmethod
    def normal(mean: Floats, deviation: Floats) -> Gaussian:
        """Density of independent normal coordinates, each of shape (state,); infinite deviations carry no weight."""
        known = np.isfinite(deviation)
        precision = np.where(known, 1 / np.where(known, deviation, 1.0) ** 2, 0.0)
        centre = np.where(known, mean, 0.0)
        spread = np.log(2 * np.pi * np.where(known, deviation, 1.0) ** 2)
        log_scale = -0.5 * np.sum(precision * centre**2 + np.where(known, spread, 0.0))
        return Gaussian(np.diag(precision), precision * centre, np.asarray(log_scale))

    @property
    def parts(self) -> tuple[Floats, Floats, Floats]:
        """Information, vector and logarithm of the scale as the compiled functions take them."""
        information, vector, log_scale = (
            np.ascontiguousarray(part, dtype=float) for part in (self.information, self.vector, self.log_scale)
        )
        return information, vector, log_scale

    def __mul__(self, other: Gaussian) -> Gaussian:
        return Gaussian(
            self.information + other.information, self.vector + other.vector, self.log_scale + other.log_scale
        )

    def __getitem__(self, index: int | slice) -> Gaussian:
        """Members along the leading dimensions."""
        return Gaussian(self.information[index], self.vector[index], self.log_scale[index])

    def walked(self, variance: Floats) -> Gaussian:
        """After a random step of the first coordinates, of variance (..., walking); 0 is no step.

        The coordinates before the step are integrated over, see `drillid.fits.joint.kernel.walk`.
        """
        shape, size = np.broadcast_shapes(self.log_scale.shape, variance.shape[:-1]), self.vector.shape[-1]
        information = np.array(np.broadcast_to(self.information, (*shape, size, size)))
        vector = np.array(np.broadcast_to(self.vector, (*shape, size)))
        log_scale = np.array(np.broadcast_to(self.log_scale, shape), dtype=float)
        steps = np.array(np.broadcast_to(variance, (*shape, variance.shape[-1])))
        walk_each(
            information.reshape(-1, size, size),
            vector.reshape(-1, size),
            log_scale.reshape(-1),
            steps.reshape(-1, steps.shape[-1]),
        )
        return Gaussian(information, vector, log_scale)

    def log_integral(self) -> Floats:
        """Logarithm of the integral over all coordinates; −∞ where the information is not positive definite."""
        size, shape = self.vector.shape[-1], self.log_scale.shape
        found = np.empty(int(np.prod(shape)))
        information, vector, log_scale = self.parts
        integrate_each(information.reshape(-1, size, size), vector.reshape(-1, size), log_scale.reshape(-1), found)
        return found.reshape(shape)

    def moments(self) -> tuple[Floats, Floats]:
        """Mean (..., state) and covariance (..., state, state)."""
        covariance = np.asarray(np.linalg.inv(self.information), dtype=float)
        mean: Floats = np.matvec(covariance, self.vector)
        return mean, covariance


def forward(prior: Gaussian, factors: Gaussian, steps: Floats) -> Gaussian:
    """What the windows up to each one, and the prior, say about its state.

    Parameters
    ----------
    prior : of the first window's state
    factors : along windows
    steps : variance of the random steps between windows, shape (window − 1, ..., walking);
        the dimensions between are hypotheses, which the result has too
    """
    first = prior * factors[0]
    return _gathered(
        Gaussian(
            np.concatenate([first.information[None], factors.information[1:]]),
            np.concatenate([first.vector[None], factors.vector[1:]]),
            np.concatenate([first.log_scale[None], factors.log_scale[1:]]),
        ),
        steps,
    )


def backward(factors: Gaussian, steps: Floats) -> Gaussian:
    """What the windows from each one on say about its state, without the prior; as `forward`."""
    turned = slice(None, None, -1)
    found = _gathered(Gaussian(*(part[turned] for part in factors.parts)), steps[turned])
    return Gaussian(*(part[turned] for part in found.parts))


def _gathered(factors: Gaussian, steps: Floats) -> Gaussian:
    """What each factor and those before it say about its state; as `forward`."""
    windows, size = factors.vector.shape
    batch, walking = steps.shape[1:-1], steps.shape[-1]
    hypotheses = int(np.prod(batch))
    shape = (windows, hypotheses)
    found = np.empty((*shape, size, size)), np.empty((*shape, size)), np.empty(shape)
    variances = np.ascontiguousarray(steps).reshape(-1, hypotheses, walking)
    accumulate(*factors.parts, variances, *found)
    information, vector, log_scale = (part.reshape(windows, *batch, *part.shape[2:]) for part in found)
    return Gaussian(information, vector, log_scale)


def smoothed(prior: Gaussian, factors: Gaussian, steps: Floats) -> Gaussian:
    """What all windows say about each one's state, along windows; not normalised, so its integral is the evidence."""
    before = forward(prior, factors, steps)
    if not steps.shape[0]:
        return before
    after = backward(factors, steps)[1:].walked(steps)
    return Gaussian(
        np.concatenate([before.information[:-1] + after.information, before.information[-1:]]),
        np.concatenate([before.vector[:-1] + after.vector, before.vector[-1:]]),
        np.concatenate([before.log_scale[:-1] + after.log_scale, before.log_scale[-1:]]),
    )
