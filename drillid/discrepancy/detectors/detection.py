"""What a detector finds in one window's record."""

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray


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
    """The line that the window's own detection is of, as a multiple of the spacing."""
    place: NDArray[np.int32]
    """(L,) those with a log ratio above LINE_KEPT, as multiples of the spacing."""
    log_ratio: NDArray[np.float32]
    """(L,) −log of the p-value of so much power in noise."""
    size: NDArray[np.float32]
    """(L,) amplitude, less what noise adds in the mean, rad/s."""
    size_error: NDArray[np.float32]
    """(L,) rad/s."""


@dataclass(frozen=True)
class Detection:
    """What one window's own record shows of a cause that the linear responses do not show, or show late."""

    cause: str
    """Identifier in the catalogue, or name of a symptom."""
    window: int
    score: float
    """Standard normal where the cause is absent, large where it is present; the search for it is counted."""
    size: float
    size_error: float
    log_ratio: float
    """Log-likelihood of the data that the detection is read from, with the cause at its best size less without."""
    misfit: float = np.nan
    """Standard normal where the record follows the cause, large where something like it does more; NaN if not asked."""
    by_shape: tuple[tuple[float, float], ...] = ()
    """Size and its error at each shape, as each moment of a jump; empty where the cause has one shape in the record."""
    apart: float = np.nan
    """Standard deviations between what this and the other way of the same change say of the record; NaN if not told."""
    lines: Lines | None = field(default=None, compare=False)
    """Of a tone, all lines that stand out; None of other causes."""
