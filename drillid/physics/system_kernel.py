"""Responses of any drilling system with derivatives to all its quantities, compiled.

The mobility is followed from the bit up, and its derivatives from the top drive down, in the reverse mode of automatic
differentiation (Griewank and Walther 2008, Evaluating Derivatives, chapter 3): one way down gives the derivatives to
all quantities. Quantities depend on a few coordinates, window by window; their derivatives to these are summed here
too, and everything is whitened, so that no table over frequencies leaves the processor's first-level cache.

Frequencies are taken in blocks, and every loop over a block reads and writes few arrays at places known at compile
time, so that it is vectorised.
"""

import math
from typing import NamedTuple

import numpy as np

from drillid.arrays import Complex, Floats, Integers
from drillid.physics.kernel import BLOCK, compiled, falling, inlined, inverse, root, through_section

RECORDING, CONTROL, TOP_DRIVE, MOTOR, BIT, COURSE = 0, 4, 8, 13, 16, 19
"""Where the quantities of each part begin in a row: scale, clock offset, clock jitter and filter frequency of the
recording; P, I and the filters of speed and torque; inertia, delay, delay jitter, gain and lag of the top drive;
stiffness, damping and inertia of the motor; inertia of the bit, amplitude and blade time of its regenerative cutting;
damping at the bit in every part of the window. κ, δ, drag and loss factor of every line follow, then length and polar
moment of every section."""
PER_LINE, PER_SECTION = 4, 2
FIXED = 2
"""Number of constants before those of the lines: compensated inertia and the filter of its compensation."""
FIXED_PER_LINE = 3
"""Density, shear modulus and reference frequency of the loss factor."""


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


class Data(NamedTuple):
    """What is compared with a system's responses, with F frequencies."""

    omega: Floats
    """(blocks · BLOCK,) 1/s, the last one repeated."""
    frequencies: int
    mobility: Complex
    """(W, F)"""
    weight: Floats
    """(W, F) reciprocal standard deviations."""
    control_rows: Integers
    """(F,) row of each frequency's response of the control, or −1."""
    control: Complex
    """(W, control rows)"""
    control_weight: Floats
    """(W, control rows)"""


class Slopes(NamedTuple):
    """Derivatives of quantities to coordinates that are not zero."""

    quantity: Integers
    """(pairs,)"""
    coordinate: Integers
    """(pairs,)"""
    slope: Floats
    """(W, pairs)"""


# places in the table of a block, each of a real and an imaginary row
_DRIVE, _CONTROL, _RECORD, _UNFILTERED, _LOAD, _ADJOINT = 0, 1, 2, 3, 4, 5
_MOBILITY, _TO_DRIVE, _TO_CONTROL, _LOGARITHM, _ROW = 6, 7, 8, 9, 10
_TABLE = 2 * 11 * BLOCK
# places in what is kept of a section
_GAMMA, _SERIES, _BY_LOAD, _BY_OWN, _BY_PHASE = 0, 1, 2, 3, 4
_KEPT = 2 * 5 * BLOCK
# places in what is kept of a motor
_BY_BELOW, _BY_SPRING, _SPRING = 0, 1, 2


@inlined
def _read(table: Floats, which: int, j: int) -> complex:
    return complex(table[2 * which * BLOCK + j], table[(2 * which + 1) * BLOCK + j])


@inlined
def _write(table: Floats, which: int, j: int, value: complex) -> None:
    table[2 * which * BLOCK + j], table[(2 * which + 1) * BLOCK + j] = value.real, value.imag


@inlined
def _add(table: Floats, which: int, j: int, value: complex) -> None:
    table[2 * which * BLOCK + j] += value.real
    table[(2 * which + 1) * BLOCK + j] += value.imag


@compiled
def _drive(values: Floats, constants: Floats, omega: Floats, table: Floats) -> None:
    """Drive, control and clock of the recording."""
    jitter, offset = values[RECORDING + 2], values[RECORDING + 1]
    proportional, integral = values[CONTROL], values[CONTROL + 1]
    speed_filter, torque_filter = values[CONTROL + 2], values[CONTROL + 3]
    delay, delay_jitter, gain, lag = values[9], values[10], values[11], values[12]
    compensated, compensation_filter = constants[0], constants[1]
    for j in range(BLOCK):
        s = complex(0.0, omega[j])
        compensation = compensated * s * inverse(1.0 + compensation_filter * s)
        filters = inverse(1.0 + speed_filter * s) * inverse(1.0 + torque_filter * s)
        square = 0.5 * omega[j] * omega[j]
        delayed = falling(complex(square * delay_jitter * delay_jitter, delay * omega[j]))
        _write(table, _CONTROL, j, (complex(proportional, -integral / omega[j]) - compensation) * filters)
        _write(table, _DRIVE, j, gain * delayed * inverse(1.0 + lag * s))
        _write(table, _RECORD, j, falling(complex(square * jitter * jitter, offset * omega[j])))
        _write(table, _TO_DRIVE, j, complex(0.0, 0.0))
        _write(table, _TO_CONTROL, j, complex(0.0, 0.0))
        _write(table, _MOBILITY, j, complex(0.0, 0.0))


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
        _write(table, _LOGARITHM, j, -logarithm * u * per_corner)
        _write(table, _RECORD, j, _read(table, _RECORD, j) * inverse(polynomial))


@compiled
def _bit(values: Floats, damping: float, has_cutting: bool, omega: Floats, table: Floats) -> None:
    """Admittance of the bit."""
    inertia = values[BIT]
    for j in range(BLOCK):
        _write(table, _LOAD, j, complex(damping, inertia * omega[j]))
    if has_cutting:
        amplitude, blade_time = values[BIT + 1], values[BIT + 2]
        for j in range(BLOCK):
            turned = falling(complex(0.0, blade_time * omega[j])) - 1.0
            _add(table, _LOAD, j, amplitude * turned * complex(0.0, -1.0 / omega[j]))


@compiled
def _motor(values: Floats, omega: Floats, table: Floats, kept: Floats) -> None:
    """Admittance above the motor, and its derivatives to the load and to the spring."""
    stiffness, damping, inertia = values[MOTOR], values[MOTOR + 1], values[MOTOR + 2]
    for j in range(BLOCK):
        s, load = complex(0.0, omega[j]), _read(table, _LOAD, j)
        spring = s * inverse(stiffness + damping * s)
        share = inverse(1.0 + load * spring)
        _write(table, _LOAD, j, inertia * s + load * share)
        _write(kept, _BY_BELOW, j, share * share)
        _write(kept, _BY_SPRING, j, -(load * share) * (load * share))
        _write(kept, _SPRING, j, spring)


@compiled
def _loss(factor: float, reference: float, omega: Floats, stiffening: Floats) -> None:
    """Complex stiffness relative to that without loss, and its derivative to the loss factor."""
    exponent = 2 / math.pi * math.atan(factor)
    slope = 2 / math.pi / (1.0 + factor * factor)
    for j in range(BLOCK):
        logarithm = math.log(omega[j] / (2 * math.pi * reference))
        power = math.exp(exponent * logarithm)
        stiffness = complex(power, factor * power)
        _write(stiffening, 0, j, stiffness)
        _write(stiffening, 1, j, complex(0.0, power) + stiffness * (slope * logarithm))


@compiled
def _section(
    line: Floats, own: Floats, steel: Floats, stiffening: Floats, omega: Floats, table: Floats, kept: Floats
) -> None:
    """Admittance at the upper end of a section, and its derivatives to the load, to Y₀ and to γL."""
    kappa, delta, drag, length, polar = line[0], line[1], line[2], own[0], own[1]
    density, modulus, half_root = steel[0], steel[1], math.sqrt(0.5)
    for j in range(BLOCK):
        dragging = drag * half_root * math.sqrt(omega[j])
        shunt = complex(kappa + dragging, density * omega[j] + dragging)
        series = _read(stiffening, 0, j) * complex(0.0, -modulus / omega[j]) + delta
        per_series = inverse(series)
        gamma = root(shunt * per_series)
        above, by_load, by_own, by_phase = through_section(
            polar * series * gamma, _read(table, _LOAD, j), falling(2.0 * length * gamma)
        )
        _write(table, _LOAD, j, above)
        _write(kept, _GAMMA, j, gamma)
        _write(kept, _SERIES, j, series)
        _write(kept, _BY_LOAD, j, by_load)
        _write(kept, _BY_OWN, j, by_own)
        _write(kept, _BY_PHASE, j, by_phase)


@compiled
def _top(inertia: float, share: float, omega: Floats, table: Floats, to_inertia: Floats) -> None:
    """The mobility, and its derivatives to the string's admittance, to drive, control and inertia."""
    for j in range(BLOCK):
        drive, response = _read(table, _DRIVE, j), _read(table, _CONTROL, j)
        per_total = inverse(complex(0.0, inertia * omega[j]) + _read(table, _LOAD, j) + drive * response)
        mobility = drive * per_total
        adjoint = -share * mobility * per_total
        _add(table, _MOBILITY, j, share * mobility)
        _write(table, _ADJOINT, j, adjoint)
        _add(table, _TO_DRIVE, j, share * per_total + adjoint * response)
        _add(table, _TO_CONTROL, j, adjoint * drive)
        _add(to_inertia, 0, j, adjoint * complex(0.0, omega[j]))


@compiled
def _down_section(own: Floats, kept: Floats, table: Floats, to_line: Floats, to_own: Floats) -> None:
    """From the derivative to the admittance above a section to those to its quantities and to the load below."""
    length, polar = own[0], own[1]
    for j in range(BLOCK):
        adjoint = _read(table, _ADJOINT, j)
        gamma, series = _read(kept, _GAMMA, j), _read(kept, _SERIES, j)
        to_admittance, to_phase = adjoint * _read(kept, _BY_OWN, j), adjoint * _read(kept, _BY_PHASE, j)
        first, second = polar * to_admittance, length * to_phase * inverse(series)
        _add(to_line, 0, j, 0.5 * (first + second) * inverse(gamma))
        _add(to_line, 1, j, 0.5 * (first - second) * gamma)
        _add(to_own, 0, j, to_phase * gamma)
        _add(to_own, 1, j, to_admittance * series * gamma)
        _write(table, _ADJOINT, j, adjoint * _read(kept, _BY_LOAD, j))


@compiled
def _down_laws(modulus: float, omega: Floats, stiffening: Floats, to_line: Floats) -> None:
    """Derivatives to drag and loss factor of a line from those to κ and δ."""
    half_root = math.sqrt(0.5)
    for j in range(BLOCK):
        drag = half_root * math.sqrt(omega[j])
        _write(to_line, 2, j, _read(to_line, 0, j) * complex(drag, drag))
        stiffness = _read(stiffening, 1, j) * complex(0.0, -modulus / omega[j])
        _write(to_line, 3, j, _read(to_line, 1, j) * stiffness)


@compiled
def _down_motor(omega: Floats, kept: Floats, table: Floats, slopes: Floats) -> None:
    for j in range(BLOCK):
        adjoint, s = _read(table, _ADJOINT, j), complex(0.0, omega[j])
        to_spring, spring = adjoint * _read(kept, _BY_SPRING, j), _read(kept, _SPRING, j)
        _add(slopes, MOTOR, j, -to_spring * spring * spring * complex(0.0, -1.0 / omega[j]))
        _add(slopes, MOTOR + 1, j, -to_spring * spring * spring)
        _add(slopes, MOTOR + 2, j, adjoint * s)
        _write(table, _ADJOINT, j, adjoint * _read(kept, _BY_BELOW, j))


@compiled
def _down_bit(
    values: Floats, has_cutting: bool, omega: Floats, table: Floats, slopes: Floats, to_damping: Floats
) -> None:
    for j in range(BLOCK):
        adjoint = _read(table, _ADJOINT, j)
        _add(slopes, BIT, j, adjoint * complex(0.0, omega[j]))
        _write(to_damping, 0, j, adjoint)
    if has_cutting:
        amplitude, blade_time = values[BIT + 1], values[BIT + 2]
        for j in range(BLOCK):
            turned, adjoint = falling(complex(0.0, blade_time * omega[j])), _read(table, _ADJOINT, j)
            _add(slopes, BIT + 1, j, adjoint * (turned - 1.0) * complex(0.0, -1.0 / omega[j]))
            _add(slopes, BIT + 2, j, -amplitude * adjoint * turned)


@compiled
def _down_drive(values: Floats, omega: Floats, table: Floats, slopes: Floats, of_control: Floats) -> None:
    """Derivatives to the quantities of drive and control; those of the control's own response beside them."""
    gain, lag, jitter = values[11], values[12], values[10]
    speed_filter, torque_filter = values[CONTROL + 2], values[CONTROL + 3]
    for j in range(BLOCK):
        s, drive, response = complex(0.0, omega[j]), _read(table, _DRIVE, j), _read(table, _CONTROL, j)
        to_drive, to_control = _read(table, _TO_DRIVE, j) * drive, _read(table, _TO_CONTROL, j)
        _write(slopes, 9, j, -s * to_drive)
        _write(slopes, 10, j, -omega[j] * omega[j] * jitter * to_drive)
        _write(slopes, 11, j, to_drive * (1.0 / gain))
        _write(slopes, 12, j, -s * to_drive * inverse(1.0 + lag * s))
        on_speed, on_torque = inverse(1.0 + speed_filter * s), inverse(1.0 + torque_filter * s)
        filters, per_s = on_speed * on_torque, complex(0.0, -1.0 / omega[j])
        _write(of_control, 4, j, filters)
        _write(of_control, 5, j, filters * per_s)
        _write(of_control, 6, j, -s * response * on_speed)
        _write(of_control, 7, j, -s * response * on_torque)
        _write(slopes, 4, j, to_control * filters)
        _write(slopes, 5, j, to_control * filters * per_s)
        _write(slopes, 6, j, -to_control * s * response * on_speed)
        _write(slopes, 7, j, -to_control * s * response * on_torque)


@compiled
def _recorded(
    values: Floats, is_filtered: bool, omega: Floats, table: Floats, slopes: Floats, of_control: Floats
) -> None:
    """Mobility and control's response as recorded, and their derivatives to the recording."""
    scale, jitter = values[RECORDING], values[RECORDING + 2]
    for j in range(BLOCK):
        unscaled = _read(table, _RECORD, j)
        record = scale * unscaled
        mobility, response = record * _read(table, _MOBILITY, j), _read(table, _CONTROL, j) * inverse(record)
        _write(table, _RECORD, j, record)
        _write(table, _MOBILITY, j, mobility)
        _write(table, _CONTROL, j, response)
        s, square = complex(0.0, omega[j]), omega[j] * omega[j] * jitter
        _write(slopes, 0, j, mobility * (1.0 / scale))
        _write(slopes, 1, j, -s * mobility)
        _write(slopes, 2, j, -square * mobility)
        _write(of_control, 0, j, -response * (1.0 / scale))
        _write(of_control, 1, j, s * response)
        _write(of_control, 2, j, square * response)
    if is_filtered:
        for j in range(BLOCK):
            logarithm = _read(table, _LOGARITHM, j)
            _write(slopes, 3, j, -logarithm * _read(table, _MOBILITY, j))
            _write(of_control, 3, j, logarithm * _read(table, _CONTROL, j))


@compiled
def _upwards(
    values: Floats,
    constants: Floats,
    structure: Structure,
    part: int,
    omega: Floats,
    stiffening: Floats,
    table: Floats,
    kept: Floats,
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
            constants[FIXED + FIXED_PER_LINE * line : FIXED + FIXED_PER_LINE * (line + 1)],
            stiffening[line],
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


@compiled
def _whiten(
    first: int, window: int, data: Data, table: Floats, active: Integers, slopes: Floats, of_control: Floats
) -> None:
    """Derivatives of the recorded responses, whitened."""
    count = min(BLOCK, data.frequencies - first)
    factor, control_factor = np.zeros(2 * BLOCK), np.zeros(2 * BLOCK)
    weight, control_weight = np.zeros(BLOCK), np.zeros(BLOCK)
    for j in range(count):
        weight[j] = data.weight[window, first + j]
        row = data.control_rows[first + j]
        if row >= 0:
            control_weight[j] = data.control_weight[window, row]
    for j in range(BLOCK):
        record = _read(table, _RECORD, j)
        _write(factor, 0, j, weight[j] * record)
        _write(control_factor, 0, j, control_weight[j] * inverse(record))
    for quantity in active:
        own = slopes[2 * BLOCK * quantity : 2 * BLOCK * (quantity + 1)]
        if quantity >= CONTROL:
            for j in range(BLOCK):
                _write(own, 0, j, _read(own, 0, j) * _read(factor, 0, j))
        else:
            for j in range(BLOCK):
                _write(own, 0, j, _read(own, 0, j) * weight[j])
        if quantity >= TOP_DRIVE:
            continue
        own = of_control[2 * BLOCK * quantity : 2 * BLOCK * (quantity + 1)]
        if quantity >= CONTROL:
            for j in range(BLOCK):
                _write(own, 0, j, _read(own, 0, j) * _read(control_factor, 0, j))
        else:
            for j in range(BLOCK):
                _write(own, 0, j, _read(own, 0, j) * control_weight[j])


@compiled
def _residuals(first: int, window: int, data: Data, table: Floats, residual: Complex) -> None:
    for j in range(min(BLOCK, data.frequencies - first)):
        i = first + j
        residual[window, i] = (data.mobility[window, i] - _read(table, _MOBILITY, j)) * data.weight[window, i]
        row = data.control_rows[i]
        if row >= 0:
            own = data.frequencies + row
            difference = data.control[window, row] - _read(table, _CONTROL, j)
            residual[window, own] = difference * data.control_weight[window, row]


@compiled
def _to_coordinates(
    first: int, window: int, data: Data, pairs: Slopes, slopes: Floats, of_control: Floats, jacobian: Complex
) -> None:
    """Derivatives to the coordinates, by the chain rule."""
    coordinates = jacobian.shape[1]
    mobility, control = np.zeros((2, coordinates, 2 * BLOCK))
    for pair in range(pairs.quantity.size):
        quantity, slope = pairs.quantity[pair], pairs.slope[window, pair]
        own, total = slopes[2 * BLOCK * quantity :], mobility[pairs.coordinate[pair]]
        for j in range(2 * BLOCK):
            total[j] += slope * own[j]
        if quantity < TOP_DRIVE:
            own, total = of_control[2 * BLOCK * quantity :], control[pairs.coordinate[pair]]
            for j in range(2 * BLOCK):
                total[j] += slope * own[j]
    for coordinate in range(coordinates):
        of_mobility, of_response, target = mobility[coordinate], control[coordinate], jacobian[window, coordinate]
        for j in range(min(BLOCK, data.frequencies - first)):
            target[first + j] = _read(of_mobility, 0, j)
            row = data.control_rows[first + j]
            if row >= 0:
                target[data.frequencies + row] = _read(of_response, 0, j)


@compiled
def whitened(
    values: Floats,
    constants: Floats,
    structure: Structure,
    data: Data,
    pairs: Slopes,
    active: Integers,
    residual: Complex,
    jacobian: Complex,
) -> None:
    """Whitened residuals of mobilities and of the control's responses, and derivatives of the modelled ones.

    Parameters
    ----------
    values : (W, quantities)
    constants : (W, 2 + 3 lines)
    active : quantities that depend on coordinates
    residual : (W, rows), filled
    jacobian : (W, coordinates, rows), filled; without coordinates no derivatives are computed
    """
    share = 1.0 / structure.parts
    table, kept = np.empty(_TABLE), np.empty((structure.line_of.size + 1, _KEPT))
    slopes, of_control = np.empty(2 * BLOCK * values.shape[1]), np.zeros(2 * BLOCK * TOP_DRIVE)
    stiffening = np.zeros((structure.lines, 4 * BLOCK))
    stiffening[:, :BLOCK] = 1.0
    lines = COURSE + structure.parts
    for window in range(values.shape[0]):
        own, fixed = values[window], constants[window]
        for first in range(0, data.frequencies, BLOCK):
            omega = data.omega[first : first + BLOCK]
            _drive(own, fixed, omega, table)
            if structure.filter_order > 0:
                _filter(own, structure, omega, table)
            for line in range(structure.lines):
                if structure.has_loss[line]:
                    reference = fixed[FIXED + FIXED_PER_LINE * line + 2]
                    _loss(own[lines + PER_LINE * line + 3], reference, omega, stiffening[line])
            slopes[:] = 0.0
            for part in range(structure.parts):
                _upwards(own, fixed, structure, part, omega, stiffening, table, kept)
                _top(own[TOP_DRIVE], share, omega, table, slopes[2 * BLOCK * TOP_DRIVE :])
                if active.size:
                    _downwards(own, structure, part, omega, table, kept, slopes)
            if active.size:
                for line in range(structure.lines):
                    to_line = slopes[2 * BLOCK * (lines + PER_LINE * line) :]
                    _down_laws(fixed[FIXED + FIXED_PER_LINE * line + 1], omega, stiffening[line], to_line)
                _down_drive(own, omega, table, slopes, of_control)
            _recorded(own, structure.filter_order > 0, omega, table, slopes, of_control)
            _residuals(first, window, data, table, residual)
            if active.size:
                _whiten(first, window, data, table, active, slopes, of_control)
                _to_coordinates(first, window, data, pairs, slopes, of_control, jacobian)
