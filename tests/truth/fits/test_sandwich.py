"""Errors hold where the model's shape is in error, and are left as they are where it is right."""

import numpy as np
import pytest

from drillid.arrays import Complex, Floats
from drillid.fits.sandwich import error_factors

LINES, FREEDOM, TRIALS = 500, 48.0, 400


def pulls(alike: float) -> tuple[Floats, Floats]:
    """Errors of least squares over their plain and their robust standard errors, (trial, 3), where the model has errors
    of this size per noise that are alike over ten lines.
    """
    generator = np.random.default_rng(3)
    place = np.linspace(0, 1, LINES)
    derivatives = np.array([np.exp(1j * 7 * place), np.cos(20 * place) + 0j, 1j * np.sin(50 * place)])
    plain, robust = [], []
    for _ in range(TRIALS):
        shape = np.repeat(_complex(generator, LINES // 10), 10)
        error = _complex(generator, LINES) + alike * shape
        variance = generator.gamma(FREEDOM, size=LINES) / FREEDOM
        weights = 2 / variance
        curvature = (np.conj(derivatives) * weights @ derivatives.T).real
        value = np.linalg.solve(curvature, (np.conj(derivatives) * weights @ error).real)
        deviation = np.sqrt(np.diag(np.linalg.inv(curvature)))
        residual = value @ derivatives - error
        factors = error_factors(residual, derivatives, variance, np.full(LINES, FREEDOM), np.zeros(3))
        plain.append(value / deviation)
        robust.append(value / deviation / factors)
    return np.array(plain), np.array(robust)


def _complex(generator: np.random.Generator, size: int) -> Complex:
    return np.asarray(generator.normal(size=(size, 2)) @ [np.sqrt(0.5), 1j * np.sqrt(0.5)], dtype=complex)


def covered(pulls: Floats) -> float:
    return float(np.mean(np.abs(pulls) < 1.96))


def test_intervals_cover_where_the_model_is_right() -> None:
    plain, robust = pulls(0.0)
    assert covered(plain) == pytest.approx(0.95, abs=0.02)
    assert 0.94 < covered(robust) < 0.98


def test_intervals_cover_where_errors_of_the_model_are_alike_over_neighbours() -> None:
    plain, robust = pulls(1.0)
    assert covered(plain) < 0.6
    assert 0.87 < covered(robust) < 0.98
