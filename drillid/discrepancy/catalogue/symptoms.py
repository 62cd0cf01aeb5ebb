"""Symptoms: what a record shows that no rig as the model has it would show, whatever its cause."""

from dataclasses import dataclass

from drillid.discrepancy.detectors.change import TrendDetector
from drillid.discrepancy.detectors.detector import Detector
from drillid.discrepancy.detectors.recorder import ControlTrendDetector
from drillid.discrepancy.detectors.tone import LineDetector


@dataclass(frozen=True)
class Symptom:
    """Something wrong that is detected without a cause; the verdict on it is `unknown`."""

    name: str
    family: str
    """Part of the chain where it shows."""
    meaning: str
    """In plain words."""
    separated_by: str
    """What would show its cause."""
    detector: Detector


SYMPTOMS = {
    symptom.name: symptom
    for symptom in (
        Symptom(
            "line",
            "sensor",
            "a tone stands out of the record's noise",
            "windows at other speeds of the top drive",
            LineDetector(),
        ),
        Symptom(
            "trend",
            "time",
            "the response to the sweep changes while a window lasts",
            "what was changed meanwhile",
            TrendDetector(),
        ),
        Symptom(
            "control_trend",
            "control",
            "the control's response changes while a window lasts",
            "the drive's own log",
            ControlTrendDetector(),
        ),
    )
}
"""By name; none is the name of a cause."""
