"""Layout of a drilling system for the compiled responses: quantities in a row, curves, and tables of a block."""

from typing import NamedTuple

from drillid.arrays import Complex, Floats, Integers
from drillid.physics.kernel import BLOCK, inlined

RECORDING, CONTROL, TOP_DRIVE, MOTOR, BIT, COURSE = 0, 6, 11, 18, 21, 24
"""Where the quantities of each part begin in a row: scale, clock offset, variance of the clock, filter frequency, third
cumulant of the clock and logarithm of the further factor of the recording; P, I, the filters of speed and torque and
logarithm of the further factor of the control; inertia, delay, its variance, gain, lag, third cumulant of the delay and
logarithm of the further factor of the top drive; stiffness, damping and inertia of the motor; inertia of the bit,
amplitude and blade time of its regenerative cutting; damping at the bit in every part of the window. κ, δ, drag, loss
factor, density and shear modulus of every line follow, then length and polar moment of every section."""
RECORD_FACTOR, CONTROL_FACTOR, DRIVE_FACTOR = CONTROL - 1, TOP_DRIVE - 1, MOTOR - 1
"""The further factors: curves of frequency, so that their places in a row of numbers are empty."""
PER_LINE, PER_SECTION = 6, 2
HELD = 6
"""Where the constants of held control begin."""
FIXED = HELD + 3
"""Number of constants before those of the lines: compensated inertia, the filter of its compensation, fourth and fifth
cumulant of the drive's delay, and the same of the recording's clock; of held control the interval, 0 without it, and
the variances of jitter of drive and clock."""
FIXED_PER_LINE = 1
"""Reference frequency of the loss factor."""


class Structure(NamedTuple):
    """What a system consists of, the same in all windows."""

    parts: int
    """Number of equally long parts of a window."""
    lines: int
    """Number of different materials and dampings."""
    line_of: Integers
    """(sections,) line of every section, from the top."""
    has_loss: Integers
    """(lines,) 1 where a line has a loss factor."""
    has_motor: bool
    has_cutting: bool
    """Whether the bit cuts regeneratively."""
    filter_order: int
    """Of the recording; 0 without a filter."""
    filter_pairs: Floats
    """(order // 2,) linear coefficients of the filter's quadratic factors."""


class Curves(NamedTuple):
    """Parts of the system given as curves over N frequencies, alike in all windows (V = 1) or for each of them (V = W).

    Their derivatives are to coordinates, each through the quantity that stands for the curve.
    """

    factors: Complex
    """(V, 3, N) further factors of recording, control and drive; (V, 0, N) without any."""
    shunts: Complex
    """(V, lines, N) addition to the shunt admittance per length and polar moment, N s/(rad m⁴); (V, 0, N) without."""
    quantity: Integers
    """(pairs,) place of the quantity: of a factor its own, of a line's addition that of the line's κ."""
    coordinate: Integers
    """(pairs,) coordinate that the derivative is taken to."""
    slope: Complex
    """(V, pairs, N) derivative of the factor's logarithm, or of the addition."""


@inlined
def add(table: Floats, which: int, j: int, value: complex) -> None:
    """Add to a number of a row of a block's table."""
    table[2 * which * BLOCK + j] += value.real
    table[(2 * which + 1) * BLOCK + j] += value.imag
