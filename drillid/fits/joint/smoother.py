"""Information filter and smoother of windows in order of depth: some coordinates are random walks, the others shared.

The state of a window is what walks from one to the next, followed by what is the same in all
of them. A window's likelihood, expanded to second order, is a Gaussian factor of its state, so
that filter and smoother are exact for these factors and cost a time that grows linearly with
the windows (Särkkä and Svensson, Bayesian Filtering and Smoothing, 2nd ed., chapters 6 and 12;
in information form, so that a factor may leave directions open).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from drillid.arrays import Floats


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

    def __mul__(self, other: Gaussian) -> Gaussian:
        return Gaussian(
            self.information + other.information, self.vector + other.vector, self.log_scale + other.log_scale
        )

    def __getitem__(self, index: int | slice) -> Gaussian:
        """Members along the leading dimensions."""
        return Gaussian(self.information[index], self.vector[index], self.log_scale[index])

    def walked(self, variance: Floats) -> Gaussian:
        """After a random step of the first coordinates, of variance (..., walking); 0 is no step.

        The coordinates before the step are integrated over. With M their information and Q the
        variance, information goes to (I + M Q)⁻¹ M, which exists for steps of any size and for
        coordinates of which nothing is known.
        """
        walking = variance.shape[-1]
        both = np.concatenate([self.information, self.vector[..., None]], axis=-1)[..., :walking, :]
        system = np.eye(walking) + self.information[..., :walking, :walking] * variance[..., None, :]
        kept = np.linalg.solve(system, both)
        lost = np.swapaxes(both, -1, -2) @ (variance[..., :, None] * kept)
        rest = np.concatenate([self.information, self.vector[..., None]], axis=-1) - lost[..., :-1, :]
        shift = 0.5 * lost[..., -1, -1] - 0.5 * np.linalg.slogdet(system)[1]
        information = rest[..., :-1]
        return Gaussian((information + np.swapaxes(information, -1, -2)) / 2, rest[..., -1], self.log_scale + shift)

    def log_integral(self) -> Floats:
        """Logarithm of the integral over all coordinates."""
        size = self.vector.shape[-1]
        mean = np.linalg.solve(self.information, self.vector[..., None])[..., 0]
        determinant = np.linalg.slogdet(self.information)[1]
        log_integral = self.log_scale + 0.5 * np.vecdot(self.vector, mean) - 0.5 * determinant
        return np.asarray(log_integral + 0.5 * size * np.log(2 * np.pi))

    def moments(self) -> tuple[Floats, Floats]:
        """Mean (..., state) and covariance (..., state, state)."""
        covariance = np.asarray(np.linalg.inv(self.information), dtype=float)
        mean: Floats = np.matvec(covariance, self.vector)
        return mean, covariance


def stacked(members: list[Gaussian]) -> Gaussian:
    """Members along a new first dimension."""
    return Gaussian(
        np.stack([member.information for member in members]),
        np.stack([member.vector for member in members]),
        np.stack([member.log_scale for member in members]),
    )


def forward(prior: Gaussian, factors: Gaussian, steps: Floats) -> Gaussian:
    """What the windows up to each one, and the prior, say of its state.

    Parameters
    ----------
    prior : of the first window's state
    factors : along windows
    steps : variance of the random steps between windows, shape (window − 1, ..., walking);
        the dimensions between are hypotheses, which the result has too
    """
    batch = steps.shape[1:-1]
    size = factors.vector.shape[-1]
    first = prior * factors[0]
    state = Gaussian(
        np.broadcast_to(first.information, (*batch, size, size)),
        np.broadcast_to(first.vector, (*batch, size)),
        np.broadcast_to(first.log_scale, batch),
    )
    states = [state]
    for window, step in enumerate(steps, start=1):
        state = state.walked(step) * factors[window]
        states.append(state)
    return stacked(states)


def backward(factors: Gaussian, steps: Floats) -> Gaussian:
    """What the windows from each one on say of its state, without the prior; as `forward`."""
    batch, size = steps.shape[1:-1], factors.vector.shape[-1]
    nothing = Gaussian(np.zeros((*batch, size, size)), np.zeros((*batch, size)), np.zeros(batch))
    state = nothing * factors[-1]
    states = [state]
    for window in range(steps.shape[0] - 1, -1, -1):
        state = state.walked(steps[window]) * factors[window]
        states.append(state)
    return stacked(states[::-1])


def smoothed(prior: Gaussian, factors: Gaussian, steps: Floats) -> Gaussian:
    """What all windows say of each one's state, along windows; normalised by none, so its integral is the evidence."""
    before = forward(prior, factors, steps)
    if not steps.shape[0]:
        return before
    after = backward(factors, steps)[1:].walked(steps)
    return Gaussian(
        np.concatenate([before.information[:-1] + after.information, before.information[-1:]]),
        np.concatenate([before.vector[:-1] + after.vector, before.vector[-1:]]),
        np.concatenate([before.log_scale[:-1] + after.log_scale, before.log_scale[-1:]]),
    )
