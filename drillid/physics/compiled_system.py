"""A drilling system and its recording as rows of numbers, from which compiled responses are computed.

The responses are those of `drillid.physics.responses` and `drillid.physics.sensor`, whitened and with derivatives, at
a small part of the cost. What the compiled code does not know, such as impedance matching or a law of damping that a
user has added, is left to those.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from drillid.arrays import Complex, Floats, Indices
from drillid.physics.bottom_end import cutting_admittance
from drillid.physics.damping import ConstantLossFactor, RootDrag
from drillid.physics.dual_numbers import Dual, primal
from drillid.physics.equipment import Bit, Controller, DrillingSystem, Motor, Section, StribeckCutting, TopDrive
from drillid.physics.kernel import BLOCK
from drillid.physics.sensor import Recording
from drillid.physics.system_kernel import Structure
from drillid.physics.system_products import Data, Slopes, products, whitened


@dataclass(frozen=True, eq=False)
class CompiledSystem:
    """Quantities of a system in all windows."""

    quantities: list[Any]
    """In the order of `drillid.physics.system_kernel`; numbers, arrays (W, 1) or Duals of them."""
    constants: list[Any]
    """The same of what no derivative is taken to."""
    structure: Structure

    def whitened(self, data: Data, coordinates: int) -> tuple[Complex, Complex]:
        """Whitened residuals (W, rows), and derivatives (W, coordinates, rows) of the modelled responses.

        Parameters
        ----------
        coordinates : number of those that the quantities are Duals of
        """
        windows, rows = data.weight.shape[0], data.frequencies + data.control_weight.shape[1]
        residual = np.empty((windows, rows), dtype=complex)
        jacobian = np.zeros((windows, coordinates, rows), dtype=complex)
        values, constants, pairs, active = self._numbers(windows)
        whitened(values, constants, self.structure, data, pairs, active, residual, jacobian)
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
        values, constants, pairs, active = self._numbers(count)
        products(values, constants, self.structure, data, pairs, active, windows, sums[0], sums[1])
        lower = np.tril(sums)
        full = lower + np.swapaxes(np.tril(sums, -1), -1, -2)
        return full[0], full[1]

    def _numbers(self, windows: int) -> tuple[Floats, Floats, Slopes, Indices]:
        """Quantities and constants (W, K), their derivatives to coordinates, and which quantities have any."""
        duals = [(place, own) for place, own in enumerate(self.quantities) if isinstance(own, Dual)]
        pairs = Slopes(
            np.array([place for place, own in duals for _ in own.indices], dtype=np.int64),
            np.array([index for _, own in duals for index in own.indices], dtype=np.int64),
            _columns([slope for _, own in duals for slope in own.tangents], windows),
        )
        active = np.array([place for place, _ in duals], dtype=np.int64)
        return _columns(self.quantities, windows), _columns(self.constants, windows), pairs, active


def _columns(quantities: Sequence[Any], windows: int) -> Floats:
    """Table (W, K) of numbers and arrays (W, 1)."""
    table = np.empty((windows, len(quantities)))
    for place, quantity in enumerate(quantities):
        value = primal(quantity)
        table[:, place] = value[..., 0] if np.ndim(value) else value
    return table


def data_of(
    frequency: Floats,
    mobility: Complex,
    weight: Floats,
    control_rows: Indices,
    control: Complex,
    control_weight: Floats,
) -> Data:
    """Measured responses (W, F) with their weights, where the control's are (W, rows) at some of the frequencies."""
    omega = 2 * np.pi * np.asarray(frequency, dtype=float)
    padded = np.append(omega, np.full(-omega.size % BLOCK, omega[-1]))
    places = np.full(omega.size, -1, dtype=np.int64)
    places[control_rows] = np.arange(len(control_rows))
    measured = np.where(weight > 0, mobility, 0.0), np.where(control_weight > 0, control, 0.0)
    weights = np.ascontiguousarray(weight), np.ascontiguousarray(control_weight)
    return Data(padded, omega.size, measured[0], weights[0], places, measured[1], weights[1])


def compiled_system(system: DrillingSystem, recording: Recording, course: Sequence[Any]) -> CompiledSystem | None:
    """The system as rows of numbers; None where the compiled code does not know a part of it.

    Parameters
    ----------
    course : N m s/rad, deviation of the damping at the bit in successive, equally long parts of the window
    """
    if not _has_known_parts(system, recording):
        return None
    lines, motor, bit = _Lines(), system.motor or Motor(1.0), _Bit.of(system.bit)
    sections = [lines.add(section) for section in system.string]
    top_drive, controller = system.top_drive, system.top_drive.controller
    higher = *top_drive.hold_higher, *recording.hold_higher
    constants = [controller.compensated_inertia, controller.compensation_filter, *higher, *lines.constants]
    is_shaped = any(part.shaping is not None for part in (top_drive, controller, recording))
    is_known = bit is not None and None not in sections and controller.matching is None and not is_shaped
    if bit is None or not is_known or any(isinstance(constant, Dual) for constant in constants):
        return None
    if not np.all(np.isfinite(primal(motor.stiffness))):
        return None
    order = 0 if np.all(np.isinf(primal(recording.filter_frequency))) else recording.filter_order
    structure = Structure(
        len(course),
        len(lines.has_loss),
        np.array(sections, dtype=np.int64),
        np.array(lines.has_loss, dtype=np.int64),
        system.motor is not None,
        bit.has_cutting,
        order,
        np.array([2 * np.sin(np.pi * (2 * pair + 1) / (2 * order)) for pair in range(order // 2)]),
    )
    clock_variance = recording.clock_jitter * recording.clock_jitter + recording.hold_variance
    delay_variance = top_drive.delay_jitter * top_drive.delay_jitter + top_drive.hold_variance
    quantities = [
        *(recording.scale, recording.clock_offset, clock_variance, recording.filter_frequency),
        recording.hold_skewness,
        *(controller.proportional, controller.integral, controller.speed_filter, controller.torque_filter),
        *(top_drive.inertia, top_drive.delay, delay_variance, top_drive.gain, top_drive.lag, top_drive.hold_skewness),
        *(motor.stiffness, motor.damping, motor.inertia),
        *(system.bit.inertia, bit.amplitude, bit.blade_time),
        *(bit.damping if isinstance(more, float) and more == 0 else bit.damping + more for more in course),
        *lines.quantities,
        *(quantity for section in system.string for quantity in (section.length, section.polar_moment)),
    ]
    return CompiledSystem(quantities, constants, structure)


def _has_known_parts(system: DrillingSystem, recording: Recording) -> bool:
    """Whether every part is of the very class that the compiled code was written for, as a subclass may add to it."""
    parts: dict[type, Sequence[Any]] = {
        DrillingSystem: [system],
        Recording: [recording],
        TopDrive: [system.top_drive],
        Controller: [system.top_drive.controller],
        Motor: [system.motor] if system.motor else [],
        Bit: [system.bit],
        Section: system.string,
    }
    return all(type(part) is kind for kind, found in parts.items() for part in found)


@dataclass(frozen=True, eq=False)
class _Bit:
    """Damping at the bit, and its regenerative cutting."""

    damping: Any
    amplitude: Any = 0.0
    blade_time: Any = 1.0
    has_cutting: bool = False

    @classmethod
    def of(cls, bit: Bit) -> "_Bit | None":
        """Of a bit that cuts regeneratively by one law at most."""
        damping, regenerative = bit.damping, []
        for law in bit.cutting:
            if isinstance(law, StribeckCutting):
                # its admittance is a number
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
    """κ, δ, coefficient of drag and loss factor of each."""
    constants: list[Any] = field(default_factory=list)
    """Density, shear modulus and reference frequency of each."""
    has_loss: list[int] = field(default_factory=list)
    places: dict[tuple[int, ...], int] = field(default_factory=dict)

    def add(self, section: Section) -> int | None:
        """Place of a section's line; None where its laws are not known."""
        laws = {type(law): law for law in section.laws}
        if len(laws) < len(section.laws) or not laws.keys() <= {RootDrag, ConstantLossFactor}:
            return None
        # sections are copies of one another with other lengths, and share their quantities
        own = (section.kappa, section.delta, section.density, section.shear_modulus, *section.laws)
        key = tuple(id(quantity) for quantity in own)
        if key not in self.places:
            drag, loss = laws.get(RootDrag), laws.get(ConstantLossFactor)
            coefficient = drag.coefficient if isinstance(drag, RootDrag) else 0.0
            factor, reference = (
                (loss.loss_factor, loss.reference_frequency) if isinstance(loss, ConstantLossFactor) else (0.0, 1.0)
            )
            self.quantities += [section.kappa, section.delta, coefficient, factor]
            self.constants += [section.density, section.shear_modulus, reference]
            self.places[key] = len(self.has_loss)
            self.has_loss.append(int(loss is not None))
        return self.places[key]
