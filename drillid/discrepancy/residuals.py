"""Whitened residuals of fitted mobilities, and tests of them."""

import numpy as np
from numpy.typing import NDArray

from drillid.estimation import Measured
from drillid.physics.model import KnownEquipment, drilling_system
from drillid.physics.responses import command_mobility, laplace
from drillid.statistics import to_normal

Floats = NDArray[np.float64]

_LAGS = 5
"""Neighbouring frequencies over which residuals are tested for dependence."""


def whitened_residuals(measured: Measured, parameters: Floats, known: KnownEquipment) -> NDArray[np.complex128]:
    """Measured less fitted mobility over the deviation of each component, as if Gaussian; shape (frequency,)."""
    fitted = command_mobility(drilling_system(parameters, known), laplace(measured.frequency))
    ratio = (measured.mobility - fitted) * np.sqrt(2 / measured.variance)
    freedom = measured.degrees_of_freedom
    return to_normal(ratio.real, freedom) + 1j * to_normal(ratio.imag, freedom)


def normality_probability(residual: NDArray[np.complex128]) -> float:
    """Chance of such residuals if standard normal (Kolmogorov–Smirnov over both components)."""
    from scipy.stats import kstest

    return float(kstest(np.concatenate([residual.real, residual.imag]), "norm").pvalue)


def whiteness_probability(residual: NDArray[np.complex128]) -> float:
    """Chance of such correlation between neighbouring frequencies if there is none (Ljung and Box 1978, complex)."""
    from scipy.special import chdtrc

    size = residual.size
    power = np.sum(np.abs(residual) ** 2)
    correlation = np.array([np.sum(residual[lag:] * np.conj(residual[:-lag])) / power for lag in range(1, _LAGS + 1)])
    statistic = 2 * size * (size + 2) * np.sum(np.abs(correlation) ** 2 / (size - np.arange(1, _LAGS + 1)))
    return float(chdtrc(2 * _LAGS, statistic))
