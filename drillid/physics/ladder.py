"""The string as a ladder of lumped elements (paper, figures 2 to 4); it converges to the line as n grows."""

from drillid.physics.bottom_end import above_motor, bit_load
from drillid.physics.equipment import DrillingSystem, Section
from drillid.physics.line import Complex, immittances


def ladder_input_admittance(section: Section, load: Complex, s: Complex, elements: int) -> Complex:
    """Admittance (N m s/rad) at one end of a section of `elements` equal lumps whose other end carries `load`.

    Each element has half of its inertia and drag at either node and between them its stiffness in
    parallel with its internal damping, whatever the laws, so that the error falls with elements⁻².
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
