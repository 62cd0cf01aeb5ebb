"""Friction at low speed and blades that follow each other, compiled.

A contact's torque is chosen at the end of a step, from the speed that it would have without friction and the compliance
of the string there, so that sticking is exact: the torque that stops it, where that is below the level at rest.
"""

from pathlib import Path
from typing import NamedTuple

import numpy as np

from benchmarks.blind.other_world.rig import FALLS, LAWS
from drillid.arrays import Floats, Integers
from drillid.compiled import compiler

_FOLDER = Path(__file__).parent
compiled = compiler(_FOLDER.name, root=_FOLDER.parent, fastmath={"contract", "reassoc", "nsz"}, _nrt=False)
"""Compile a function of the second world's simulator, which makes no arrays; sums over modes may be reordered."""

KARNOPP, DAHL = LAWS.index("karnopp"), LAWS.index("dahl")
GAUSSIAN = FALLS.index("gaussian")
_DEAD_BAND = 0.02
"""rad/s, of Karnopp's model."""
_BRISTLE = 0.3
"""Stiffness of the bristles, per effective inertia and squared step."""
_BRISTLE_DAMPING = 0.3
"""Damping of the bristles, per effective inertia and step."""


class Contacts(NamedTuple):
    """Frictions of several contacts, each array (contacts,)."""

    law: Integers
    fall: Integers
    coulomb: Floats
    rise: Floats
    threshold: Floats


@compiled
def level(contacts: Contacts, k: int, speed: float) -> float:
    """Friction of steady sliding, N m."""
    ratio = abs(speed) / contacts.threshold[k]
    shape = np.exp(-ratio * ratio) if contacts.fall[k] == GAUSSIAN else 1 / (1 + ratio)
    return float(contacts.coulomb[k] + contacts.rise[k] * shape)


@compiled
def friction_torque(
    contacts: Contacts, k: int, before: float, free: float, compliance: float, step: float, bristle: Floats
) -> float:
    """Torque on the string, N m.

    Parameters
    ----------
    before : rad/s, speed at the step's begin
    free : rad/s, speed at its end without this friction
    compliance : change of that speed per torque
    bristle : (contacts,) rad, deflection of the bristles, updated
    """
    inertia = step / compliance
    if contacts.law[k] == KARNOPP:
        stopping = -free / compliance
        most = level(contacts, k, before if abs(before) > _DEAD_BAND else 0.0)
        return float(min(max(stopping, -most), most))
    stiffness, old = _BRISTLE * inertia / step**2, bristle[k]
    # bristles that stick and slide together end the step at this speed
    damping = 0.0 if contacts.law[k] == DAHL else _BRISTLE_DAMPING * inertia / step
    speed = (free - compliance * stiffness * old) / (1 + compliance * (stiffness * step + damping))
    most = contacts.coulomb[k] if contacts.law[k] == DAHL else level(contacts, k, before)
    bristle[k] = (old + step * speed) / (1 + stiffness * step * abs(speed) / most)
    # their damping vanishes at high speed, so that steady sliding is the level
    damping *= np.exp(-((before / _DEAD_BAND) ** 2))
    return float(-(stiffness * bristle[k] + damping * (bristle[k] - old) / step))


@compiled
def time_behind(angle: Floats, target: float, n: int, start: int) -> tuple[int, float]:
    """Step within which the bit was at an angle, from the last one's, and the steps between that moment and step n."""
    j = start
    while j > 0 and angle[j] > target:
        j -= 1
    while j + 1 < n and angle[j + 1] <= target:
        j += 1
    span = angle[j + 1] - angle[j]
    share = (target - angle[j]) / span if span > 0 else 0.0
    return j, n - j - share
