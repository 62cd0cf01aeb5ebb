"""Causes weighed on one measured response: their evidence, and their gain on lines that had no part in the fit.

The engine of `drillid.discrepancy` knows the drill string's eleven coordinates. Here the same reckoning (Laplace's
approximation, equal prior odds, smooth disturbances at the ports as the unknown cause) is done for any base model
whose coordinates are positive.
"""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace
from typing import Any, Protocol

import numpy as np

from drillid.arrays import Complex, Floats
from drillid.discrepancy import CATALOGUE
from drillid.discrepancy.catalogue import OperatingPoint, WindowModel
from drillid.discrepancy.rules import WIDE_PRIOR
from drillid.physics.dual_numbers import Dual, derivatives
from drillid.physics.responses import laplace

Base = Callable[[Sequence[Any]], WindowModel]
"""Base model from its coordinates."""

_PRIOR_LOGARITHM = 3.0
"""Standard deviation of the logarithm of each of the base's coordinates."""
_REACH = 12.0
_NEIGHBOURS = 21
"""Lines over which the jumps from line to line are averaged."""
_JUMP_VARIANCE = 1.5
"""Variance of a value less the mean of its two neighbours, per variance of a value."""
_NOWHERE = OperatingPoint(1.0, 0.0, 1.0)
PORTS = ("record", "top", "bit")


@dataclass(frozen=True, eq=False)
class Response:
    """A measured response, each (F,)."""

    frequency: Floats
    """Hz."""
    value: Complex
    deviation: Floats
    """Standard deviation of the complex value."""

    def at(self, lines: slice) -> "Response":
        """Some of its lines."""
        return Response(self.frequency[lines], self.value[lines], self.deviation[lines])


@dataclass(frozen=True)
class Candidate:
    """A cause of the catalogue at one of its shapes."""

    cause: str
    typical: float
    """Its usual size in this rig."""
    shape: float = 0.0


class Disturbance(Protocol):
    """Something unknown that changes the response: a value at each frequency, of coefficients with normal priors."""

    @property
    def basis(self) -> Complex:
        """(coefficient, F) of the value, for coefficients of standard normal prior."""

    def mobility(self, window_model: WindowModel, value: Any, s: Complex) -> Any:
        """The disturbed response."""


@dataclass(frozen=True, eq=False)
class Problem:
    """A base model, what it is held against, and the causes that are in it already."""

    base: Base
    start: Floats
    """(P,) expected coordinates of the base."""
    measured: Response
    given: tuple[Candidate, ...] = ()
    disturbance: Disturbance | None = None
    ports: tuple[str, ...] = PORTS
    """At which something unknown may act."""

    def mobility(self, coordinates: Sequence[Any], s: Complex, value: Any = 0.0) -> Any:
        """The response with the given causes and the disturbance's value.

        Figures are logarithms relative to the start, then sizes per usual size.
        """
        count = self.start.size
        window_model = self.base(
            [first * np.exp(one) for first, one in zip(self.start, coordinates[:count], strict=True)]
        )
        for candidate, size in zip(self.given, coordinates[count:], strict=True):
            cause = CATALOGUE[candidate.cause]
            window_model = cause.extend(window_model, size * candidate.typical, candidate.shape, _NOWHERE)
        return (
            window_model.mobility(s) if self.disturbance is None else self.disturbance.mobility(window_model, value, s)
        )

    def window_model(self, coordinates: Floats) -> WindowModel:
        """The base without its causes."""
        return self.base(list(self.start * np.exp(coordinates[: self.start.size])))

    def whitened(self, coordinates: Floats) -> tuple[Complex, Complex]:
        """Residual (F,) with real and imaginary parts of unit variance, and the model's derivatives (P, F)."""
        s, weight = laplace(self.measured.frequency), np.sqrt(2) / self.measured.deviation
        count = self.start.size + len(self.given)
        if self.disturbance is None:
            value, slopes = derivatives(lambda *each: self.mobility(each, s), coordinates)
            return (self.measured.value - value) * weight, slopes * weight
        # each coefficient acts through the value at every frequency: one direction serves all of them
        basis, directions = self.disturbance.basis, np.eye(count + 1)
        own = [
            Dual(coordinate, direction)
            for coordinate, direction in zip(coordinates[:count], directions[:-1], strict=True)
        ]
        response = self.mobility(own, s, Dual(coordinates[count:] @ basis, directions[-1]))
        tangents = response.full_tangents()
        slopes = np.concatenate([tangents[:-1], tangents[-1] * basis])
        return (self.measured.value - response.value) * weight, slopes * weight

    @property
    def prior(self) -> Floats:
        """Standard deviations of the coordinates' normal priors about zero."""
        further = 0 if self.disturbance is None else len(self.disturbance.basis)
        return np.repeat([_PRIOR_LOGARITHM, WIDE_PRIOR, 1.0], [self.start.size, len(self.given), further])

    def bounds(self) -> tuple[Floats, Floats]:
        """Of the coordinates."""
        sizes = [CATALOGUE[one.cause].size for one in self.given]
        low = [size.low / one.typical for size, one in zip(sizes, self.given, strict=True)]
        high = [size.high / one.typical for size, one in zip(sizes, self.given, strict=True)]
        reach = np.full(self.start.size, _REACH)
        further = np.full(0 if self.disturbance is None else len(self.disturbance.basis), _REACH)
        return np.concatenate([-reach, low, -further]), np.concatenate([reach, high, further])


@dataclass(frozen=True, eq=False)
class Fit:
    """Optimum of a problem."""

    problem: Problem
    coordinates: Floats
    cost: float
    """Half the sum of squares of residuals and prior pulls."""
    information: Floats
    """(P, P) curvature of the cost."""
    misfit: float
    """Mean of |measured − model|²/variance."""

    @property
    def size(self) -> tuple[float, float]:
        """Size of the last cause with its standard error."""
        typical = self.problem.given[-1].typical
        error = float(np.sqrt(np.linalg.inv(self.information)[-1, -1]))
        return float(self.coordinates[-1]) * typical, error * typical

    def predicted(self, frequency: Floats) -> Complex:
        """The model's response."""
        return np.asarray(self.problem.mobility(list(self.coordinates), laplace(frequency)), dtype=complex)


def fit(problem: Problem, starts: Iterable[Floats], evaluations: int = 400) -> Fit:
    """Penalised least squares from some starts; the best is kept."""
    from scipy.optimize import least_squares

    prior, bounds = problem.prior, problem.bounds()

    def residuals(coordinates: Floats) -> Floats:
        residual, _ = problem.whitened(coordinates)
        return np.concatenate([residual.real, residual.imag, coordinates / prior])

    def jacobian(coordinates: Floats) -> Floats:
        _, slopes = problem.whitened(coordinates)
        return np.concatenate([-slopes.real.T, -slopes.imag.T, np.diag(1 / prior)])

    if not prior.size:
        residual, _ = problem.whitened(np.empty(0))
        square = float(np.sum(np.abs(residual) ** 2))
        return Fit(problem, np.empty(0), square / 2, np.empty((0, 0)), square / residual.size / 2)
    inside = [np.clip(start, bounds[0] + 1e-9, bounds[1] - 1e-9) for start in starts]
    trials = [
        least_squares(residuals, start, jacobian, bounds, x_scale="jac", max_nfev=evaluations) for start in inside
    ]
    best = min(trials, key=lambda trial: float(trial.cost))
    residual, _ = problem.whitened(best.x)
    return Fit(problem, best.x, float(best.cost), best.jac.T @ best.jac, float(np.mean(np.abs(residual) ** 2) / 2))


def extended(base: Fit, candidate: Candidate) -> Fit:
    """The base with one more cause, fitted from no size and from its usual size, from the base's fit and afresh."""
    problem = replace(base.problem, given=(*base.problem.given, candidate))
    fresh = np.zeros(base.coordinates.size)
    sizes = (0.01, 1.0) if CATALOGUE[candidate.cause].size.low >= 0 else (0.01, 1.0, -1.0)
    starts = [np.append(origin, size) for origin in (base.coordinates, fresh) for size in sizes]
    return fit(problem, starts)


def log_evidence(base: Fit, more: Fit) -> float:
    """Log Bayes factor of the last cause by Laplace's approximation (Kass and Raftery 1995, JASA 90, 773–795)."""
    from scipy.special import log_ndtr

    with_cause, without = np.linalg.slogdet(more.information)[1], np.linalg.slogdet(base.information)[1]
    evidence = base.cost - more.cost - 0.5 * (with_cause - without) - np.log(WIDE_PRIOR)
    if CATALOGUE[more.problem.given[-1].cause].size.low >= 0:
        size, error = more.size
        evidence += np.log(2.0) + log_ndtr(size / error)
    return float(evidence)


def with_distortion(measured: Response, model: Complex) -> Response:
    """The deviation with what jumps from line to line: non-linear distortion, which repeats from period to period.

    A linear rig's response is smooth over neighbouring lines, and so is the ratio of measured to modelled (Pintelon
    and Schoukens 2012, System Identification, chapter 4: stochastic non-linear distortion).
    """
    from scipy.ndimage import uniform_filter1d

    ratio = measured.value / model
    jumps = ratio[1:-1] - (ratio[:-2] + ratio[2:]) / 2
    power = np.pad(np.abs(jumps) ** 2 / _JUMP_VARIANCE, 1, mode="edge")
    distortion = np.sqrt(uniform_filter1d(power, _NEIGHBOURS)) * np.abs(model)
    return replace(measured, deviation=np.maximum(measured.deviation, distortion))
