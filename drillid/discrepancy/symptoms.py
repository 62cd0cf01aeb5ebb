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
    "line": Symptom("sensor", "a tone stands out of the record's noise", "windows at other speeds of the top drive"),
    "trend": Symptom("time", "the answer to the sweep moves while a window lasts", "what was changed meanwhile"),
    "control_trend": Symptom("control", "the control's answer moves while a window lasts", "the drive's own log"),
}
"""By name; none is the name of a cause."""
