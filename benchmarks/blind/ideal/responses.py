"""What the ideal test asks of a world: expected responses of a case's windows, their noise, and what is not known."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Protocol

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
}
"""Nuisance parameters, unknown to every test, and the unit of the offset of each."""
LOCAL = (0, 1, 6)
"""Indices of the nuisances that differ from window to window."""


@dataclass(frozen=True, eq=False)
class Priors:
    """Prior standard deviations of the nuisances, in their units: of the set (11,), and of single windows (3,)."""

    shared: Floats
    local: Floats


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

    def size_range(self, hidden: Hidden) -> tuple[float, float]:
        """Least and largest size that is drawn, in the first window."""

    def expected(
        self, window: int, hidden: tuple[Hidden, ...], nuisances: Floats | None, s: Complex, shares: Sequence[float]
    ) -> list[tuple[Complex, Complex]]:
        """Recorded command mobility and response of the control at elapsed shares of a window, with causes."""

    def noise_density(self, window: int, hidden: tuple[Hidden, ...], s: Complex, share: float = 0.5) -> Floats:
        """One-sided power density of the recorded speed's noise, (rad/s)²/Hz."""

    def sensor_density(self, window: int, hidden: tuple[Hidden, ...]) -> float:
        """The same of the recording's own noise."""

    def tone(self, window: int, hidden: Hidden) -> tuple[float, float]:
        """Frequency (Hz) and amplitude (rad/s) of a tone in the record."""
