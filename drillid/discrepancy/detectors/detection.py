"""Results of the detectors on one window's record."""

from collections.abc import Mapping
from dataclasses import asdict, dataclass, field
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True, eq=False)
class SpectralLines:
    """Lines between the harmonics of the sweep that stand out of one window's record at all: pooled over windows they
    show a tone that is too faint in each.
    """

    spacing: float
    """Hz."""
    tried: int
    """Number of lines tested."""
    strongest: int
    """Line of the window's own detection, as a multiple of the spacing."""
    place: NDArray[np.int32]
    """(L,) lines with a log ratio above LINE_KEPT, as multiples of the spacing."""
    log_ratio: NDArray[np.float32]
    """(L,) −log of the p-value of so much power in noise."""
    size: NDArray[np.float32]
    """(L,) amplitude, less the mean contribution of noise, rad/s."""
    size_error: NDArray[np.float32]
    """(L,) rad/s."""

    def content(self) -> dict[str, Any]:
        """Its content for JSON."""
        return {name: value.tolist() if isinstance(value, np.ndarray) else value for name, value in vars(self).items()}

    @classmethod
    def of(cls, content: Mapping[str, Any]) -> Self:
        """From its content in JSON."""
        lines = {name: np.array(content[name], np.float32) for name in ("log_ratio", "size", "size_error")}
        return cls(**{**content, **lines, "place": np.array(content["place"], np.int32)})


@dataclass(frozen=True)
class Detection:
    """Evidence in one window's record for a cause that the linear responses do not show, or only when it is large."""

    cause: str
    """Identifier in the catalogue, or name of a symptom."""
    window: int
    score: float
    """Standard normal where the cause is absent, large where it is present; corrected for the search over settings."""
    size: float
    size_error: float
    log_ratio: float
    """Log-likelihood ratio of the cause at its best size against no cause."""
    misfit: float = np.nan
    """Standard normal where the record follows the cause, large where something similar fits better; NaN where not
    tested."""
    by_shape: tuple[tuple[float, float], ...] = ()
    """Size and standard error at each shape, such as each moment of a jump; empty where a cause has one shape only."""
    separation: float = np.nan
    """Standard deviations between the records predicted by this and by the other course of the same parameter; NaN
    where there is none."""
    lines: SpectralLines | None = field(default=None, compare=False)
    """Of a tone, all lines that stand out; None for other causes."""

    def content(self) -> dict[str, Any]:
        """Its content for JSON, without its window."""
        found = {name: value for name, value in asdict(self).items() if name != "window"}
        return found | {"lines": None if self.lines is None else self.lines.content()}

    @classmethod
    def of(cls, content: Mapping[str, Any], window: int) -> Self:
        """From its content in JSON."""
        shapes = tuple((size, error) for size, error in content["by_shape"])
        lines = None if content["lines"] is None else SpectralLines.of(content["lines"])
        return cls(**{**content, "by_shape": shapes, "lines": lines}, window=window)
