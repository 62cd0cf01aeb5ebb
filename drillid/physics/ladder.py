"""The string as a ladder of lumped elements (paper, figures 2 to 4); it converges to the line as n grows."""

import numpy as np

from drillid.physics.equipment import Section
from drillid.physics.line import Complex


def ladder_input_admittance(section: Section, load: Complex, s: Complex, elements: int) -> Complex:
    """Admittance (N m s/rad) at one end of a section of `elements` equal lumps whose other end carries `load`.

    Each element has half of its inertia and wall damping at either node and between them its
    stiffness in parallel with its internal damping, so that the error falls with elements⁻².
    One element is the lumped two-inertia model of figure 2.
    """
    step = section.length / elements
    shunt = (section.density * s + section.kappa) * section.polar_moment * step
    spring = (section.shear_modulus / s + section.delta) * section.polar_moment / step
    admittance = np.asarray(load, dtype=complex)
    for _ in range(elements):
        below = admittance + shunt / 2
        admittance = shunt / 2 + below * spring / (below + spring)
    return admittance
