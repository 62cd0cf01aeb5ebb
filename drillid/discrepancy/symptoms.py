"""What a record may show that no cause of the catalogue stands for."""

from dataclasses import dataclass


@dataclass(frozen=True)
class Symptom:
    """Something that a rig as the model has it does not show, whatever its cause."""

    name: str
    family: str
    """Part of the chain where it shows."""
    meaning: str
    """In plain words."""
    separated_by: str
    """What would tell its cause."""


SYMPTOMS = {
    one.name: one
    for one in (
        Symptom(
            "line",
            "sensor",
            "a tone stands out of the record's noise",
            "the same tone at other speeds of the top drive",
        ),
        Symptom("change", "time", "the response changes while the window lasts", "shorter windows"),
    )
}
"""By name; none is the name of a cause."""
