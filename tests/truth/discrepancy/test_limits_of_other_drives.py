"""Limits of drives in the second world, whose control samples and holds: found, of the right size, or none."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from benchmarks.blind import world
from benchmarks.blind.engines import evidence_of
from benchmarks.blind.other_world.cases import plain_case
from benchmarks.blind.other_world.effects_top import mean_load
from drillid.discrepancy.detectors import detect as detecting
from drillid.discrepancy.detectors.detect import detectors
from drillid.discrepancy.detectors.pooling import PooledDetection, pool

INTERVAL = 0.03
"""s, of the control."""


def detected(
    name: str, *, seed: int = 902, command_logged: bool = True, rate: float = np.inf, beyond: float = np.inf
) -> PooledDetection | None:
    """Detection of a limit in windows of a rig whose drive has some.

    Parameters
    ----------
    rate : limit of the torque's rate, amplitudes of the sweep per s
    beyond : limit of the torque, amplitudes of the sweep above the mean
    """
    case, _ = plain_case(seed, 2)
    window = case.window(0)
    limit = mean_load(window) + beyond * window.sweep
    drive = replace(case.rig.drive, rate=rate * window.sweep, limit=limit)
    control = replace(case.rig.control, interval=INTERVAL)
    rig = replace(case.rig, control=control, drive=drive, recording=replace(case.rig.recording, kind="hold"))
    found = pool(evidence_of(replace(case, rig=rig, command_logged=command_logged)).detections)
    return next((each for each in found if each.cause == name and each.log_evidence > 10), None)


@pytest.fixture(autouse=True)
def _own_folder(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setattr(world, "FOLDER", tmp_path)


@pytest.mark.parametrize("rate", [15.0, 45.0], ids=["in the command's slopes", "in its steps alone"])
def test_a_rate_that_a_held_command_exceeds(rate: float) -> None:
    case, _ = plain_case(902, 2)
    found = detected("torque_rate_limit", rate=rate)
    assert found is not None
    limit = rate * case.window(0).sweep
    assert abs(found.size - limit) < 3 * found.size_error + 0.02 * limit
    assert found.size_error < 0.2 * limit


def test_a_limit_that_no_logged_command_shows() -> None:
    assert detected("torque_limit", command_logged=False, beyond=1.3) is not None


@pytest.mark.parametrize("command_logged", [True, False])
@pytest.mark.parametrize("name", ["torque_limit", "torque_rate_limit"])
def test_a_drive_without_limits(name: str, command_logged: bool) -> None:
    assert detected(name, command_logged=command_logged) is None


def test_scores_of_limits_that_are_absent_are_standard_normal(monkeypatch: pytest.MonkeyPatch) -> None:
    """As far as 20 windows tell, of rigs whose noise, control and recorder differ; no other cause is looked for."""
    monkeypatch.setattr(detecting, "detectors", lambda: {"torque_rate_limit": detectors()["torque_rate_limit"]})
    scores = []
    for seed in range(300500, 300510):
        case, _ = plain_case(seed, 2)
        rig = replace(case.rig, control=replace(case.rig.control, interval=INTERVAL))
        detections = evidence_of(replace(case, rig=rig)).detections
        scores += [each.score for each in detections if each.cause == "torque_rate_limit"]
    assert max(scores) < 3.0
    assert abs(np.mean(scores)) < 3 / np.sqrt(20)
