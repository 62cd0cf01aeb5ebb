"""Laws of fractional order as sums of relaxations, which have a response in time.

Drag of a boundary layer is √s, and the elastic torque of steel that loses the same share of energy in every cycle is
(2/π) ln(s/ω_r), the causal hysteretic element (Makris 1997, Journal of Engineering Mechanics 123, 1209-1214). Over the
band of a simulation each is a constant and relaxations s/(s + p) with positive shares, none of which gives energy.
"""

import functools
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.optimize import lsq_linear

from drillid.arrays import Complex, Floats

REFERENCE = 2 * np.pi
"""rad/s, ω_r: there the shear modulus of steel with losses is that without."""
_FREQUENCIES = np.geomspace(0.02, 20.0, 200)
"""Hz, at which the laws are fitted."""
_RATES = 2 * np.pi * np.geomspace(0.008, 120.0, 8)
"""1/s."""


@dataclass(frozen=True, eq=False)
class Relaxations:
    """constant + Σ shares s/(s + rates)."""

    constant: float
    shares: Floats
    rates: Floats

    def __call__(self, s: Complex) -> Complex:
        """At values of the Laplace variable, (F,)."""
        return np.asarray(self.constant + s[:, None] / (s[:, None] + self.rates) @ self.shares, dtype=complex)


NONE = Relaxations(0.0, np.empty(0), np.empty(0))


def hysteresis(s: Complex) -> Complex:
    """Elastic torque of a loss factor of one, relative to that of the spring."""
    return np.asarray(2 / np.pi * np.log(s / REFERENCE), dtype=complex)


@functools.cache
def relaxing_drag() -> Relaxations:
    """√s, to 0.2 % of itself from 0.05 to 5 Hz."""
    return _fitted(np.sqrt, np.abs, least=0.0)


@functools.cache
def relaxing_hysteresis() -> Relaxations:
    """`hysteresis`, to 0.008 from 0.05 to 5 Hz; its constant, of steel that has relaxed, is negative."""
    return _fitted(hysteresis, np.ones_like, least=-np.inf)


def _fitted(law: Callable[[Complex], Complex], size: Callable[[Complex], Complex], least: float) -> Relaxations:
    """Least squares of errors relative to a size of the law's values, with a constant of at least so much."""
    s = 2j * np.pi * _FREQUENCIES
    values = law(s)
    parts = np.column_stack([np.ones_like(s), s[:, None] / (s[:, None] + _RATES)]) / size(values)[:, None]
    values = values / size(values)
    bounds = np.append(least, np.zeros(_RATES.size)), np.inf
    constant, *shares = lsq_linear(np.vstack([parts.real, parts.imag]), np.append(values.real, values.imag), bounds).x
    return Relaxations(float(constant), np.array(shares), _RATES)
