"""Compiled responses beside measured ones: whitened residuals, derivatives to coordinates, and their products.

A system's quantities depend on a few coordinates, window by window. Sums over frequencies are taken block by
block, while a block's tables are in the processor's cache.
"""

from typing import NamedTuple

import numpy as np

from drillid.arrays import Complex, Floats, Integers
from drillid.physics.kernel import BLOCK, compiled, inverse, read, write
from drillid.physics.system_kernel import (
    CONTROL_ROW,
    MOBILITY_ROW,
    RECORD_ROW,
    Scratch,
    fill_curves,
    fold,
    new_scratch,
    respond,
)
from drillid.physics.system_layout import CONTROL, TOP_DRIVE, Curves, Structure, add


class Data(NamedTuple):
    """Measurements to compare with a system's responses, at F frequencies."""

    omega: Floats
    """(blocks · BLOCK,) 1/s, padded with the last one."""
    frequencies: int
    mobility: Complex
    """(W, F)"""
    weight: Floats
    """(W, F) reciprocal standard deviations."""
    control_rows: Integers
    """(F,) row of the control's response at each frequency; −1 where there is none."""
    control: Complex
    """(W, control rows)"""
    control_weight: Floats
    """(W, control rows)"""


class Slopes(NamedTuple):
    """Non-zero derivatives of quantities to coordinates."""

    quantity: Integers
    """(pairs,) place of the quantity."""
    coordinate: Integers
    """(pairs,) coordinate that the derivative is taken to."""
    slope: Floats
    """(W, pairs) derivative."""


@compiled
def _whiten(first: int, window: int, data: Data, active: Integers, scratch: Scratch) -> None:
    """Derivatives of the recorded responses, whitened."""
    table, slopes, of_control = scratch.table, scratch.slopes, scratch.of_control
    factor, control_factor = np.zeros(2 * BLOCK), np.zeros(2 * BLOCK)
    weight, control_weight = np.zeros(BLOCK), np.zeros(BLOCK)
    for j in range(min(BLOCK, data.frequencies - first)):
        weight[j] = data.weight[window, first + j]
        row = data.control_rows[first + j]
        if row >= 0:
            control_weight[j] = data.control_weight[window, row]
    for j in range(BLOCK):
        record = read(table, RECORD_ROW, j)
        write(factor, 0, j, weight[j] * record)
        write(control_factor, 0, j, control_weight[j] * inverse(record))
    for quantity in active:
        own = slopes[2 * BLOCK * quantity : 2 * BLOCK * (quantity + 1)]
        if quantity >= CONTROL:
            for j in range(BLOCK):
                write(own, 0, j, read(own, 0, j) * read(factor, 0, j))
        else:
            for j in range(BLOCK):
                write(own, 0, j, read(own, 0, j) * weight[j])
        if quantity >= TOP_DRIVE:
            continue
        own = of_control[2 * BLOCK * quantity : 2 * BLOCK * (quantity + 1)]
        if quantity >= CONTROL:
            for j in range(BLOCK):
                write(own, 0, j, read(own, 0, j) * read(control_factor, 0, j))
        else:
            for j in range(BLOCK):
                write(own, 0, j, read(own, 0, j) * control_weight[j])


@compiled
def _residuals(first: int, window: int, data: Data, table: Floats, of_mobility: Floats, of_control: Floats) -> None:
    """Whitened residuals of a block, 0 beyond the last frequency."""
    of_mobility[:], of_control[:] = 0.0, 0.0
    for j in range(min(BLOCK, data.frequencies - first)):
        i = first + j
        difference = data.mobility[window, i] - read(table, MOBILITY_ROW, j)
        write(of_mobility, 0, j, difference * data.weight[window, i])
        row = data.control_rows[i]
        if row >= 0:
            difference = data.control[window, row] - read(table, CONTROL_ROW, j)
            write(of_control, 0, j, difference * data.control_weight[window, row])


@compiled
def _to_coordinates(window: int, pairs: Slopes, scratch: Scratch, mobility: Floats, control: Floats) -> None:
    """Derivatives (coordinates, 2 BLOCK) to the coordinates, by the chain rule."""
    mobility[:], control[:] = 0.0, 0.0
    for pair in range(pairs.quantity.size):
        quantity, slope = pairs.quantity[pair], pairs.slope[window, pair]
        own, total = scratch.slopes[2 * BLOCK * quantity :], mobility[pairs.coordinate[pair]]
        for j in range(2 * BLOCK):
            total[j] += slope * own[j]
        if quantity < TOP_DRIVE:
            own, total = scratch.of_control[2 * BLOCK * quantity :], control[pairs.coordinate[pair]]
            for j in range(2 * BLOCK):
                total[j] += slope * own[j]


@compiled
def _along_curves(window: int, first: int, curves: Curves, scratch: Scratch, mobility: Floats, control: Floats) -> None:
    """Add the derivatives to the coordinates that curves depend on."""
    window = window if curves.slope.shape[0] > 1 else 0
    for pair in range(curves.quantity.size):
        quantity, coordinate = curves.quantity[pair], curves.coordinate[pair]
        own, of_control = scratch.slopes[2 * BLOCK * quantity :], scratch.of_control[2 * BLOCK * quantity :]
        for j in range(BLOCK):
            slope = curves.slope[window, pair, first + j]
            add(mobility[coordinate], 0, j, slope * read(own, 0, j))
            if quantity < TOP_DRIVE:
                add(control[coordinate], 0, j, slope * read(of_control, 0, j))


@compiled
def _put(first: int, data: Data, of_mobility: Floats, of_control: Floats, target: Complex) -> None:
    """Copy one block's numbers into a row (rows,)."""
    for j in range(min(BLOCK, data.frequencies - first)):
        target[first + j] = read(of_mobility, 0, j)
        row = data.control_rows[first + j]
        if row >= 0:
            target[data.frequencies + row] = read(of_control, 0, j)


@compiled
def whitened(
    values: Floats,
    constants: Floats,
    structure: Structure,
    data: Data,
    pairs: Slopes,
    curves: Curves,
    active: Integers,
    residual: Complex,
    jacobian: Complex,
) -> None:
    """Whitened residuals of mobilities and of the control's responses, and derivatives of the modelled ones.

    Parameters
    ----------
    values : (W, quantities)
    constants : (W, FIXED + FIXED_PER_LINE lines)
    active : quantities that depend on coordinates
    residual : (W, rows), filled
    jacobian : (W, coordinates, rows), filled; without coordinates no derivatives are computed
    """
    scratch, coordinates = new_scratch(structure, values.shape[1]), jacobian.shape[1]
    folded = np.empty((2, data.omega.size), dtype=np.complex128)
    mobility, control = np.zeros((coordinates + 1, 2 * BLOCK)), np.zeros((coordinates + 1, 2 * BLOCK))
    for window in range(values.shape[0]):
        fold(values[window], constants[window], structure, data.omega, folded)
        for first in range(0, data.frequencies, BLOCK):
            omega = data.omega[first : first + BLOCK]
            fill_curves(curves, window, first, scratch)
            scratch.folded[:] = folded[:, first : first + BLOCK]
            respond(values[window], constants[window], structure, omega, active.size > 0, scratch)
            _residuals(first, window, data, scratch.table, mobility[coordinates], control[coordinates])
            _put(first, data, mobility[coordinates], control[coordinates], residual[window])
            if active.size:
                _whiten(first, window, data, active, scratch)
                _to_coordinates(window, pairs, scratch, mobility[:coordinates], control[:coordinates])
                _along_curves(window, first, curves, scratch, mobility, control)
            for coordinate in range(coordinates):
                _put(first, data, mobility[coordinate], control[coordinate], jacobian[window, coordinate])


@compiled
def _add_products(rows: Floats, chosen: Integers, total: Floats) -> None:
    """Products of all pairs of chosen rows, at least the lower triangle, two rows by two: half as much is read."""
    paired = chosen.size // 2 * 2
    for one in range(0, paired, 2):
        first, second = rows[chosen[one]], rows[chosen[one + 1]]
        for other in range(0, one + 1, 2):
            third, fourth = rows[chosen[other]], rows[chosen[other + 1]]
            first_third, first_fourth, second_third, second_fourth = 0.0, 0.0, 0.0, 0.0
            for j in range(2 * BLOCK):
                first_third += first[j] * third[j]
                first_fourth += first[j] * fourth[j]
                second_third += second[j] * third[j]
                second_fourth += second[j] * fourth[j]
            total[chosen[one], chosen[other]] += first_third
            total[chosen[one], chosen[other + 1]] += first_fourth
            total[chosen[one + 1], chosen[other]] += second_third
            total[chosen[one + 1], chosen[other + 1]] += second_fourth
    for one in chosen[paired:]:
        first = rows[one]
        for other in chosen:
            product, second = 0.0, rows[other]
            for j in range(2 * BLOCK):
                product += first[j] * second[j]
            total[one, other] += product


@compiled
def _of_control(pairs: Slopes, curves: Curves, coordinates: int) -> Integers:
    """Coordinates that the control's response depends on, and last the place of the residuals."""
    shows = np.zeros(coordinates + 1, dtype=np.bool_)
    shows[coordinates] = True
    for pair in range(pairs.quantity.size):
        shows[pairs.coordinate[pair]] |= pairs.quantity[pair] < TOP_DRIVE
    for pair in range(curves.quantity.size):
        shows[curves.coordinate[pair]] |= curves.quantity[pair] < TOP_DRIVE
    return shows.nonzero()[0]


@compiled
def products(
    values: Floats,
    constants: Floats,
    structure: Structure,
    data: Data,
    pairs: Slopes,
    curves: Curves,
    active: Integers,
    windows: Integers,
    of_mobilities: Floats,
    of_all: Floats,
) -> None:
    """Products of the whitened derivatives and residuals, summed over rows, of some windows.

    Parameters
    ----------
    windows : rows of the windows that are computed
    of_mobilities, of_all : (W, coordinates + 1, coordinates + 1) of the mobilities alone and of all rows, filled in the
        lower triangle; the residuals come last
    """
    scratch, coordinates = new_scratch(structure, values.shape[1]), of_all.shape[1] - 1
    folded = np.empty((2, data.omega.size), dtype=np.complex128)
    mobility, control = np.zeros((coordinates + 1, 2 * BLOCK)), np.zeros((coordinates + 1, 2 * BLOCK))
    every, of_control = np.arange(coordinates + 1), _of_control(pairs, curves, coordinates)
    for window in windows:
        of_mobilities[window], of_all[window] = 0.0, 0.0
        fold(values[window], constants[window], structure, data.omega, folded)
        for first in range(0, data.frequencies, BLOCK):
            omega = data.omega[first : first + BLOCK]
            fill_curves(curves, window, first, scratch)
            scratch.folded[:] = folded[:, first : first + BLOCK]
            respond(values[window], constants[window], structure, omega, True, scratch)
            _residuals(first, window, data, scratch.table, mobility[coordinates], control[coordinates])
            _whiten(first, window, data, active, scratch)
            _to_coordinates(window, pairs, scratch, mobility[:coordinates], control[:coordinates])
            _along_curves(window, first, curves, scratch, mobility, control)
            _add_products(mobility, every, of_mobilities[window])
            if data.control_weight.shape[1]:
                _add_products(control, of_control, of_all[window])
        of_all[window] += of_mobilities[window]
