"""The engine's input: mobilities of a set of windows with their noise, and the rig's data sheet."""

from dataclasses import dataclass, field, replace

from drillid.arrays import Booleans, Complex, Floats, Indices
from drillid.discrepancy.detectors.detection import Detection
from drillid.errors import EstimationError
from drillid.fits.datasheet import DataSheet


@dataclass(frozen=True, eq=False)
class OperatingPoints:
    """Operating points of the windows, arrays of shape (window,)."""

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
class Evidence:
    """A set of W windows on one grid of F frequencies.

    Raises
    ------
    EstimationError
        If an array has another shape than (window, frequency), or no frequency is used.
    """

    frequency: Floats
    """(F,) Hz, ascending."""
    mobility: Complex
    """(W, F) command mobility, rad/(N m s)."""
    variance: Floats
    """(W, F) of the complex value."""
    degrees_of_freedom: Floats
    """(W, F) complex degrees of freedom of the variance."""
    used: Booleans
    """(W, F) whether the coherence gate was passed."""
    operating_points: OperatingPoints
    data_sheet: DataSheet
    fitted: Floats
    """(W, 8) the eight parameters fitted to each window separately, in the order of the schema."""
    control: Complex | None = None
    """(W, F) response of the control, −(command − sweep)/recorded speed, N m s/rad; NaN where not logged."""
    control_variance: Floats | None = None
    """(W, F) of the complex value, independent in every window."""
    control_rounding: Floats | None = None
    """(W, F) the same of an error common to all windows, from quantisation of the recorded sweep."""
    detections: tuple[Detection, ...] = field(default=())
    """Detections in the windows' records, at most one for each cause and window."""

    def __post_init__(self) -> None:
        shape = (self.operating_points.bit_depth.size, self.frequency.size)
        for name in ("mobility", "variance", "degrees_of_freedom", "used"):
            if getattr(self, name).shape != shape:
                raise EstimationError(
                    f"evidence, {name}",
                    f"its shape is {getattr(self, name).shape}, not {shape}",
                    "Give one row for each window and one column for each frequency",
                )
        if not self.used.any():
            raise EstimationError("evidence", "no frequency of any window is used", "Check the coherence gate")

    @property
    def windows(self) -> int:
        """Number of windows."""
        return int(self.mobility.shape[0])

    def subset(self, rows: Indices) -> "Evidence":
        """A selection of the windows, with their detections renumbered."""
        places = {int(row): place for place, row in enumerate(rows)}
        operating_points = OperatingPoints(*(values[rows] for values in vars(self.operating_points).values()))
        detections = tuple(
            replace(detection, window=places[detection.window])
            for detection in self.detections
            if detection.window in places
        )
        return Evidence(
            self.frequency,
            self.mobility[rows],
            self.variance[rows],
            self.degrees_of_freedom[rows],
            self.used[rows],
            operating_points,
            self.data_sheet,
            self.fitted[rows],
            None if self.control is None else self.control[rows],
            None if self.control_variance is None else self.control_variance[rows],
            None if self.control_rounding is None else self.control_rounding[rows],
            detections,
        )
