"""Torque of wall friction along a string that turns in a deviated hole, by the soft-string approximation.

A string without bending stiffness lies on the wall wherever the hole goes. With the effective tension F (N), the
buoyed weight w (N/m), the inclination θ and the azimuth φ along the depth z, its side force per length is

    f = √((F dθ/dz − w sin θ)² + (F sin θ dφ/dz)²),    dF/dz = −w cos θ,

after Johancsik, Friesen and Dawson (1984), Journal of Petroleum Technology 36, 987–992, in the differential form
of Sheppard, Wick and Burgess (1987), SPE Drilling Engineering 2, 344–350. A rotating string slides across the hole's
axis, so that friction acts on the torque, by μ f r per length with r the contact radius, and not on the tension.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from drillid.arrays import Floats
from drillid.errors import SettingsError
from drillid.physics.equipment import STEEL_DENSITY
from drillid.physics.nonlinear import WallContact, Weakening
from drillid.units import STANDARD_GRAVITY

LONGEST_PIECE = 5.0
"""m; friction is constant over a piece."""


@dataclass(frozen=True, eq=False)
class Survey:
    """Stations of a directional survey; both angles change linearly with depth between them."""

    depth: Floats
    """(stations,) m, measured depth, increasing."""
    inclination: Floats
    """(stations,) rad from the vertical."""
    azimuth: Floats
    """(stations,) rad, without jumps of a full turn."""

    @classmethod
    def from_degrees(cls, depth: ArrayLike, inclination: ArrayLike, azimuth: ArrayLike = 0.0) -> "Survey":
        """Survey from depths in m and angles in degrees; the azimuth may pass through north.

        Raises
        ------
        SettingsError
            If the depths do not increase, an angle is missing or an inclination lies outside 0 … 180°.
        """
        depths, inclinations = np.asarray(depth, dtype=float), np.radians(np.asarray(inclination, dtype=float))
        azimuths = np.unwrap(np.radians(np.broadcast_to(np.asarray(azimuth, dtype=float), depths.shape)))
        if depths.shape != inclinations.shape or depths.size < 2 or not np.all(np.diff(depths) > 0):
            raise SettingsError("survey", "it needs two or more stations with rising depths", "Sort and complete them")
        if not np.all((inclinations >= 0) & (inclinations <= np.pi) & np.isfinite(azimuths)):
            raise SettingsError("survey", "an inclination lies outside 0 … 180° or an azimuth is missing", "Correct it")
        return cls(depths, inclinations, azimuths)


@dataclass(frozen=True)
class Pipe:
    """A length of pipe or collars, filled with mud and surrounded by it."""

    length: float
    """m."""
    outer_diameter: float
    """m."""
    inner_diameter: float
    """m."""
    contact_diameter: float
    """m, of the contact with the wall: of the tool joints where there are any."""
    density: float = STEEL_DENSITY
    """kg/m³."""

    def buoyed_weight(self, mud_density: float) -> float:
        """Buoyed weight per length, N/m."""
        area = np.pi / 4 * (self.outer_diameter**2 - self.inner_diameter**2)
        return float((self.density - mud_density) * STANDARD_GRAVITY * area)


@dataclass(frozen=True, eq=False)
class SideForces:
    """Forces along the string, in pieces."""

    edges: Floats
    """(pieces + 1,) m."""
    tension: Floats
    """(pieces,) N, effective tension in the middle of each piece."""
    side_force: Floats
    """(pieces,) N/m."""
    radius: Floats
    """(pieces,) m, of the contact with the wall."""


def side_forces(survey: Survey, pipes: Sequence[Pipe], mud_density: float, weight_on_bit: float = 0.0) -> SideForces:
    """Tension and side force along a string of pipes.

    Parameters
    ----------
    pipes : from top to bit
    mud_density : kg/m³
    weight_on_bit : N

    Raises
    ------
    SettingsError
        If the survey ends above the bit or begins below the surface.
    """
    ends = np.cumsum([pipe.length for pipe in pipes])
    if survey.depth[-1] < ends[-1] - 1e-6 or survey.depth[0] > 0:
        raise SettingsError(
            "survey",
            f"it covers {survey.depth[0]:.0f} … {survey.depth[-1]:.0f} m, the string 0 … {ends[-1]:.0f} m",
            "Add stations at the surface and at the bit",
        )
    inner = survey.depth[(survey.depth > 0) & (survey.depth < ends[-1])]
    stations = np.unique(np.concatenate([[0.0], inner, ends]))
    counts = np.ceil(np.diff(stations) / LONGEST_PIECE).astype(int)
    spans = zip(stations[:-1], stations[1:], counts, strict=True)
    parts = [np.linspace(upper, lower, int(count), endpoint=False) for upper, lower, count in spans]
    edges = np.concatenate([*parts, stations[-1:]])
    middle, widths = (edges[:-1] + edges[1:]) / 2, np.diff(edges)
    kind = np.minimum(np.searchsorted(ends, middle), len(pipes) - 1)
    weight = np.array([pipe.buoyed_weight(mud_density) for pipe in pipes])[kind]
    radius = np.array([pipe.contact_diameter / 2 for pipe in pipes])[kind]
    inclination, azimuth = (np.interp(edges, survey.depth, angle) for angle in (survey.inclination, survey.azimuth))
    build, turn = np.diff(inclination) / widths, np.diff(azimuth) / widths
    lean = (inclination[:-1] + inclination[1:]) / 2
    axial = weight * np.cos(lean) * widths
    tension = np.cumsum(axial[::-1])[::-1] - axial / 2 - weight_on_bit
    side = np.hypot(tension * build - weight * np.sin(lean), tension * np.sin(lean) * turn)
    return SideForces(edges, tension, side, radius)


def wall_contact(forces: SideForces, static: float, dynamic: float, weakening: Weakening | None = None) -> WallContact:
    """Wall contact at static and dynamic coefficients of friction, μ f r per length."""
    torque = forces.side_force * forces.radius
    return WallContact(forces.edges, static * torque, dynamic * torque, weakening or Weakening())
