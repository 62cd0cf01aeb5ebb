"""The lumped two-inertia model (paper, figure 2): top drive and bottom-hole assembly joined by one spring."""

from dataclasses import dataclass

import numpy as np

from drillid.arrays import Complex
from drillid.physics.bottom_end import above_motor, bit_load
from drillid.physics.equipment import DrillingSystem, Quantity, Section, TopDrive
from drillid.physics.line import immittances
from drillid.physics.top_drive import torque_transfers


@dataclass(frozen=True)
class LumpedString:
    """A spring with the bottom-hole assembly's inertia at its end; undamped, it is that figure's upper graph.

    The paper's lumped model has no inertia of the string itself; `of_section` distributes it as
    one element of the ladder does, half at the top and half below.
    """

    stiffness: Quantity
    """K_s, N m/rad."""
    inertia_bha: Quantity
    """J_bha, kg m²."""
    internal_damping: Quantity = 0.0
    """Y_int, N m s/rad, in parallel with the spring."""
    external_damping: Quantity = 0.0
    """Y_ext, N m s/rad, between the bottom-hole assembly and the ground."""
    inertia_top: Quantity = 0.0
    """kg m², of the string at the top drive."""
    external_damping_top: Quantity = 0.0
    """N m s/rad, of the string at the top drive."""

    @classmethod
    def of_section(cls, section: Section, inertia_bha: Quantity = 0.0, damping_bha: Quantity = 0.0) -> "LumpedString":
        """One element of a uniform section with the paper's two dampings, loaded by a bottom-hole assembly."""
        half_inertia = section.inertia / 2
        half_drag = section.kappa * section.polar_moment * section.length / 2
        per_length = section.polar_moment / section.length
        return cls(
            stiffness=section.shear_modulus * per_length,
            inertia_bha=half_inertia + inertia_bha,
            internal_damping=section.delta * per_length,
            external_damping=half_drag + damping_bha,
            inertia_top=half_inertia,
            external_damping_top=half_drag,
        )

    @property
    def clamped_mode(self) -> Quantity:
        """Pole above the real axis with the top clamped, 1/s; on the real axis where the system is overdamped."""
        damping = self.internal_damping + self.external_damping
        half = damping / (2 * self.inertia_bha)
        return -half + np.sqrt(half * half - self.stiffness / self.inertia_bha + 0j)

    def admittance(self, s: Complex) -> Complex:
        """Y_in, torque into the string per speed at its upper end, N m s/rad."""
        spring = self.stiffness / s + self.internal_damping
        below = self.inertia_bha * s + self.external_damping
        total: Complex = self.inertia_top * s + self.external_damping_top + spring * below / (spring + below)
        return total

    def command_mobility(self, top_drive: TopDrive, s: Complex) -> Complex:
        """Top-drive speed per sweep torque, rad/(N m s)."""
        command_transfer, feedback = torque_transfers(top_drive, s)
        mobility: Complex = command_transfer / (top_drive.inertia * s + feedback + self.admittance(s))
        return mobility


def ladder_input_admittance(section: Section, load: Complex, s: Complex, elements: int) -> Complex:
    """Admittance (N m s/rad) at one end of a section of `elements` equal lumps whose other end carries `load`.

    Each element has half of its inertia and drag at either node, and between them its stiffness in
    parallel with its internal damping, whatever the laws, so that the error is of order elements⁻².
    One element is the lumped two-inertia model of figure 2.
    """
    step = section.length / elements
    shunt, series = immittances(section, s)
    half, spring = shunt * step / 2, series / step
    admittance = load
    for _ in range(elements):
        below = admittance + half
        admittance = half + below * spring / (below + spring)
    return admittance


def ladder_string_admittance(system: DrillingSystem, s: Complex, elements: int) -> Complex:
    """Y_in (N m s/rad) of the whole string with so many elements in each section."""
    admittance = above_motor(system.motor, bit_load(system.bit, s), s)
    for section in reversed(system.string):
        admittance = ladder_input_admittance(section, admittance, s, elements)
    return admittance
