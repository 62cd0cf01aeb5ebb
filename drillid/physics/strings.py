"""Modified strings: cut at a depth, a zone of stronger damping, a taper."""

from dataclasses import replace

import numpy as np

from drillid.errors import SettingsError
from drillid.physics.dual_numbers import primal
from drillid.physics.equipment import Quantity, Section

String = tuple[Section, ...]


def cut(string: String, depth: Quantity) -> tuple[String, String]:
    """The string above and below a cut at `depth`, m from its upper end; the depth may be a Dual.

    Raises
    ------
    SettingsError
        If the cut lies outside the string, or in different sections in different windows.
    """
    remaining = depth
    for index, section in enumerate(string):
        inside = (primal(remaining) >= 0) & (primal(remaining) <= primal(section.length))
        if np.all(inside):
            upper, lower = replace(section, length=remaining), replace(section, length=section.length - remaining)
            return (*string[:index], upper), (lower, *string[index + 1 :])
        if np.any(inside):
            raise SettingsError(
                f"cut of the string at {primal(depth)} m",
                "it lies in different sections in different windows",
                "Build the strings of these windows one by one",
            )
        remaining = remaining - section.length
    total = sum(primal(section.length) for section in string)
    raise SettingsError(
        f"cut of the string at {primal(depth)} m", f"the string reaches from 0 to {total} m", "Correct the depth"
    )


def with_zone(string: String, top: Quantity, length: Quantity, factor: Quantity) -> String:
    """The string with its wall damping κ multiplied by `factor` in a zone.

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


def tapered(section: Section, polar_moment_below: Quantity, pieces: int) -> String:
    """A linear taper from the section's polar moment to another, as uniform pieces of equal length."""
    middles = (np.arange(pieces) + 0.5) / pieces
    rise = polar_moment_below - section.polar_moment
    length = section.length / pieces
    return tuple(
        replace(section, length=length, polar_moment=section.polar_moment + rise * middle) for middle in middles
    )
