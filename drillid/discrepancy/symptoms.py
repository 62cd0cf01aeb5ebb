"""What a record may show that no cause of the catalogue stands for."""

from dataclasses import dataclass


@dataclass(frozen=True)
class Symptom:
    """Something that a rig as the model has it does not show, whatever its cause."""

    family: str
    """Part of the chain where it shows."""
    meaning: str
    """In plain words."""
    separated_by: str
    """What would tell its cause."""


SYMPTOMS = {
    "line": Symptom("sensor", "a tone stands out of the record's noise", "windows at other speeds of the top drive")
}
"""By name; none is the name of a cause."""
