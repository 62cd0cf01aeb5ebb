"""Strings made from strings: cut at a depth, a zone of stronger damping, a taper."""

from dataclasses import replace

import numpy as np

from drillid.errors import SettingsError
from drillid.physics.dual_numbers import primal
from drillid.physics.equipment import Figure, Section

String = tuple[Section, ...]


def cut(string: String, depth: Figure) -> tuple[String, String]:
    """The string above and below a cut at `depth`, m from its upper end; the depth may be a Dual.

    Raises
    ------
    SettingsError
        If the cut lies outside the string, or in different sections for different windows.
    """
    left = depth
    for index, section in enumerate(string):
        inside = (primal(left) >= 0) & (primal(left) <= primal(section.length))
        if np.all(inside):
            upper, lower = replace(section, length=left), replace(section, length=section.length - left)
            return (*string[:index], upper), (lower, *string[index + 1 :])
        if np.any(inside):
            raise SettingsError(
                f"cut of the string at {primal(depth)} m",
                "it lies in different sections for different windows",
                "Build the strings of these windows one by one",
            )
        left = left - section.length
    total = sum(primal(section.length) for section in string)
    raise SettingsError(
        f"cut of the string at {primal(depth)} m", f"the string reaches from 0 to {total} m", "Correct the depth"
    )


def with_zone(string: String, top: Figure, length: Figure, factor: Figure) -> String:
    """The string with its wall damping κ multiplied by `factor` over a zone.

    Parameters
    ----------
    top : m from the string's upper end to the zone
    length : m

    Raises
    ------
    SettingsError
        If the zone lies outside the string.
    """
    above, rest = cut(string, top)
    zone, below = cut(rest, length)
    return (*above, *(replace(section, kappa=section.kappa * factor) for section in zone), *below)


def tapered(section: Section, polar_moment_below: Figure, pieces: int) -> String:
    """A section whose polar moment runs linearly from its own to another, as equal uniform pieces."""
    middles = (np.arange(pieces) + 0.5) / pieces
    rise = polar_moment_below - section.polar_moment
    length = section.length / pieces
    return tuple(
        replace(section, length=length, polar_moment=section.polar_moment + rise * middle) for middle in middles
    )
