"""What is fitted for a set of windows: coordinates shared by all, deviations of each, sizes and shapes of causes.

Fourteen parameters describe a window: the eight of the transmission line, the two gains of the control, the offset
between the clocks of speed and torque, the interval of a control that samples and holds, and how far the variances that
it adds to delay and record are off their formula; scaled to be of order one they are its coordinates. They are shared
by the set, and four of them (wall damping, internal damping, damping and inertia at the bit) may also deviate from
window to window.
"""

from dataclasses import dataclass, field, replace

import numpy as np

from drillid.arrays import Floats
from drillid.discrepancy.catalogue import Cause
from drillid.discrepancy.rules import STUDENT_TAIL

COORDINATES = (
    "kappa",
    "delta",
    "length",
    "polar_moment",
    "delay",
    "inertia_td",
    "damping_bha",
    "inertia_bit",
    "P",
    "I",
    "clock",
    "interval",
    "hold",
    "reading",
)
"""Coordinates of a window, of order one; the pipe's length, polar moment and the gains are relative changes, and
damping and inertia at the bit are relative to the pipe's polar moment.
"""
SHARED = len(COORDINATES)
"""Number of shared coordinates."""
LOCAL = (0, 1, 6, 7)
"""Indices of the coordinates that deviate from window to window."""
DATA_SHEET = (2, 3, 4, 5, 8, 9, 10)
"""Indices of the coordinates that data sheets state with a tolerance."""
RELATIVE = (2, 3, 8, 9)
"""Indices of the coordinates that are relative changes."""
IMPEDANCES = (3, 5, 8, 9)
"""Indices of the coordinates by which torques per speed grow: with all of these and the inertia of collars times a
factor, mobilities are divided by it."""
_NOT_MEASURED = np.isin(COORDINATES, ("polar_moment", "delay", "inertia_td", "inertia_bit", "P", "I"))
"""(14,) which coordinates no one on the rig measures, so that their values are now and then plainly wrong."""
DEGREES = np.where(_NOT_MEASURED, float(STUDENT_TAIL), np.inf)
"""(14,) degrees of freedom of the coordinates' priors, which are Student's t; infinite where they are normal."""
MEASURED = np.isin(COORDINATES, ("length", "clock"))
"""(14,) which coordinates are read on the rig: as exact as their tolerances say, if these can be trusted."""
INTERVAL = COORDINATES.index("interval")
"""Index of the interval of the control."""
STATED = (*DATA_SHEET, INTERVAL)
"""Indices of all coordinates for which a data sheet may state a value."""
DEVIATION = np.array([0.5, 0.2, 0.5, 0.4])
"""Usual standard deviation of the windows from their set, scaled; the prior where the set itself shows little."""
LOWEST = np.array([-20.0, -3.0, -0.5, -0.7, 0.0, 0.05, -40.0, -60.0, -0.9, -0.9, -20.0, 0.0, -10.0, -10.0])
HIGHEST = np.array([100.0, 3.0, 1.0, 2.0, 30.0, 15.0, 200.0, 60.0, 4.0, 4.0, 20.0, 20.0, 10.0, 10.0])
"""Bounds of the shared coordinates: wider than any rig, and the model is defined within."""
DAMPING_BIT = COORDINATES.index("damping_bha")
"""Index of the damping at the bit."""
PASSIVE = 0.04
"""Standard deviation by which a window's damping at the bit may fall below zero, scaled, 2 N m s/rad: a bit is passive
unless a cause acts, such as a torque that falls with speed. Small beside the values of windows, but the cost stays
smooth.
"""
FURTHEST_SHAPE = 2.5
"""Bound of the fitted coordinates of shapes, in standard deviations."""


@dataclass(frozen=True)
class Extension:
    """A cause at one of its shapes."""

    cause: Cause
    shape: float
    windows: tuple[int, ...] | None = None
    """Rows of the windows in which it is present; all where not given."""

    def present(self, windows: int) -> Floats | float:
        """1 where it is present and 0 elsewhere, (W, 1)."""
        if self.windows is None:
            return 1.0
        return np.isin(np.arange(windows), self.windows).astype(float)[:, None]


def fitted_shapes(extensions: tuple[Extension, ...]) -> list[int]:
    """Indices of the extensions that have a fitted shape parameter."""
    return [place for place, extension in enumerate(extensions) if extension.cause.shape_is_fitted]


def coordinate_count(extensions: tuple[Extension, ...]) -> int:
    """Number P of all that is fitted for a set: shared coordinates, sizes, and parameters of shapes, in this order."""
    return SHARED + len(extensions) + len(fitted_shapes(extensions))


@dataclass(frozen=True, eq=False)
class Point:
    """Coordinates of a set, and sizes and shapes of its causes."""

    shared: Floats
    """(14,) coordinates shared by all windows."""
    local: Floats
    """(W, 4) deviations of each window from them."""
    sizes: Floats
    """(extensions,) sizes of the causes, in their units."""
    shapes: Floats = field(default_factory=lambda: np.empty(0))
    """(extensions,) standard normal coordinates of the causes' shapes; zero for the last ones where not given."""

    def __post_init__(self) -> None:
        missing = self.sizes.size - self.shapes.size
        object.__setattr__(self, "shapes", np.append(self.shapes, np.zeros(missing)))

    def coordinates(self, extensions: tuple[Extension, ...]) -> Floats:
        """All that is fitted for the set, (P,)."""
        return np.concatenate([self.shared, self.sizes, self.shapes[fitted_shapes(extensions)]])

    def moved(self, coordinates: Floats, local: Floats, extensions: tuple[Extension, ...]) -> "Point":
        """The point with all that is fitted for the set at other values (P,), and other deviations of the windows."""
        count, shapes = SHARED + len(extensions), np.zeros(len(extensions))
        shapes[fitted_shapes(extensions)] = coordinates[count:]
        return Point(coordinates[:SHARED], local, coordinates[SHARED:count], shapes)

    def at_impedances(self, factor: float) -> "Point":
        """The point with impedances times a factor; those of the collars, which a tally states, remain."""
        offset = np.isin(np.arange(SHARED), RELATIVE).astype(float)
        scaled = np.where(np.isin(np.arange(SHARED), IMPEDANCES), factor * (self.shared + offset) - offset, self.shared)
        return replace(self, shared=scaled)

    def without(self, place: int) -> "Point":
        """The point without one of the causes."""
        return replace(self, sizes=np.delete(self.sizes, place), shapes=np.delete(self.shapes, place))
