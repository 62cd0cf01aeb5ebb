"""What the engine looks at: mobilities of a set of windows with their noise, and what is known about the rig."""

from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from drillid.errors import EstimationError
from drillid.physics.equipment import Controller
from drillid.physics.model import KnownEquipment

Floats = NDArray[np.float64]
Complex = NDArray[np.complex128]


@dataclass(frozen=True, eq=False)
class Conditions:
    """How each window was drilled, arrays of shape (window,)."""

    hole_depth: Floats
    """m."""
    bit_depth: Floats
    """m; length of the whole string."""
    speed: Floats
    """rad/s, mean of the top drive."""
    torque: Floats
    """N m, mean of the command; NaN where it is not logged."""
    weight_on_bit: Floats
    """N; NaN where it is not logged."""


@dataclass(frozen=True, eq=False)
class Knowledge:
    """What the rig's papers say, each with its standard uncertainty; infinite where they are silent."""

    controller: Controller
    controller_relative: float = 0.02
    """Of both gains."""
    collar_length: float = 0.0
    """m; 0 without collars."""
    collar_polar_moment: float = 0.0
    """m⁴."""
    collar_relative: float = 0.1
    """Of the collars' inertia."""
    delay: float = 0.04
    """s."""
    delay_error: float = np.inf
    inertia_td: float = 1000.0
    """kg m²."""
    inertia_td_error: float = np.inf
    polar_moment: float = 1e-5
    """m⁴, of the pipe."""
    polar_moment_error: float = np.inf
    length_relative: float = np.inf
    """Of the pipe's length as waves see it."""
    clock_error: float = 0.002
    """s, between the clocks of speed and torque: sampling of the control, rows put on one grid."""

    @property
    def equipment(self) -> KnownEquipment:
        """What a fit of one window takes as given."""
        return KnownEquipment(self.controller, self.collar_length, self.collar_polar_moment)


STANDS_OUT = 2.0
"""Log ratio above which a line is kept; of noise, one line in seven has so much."""


@dataclass(frozen=True, eq=False)
class Lines:
    """Lines between the harmonics of the sweep that stand out of one window's record at all, so that windows whose own
    lines are faint tell a tone together.
    """

    spacing: float
    """Hz."""
    tried: int
    """Lines that were looked at."""
    strongest: int
    """The line that the window's own sign is of, as a multiple of the spacing."""
    place: NDArray[np.int32]
    """(L,) those with a log ratio above STANDS_OUT, as multiples of the spacing."""
    log_ratio: NDArray[np.float32]
    """(L,) −log of the chance of so much power in noise."""
    size: NDArray[np.float32]
    """(L,) amplitude, less what noise adds in the mean, rad/s."""
    size_error: NDArray[np.float32]
    """(L,) rad/s."""


@dataclass(frozen=True)
class Sign:
    """What one window's own record shows of a cause that the linear responses do not show, or show late."""

    cause: str
    """Identifier in the catalogue, or name of a symptom."""
    window: int
    score: float
    """Standard normal where the cause is absent, large where it is present; the search for it is counted."""
    size: float
    size_error: float
    log_ratio: float
    """Log-likelihood of the data that the sign is read from, with the cause at its best size less without."""
    misfit: float = np.nan
    """Standard normal where the record follows the cause, large where something like it does more; NaN if not asked."""
    by_shape: tuple[tuple[float, float], ...] = ()
    """Size and its error at each shape, as each moment of a jump; empty where the cause has one shape in the record."""
    apart: float = np.nan
    """Standard deviations between what this and the other way of the same change say of the record; NaN if not told."""
    lines: Lines | None = field(default=None, compare=False)
    """Of a tone, all lines that stand out; None of other causes."""


@dataclass(frozen=True, eq=False)
class Evidence:
    """A set of W windows on one grid of F frequencies.

    Raises
    ------
    EstimationError
        If an array has another shape than (window, frequency), or nothing is used.
    """

    frequency: Floats
    """(F,) Hz, rising."""
    mobility: Complex
    """(W, F) command mobility, rad/(N m s)."""
    variance: Floats
    """(W, F) of the complex value."""
    degrees_of_freedom: Floats
    """(W, F) complex degrees of freedom of the variance."""
    used: NDArray[np.bool_]
    """(W, F) what passed the coherence gate."""
    conditions: Conditions
    knowledge: Knowledge
    fitted: Floats
    """(W, 8) a fit of the eight parameters to each window on its own, in the order of the schema."""
    control: Complex | None = None
    """(W, F) what the control takes back, −(command − sweep)/recorded speed, N m s/rad; NaN where not logged."""
    control_variance: Floats | None = None
    """(W, F) of the complex value, independent in every window."""
    control_rounding: Floats | None = None
    """(W, F) the same of an error that is one in all windows, by the steps of the recorded sweep."""
    signs: tuple[Sign, ...] = field(default=())
    """Signs in the windows' records, at most one a cause and window."""

    def __post_init__(self) -> None:
        shape = (self.conditions.bit_depth.size, self.frequency.size)
        for name in ("mobility", "variance", "degrees_of_freedom", "used"):
            if getattr(self, name).shape != shape:
                raise EstimationError(
                    f"evidence, {name}",
                    f"its shape is {getattr(self, name).shape}, not {shape}",
                    "Give one row a window and one column a frequency",
                )
        if not self.used.any():
            raise EstimationError("evidence", "no frequency of any window is used", "Check the coherence gate")

    @property
    def windows(self) -> int:
        """Number of windows."""
        return int(self.mobility.shape[0])

    def subset(self, rows: NDArray[np.intp]) -> "Evidence":
        """Some of the windows, with their signs renumbered."""
        places = {int(row): place for place, row in enumerate(rows)}
        conditions = Conditions(*(values[rows] for values in vars(self.conditions).values()))
        signs = tuple(replace(sign, window=places[sign.window]) for sign in self.signs if sign.window in places)
        return Evidence(
            self.frequency,
            self.mobility[rows],
            self.variance[rows],
            self.degrees_of_freedom[rows],
            self.used[rows],
            conditions,
            self.knowledge,
            self.fitted[rows],
            None if self.control is None else self.control[rows],
            None if self.control_variance is None else self.control_variance[rows],
            None if self.control_rounding is None else self.control_rounding[rows],
            signs,
        )
