"""The interface of what is hidden in the second world: changes of a window."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from benchmarks.blind.other_world.rig import Window
from benchmarks.blind.other_world.rigs import Rig, Segment

Range = tuple[float, float]


@dataclass(frozen=True)
class Context:
    """Context of an effect beside the window."""

    rig: Rig
    segment: Segment
    """The window's."""
    first: Segment
    """First window of the set."""
    shape: float
    """0 to 1, selects one of the cause's shapes, drawn for the whole set."""
    seed: int
    """Of the case."""

    def generator(self) -> np.random.Generator:
        """Draws of what size and shape leave open, the same for all windows of a case."""
        return np.random.default_rng([27182, self.seed])

    @property
    def depth(self) -> float:
        """Depth at which the collars begin, m."""
        return self.segment.pipe_length


@dataclass(frozen=True)
class Effect:
    """A cause with the sizes that are drawn, in the catalogue's unit."""

    name: str
    """Identifier in the catalogue, or of what no catalogue holds."""
    apply: Callable[[Window, float, Context], Window]
    sizes: Range | Callable[[Window, Context], Range]
    """Least and largest size."""
    signed: bool = False
    linear: bool = True
    """Whether the rig is linear for small vibrations, so that its response has a closed form."""
    in_catalogue: bool = True

    def range(self, window: Window, context: Context) -> Range:
        """Least and largest size in this window."""
        return self.sizes(window, context) if callable(self.sizes) else self.sizes
