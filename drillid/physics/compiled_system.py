"""A drilling system and its recording as rows of numbers, from which compiled responses are computed.

The responses are those of `drillid.physics.responses` and `drillid.physics.sensor`, whitened and with derivatives, at
a small part of the cost. Further factors of a transfer and laws that add to the shunt admittance are computed
outside and passed in as curves over frequency. What the compiled code does not cover, such as impedance matching or a
law that adds to the series admittance, is left to those modules.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import lru_cache
from typing import Any

import numpy as np

from drillid.arrays import Booleans, Complex, Floats, Indices, Integers
from drillid.physics.bottom_end import cutting_admittance
from drillid.physics.damping import ConstantLossFactor, DampingLaw, RootDrag
from drillid.physics.dual_numbers import Dual, primal
from drillid.physics.equipment import (
    Bit,
    Controller,
    DrillingSystem,
    Motor,
    Section,
    Shaping,
    StribeckCutting,
    TopDrive,
)
from drillid.physics.held_control import Held, cumulants_beyond, filter_pairs
from drillid.physics.kernel import BLOCK
from drillid.physics.sensor import Recording
from drillid.physics.system_layout import (
    CONTROL_FACTOR,
    COURSE,
    DRIVE_FACTOR,
    FIXED,
    HELD,
    PER_LINE,
    RECORD_FACTOR,
    Curves,
    Structure,
)
from drillid.physics.system_products import Data, Slopes, products, whitened

_FACTORS = RECORD_FACTOR, CONTROL_FACTOR, DRIVE_FACTOR
"""Quantities that stand for the further factors, in the order of the curves."""
_KNOWN = frozenset((RootDrag, ConstantLossFactor))
"""Laws that the compiled code computes itself."""


@dataclass(frozen=True, eq=False)
class CompiledSystem:
    """Quantities of a system in all windows."""

    quantities: list[Any]
    """In the order of `drillid.physics.system_layout`; numbers, arrays (W, 1) or Duals of them."""
    constants: list[Any]
    """Likewise the constants, to which no derivatives are taken."""
    structure: Structure
    factors: tuple[Recording | None, Shaping | None, Shaping | None]
    """Further factors of recording, control and top drive."""
    shunts: Sequence[tuple[int, DampingLaw, Section]]
    """Laws that add to the shunt admittance of a line, each with its place and a section of that line."""

    def whitened(self, data: Data, coordinates: int) -> tuple[Complex, Complex]:
        """Whitened residuals (W, rows), and derivatives (W, coordinates, rows) of the modelled responses.

        Parameters
        ----------
        coordinates : number of those that the quantities are Duals of
        """
        windows, rows = data.weight.shape[0], data.frequencies + data.control_weight.shape[1]
        residual = np.empty((windows, rows), dtype=complex)
        jacobian = np.zeros((windows, coordinates, rows), dtype=complex)
        whitened(*self._arguments(data), residual, jacobian)
        return residual, jacobian

    def products(self, data: Data, coordinates: int, windows: Indices) -> tuple[Floats, Floats]:
        """Products of the derivatives and of the residuals, which come last, summed over rows.

        Parameters
        ----------
        windows : rows of the windows that are computed; the others are zero

        Returns
        -------
        of_mobilities, of_all : (W, coordinates + 1, coordinates + 1)
        """
        count = data.weight.shape[0]
        sums = np.zeros((2, count, coordinates + 1, coordinates + 1))
        products(*self._arguments(data), windows, sums[0], sums[1])
        # the lower triangle is computed
        full = np.where(_lower(coordinates + 1), sums, np.swapaxes(sums, -1, -2))
        return full[0], full[1]

    def _arguments(self, data: Data) -> tuple[Floats, Floats, Structure, Data, Slopes, Curves, Integers]:
        """Arguments of the compiled functions: quantities and constants (W, K), and what depends on coordinates."""
        windows = data.weight.shape[0]
        duals = [(place, own) for place, own in enumerate(self.quantities) if isinstance(own, Dual)]
        pairs = Slopes(*_pairs(duals), _columns([slope for _, own in duals for slope in own.tangents], windows))
        values, constants = (_columns(own, windows) for own in (self.quantities, self.constants))
        curves = self._curves(data.omega)
        active = np.bincount(np.concatenate([pairs.quantity, curves.quantity])).nonzero()[0]
        return values, constants, self.structure, data, pairs, curves, active

    def _curves(self, omega: Floats) -> Curves:
        """Further factors and additions to shunt admittances, with their derivatives to coordinates."""
        if not self.shunts and all(own is None for own in self.factors):
            return _no_curves(omega.size)
        s, kappa = np.asarray(1j * omega, dtype=complex), COURSE + self.structure.parts
        factors = {place: own.factor(s) for place, own in zip(_FACTORS, self.factors, strict=True) if own is not None}
        shunts = [(line, law.shunt(section, s) / section.polar_moment) for line, law, section in self.shunts]
        # a factor divided by its value has the derivatives of its logarithm
        by_place = [(place, factor / primal(factor)) for place, factor in factors.items()]
        by_place += [(kappa + PER_LINE * line, addition) for line, addition in shunts]
        windows = max((primal(curve).shape[0] for _, curve in by_place if np.ndim(primal(curve)) > 1), default=1)
        of_factors = np.ones((windows, len(_FACTORS) if factors else 0, s.size), dtype=complex)
        for place, factor in factors.items():
            of_factors[:, _FACTORS.index(place)] = primal(factor)
        of_lines = np.zeros((windows, self.structure.lines if shunts else 0, s.size), dtype=complex)
        for line, addition in shunts:
            of_lines[:, line] += primal(addition)
        duals = [(place, own) for place, own in by_place if isinstance(own, Dual)]
        rows = [np.broadcast_to(row, (windows, s.size)) for _, own in duals for row in own.tangents]
        slope = np.stack(rows, axis=1).astype(complex) if rows else np.empty((windows, 0, s.size), dtype=complex)
        return Curves(of_factors, of_lines, *_pairs(duals), slope)


@lru_cache
def _no_curves(frequencies: int) -> Curves:
    """Of a system without further factors and additions."""
    none, pairs = np.ones((1, 0, frequencies), dtype=complex), np.empty(0, dtype=np.int64)
    return Curves(none, none, pairs, pairs, none)


@lru_cache
def _lower(size: int) -> Booleans:
    """Mask of a matrix's lower triangle."""
    return np.tri(size, dtype=bool)


def _pairs(duals: Sequence[tuple[int, Dual]]) -> tuple[Integers, Integers]:
    """Place of each Dual, and each coordinate that it depends on, pair by pair."""
    places = [place for place, own in duals for _ in range(own.indices.size)]
    coordinates = [index for _, own in duals for index in own.indices.tolist()]
    return np.array(places, dtype=np.int64), np.array(coordinates, dtype=np.int64)


def _columns(quantities: Sequence[Any], windows: int) -> Floats:
    """Table (W, K) of numbers and arrays (W, 1)."""
    values = [quantity.value if isinstance(quantity, Dual) else quantity for quantity in quantities]
    if windows == 1:
        # the same result at a fraction of the cost
        return np.array([[value.item() if isinstance(value, np.ndarray) else value for value in values]], dtype=float)
    table = np.empty((windows, len(values)))
    for place, value in enumerate(values):
        table[:, place] = value[..., 0] if isinstance(value, np.ndarray) and value.ndim else value
    return table


def data_of(
    frequency: Floats,
    mobility: Complex,
    weight: Floats,
    control_rows: Indices,
    control: Complex,
    control_weight: Floats,
) -> Data:
    """Measured responses (W, F) with their weights; those of the control are (W, rows), at some of the frequencies."""
    omega = 2 * np.pi * np.asarray(frequency, dtype=float)
    padded = np.append(omega, np.full(-omega.size % BLOCK, omega[-1]))
    places = np.full(omega.size, -1, dtype=np.int64)
    places[control_rows] = np.arange(len(control_rows))
    measured = np.where(weight > 0, mobility, 0.0), np.where(control_weight > 0, control, 0.0)
    weights = np.ascontiguousarray(weight), np.ascontiguousarray(control_weight)
    return Data(padded, omega.size, measured[0], weights[0], places, measured[1], weights[1])


def compiled_system(
    system: DrillingSystem, recording: Recording, course: Sequence[Any], held: Held | None = None
) -> CompiledSystem | None:
    """The system as rows of numbers; None where the compiled code does not cover a part of it.

    Parameters
    ----------
    course : N m s/rad, deviation of the damping at the bit in successive, equally long parts of the window
    held : control that samples and holds, whose cumulants the system has
    """
    if not _has_known_parts(system, recording):
        return None
    lines, motor, bit = _Lines(), system.motor or Motor(1.0), _Bit.of(system.bit)
    sections = [lines.add(section) for section in system.string]
    top_drive, controller = system.top_drive, system.top_drive.controller
    read, later = (held.read, held.later) if held is not None else (None, None)
    hold_variance, hold_skewness, *hold_higher = cumulants_beyond(top_drive, read)
    kept_variance, kept_skewness, *kept_higher = cumulants_beyond(recording, later)
    constants = [controller.compensated_inertia, controller.compensation_filter]
    constants += [*hold_higher, *kept_higher, *_held_constants(held), *lines.constants]
    is_known = None not in sections and controller.matching is None
    if bit is None or not is_known or any(isinstance(constant, Dual) for constant in constants):
        return None
    if not np.all(np.isfinite(primal(motor.stiffness))):
        return None
    order = recording.filter_order if recording.has_filter else 0
    structure = Structure(
        len(course),
        len(lines.has_loss),
        np.array(sections, dtype=np.int64),
        np.array(lines.has_loss, dtype=np.int64),
        system.motor is not None,
        bit.has_cutting,
        order,
        filter_pairs(order),
    )
    clock_variance = recording.variance + kept_variance
    delay_variance = top_drive.delay_jitter * top_drive.delay_jitter + hold_variance
    quantities = [
        *(recording.scale, recording.lateness, clock_variance, recording.filter_frequency),
        *(kept_skewness, 0.0),
        *(controller.proportional, controller.integral, controller.speed_filter, controller.torque_filter, 0.0),
        *(top_drive.inertia, top_drive.delay, delay_variance, top_drive.gain, top_drive.lag, hold_skewness),
        0.0,
        *(motor.stiffness, motor.damping, motor.inertia),
        *(system.bit.inertia, bit.amplitude, bit.blade_time),
        *(bit.damping if isinstance(more, float) and more == 0 else bit.damping + more for more in course),
        *lines.quantities,
        *(quantity for section in system.string for quantity in (section.length, section.polar_moment)),
    ]
    factors = recording if recording.has_factor else None, controller.shaping, top_drive.shaping
    return CompiledSystem(quantities, constants, structure, factors, lines.shunts)


def _held_constants(held: Held | None) -> list[Any]:
    if held is None:
        return [0.0] * (FIXED - HELD)
    *_, jitter, clock_jitter, _ = held.quantities
    return [held.interval, jitter, clock_jitter]


def _has_known_parts(system: DrillingSystem, recording: Recording) -> bool:
    """Whether every part is exactly of the class that the compiled code was written for; a subclass may add to it."""
    top_drive = system.top_drive
    is_known = type(system) is DrillingSystem and type(recording) is Recording and type(system.bit) is Bit
    is_known = is_known and type(top_drive) is TopDrive and type(top_drive.controller) is Controller
    is_known = is_known and (system.motor is None or type(system.motor) is Motor)
    return is_known and all(type(section) is Section for section in system.string)


@dataclass(frozen=True, eq=False)
class _Bit:
    """Damping at the bit, and its regenerative cutting."""

    damping: Any
    amplitude: Any = 0.0
    blade_time: Any = 1.0
    has_cutting: bool = False

    @classmethod
    def of(cls, bit: Bit) -> "_Bit | None":
        """The bit, if it has at most one regenerative cutting law; None otherwise."""
        damping, regenerative = bit.damping, []
        for law in bit.cutting:
            if isinstance(law, StribeckCutting):
                # its admittance is the same at all frequencies
                damping = damping + cutting_admittance(law, np.zeros(1, dtype=complex))
            else:
                regenerative.append(law)
        if not regenerative:
            return cls(damping)
        if len(regenerative) > 1:
            return None
        amplitude = regenerative[0].blades * regenerative[0].torque / (2 * np.pi)
        return cls(damping, amplitude, 2 * np.pi / (regenerative[0].blades * regenerative[0].speed), True)


@dataclass(eq=False)
class _Lines:
    """The different materials and dampings of a string's sections."""

    quantities: list[Any] = field(default_factory=list)
    """κ, δ, coefficient of drag, loss factor, density and shear modulus of each."""
    constants: list[Any] = field(default_factory=list)
    """Reference frequency of each."""
    shunts: list[tuple[int, DampingLaw, Section]] = field(default_factory=list)
    """Place of a line, a further law that adds to its shunt admittance, and a section of that line."""
    has_loss: list[int] = field(default_factory=list)
    places: dict[tuple[int, ...], int] = field(default_factory=dict)

    def add(self, section: Section) -> int | None:
        """Place of a section's line; None where its laws are not known."""
        laws = {type(law): law for law in section.laws if type(law) in _KNOWN}
        others = [law for law in section.laws if type(law) not in _KNOWN]
        if len(laws) + len(others) < len(section.laws) or any(_adds_in_series(law) for law in others):
            return None
        # sections are often copies of one another with other lengths, and share their quantities
        own = (section.kappa, section.delta, section.density, section.shear_modulus, *section.laws)
        key = tuple(id(quantity) for quantity in own)
        if others:
            key = (*key, id(section.polar_moment))
        if key not in self.places:
            drag, loss = laws.get(RootDrag), laws.get(ConstantLossFactor)
            coefficient = drag.coefficient if isinstance(drag, RootDrag) else 0.0
            factor, reference = (
                (loss.loss_factor, loss.reference_frequency) if isinstance(loss, ConstantLossFactor) else (0.0, 1.0)
            )
            self.quantities += [section.kappa, section.delta, coefficient, factor]
            self.quantities += [section.density, section.shear_modulus]
            self.constants.append(reference)
            self.places[key] = len(self.has_loss)
            self.shunts += [(len(self.has_loss), law, section) for law in others]
            self.has_loss.append(int(loss is not None))
        return self.places[key]


def _adds_in_series(law: DampingLaw) -> bool:
    return type(law).series is not DampingLaw.series
