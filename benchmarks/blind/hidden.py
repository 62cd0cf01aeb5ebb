"""What is hidden in a sealed case, and how its records are kept, in either world."""

import io
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeVar

import numpy as np

from benchmarks.kept import write
from drillid.arrays import Floats

Part = TypeVar("Part")
_CHANNELS = ("sweep", "speed", "command", "standing")


def altered(part: Part, **parameters: Any) -> Part:
    """A part with other parameters: `dataclasses.replace` without its checks, as rigs are altered very often."""
    other = object.__new__(type(part))
    other.__dict__.update(part.__dict__, **parameters)
    return other


@dataclass(frozen=True)
class Hidden:
    """A hidden cause."""

    name: str
    size: float
    """In the catalogue's unit."""
    shape: float
    """0 to 1, selects one of the cause's shapes."""


class Sealed:
    """A case in which causes are hidden."""

    hidden: tuple[Hidden, ...]

    @property
    def hidden_names(self) -> frozenset[str]:
        """Names of all that is hidden."""
        return frozenset(cause.name for cause in self.hidden)


def kept_records(path: Path, windows: int, simulated: Callable[[int], dict[str, Floats]]) -> dict[str, Floats]:
    """Channels (W, samples) and `standing` (W,) of a case from a file, which is written where there is none.

    Parameters
    ----------
    simulated : the same of the window of a number, without the first dimension
    """
    if not path.is_file():
        parts = [simulated(number) for number in range(windows)]
        series = {name: np.stack([part[name] for part in parts]).astype(np.float32) for name in _CHANNELS}
        content = io.BytesIO()
        np.savez_compressed(content, **series)
        write(path, content.getvalue())
    with np.load(path) as stored:
        return {name: stored[name].astype(float) for name in _CHANNELS}
