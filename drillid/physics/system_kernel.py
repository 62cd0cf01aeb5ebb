"""Responses of any drilling system with derivatives to all its quantities, compiled.

The mobility is followed from the bit up, and its derivatives from the top drive down, in the reverse mode of automatic
differentiation (Griewank and Walther 2008, Evaluating Derivatives, chapter 3): one way down gives the derivatives to
all quantities.

Frequencies are taken in blocks, and every loop over a block reads and writes few arrays at places known at compile
time, so that it is vectorised.
"""

import math
from typing import NamedTuple

import numpy as np

from drillid.arrays import Complex, Floats
from drillid.physics.images_kernel import images
from drillid.physics.kernel import BLOCK, compiled, falling, inlined, inverse, read, root, through_section, turn, write
from drillid.physics.system_layout import (
    BIT,
    CONTROL,
    CONTROL_FACTOR,
    COURSE,
    DRIVE_FACTOR,
    FIXED,
    FIXED_PER_LINE,
    HELD,
    MOTOR,
    PER_LINE,
    PER_SECTION,
    RECORD_FACTOR,
    RECORDING,
    TOP_DRIVE,
    Curves,
    Structure,
    add,
)

# places in the table of a block, each of a real and an imaginary row
_DRIVE, CONTROL_ROW, RECORD_ROW, _KEPT_ROW, _LOAD, _ADJOINT = 0, 1, 2, 3, 4, 5
MOBILITY_ROW, _TO_DRIVE, _TO_CONTROL, _LOGARITHM = 6, 7, 8, 9
_TABLE = 2 * 10 * BLOCK
# places in what is kept of a section
_GAMMA, _SERIES, _BY_LOAD, _BY_OWN, _BY_PHASE = 0, 1, 2, 3, 4
_KEPT = 2 * 5 * BLOCK
# places in what is kept of a motor
_BY_BELOW, _BY_SPRING, _SPRING = 0, 1, 2
# places in the table of a line
_STIFFNESS, _BY_LOSS, _SHUNT = 0, 1, 2
_OF_LINE = 2 * 3 * BLOCK


@inlined
def _computed(omega: float, half: float) -> float:
    """Angular frequency at which a computer's trapezoidal rule evaluates the control; half of its interval, or 0."""
    if half > 0:
        turned = turn(omega * half)
        return turned.imag / (turned.real * half)
    return omega


@compiled
def _drive(values: Floats, constants: Floats, omega: Floats, factors: Floats, table: Floats) -> None:
    """Drive, control and clock of the recording, and the steps of a held command."""
    clock_variance, offset = values[RECORDING + 2], values[RECORDING + 1]
    proportional, integral = values[CONTROL], values[CONTROL + 1]
    speed_filter, torque_filter = values[CONTROL + 2], values[CONTROL + 3]
    delay, variance, gain = values[TOP_DRIVE + 1], values[TOP_DRIVE + 2], values[TOP_DRIVE + 3]
    lag, of_delay, of_clock = values[TOP_DRIVE + 4], values[TOP_DRIVE + 5] / 6, values[RECORDING + 4] / 6
    compensated, compensation_filter, half = constants[0], constants[1], 0.5 * constants[HELD]
    for j in range(BLOCK):
        s, computed = complex(0.0, omega[j]), complex(0.0, _computed(omega[j], half))
        compensation = compensated * computed * inverse(1.0 + compensation_filter * computed)
        filters = inverse(1.0 + speed_filter * s) * inverse(1.0 + torque_filter * computed)
        square, cube = 0.5 * omega[j] * omega[j], omega[j] * omega[j] * omega[j]
        fourth, fifth = square * square / 6.0, cube * square / 60.0
        turned = delay * omega[j] - of_delay * cube + constants[3] * fifth
        delayed = falling(complex(square * variance - constants[2] * fourth, turned))
        response = (complex(proportional, -integral / computed.imag) - compensation) * filters
        write(table, CONTROL_ROW, j, response * read(factors, 1, j))
        write(table, _DRIVE, j, gain * delayed * inverse(1.0 + lag * s) * read(factors, 2, j))
        turned = offset * omega[j] - of_clock * cube + constants[5] * fifth
        clock = falling(complex(square * clock_variance - constants[4] * fourth, turned))
        write(table, RECORD_ROW, j, clock * read(factors, 0, j))
        write(table, _TO_DRIVE, j, complex(0.0, 0.0))
        write(table, _TO_CONTROL, j, complex(0.0, 0.0))
        write(table, MOBILITY_ROW, j, complex(0.0, 0.0))
        write(table, _KEPT_ROW, j, complex(0.0, 0.0))
    if half > 0:
        for j in range(BLOCK):
            write(table, _DRIVE, j, read(table, _DRIVE, j) * (turn(half * omega[j]).imag / (half * omega[j])))


@compiled
def fold(values: Floats, constants: Floats, structure: Structure, omega: Floats, folded: Complex) -> None:
    """What the readings of held control fold of its steps at all frequencies, (2, F); 0 without it."""
    folded[:] = 0.0
    if constants[HELD] > 0:
        line = COURSE + structure.parts + PER_LINE * structure.line_of[0]
        polar = values[COURSE + structure.parts + PER_LINE * structure.lines + 1]
        admittance = polar * math.sqrt(values[line + 4] * values[line + 5])
        corner_time = 1.0 / (2 * math.pi * values[RECORDING + 3]) if structure.filter_order > 0 else 0.0
        quantities = np.array(
            [
                *(constants[HELD], values[TOP_DRIVE + 1], values[RECORDING + 1], values[TOP_DRIVE + 4]),
                *(values[CONTROL + 2], constants[HELD + 1], constants[HELD + 2], corner_time),
            ]
        )
        images(quantities, structure.filter_pairs, structure.filter_order, values[TOP_DRIVE], admittance, omega, folded)


@compiled
def _filter(values: Floats, structure: Structure, omega: Floats, table: Floats) -> None:
    """The recording's filter, with the logarithmic derivative of its polynomial to the frequency of the filter."""
    per_corner = 1.0 / values[RECORDING + 3]
    for j in range(BLOCK):
        u = complex(0.0, omega[j] * per_corner / (2 * math.pi))
        polynomial, logarithm = complex(1.0, 0.0), complex(0.0, 0.0)
        if structure.filter_order % 2:
            polynomial = 1.0 + u
            logarithm = inverse(polynomial)
        for pair in structure.filter_pairs:
            factor = 1.0 + pair * u + u * u
            polynomial = polynomial * factor
            logarithm = logarithm + (pair + 2.0 * u) * inverse(factor)
        write(table, _LOGARITHM, j, -logarithm * u * per_corner)
        write(table, RECORD_ROW, j, read(table, RECORD_ROW, j) * inverse(polynomial))


@compiled
def _bit(values: Floats, damping: float, has_cutting: bool, omega: Floats, table: Floats) -> None:
    """Admittance of the bit."""
    inertia = values[BIT]
    for j in range(BLOCK):
        write(table, _LOAD, j, complex(damping, inertia * omega[j]))
    if has_cutting:
        amplitude, blade_time = values[BIT + 1], values[BIT + 2]
        for j in range(BLOCK):
            turned = falling(complex(0.0, blade_time * omega[j])) - 1.0
            add(table, _LOAD, j, amplitude * turned * complex(0.0, -1.0 / omega[j]))


@compiled
def _motor(values: Floats, omega: Floats, table: Floats, kept: Floats) -> None:
    """Admittance above the motor, and its derivatives to the load and to the spring."""
    stiffness, damping, inertia = values[MOTOR], values[MOTOR + 1], values[MOTOR + 2]
    for j in range(BLOCK):
        s, load = complex(0.0, omega[j]), read(table, _LOAD, j)
        spring = s * inverse(stiffness + damping * s)
        share = inverse(1.0 + load * spring)
        write(table, _LOAD, j, inertia * s + load * share)
        write(kept, _BY_BELOW, j, share * share)
        write(kept, _BY_SPRING, j, -(load * share) * (load * share))
        write(kept, _SPRING, j, spring)


@compiled
def _loss(factor: float, reference: float, omega: Floats, of_line: Floats) -> None:
    """Complex stiffness relative to that without loss, and its derivative to the loss factor."""
    exponent = 2 / math.pi * math.atan(factor)
    slope = 2 / math.pi / (1.0 + factor * factor)
    for j in range(BLOCK):
        logarithm = math.log(omega[j] / (2 * math.pi * reference))
        power = math.exp(exponent * logarithm)
        stiffness = complex(power, factor * power)
        write(of_line, _STIFFNESS, j, stiffness)
        write(of_line, _BY_LOSS, j, complex(0.0, power) + stiffness * (slope * logarithm))


@compiled
def _section(line: Floats, own: Floats, of_line: Floats, omega: Floats, table: Floats, kept: Floats) -> None:
    """Admittance at the upper end of a section, and its derivatives to the load, to Y₀ and to γL."""
    kappa, delta, drag, length, polar = line[0], line[1], line[2], own[0], own[1]
    density, modulus, half_root = line[4], line[5], math.sqrt(0.5)
    for j in range(BLOCK):
        dragging = drag * half_root * math.sqrt(omega[j])
        shunt = complex(kappa + dragging, density * omega[j] + dragging) + read(of_line, _SHUNT, j)
        series = read(of_line, _STIFFNESS, j) * complex(0.0, -modulus / omega[j]) + delta
        per_series = inverse(series)
        gamma = root(shunt * per_series)
        above, by_load, by_own, by_phase = through_section(
            polar * series * gamma, read(table, _LOAD, j), falling(2.0 * length * gamma)
        )
        write(table, _LOAD, j, above)
        write(kept, _GAMMA, j, gamma)
        write(kept, _SERIES, j, series)
        write(kept, _BY_LOAD, j, by_load)
        write(kept, _BY_OWN, j, by_own)
        write(kept, _BY_PHASE, j, by_phase)


@compiled
def _top(inertia: float, share: float, omega: Floats, folded: Complex, table: Floats, to_inertia: Floats) -> None:
    """The mobility, and its derivatives to the string's admittance, to drive (its logarithm), control and inertia.

    What is folded is relative to the inertia, so that its derivative to that is left out.
    """
    for j in range(BLOCK):
        drive, response, image = read(table, _DRIVE, j), read(table, CONTROL_ROW, j), folded[0, j]
        load = complex(0.0, inertia * omega[j]) + read(table, _LOAD, j)
        whole = 1.0 + image * load
        per_total = inverse(load + drive * whole * response)
        mobility = drive * whole * per_total
        open_share = 1.0 - mobility * response
        add(table, MOBILITY_ROW, j, share * mobility)
        add(table, _KEPT_ROW, j, share * (1.0 + folded[1, j] * load) * inverse(whole))
        write(table, _ADJOINT, j, share * per_total * (drive * image * open_share - mobility))
        add(table, _TO_DRIVE, j, share * mobility * open_share)
        add(table, _TO_CONTROL, j, -share * mobility * mobility)
        add(to_inertia, 0, j, -share * mobility * per_total * complex(0.0, omega[j]))


@compiled
def _down_section(own: Floats, kept: Floats, table: Floats, to_line: Floats, to_own: Floats) -> None:
    """Derivatives to a section's quantities and to the load below, from that to the admittance above it."""
    length, polar = own[0], own[1]
    for j in range(BLOCK):
        adjoint = read(table, _ADJOINT, j)
        gamma, series = read(kept, _GAMMA, j), read(kept, _SERIES, j)
        to_admittance, to_phase = adjoint * read(kept, _BY_OWN, j), adjoint * read(kept, _BY_PHASE, j)
        first, second = polar * to_admittance, length * to_phase * inverse(series)
        add(to_line, 0, j, 0.5 * (first + second) * inverse(gamma))
        add(to_line, 1, j, 0.5 * (first - second) * gamma)
        add(to_own, 0, j, to_phase * gamma)
        add(to_own, 1, j, to_admittance * series * gamma)
        write(table, _ADJOINT, j, adjoint * read(kept, _BY_LOAD, j))


@compiled
def _down_laws(modulus: float, omega: Floats, of_line: Floats, to_line: Floats) -> None:
    """Derivatives to drag, loss factor, density and shear modulus of a line from those to κ and δ."""
    half_root = math.sqrt(0.5)
    for j in range(BLOCK):
        drag, to_shunt, to_series = half_root * math.sqrt(omega[j]), read(to_line, 0, j), read(to_line, 1, j)
        per_s = complex(0.0, -1.0 / omega[j])
        write(to_line, 2, j, to_shunt * complex(drag, drag))
        write(to_line, 3, j, to_series * read(of_line, _BY_LOSS, j) * per_s * modulus)
        write(to_line, 4, j, to_shunt * complex(0.0, omega[j]))
        write(to_line, 5, j, to_series * read(of_line, _STIFFNESS, j) * per_s)


@compiled
def _down_motor(omega: Floats, kept: Floats, table: Floats, slopes: Floats) -> None:
    for j in range(BLOCK):
        adjoint, s = read(table, _ADJOINT, j), complex(0.0, omega[j])
        to_spring, spring = adjoint * read(kept, _BY_SPRING, j), read(kept, _SPRING, j)
        add(slopes, MOTOR, j, -to_spring * spring * spring * complex(0.0, -1.0 / omega[j]))
        add(slopes, MOTOR + 1, j, -to_spring * spring * spring)
        add(slopes, MOTOR + 2, j, adjoint * s)
        write(table, _ADJOINT, j, adjoint * read(kept, _BY_BELOW, j))


@compiled
def _down_bit(
    values: Floats, has_cutting: bool, omega: Floats, table: Floats, slopes: Floats, to_damping: Floats
) -> None:
    for j in range(BLOCK):
        adjoint = read(table, _ADJOINT, j)
        add(slopes, BIT, j, adjoint * complex(0.0, omega[j]))
        write(to_damping, 0, j, adjoint)
    if has_cutting:
        amplitude, blade_time = values[BIT + 1], values[BIT + 2]
        for j in range(BLOCK):
            turned, adjoint = falling(complex(0.0, blade_time * omega[j])), read(table, _ADJOINT, j)
            add(slopes, BIT + 1, j, adjoint * (turned - 1.0) * complex(0.0, -1.0 / omega[j]))
            add(slopes, BIT + 2, j, -amplitude * adjoint * turned)


@compiled
def _down_drive(
    values: Floats, half: float, omega: Floats, factors: Floats, table: Floats, slopes: Floats, of_control: Floats
) -> None:
    """Derivatives to the quantities of drive and control; those of the control's own response beside them."""
    gain, lag = values[TOP_DRIVE + 3], values[TOP_DRIVE + 4]
    speed_filter, torque_filter = values[CONTROL + 2], values[CONTROL + 3]
    for j in range(BLOCK):
        s, response = complex(0.0, omega[j]), read(table, CONTROL_ROW, j)
        to_drive, to_control = read(table, _TO_DRIVE, j), read(table, _TO_CONTROL, j)
        write(slopes, TOP_DRIVE + 1, j, -s * to_drive)
        write(slopes, TOP_DRIVE + 2, j, -0.5 * omega[j] * omega[j] * to_drive)
        write(slopes, TOP_DRIVE + 3, j, to_drive * (1.0 / gain))
        write(slopes, TOP_DRIVE + 4, j, -s * to_drive * inverse(1.0 + lag * s))
        write(slopes, TOP_DRIVE + 5, j, -s * s * s * to_drive * (1.0 / 6.0))
        write(slopes, DRIVE_FACTOR, j, to_drive)
        computed = complex(0.0, _computed(omega[j], half))
        on_speed, on_torque = inverse(1.0 + speed_filter * s), inverse(1.0 + torque_filter * computed)
        filters, per_s = on_speed * on_torque * read(factors, 1, j), complex(0.0, -1.0 / computed.imag)
        write(of_control, CONTROL, j, filters)
        write(of_control, CONTROL + 1, j, filters * per_s)
        write(of_control, CONTROL + 2, j, -s * response * on_speed)
        write(of_control, CONTROL + 3, j, -computed * response * on_torque)
        write(of_control, CONTROL_FACTOR, j, response)
        write(slopes, CONTROL, j, to_control * filters)
        write(slopes, CONTROL + 1, j, to_control * filters * per_s)
        write(slopes, CONTROL + 2, j, -to_control * s * response * on_speed)
        write(slopes, CONTROL + 3, j, -to_control * computed * response * on_torque)
        write(slopes, CONTROL_FACTOR, j, to_control * response)


@compiled
def _recorded(
    values: Floats, is_filtered: bool, omega: Floats, table: Floats, slopes: Floats, of_control: Floats
) -> None:
    """Mobility and control's response as recorded, and their derivatives to the recording."""
    scale = values[RECORDING]
    for j in range(BLOCK):
        unscaled = read(table, RECORD_ROW, j) * read(table, _KEPT_ROW, j)
        record = scale * unscaled
        mobility, response = record * read(table, MOBILITY_ROW, j), read(table, CONTROL_ROW, j) * inverse(record)
        write(table, RECORD_ROW, j, record)
        write(table, MOBILITY_ROW, j, mobility)
        write(table, CONTROL_ROW, j, response)
        s, half_square = complex(0.0, omega[j]), 0.5 * omega[j] * omega[j]
        sixth_cube = s * s * s * (1.0 / 6.0)
        write(slopes, RECORDING, j, mobility * (1.0 / scale))
        write(slopes, RECORDING + 1, j, -s * mobility)
        write(slopes, RECORDING + 2, j, -half_square * mobility)
        write(slopes, RECORDING + 4, j, -sixth_cube * mobility)
        write(slopes, RECORD_FACTOR, j, mobility)
        write(of_control, RECORDING, j, -response * (1.0 / scale))
        write(of_control, RECORDING + 1, j, s * response)
        write(of_control, RECORDING + 2, j, half_square * response)
        write(of_control, RECORDING + 4, j, sixth_cube * response)
        write(of_control, RECORD_FACTOR, j, -response)
    if is_filtered:
        for j in range(BLOCK):
            logarithm = read(table, _LOGARITHM, j)
            write(slopes, RECORDING + 3, j, -logarithm * read(table, MOBILITY_ROW, j))
            write(of_control, RECORDING + 3, j, logarithm * read(table, CONTROL_ROW, j))


@compiled
def _upwards(
    values: Floats, structure: Structure, part: int, omega: Floats, of_lines: Floats, table: Floats, kept: Floats
) -> None:
    """Admittance of all that lies below the top drive, from the bit up."""
    lines, sections = COURSE + structure.parts, COURSE + structure.parts + PER_LINE * structure.lines
    _bit(values, values[COURSE + part], structure.has_cutting, omega, table)
    if structure.has_motor:
        _motor(values, omega, table, kept[structure.line_of.size])
    for section in range(structure.line_of.size - 1, -1, -1):
        line = structure.line_of[section]
        _section(
            values[lines + PER_LINE * line : lines + PER_LINE * (line + 1)],
            values[sections + PER_SECTION * section : sections + PER_SECTION * (section + 1)],
            of_lines[line],
            omega,
            table,
            kept[section],
        )


@compiled
def _downwards(
    values: Floats, structure: Structure, part: int, omega: Floats, table: Floats, kept: Floats, slopes: Floats
) -> None:
    """Derivatives to the quantities below the top drive, from the top down."""
    lines, sections = COURSE + structure.parts, COURSE + structure.parts + PER_LINE * structure.lines
    for section in range(structure.line_of.size):
        own, line = sections + PER_SECTION * section, lines + PER_LINE * structure.line_of[section]
        _down_section(
            values[own : own + PER_SECTION],
            kept[section],
            table,
            slopes[2 * BLOCK * line :],
            slopes[2 * BLOCK * own :],
        )
    if structure.has_motor:
        _down_motor(omega, kept[structure.line_of.size], table, slopes)
    _down_bit(values, structure.has_cutting, omega, table, slopes, slopes[2 * BLOCK * (COURSE + part) :])


class Scratch(NamedTuple):
    """Tables of one block, refilled for each block."""

    table: Floats
    kept: Floats
    slopes: Floats
    """Derivatives of the mobility to all quantities."""
    of_control: Floats
    """Derivatives of the control's response to the quantities of recording and control."""
    of_lines: Floats
    """Relative stiffness, its derivative to the loss factor, and addition to the shunt admittance of every line."""
    factors: Floats
    """Further factors of recording, control and drive."""
    folded: Complex
    """(2, BLOCK) what the readings of held control fold, rad/(N m s): those of the control, and the recorded ones."""


@compiled
def new_scratch(structure: Structure, quantities: int) -> Scratch:
    """Tables for a system."""
    of_lines, factors = np.zeros((structure.lines, _OF_LINE)), np.zeros(2 * 3 * BLOCK)
    of_lines[:, :BLOCK] = 1.0
    for factor in range(3):
        factors[2 * factor * BLOCK : (2 * factor + 1) * BLOCK] = 1.0
    kept = np.empty((structure.line_of.size + 1, _KEPT))
    slopes, of_control = np.zeros(2 * BLOCK * quantities), np.zeros(2 * BLOCK * TOP_DRIVE)
    folded = np.zeros((2, BLOCK), dtype=np.complex128)
    return Scratch(np.empty(_TABLE), kept, slopes, of_control, of_lines, factors, folded)


@compiled
def fill_curves(curves: Curves, window: int, first: int, scratch: Scratch) -> None:
    """Put one block of the curves of a window into the tables."""
    own = window if curves.factors.shape[0] > 1 else 0
    for factor in range(curves.factors.shape[1]):
        for j in range(BLOCK):
            write(scratch.factors, factor, j, curves.factors[own, factor, first + j])
    for line in range(curves.shunts.shape[1]):
        for j in range(BLOCK):
            write(scratch.of_lines[line], _SHUNT, j, curves.shunts[own, line, first + j])


@compiled
def respond(
    values: Floats, constants: Floats, structure: Structure, omega: Floats, with_slopes: bool, scratch: Scratch
) -> None:
    """Fill the tables with recorded mobility and response of the control at a block of frequencies.

    Parameters
    ----------
    with_slopes : whether derivatives are needed; except to the recording's quantities, they are those before recording
    """
    share, lines = 1.0 / structure.parts, COURSE + structure.parts
    table, kept, slopes, of_control, of_lines, factors, folded = scratch
    _drive(values, constants, omega, factors, table)
    if structure.filter_order > 0:
        _filter(values, structure, omega, table)
    for line in range(structure.lines):
        if structure.has_loss[line]:
            _loss(values[lines + PER_LINE * line + 3], constants[FIXED + FIXED_PER_LINE * line], omega, of_lines[line])
    # what follows adds to these; all others are written
    slopes[2 * BLOCK * TOP_DRIVE : 2 * BLOCK * (TOP_DRIVE + 1)] = 0.0
    slopes[2 * BLOCK * MOTOR :] = 0.0
    for part in range(structure.parts):
        _upwards(values, structure, part, omega, of_lines, table, kept)
        _top(values[TOP_DRIVE], share, omega, folded, table, slopes[2 * BLOCK * TOP_DRIVE :])
        if with_slopes:
            _downwards(values, structure, part, omega, table, kept, slopes)
    if with_slopes:
        for line in range(structure.lines):
            to_line = slopes[2 * BLOCK * (lines + PER_LINE * line) :]
            _down_laws(values[lines + PER_LINE * line + 5], omega, of_lines[line], to_line)
        _down_drive(values, 0.5 * constants[HELD], omega, factors, table, slopes, of_control)
    _recorded(values, structure.filter_order > 0, omega, table, slopes, of_control)
