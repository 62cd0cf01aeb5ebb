"""Symptoms: deviations of a record from any linear time-invariant rig, whatever their cause."""

from dataclasses import dataclass

from drillid.discrepancy.detectors.change import TrendDetector
from drillid.discrepancy.detectors.detector import Detector
from drillid.discrepancy.detectors.recorder import ControlTrendDetector
from drillid.discrepancy.detectors.tone import LineDetector


@dataclass(frozen=True)
class Symptom:
    """A deviation that is detected without a specific cause; its verdict is `unknown`."""

    name: str
    family: str
    """Part of the measurement chain in which it shows."""
    meaning: str
    """In plain words."""
    separated_by: str
    """Measurement that would show its cause."""
    detector: Detector


SYMPTOMS = {
    symptom.name: symptom
    for symptom in (
        Symptom(
            "line",
            "sensor",
            "the record contains a tone above its noise",
            "windows at other speeds of the top drive",
            LineDetector(),
        ),
        Symptom(
            "trend",
            "time",
            "the response to the sweep changes within a window",
            "a note of what was changed during the window",
            TrendDetector(),
        ),
        Symptom(
            "control_trend",
            "control",
            "the control's response changes within a window",
            "the drive's own log",
            ControlTrendDetector(),
        ),
    )
}
"""All symptoms by name; names differ from those of causes."""
