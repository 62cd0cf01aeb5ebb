"""Whitened rows of a set's windows, their derivatives, and sums over them."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from drillid.arrays import Complex, Floats
from drillid.physics.dual_numbers import Dual, primal


@dataclass(frozen=True, eq=False)
class Linearised:
    """Whitened residuals of a set and the Jacobian of its responses at a point."""

    residual: Complex
    """(W, rows); real and imaginary part are standard normal where the model is right."""
    jacobian: Complex
    """(W, P, rows) of the modelled responses, whitened."""

    def mobility_chi2(self, frequencies: int) -> float:
        """Sum of squared residuals of the mobilities, which come first among the rows."""
        return float(np.sum(np.abs(self.residual[:, :frequencies]) ** 2))


@dataclass(frozen=True, eq=False)
class Products:
    """Sums over the rows of each window about a point, for all P coordinates of the set."""

    each: Floats
    """(W, P, P) products of the derivatives."""
    own: Floats
    """(W, P) products of derivatives and residuals."""
    squares: Floats
    """(W,) squared residuals."""
    of_mobilities: Floats
    """(W, P + 1, P + 1) of the mobilities' rows alone, with the residuals last."""

    @property
    def mobility_chi2(self) -> float:
        """Sum of squared residuals of the mobilities."""
        return float(self.of_mobilities[:, -1, -1].sum())


def weighted(response: Any, measured: Complex, weight: Floats, count: int) -> tuple[Complex, Complex]:
    """Whitened residual (W, F) and derivatives (W, count, F) of a modelled response."""
    measured = np.where(weight > 0, measured, 0.0)
    residual = (measured - np.broadcast_to(primal(response), measured.shape)) * weight
    slopes = np.zeros((count, *measured.shape), dtype=complex)
    if isinstance(response, Dual):
        slopes[response.indices] = response.tangents * weight
    return residual, np.moveaxis(slopes, 0, 1)


def real_rows(values: Complex) -> Floats:
    """Real and imaginary parts of rows (..., R) as one row (..., 2 R), a view of the same memory."""
    return values.view(float)


def products_of(linear: Linearised, frequencies: int) -> Products:
    """Sums over the rows, of which those of the mobilities come first."""
    rows, residual = real_rows(linear.jacobian), real_rows(linear.residual)
    own = (rows @ residual[..., None])[..., 0]
    squares = np.sum(residual**2, axis=1)
    of_mobilities = np.concatenate([rows, residual[:, None]], axis=1)[..., : 2 * frequencies]
    return Products(rows @ np.swapaxes(rows, -1, -2), own, squares, of_mobilities @ np.swapaxes(of_mobilities, -1, -2))
