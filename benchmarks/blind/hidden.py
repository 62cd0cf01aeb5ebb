"""What is hidden in a sealed case, in either world."""

from dataclasses import dataclass


@dataclass(frozen=True)
class Hidden:
    """A hidden cause."""

    name: str
    size: float
    """In the catalogue's unit."""
    shape: float
    """0 to 1, selects one of the cause's shapes."""
