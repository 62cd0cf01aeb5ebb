"""Laws as tables, compiled: torque of bit and control, compliance of a coupling."""

import numpy as np

from drillid.simulation.parts import CouplingTable, LawTable, compiled


@compiled
def law_torque(law: LawTable, place: float) -> float:
    """Torque (N m) of a law at a speed, or a speed error, in rad/s; straight beyond its ends."""
    steps = (place - law.first) / law.spacing
    k = min(max(int(np.floor(steps)), 0), law.torque.size - 2)
    return float(law.torque[k] + (steps - k) * (law.torque[k + 1] - law.torque[k]))


@compiled
def coupling_compliance(coupling: CouplingTable, torque: float) -> float:
    """Compliance (rad/(N m)) of a coupling at a torque; constant beyond its ends."""
    place = (torque - coupling.first) / coupling.spacing
    last = coupling.compliance.size - 1
    k = min(max(int(np.floor(place)), 0), last - 1)
    share = min(max(place - k, 0.0), 1.0)
    return float(coupling.compliance[k] + share * (coupling.compliance[k + 1] - coupling.compliance[k]))
