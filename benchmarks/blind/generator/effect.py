"""The interface of hidden effects: changes of the simulator's input."""

from collections.abc import Callable
from dataclasses import dataclass

from benchmarks.blind.generator.rigs import DrillingSegment, Equipment
from benchmarks.blind.generator.world import World


@dataclass(frozen=True)
class Context:
    """Context of an effect beside the window's world."""

    equipment: Equipment
    first: DrillingSegment
    """First window of the set."""
    shape: float
    """0 to 1, selects one of the cause's shapes, drawn for the whole set."""


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
    """Whether the rig is linear for small vibrations, so that the ideal test can be computed."""
    in_catalogue: bool = True

    def range(self, world: World, context: Context) -> Range:
        """Least and largest size in this window."""
        return self.sizes(world, context) if callable(self.sizes) else self.sizes
