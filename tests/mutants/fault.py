"""A deliberate fault."""

from dataclasses import dataclass


@dataclass(frozen=True)
class Fault:
    """One deliberate fault, and the tests that must find it within seconds."""

    room: str
    file: str
    original: str
    """Text that occurs exactly once in the file."""
    mutated: str
    tests: tuple[str, ...]
    """Files or single tests, as pytest names them."""
    why: str
    """What goes wrong on a rig, in a few words."""
