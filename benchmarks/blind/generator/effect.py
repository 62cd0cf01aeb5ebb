"""What a hidden cause is to the tests: a change of what is simulated."""

from collections.abc import Callable
from dataclasses import dataclass

from benchmarks.blind.generator.rigs import Equipment, Segment
from benchmarks.blind.generator.world import World


@dataclass(frozen=True)
class Context:
    """What an effect may know beside the window's world."""

    equipment: Equipment
    first: Segment
    """First window of the set."""
    shape: float
    """Which of the cause's shapes, 0 to 1, drawn for the whole set."""


Range = tuple[float, float]


@dataclass(frozen=True)
class Effect:
    """A cause with the sizes that are drawn, in the catalogue's unit."""

    name: str
    """Identifier in the catalogue."""
    apply: Callable[[World, float, Context], World]
    """Window without the cause, size → window with it."""
    sizes: Range | Callable[[World, Context], Range]
    """Least and largest size."""
    signed: bool = False
    """Sizes of either sign."""
    linear: bool = True
    """Whether small vibrations are those of a linear rig, so that the ideal test can be computed."""

    def range(self, world: World, context: Context) -> Range:
        """Least and largest size in this window."""
        return self.sizes(world, context) if callable(self.sizes) else self.sizes
