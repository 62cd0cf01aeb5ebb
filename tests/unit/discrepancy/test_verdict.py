"""Stated probabilities after calibration."""

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from scipy.special import expit

from drillid.discrepancy import Verdict
from drillid.discrepancy.verdicts.naming import separator
from drillid.discrepancy.verdicts.verdict import CALIBRATION, CalibrationLine, calibrated, kind, log_odds


@pytest.mark.parametrize("name", ["none", "unknown", "drive_lag|recorder_filter"])
def test_more_sure_stays_more_sure_and_a_probability_one(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    posteriors = [Verdict(name, "", probability, 0.0, 1.0) for probability in (0.0, 0.2, 0.6, 0.99, 1.0)]
    monkeypatch.setitem(CALIBRATION, kind(posteriors[0]), CalibrationLine(-0.5, 0.6))
    stated = [calibrated(verdict).probability for verdict in posteriors]
    assert 0 < stated[0] < stated[1] < stated[2] < stated[3] < stated[4] < 1
    assert stated[2] == pytest.approx(expit(-0.5 + 0.6 * log_odds(0.6)))


@pytest.mark.parametrize(
    ("members", "control", "inertia", "said"),
    [
        (["clock_offset"], False, False, "the logged torque command, or a tighter tolerance of the drive's delay"),
        (["clock_offset"], True, False, "a tighter tolerance of the drive's delay"),
        (["speed_scale"], True, False, "the top drive's inertia, or a count of revolutions"),
        (["speed_scale"], False, True, "the logged torque command, or a count of revolutions"),
        (["speed_scale"], True, True, "a count of revolutions"),
        (["controller_gain", "clock_offset"], True, True, "a tighter tolerance of the drive's delay"),
    ],
)
def test_what_would_separate_causes_is_nothing_that_the_well_has(
    members: list[str], control: bool, inertia: bool, said: str
) -> None:
    sheet = SimpleNamespace(inertia_td_error=14.0 if inertia else np.inf)
    evidence: Any = SimpleNamespace(control=np.ones(3) if control else None, data_sheet=sheet)
    assert separator(members, evidence) == said
