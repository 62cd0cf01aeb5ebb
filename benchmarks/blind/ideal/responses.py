"""What the ideal test asks of a world: expected responses of a case's windows, their noise, and what is not known."""

from collections.abc import Callable, Hashable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple, Protocol

from benchmarks.blind.hidden import Hidden
from drillid.arrays import Complex, Floats

WINDOW_S = 600.0
RATE = 50.0
"""Hz, of the logs."""
NUISANCES = {
    "kappa": "100 N s/m⁴",
    "delta": "logarithm",
    "length": "relative",
    "polar_moment": "relative",
    "delay": "10 ms",
    "inertia_td": "relative",
    "damping_bha": "50 N m s/rad",
    "inertia_bit": "50 kg m²",
    "P": "relative",
    "I": "relative",
    "clock": "ms",
    "interval": "decades",
}
"""Nuisance parameters, unknown to every test, and the unit of the offset of each."""
LOCAL = (0, 1, 6)
"""Indices of the nuisances that differ from window to window."""

_MOST_KEPT = 200


class Top(NamedTuple):
    """The upper end: numbers that nuisances change, and all else."""

    delay: float
    """s."""
    inertia: float
    """kg m²."""
    proportional: float
    """N m s/rad."""
    integral: float
    """N m/rad."""
    offset: float
    """s, of the recorded speed's clock."""
    interval: float
    """s, at which the control reads; 0 where it does so at every instant."""
    admittance: float
    """Characteristic admittance of the uppermost piece, N m s/rad."""
    rest: Hashable
    """Of control, drive and recording, as a world needs it for their responses."""


class Ends(NamedTuple):
    """Responses of the upper end, each (F,) or with further dimensions in front; or their derivatives."""

    drive: Complex
    """Torque per command."""
    images_read: Complex
    """Speed per command that the control's readings fold into the band, rad/(N m s)."""
    images_kept: Complex
    """The same of the recorder's samples."""
    inertia: Complex
    """Torque per speed of the top drive's inertia, N m s/rad."""
    control: Complex
    """Torque per speed, N m s/rad."""
    recorded: Complex
    """Recorded speed per speed."""


class Kept:
    """The last responses of parts of an upper end, as few of these parts differ between one upper end and another."""

    def __init__(self) -> None:
        self._found: dict[Hashable, Any] = {}
        self._frequencies: Complex | None = None

    def __call__(self, s: Complex, parts: tuple[Hashable, ...], response: Callable[..., Any]) -> Any:
        """What `response` gives of parts at frequencies, computed or kept."""
        if s is not self._frequencies or len(self._found) > _MOST_KEPT:
            self._found, self._frequencies = {}, s
        key = (response, *parts)
        if key not in self._found:
            self._found[key] = response(*parts, s)
        return self._found[key]


@dataclass(frozen=True, eq=False)
class Line:
    """A window of a rig in numbers, linear for small vibrations, at an elapsed share of the window."""

    string: Floats
    """(pieces, columns), from top to bottom, as in `benchmarks.blind.ideal.line`."""
    blades: tuple[float, float]
    """Of blades that cut what the blade ahead left: torque per speed (N m s/rad), and time from one to the next (s)."""
    top: Top


@dataclass(frozen=True, eq=False)
class Priors:
    """Prior standard deviations of the nuisances, in their units: of the set (12,), and of single windows (3,)."""

    shared: Floats
    local: Floats
    wrong: tuple["Wrong", ...] = ()
    """Values of documents of which at most one may be wrong outright."""
    starts: tuple[tuple[int, float], ...] = ()
    """Nuisances and offsets from which fits of all begin as well, as there may be several minima."""


class Wrong(NamedTuple):
    """A value that may be wrong outright."""

    spreads: Mapping[int, float]
    """Standard deviations if it is, by place among the nuisances of the set, where they differ."""
    cost: float
    """Twice the log odds against it, and of densities at the most likely value."""


class Sealed(Protocol):
    """A sealed case of any world."""

    @property
    def seed(self) -> int:
        """Of all draws."""

    @property
    def hidden(self) -> tuple[Hidden, ...]:
        """What is hidden."""

    @property
    def removed(self) -> bool:
        """Whether the engine's catalogue lacks it."""

    @property
    def command_logged(self) -> bool:
        """Whether the torque command is logged."""


class Kind(Protocol):
    """What is known of a cause in advance."""

    @property
    def linear(self) -> bool:
        """Whether it has linear responses."""

    @property
    def in_catalogue(self) -> bool:
        """Whether the vocabulary has a name for it."""


class Responses(Protocol):
    """A case's windows as the ideal test sees them."""

    effects: Mapping[str, Kind]
    """All that may be hidden."""
    windows: int
    sweep: float
    """N m, amplitude of each sweep."""
    priors: Priors
    power_law: bool
    """Whether steel with losses follows Kjartansson's law, else Makris's."""
    mixed: tuple[int, ...]
    """Indices of the nuisances that may change the same numbers of a string as others do."""

    def size_range(self, hidden: Hidden) -> tuple[float, float]:
        """Least and largest size that is drawn, in the first window."""

    def equal(self, hidden: Hidden) -> tuple[Hidden, ...]:
        """Other causes that are the same rig, or nearly so."""

    def expected(
        self, window: int, hidden: tuple[Hidden, ...], nuisances: Floats | None, s: Complex, shares: Sequence[float]
    ) -> list[tuple[Complex, Complex]]:
        """Recorded command mobility and response of the control at elapsed shares of a window, with causes."""

    def lines(
        self, window: int, hidden: tuple[Hidden, ...], nuisances: Floats | None, shares: Sequence[float]
    ) -> list[Line]:
        """The same in numbers, whose responses can be computed with their derivatives."""

    def ends(self, top: Top, s: Complex) -> Ends:
        """Responses of an upper end."""

    def noise_density(self, window: int, hidden: tuple[Hidden, ...], s: Complex, share: float = 0.5) -> Floats:
        """One-sided power density of the recorded speed's noise, (rad/s)²/Hz."""

    def sensor_density(self, window: int, hidden: tuple[Hidden, ...]) -> float:
        """The same of the recording's own noise."""

    def tone(self, window: int, hidden: Hidden) -> tuple[float, float]:
        """Frequency (Hz) and amplitude (rad/s) of a tone in the record."""
