"""The eight-parameter model and its exact derivatives, compiled.

A section with characteristic admittance Y₀ and load Y_L has, with e = exp(−2γL), a = Y_L + Y₀ and
b = (Y_L − Y₀) e, the input admittance Y₀ (a + b)/(a − b): equation 5 of the paper, in one exponential that
cannot overflow. Its derivatives are 4 e Y₀²/(a − b)² to the load, (a + b)/(a − b) − 4 e Y₀ Y_L/(a − b)² to Y₀
and −4 e Y₀ (Y_L² − Y₀²)/(a − b)² to γL.
"""

import math
from typing import Any, NamedTuple

import numpy as np

from drillid.arrays import Complex, Floats
from drillid.compiled import compiler

OPTIONS: dict[str, Any] = {"fastmath": {"contract", "reassoc", "nsz", "arcp", "afn"}, "error_model": "numpy"}
"""Compiler options of the model and of all functions that call it."""
compiled = compiler("physics", **OPTIONS)
inlined = compiler("physics", forceinline=True, **OPTIONS)
SIZE = 8
"""Number of parameters, in the order of `drillid.physics.parameters.PARAMETERS`."""
_TURN = 2 * math.pi
BLOCK = 104
"""Frequencies whose derivatives are computed at a time, few enough for the processor's first-level cache."""
WIDTH = 2 * (SIZE + 1)
"""Numbers per frequency: real and imaginary part of the mobility and of each derivative."""


class TransmissionLine(NamedTuple):
    """Inputs of the model besides its parameters: quantities per frequency, and the collars."""

    blocks: Floats
    """For each block of frequencies (block, 8 BLOCK): real and imaginary parts of the Laplace variable s (1/s), of
    ρs (kg/(m³ s)), of G/s (Pa s) and of the controller with its filters (N m s/rad), BLOCK numbers each."""
    frequencies: int
    """Number of frequencies; the last block is padded with the last frequency."""
    collar_length: float
    """m; 0 without collars."""
    collar_polar_moment: float
    """m⁴."""
    collar_inertia: float
    """kg m², of the collars as in the tally."""


@inlined
def inverse(z: complex) -> complex:
    """1/z."""
    scale = 1.0 / (z.real * z.real + z.imag * z.imag)
    return complex(z.real * scale, -z.imag * scale)


@inlined
def root(z: complex) -> complex:
    """Square root with positive real part, without loss of digits."""
    size = math.sqrt(z.real * z.real + z.imag * z.imag)
    larger = math.sqrt(0.5 * (size + abs(z.real)))
    smaller = 0.5 * abs(z.imag) / larger
    sign = 1.0 if z.imag >= 0 else -1.0
    real = larger if z.real >= 0 else smaller
    return complex(real, sign * (smaller if z.real >= 0 else larger))


@inlined
def _decay(x: float) -> float:
    """exp(−x) for x within ±64, to which others are set: Taylor's series of x/64, squared six times."""
    y = min(max(x, -64.0), 64.0) / 64.0
    t = 1.0 - y / 16.0
    t = 1.0 - t * y / 15.0
    t = 1.0 - t * y / 14.0
    t = 1.0 - t * y / 13.0
    t = 1.0 - t * y / 12.0
    t = 1.0 - t * y / 11.0
    t = 1.0 - t * y / 10.0
    t = 1.0 - t * y / 9.0
    t = 1.0 - t * y / 8.0
    t = 1.0 - t * y / 7.0
    t = 1.0 - t * y / 6.0
    t = 1.0 - t * y / 5.0
    t = 1.0 - t * y / 4.0
    t = 1.0 - t * y / 3.0
    t = 1.0 - t * y / 2.0
    t = 1.0 - t * y
    t *= t
    t *= t
    t *= t
    t *= t
    t *= t
    return t * t


@inlined
def turn(x: float) -> complex:
    """Cosine and sine of x as a complex number: Taylor's series within an eighth of a turn, angle doubled twice."""
    y = 0.25 * (x - _TURN * np.floor(x / _TURN + 0.5))
    q = y * y
    cosine = 1.0 - q / 182.0
    cosine = 1.0 - cosine * q / 132.0
    cosine = 1.0 - cosine * q / 90.0
    cosine = 1.0 - cosine * q / 56.0
    cosine = 1.0 - cosine * q / 30.0
    cosine = 1.0 - cosine * q / 12.0
    cosine = 1.0 - cosine * q / 2.0
    sine = 1.0 - q / 210.0
    sine = 1.0 - sine * q / 156.0
    sine = 1.0 - sine * q / 110.0
    sine = 1.0 - sine * q / 72.0
    sine = 1.0 - sine * q / 42.0
    sine = 1.0 - sine * q / 20.0
    sine = y - y * sine * q / 6.0
    cosine, sine = 1.0 - 2.0 * sine * sine, 2.0 * sine * cosine
    return complex(1.0 - 2.0 * sine * sine, 2.0 * sine * cosine)


@inlined
def falling(z: complex) -> complex:
    """exp(−z) for a real part within ±64, to which others are set."""
    return _decay(z.real) * turn(-z.imag)


@inlined
def through_section(own: complex, load: complex, decay: complex) -> tuple[complex, complex, complex, complex]:
    """Input admittance of a section and its derivatives to the load, to Y₀ and to γL; decay is exp(−2γL)."""
    a, b = load + own, (load - own) * decay
    per_difference = inverse(a - b)
    ratio = (a + b) * per_difference
    common = 4.0 * decay * per_difference * per_difference * own
    return own * ratio, common * own, ratio - common * load, -common * (load - own) * a


@inlined
def read(table: Floats, which: int, j: int) -> complex:
    """Number of a row of a block's table, in which a row of real parts stands before one of imaginary parts."""
    return complex(table[2 * which * BLOCK + j], table[(2 * which + 1) * BLOCK + j])


@inlined
def write(table: Floats, which: int, j: int, value: complex) -> None:
    """Set a number of a row of a block's table."""
    table[2 * which * BLOCK + j], table[(2 * which + 1) * BLOCK + j] = value.real, value.imag


@compiled
def tabulate(parameters: Floats, line: TransmissionLine, block: int, table: Floats) -> None:
    """Command mobility and its derivatives to the eight parameters at a block of frequencies.

    The table (WIDTH BLOCK,) holds the real and imaginary parts of the mobility and then of each derivative, BLOCK
    numbers each. The loop calls no function outside this file, and all indices into its arrays are known at
    compile time, so that it is vectorised over frequencies.
    """
    kappa, delta, length, polar = parameters[0], parameters[1], parameters[2], parameters[3]
    delay, inertia_td, damping_bha, inertia_bha = parameters[4], parameters[5], parameters[6], parameters[7]
    collars = line.collar_length > 0.0
    carried = min(inertia_bha, line.collar_inertia)
    per_inertia = line.collar_polar_moment / line.collar_inertia if collars else 0.0
    collar_length, collar_polar, lump = line.collar_length, carried * per_inertia, inertia_bha - carried
    lumped = 1.0 if inertia_bha >= line.collar_inertia else 0.0
    thinned = (1.0 - lumped) * per_inertia
    inputs = line.blocks[block]
    for j in range(BLOCK):
        s, series = read(inputs, 0, j), read(inputs, 2, j) + delta
        per_series = inverse(series)
        gamma = root((read(inputs, 1, j) + kappa) * per_series)
        specific = series * gamma
        half = 0.5 * inverse(gamma)
        specific_delta = 0.5 * gamma
        gamma_kappa, gamma_delta = half * per_series, -specific_delta * per_series

        load = lump * s + damping_bha
        by_damping, by_inertia = complex(1.0, 0.0), s
        by_kappa = by_delta = complex(0.0, 0.0)
        if collars:
            decay = falling(2.0 * collar_length * gamma)
            load, by_load, by_own, by_phase = through_section(collar_polar * specific, load, decay)
            by_damping = by_load
            by_inertia = lumped * by_load * s + thinned * by_own * specific
            by_kappa = by_own * collar_polar * half + by_phase * collar_length * gamma_kappa
            by_delta = by_own * collar_polar * specific_delta + by_phase * collar_length * gamma_delta
        load, by_load, by_own, by_phase = through_section(polar * specific, load, falling(2.0 * length * gamma))

        delayed = falling(delay * s)
        below = inertia_td * s + load
        per_total = inverse(below + delayed * read(inputs, 3, j))
        mobility = delayed * per_total
        slope = -mobility * per_total
        to_load, to_own, to_phase = slope * by_load, slope * by_own, slope * by_phase
        write(table, 0, j, mobility)
        write(table, 1, j, to_load * by_kappa + to_own * polar * half + to_phase * length * gamma_kappa)
        write(table, 2, j, to_load * by_delta + to_own * polar * specific_delta + to_phase * length * gamma_delta)
        write(table, 3, j, to_phase * gamma)
        write(table, 4, j, to_own * specific)
        write(table, 5, j, slope * s * below)
        write(table, 6, j, slope * s)
        write(table, 7, j, to_load * by_damping)
        write(table, 8, j, to_load * by_inertia)


def line_of(
    s: Complex, control: Complex, shunt: Complex, series: Complex, collars: tuple[float, float, float]
) -> TransmissionLine:
    """Inputs of shape (frequency,) cut into blocks; collars are length, polar moment and inertia."""
    blocks = max(1, -(-s.size // BLOCK))
    parts = np.empty((8, blocks * BLOCK))
    for i, values in enumerate((s, shunt, series, control)):
        parts[2 * i, : s.size], parts[2 * i + 1, : s.size] = values.real, values.imag
    parts[:, s.size :] = parts[:, s.size - 1 : s.size]
    blocked = np.ascontiguousarray(parts.reshape(8, blocks, BLOCK).swapaxes(0, 1)).reshape(blocks, 8 * BLOCK)
    return TransmissionLine(blocked, s.size, *collars)


@compiled
def mobilities(points: Floats, line: TransmissionLine, mobility: Complex, derivatives: Complex) -> None:
    """Command mobility (point, frequency) and derivatives (point, 8, frequency) of parameters (point, 8)."""
    table = np.empty(WIDTH * BLOCK)
    for row in range(points.shape[0]):
        for block in range(line.blocks.shape[0]):
            first = BLOCK * block
            tabulate(points[row], line, block, table)
            for j in range(min(BLOCK, line.frequencies - first)):
                mobility[row, first + j] = read(table, 0, j)
                for i in range(SIZE):
                    derivatives[row, i, first + j] = read(table, i + 1, j)
