"""Stated probabilities after calibration."""

import pytest
from scipy.special import expit

from drillid.discrepancy import Verdict
from drillid.discrepancy.verdicts.verdict import CALIBRATION, CalibrationLine, calibrated, kind, log_odds


@pytest.mark.parametrize("name", ["none", "unknown", "drive_lag|recorder_filter"])
def test_more_sure_stays_more_sure_and_a_probability_one(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    posteriors = [Verdict(name, "", probability, 0.0, 1.0) for probability in (0.0, 0.2, 0.6, 0.99, 1.0)]
    monkeypatch.setitem(CALIBRATION, kind(posteriors[0]), CalibrationLine(-0.5, 0.6))
    stated = [calibrated(verdict).probability for verdict in posteriors]
    assert 0 < stated[0] < stated[1] < stated[2] < stated[3] < stated[4] < 1
    assert stated[2] == pytest.approx(expit(-0.5 + 0.6 * log_odds(0.6)))
