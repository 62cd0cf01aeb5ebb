"""The likelihood of a measured mobility under the eight-parameter model, with its derivatives, compiled.

Points have eight scaled parameters or, where the gains of the control are not exactly known, n = 10: the deviations of
both gains from their known values follow, in standard uncertainties. A change ΔA of the control acts on the mobility as
1/M = 1/M₀ + ΔA, so that the model's own table serves for it.
"""

import math
from typing import NamedTuple

import numpy as np

from drillid.arrays import Complex, Floats
from drillid.compiled import compiler
from drillid.physics.kernel import BLOCK, OPTIONS, SIZE, TransmissionLine, tabulate

compiled = compiler("physics", "fits", **OPTIONS)
_DELTA = 1


class Data(NamedTuple):
    """Measured mobility and prior knowledge."""

    line: TransmissionLine
    mobility: Complex
    """rad/(N m s), (frequency,)."""
    variance: Floats
    """Of the complex mobility, (frequency,)."""
    freedom: Floats
    """Complex degrees of freedom of the variance, (frequency,)."""
    prior_value: Floats
    """Scaled, (n,)."""
    prior_weight: Floats
    """One over the scaled uncertainty, (n,); 0 where nothing is known."""
    scales: Floats
    """Parameters in SI per scaled parameter, (8,); internal damping is scaled to a logarithm."""
    gains: Complex
    """Change of the control's response by a standard uncertainty of each gain, N m s/rad, (n − 8, frequency)."""


@compiled
def from_scaled(scaled: Floats, scales: Floats, values: Floats, slopes: Floats) -> None:
    """Parameters in SI (8,), and the derivatives of all coordinates to the scaled ones, (n,)."""
    slopes[:] = 1.0
    for i in range(SIZE):
        values[i] = scaled[i] * scales[i]
        slopes[i] = scales[i]
    values[_DELTA] = slopes[_DELTA] = scales[_DELTA] * math.exp(scaled[_DELTA])


@compiled
def curvature(scaled: Floats, data: Data, robust: bool, gradient: Floats, hessian: Floats) -> float:
    """Cost, with its gradient (n,) and Gauss–Newton Hessian (n, n), in scaled parameters.

    An error e over an estimated variance v with ν degrees of freedom has the likelihood of Student's t,
    (ν + 1) ln(1 + |e|²/(ν v)), with the expected information (ν + 1)/(ν + 2)/v; that is `robust`. Far from the
    optimum this flattens out, so searches use |e|² (ν − 1)/(ν v) in its place. The prior's pulls are added.
    """
    values, slopes = np.empty(SIZE), np.empty(scaled.size)
    from_scaled(scaled, data.scales, values, slopes)
    table, weights = np.empty(2 * (scaled.size + 1) * BLOCK), np.empty(BLOCK)
    gradient[:] = 0.0
    hessian[:] = 0.0
    cost = 0.0
    for block in range(data.line.blocks.shape[0]):
        first = BLOCK * block
        size = min(BLOCK, data.line.frequencies - first)
        tabulate(values, data.line, block, table)
        if scaled.size > SIZE:
            _with_gains(scaled, data.gains, first, size, table)
        cost += _weigh(data, first, size, robust, table, weights)
        _accumulate(table, size, gradient, hessian)
    for i in range(scaled.size):
        pull = (scaled[i] - data.prior_value[i]) * data.prior_weight[i]
        gradient[i] = gradient[i] * slopes[i] + pull * data.prior_weight[i]
        cost += 0.5 * pull * pull
        for j in range(i + 1):
            hessian[i, j] *= slopes[i] * slopes[j]
            hessian[j, i] = hessian[i, j]
        hessian[i, i] += data.prior_weight[i] ** 2
    return cost


@compiled
def _with_gains(scaled: Floats, gains: Complex, first: int, size: int, table: Floats) -> None:
    """Convert the table from the known gains to others, and append the derivatives to these."""
    for j in range(size):
        known = complex(table[j], table[BLOCK + j])
        by_proportional, by_integral = gains[0, first + j], gains[1, first + j]
        ratio = 1.0 / (1.0 + known * (scaled[SIZE] * by_proportional + scaled[SIZE + 1] * by_integral))
        mobility, square = known * ratio, ratio * ratio
        table[j], table[BLOCK + j] = mobility.real, mobility.imag
        for i in range(1, SIZE + 1):
            derivative = complex(table[2 * i * BLOCK + j], table[(2 * i + 1) * BLOCK + j]) * square
            table[2 * i * BLOCK + j], table[(2 * i + 1) * BLOCK + j] = derivative.real, derivative.imag
        for i, by_gain in ((SIZE + 1, by_proportional), (SIZE + 2, by_integral)):
            derivative = -mobility * mobility * by_gain
            table[2 * i * BLOCK + j], table[(2 * i + 1) * BLOCK + j] = derivative.real, derivative.imag


@compiled
def _weigh(data: Data, first: int, size: int, robust: bool, table: Floats, weights: Floats) -> float:
    """Turn the table's mobility into the error, and weight error and derivatives; returns the cost."""
    cost = 0.0
    for j in range(size):
        k = first + j
        freedom, variance = data.freedom[k], data.variance[k]
        real, imaginary = table[j] - data.mobility[k].real, table[BLOCK + j] - data.mobility[k].imag
        square = real * real + imaginary * imaginary
        if robust:
            weight = math.sqrt(2.0 * (freedom + 1.0) / ((freedom + 2.0) * variance))
            ratio = square / (freedom * variance)
            pull = weight * (freedom + 2.0) / (freedom * (1.0 + ratio))
            cost += (freedom + 1.0) * math.log1p(ratio)
        else:
            informed = max(freedom - 1.0, 0.1) / (freedom * variance)
            weight = pull = math.sqrt(2.0 * informed)
            cost += square * informed
        table[j], table[BLOCK + j] = pull * real, pull * imaginary
        weights[j] = weight
    for i in range(2, table.size // BLOCK):
        for j in range(size):
            table[i * BLOCK + j] *= weights[j]
    return cost


@compiled
def _accumulate(table: Floats, size: int, gradient: Floats, hessian: Floats) -> None:
    """Add Jᵀe and the lower triangle of JᵀJ."""
    for i in range(1, gradient.size + 1):
        for j in range(i + 1):
            total = 0.0
            for part in range(2):
                left, right = (2 * i + part) * BLOCK, (2 * j + part) * BLOCK
                for k in range(size):
                    total += table[left + k] * table[right + k]
            if j == 0:
                gradient[i - 1] += total
            else:
                hessian[i - 1, j - 1] += total
