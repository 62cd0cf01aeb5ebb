"""A new cause is one class: added to the catalogue it is fitted, named, extended, measured and reported."""

from dataclasses import dataclass, fields, replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from drillid.arrays import Complex
from drillid.discrepancy import CATALOGUE
from drillid.discrepancy.catalogue import Cause, OperatingPoint, Size, WindowModel
from drillid.discrepancy.detectors.detect import detect
from drillid.discrepancy.detectors.detector import Detector, Inspection
from drillid.discrepancy.detectors.residual_record import WindowRecord
from drillid.discrepancy.detectors.score import Candidate
from drillid.physics.sensor import Recording
from drillid.report.verdicts import read_verdict_texts
from tests.simulated import RATE, SHALLOW, Processed, drilled
from tests.truth.discrepancy.wells import processed_well

ECHO_S, SHARE = 0.4, 0.15
HUM_HZ, HUM = 6.37, 0.02


@dataclass(frozen=True)
class EchoRecording(Recording):
    """A record that shows the speed once more a little later."""

    echo: Any = 0.0

    def transfer(self, s: Complex) -> Complex:
        """With the echo."""
        return super().transfer(s) * (1 + self.echo * np.exp(-s * ECHO_S))


class RecorderEcho(Cause):
    """A telemetry link that repeats what it sends."""

    name, family, port = "recorder_echo", "sensor", "sensor"
    meaning = "the telemetry repeats the speed a little later"
    separated_by = "a record that does not pass the telemetry"
    action = "Have the telemetry link checked for reflections."
    size = Size("share of the echo", "1", 0.1, -0.5, 0.5)

    def extend(
        self, window_model: WindowModel, size: Any, shape: float, operating_point: OperatingPoint
    ) -> WindowModel:
        """An echo of the size."""
        recording = window_model.recording
        values = {field.name: getattr(recording, field.name) for field in fields(Recording)}
        echoing = EchoRecording(**values, echo=getattr(recording, "echo", 0.0) + size)
        return replace(window_model, recording=echoing)


class HumDetector(Detector):
    """A tone of known frequency."""

    def candidate(self, name: str, inspection: Inspection) -> Candidate:
        """Both quadratures."""
        phase = 2 * np.pi * HUM_HZ * inspection.residual.time
        return Candidate(name, np.stack([np.cos(phase), np.sin(phase)]), together=True)


class Hum(Cause):
    """A hum of the mains in the record, which only its detector shows."""

    name, family, port = "hum", "sensor", "sensor"
    meaning = "the mains hum in the record"
    separated_by = "a look at the cable"
    action = "Have the cable shielded."
    size = Size("amplitude", "rad/s", 0.05, 0.0, 1.0)
    detector = HumDetector()


@pytest.fixture(scope="module")
def echoing(tmp_path_factory: pytest.TempPathFactory) -> Processed:
    """Two windows whose recorded speed has an echo, examined with the new cause in the catalogue."""
    stand = drilled(SHALLOW, 1200.0, 78)
    speed, delay = stand["speed"], round(ECHO_S * RATE)
    stand["speed"] = speed + SHARE * np.concatenate([np.full(delay, speed[0]), speed[:-delay]])
    with pytest.MonkeyPatch.context() as patch:
        patch.setitem(CATALOGUE, "recorder_echo", RecorderEcho())
        return processed_well(tmp_path_factory.mktemp("echoing"), [stand], "discrepancy", "depth")


def test_a_new_linear_cause_is_named_with_its_size_and_gain(echoing: Processed) -> None:
    (verdict,) = echoing.verdicts()
    assert verdict["verdict"] == "recorder_echo"
    assert verdict["size_low"] <= SHARE <= verdict["size_high"]
    assert verdict["predictive_gain_low"] > 0


def test_a_new_linear_cause_has_its_evidence_in_the_dataset_and_its_words_in_the_report(
    echoing: Processed, monkeypatch: pytest.MonkeyPatch
) -> None:
    examination = echoing.dataset("discrepancy", "examination")
    evidence = examination["log_evidence"].sel(cause="recorder_echo")
    assert float(evidence[0]) == float(examination["log_evidence"].max())
    assert float(examination["p_value_after"][0]) > 0.01 > float(examination["p_value_before"][0])
    monkeypatch.setitem(CATALOGUE, "recorder_echo", RecorderEcho())
    (words,), _ = read_verdict_texts(echoing.folders)
    assert words.lead == "The telemetry repeats the speed a little later."
    assert words.action == RecorderEcho.action


def test_a_new_detector_sees_its_cause_with_its_size(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setitem(CATALOGUE, "hum", Hum())
    stand = drilled(SHALLOW, 600.0, 79)
    time = np.arange(stand["speed"].size) / RATE
    names = ("torque_sweep", "speed", "torque_command")
    sweep, speed, command = (stand[name].astype(float) for name in names)
    record = WindowRecord(sweep, speed, command, RATE, 120.0, SHALLOW.parameters, SHALLOW.known)
    humming = WindowRecord(
        sweep,
        speed + HUM * np.cos(2 * np.pi * HUM_HZ * time + 1),
        command,
        RATE,
        120.0,
        SHALLOW.parameters,
        SHALLOW.known,
    )
    silent, loud = ({one.cause: one for one in detect(each)}["hum"] for each in (record, humming))
    assert silent.score < 3.7
    assert loud.score > 6
    assert abs(loud.size - HUM) < 3 * loud.size_error
