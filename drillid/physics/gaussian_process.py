"""A Gaussian process over frequency: transfers of unknown shape that are causal, stable and real in time.

The impulse response g is Gaussian with covariance e^(−λ(t + t') − μ|t − t'|), diagonal and correlated (Chen, Ohlsson
and Ljung 2012, Automatica 48, 1525–1535). Its transform f(s) then has

    E f(s) f(r) = λΩ/(s + r + 2λ) · (1/(s + Ω) + 1/(r + Ω)),    Ω = λ + μ,

one at s = r = 0 (Lataire and Chen 2016, Automatica 72, 40–52). λ is the resolution in frequency: the response forgets
within 1/λ. The process is represented by its values at NODES (subset of regressors; Quiñonero-Candela and Rasmussen
2005, Journal of Machine Learning Research 6, 1939–1959), so it is one more linear model with independent standard
normal coefficients. Every function is analytic right of the imaginary axis.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np

from drillid.arrays import Complex, Floats
from drillid.physics.damping import DampingLaw, Steel
from drillid.physics.dual_numbers import composed, primal
from drillid.physics.equipment import Quantity, Shaping

NODES: Complex = np.asarray(2j * np.pi * np.linspace(0.0, 5.0, 16), dtype=complex)
"""Values of s at which real and imaginary part of f are the variables of the process."""
COUNT = 2 * NODES.size - 1
"""Number of coefficients: f is real at s = 0."""
BANDWIDTH = 2 * np.pi * 15.0
"""Ω, rad/s: the prior is nearly flat over the band of sweeps."""
_JITTER = 1e-7
"""Share of the prior variance that is added, so that the covariance of the nodes has a Cholesky factor."""


def covariance(rate: float, s: Any, r: Any) -> Any:
    """E f(s) f(r) of the process with λ = `rate`, rad/s."""
    return rate * BANDWIDTH / (s + r + 2 * rate) * (1 / (s + BANDWIDTH) + 1 / (r + BANDWIDTH))


def functions(rate: float, s: Complex) -> Complex:
    """The COUNT functions of s whose coefficients are independent and standard normal, (COUNT, *s.shape)."""
    with_nodes = _with_nodes(rate, np.asarray(s, dtype=complex).ravel())
    return np.asarray(_whitening(rate) @ with_nodes, dtype=complex).reshape(COUNT, *np.shape(s))


def _with_nodes(rate: float, s: Complex) -> Complex:
    """Covariance of f(s) with real and imaginary parts at the nodes, (COUNT, s)."""
    at, mirrored = covariance(rate, s, NODES[:, None]), covariance(rate, s, NODES.conj()[:, None])
    return np.concatenate([(at + mirrored) / 2, ((at - mirrored) / 2j)[1:]])


@cache
def _whitening(rate: float) -> Floats:
    """Inverse of the Cholesky factor of the covariance of the nodes' parts, (COUNT, COUNT)."""
    at_nodes = _with_nodes(rate, NODES)
    prior = np.concatenate([at_nodes.real, at_nodes.imag[:, 1:]], axis=1)
    factor = np.linalg.cholesky(prior + _JITTER * np.eye(COUNT))
    return np.asarray(np.linalg.inv(factor), dtype=float)


def value(rate: float, coefficients: tuple[Quantity, ...], s: Any) -> Any:
    """f(s) from its COUNT coefficients."""
    known = functions(rate, s)
    total = sum((primal(own) * row for own, row in zip(coefficients, known, strict=True)), start=np.zeros_like(s))
    return composed(total, list(zip(known, coefficients, strict=True)))


@dataclass(frozen=True)
class ProcessAdmittance(DampingLaw):
    """An admittance of unknown shape, f(s) times the characteristic admittance of its section."""

    rate: float
    """λ, rad/s."""
    coefficients: tuple[Quantity, ...]
    spread: float
    """m, length of the section that it is spread over."""

    def shunt(self, section: Steel, s: Any) -> Any:
        """Admittance per length, N s/rad."""
        characteristic = section.polar_moment * np.sqrt(section.density * section.shear_modulus)
        return value(self.rate, self.coefficients, s) * (characteristic / self.spread)


@dataclass(frozen=True)
class ProcessShaping(Shaping):
    """A rational factor of a transfer, times 1 + f(s)."""

    rate: float = 1.0
    """λ, rad/s."""
    coefficients: tuple[Quantity, ...] = (0.0,) * COUNT

    def factor(self, s: Any) -> Any:
        """The factor, dimensionless."""
        return super().factor(s) * (1 + value(self.rate, self.coefficients, s))
