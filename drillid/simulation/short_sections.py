"""Sections too short for the simulator's time step, such as the rest of a pipe beyond a zone that ends near its end."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from drillid.physics.attachments import MountedInertia
from drillid.physics.equipment import DrillingSystem, Section

_MARGIN = 1 + 1e-9


def with_short_sections_extended(system: DrillingSystem, time_step: float) -> DrillingSystem:
    """The system with every section that a wave passes in less than a time step extended until it takes that long.

    The missing length is taken from the neighbour that is more alike, which is merged if too little of it would be
    left. Length, inertia, viscous damping and mounted inertias of the string are kept. Waves of the sweep are far
    longer than what a wave passes in a time step, so they do not show where inertia and damping are within that length.

    Parameters
    ----------
    system : of one window, all its quantities numbers
    time_step : s
    """
    pieces = [section for section in system.string if section.length > 0]
    while len(pieces) > 1:
        short = [place for place, section in enumerate(pieces) if section.length < _least(section, time_step)]
        if not short:
            break
        _extend(pieces, short[0], time_step)
    return replace(system, string=tuple(pieces))


def _least(section: Section, time_step: float) -> float:
    """Length of a section that a wave passes in a time step, m."""
    return float(np.sqrt(section.shear_modulus / section.density)) * time_step


def _extend(pieces: list[Section], short: int, time_step: float) -> None:
    """Lengthen one of the pieces at the expense of a neighbour."""
    own = pieces[short]
    beside = [place for place in (short - 1, short + 1) if 0 <= place < len(pieces)]
    alike = min(beside, key=lambda place: abs(pieces[place].characteristic_admittance - own.characteristic_admittance))
    other = pieces[alike]
    lacking = _MARGIN * _least(own, time_step) - own.length
    left = other.length - lacking
    if left < _least(other, time_step):
        pieces[alike] = _joined(own, other)
        del pieces[short]
    else:
        pieces[short], pieces[alike] = _joined(own, replace(other, length=lacking)), replace(other, length=left)


def _joined(first: Section, second: Section) -> Section:
    """One section with length, inertia, viscous damping and mounted inertias of two, otherwise like the longer one."""
    longer = max(first, second, key=lambda section: float(section.length))
    both, length = (first, second), first.length + second.length
    moment = sum(section.inertia for section in both) / (longer.density * length)
    drag = sum(section.kappa * section.polar_moment * section.length for section in both)
    laws = [law for law in longer.laws if not isinstance(law, MountedInertia)]
    for section in both:
        mounted = [law for law in section.laws if isinstance(law, MountedInertia)]
        laws += [replace(law, spread=law.spread * length / section.length) for law in mounted]
    return replace(longer, length=length, polar_moment=moment, kappa=drag / (moment * length), laws=tuple(laws))
