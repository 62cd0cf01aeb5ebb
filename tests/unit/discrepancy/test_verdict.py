"""Stated probabilities after calibration."""

import pytest
from scipy.special import expit

from drillid.discrepancy import Verdict
from drillid.discrepancy.verdicts.verdict import LINES, Line, calibrated, kind, log_odds


@pytest.mark.parametrize("name", ["none", "unknown", "drive_lag|recorder_filter"])
def test_more_sure_stays_more_sure_and_a_probability_one(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    said = [Verdict(name, "", probability, 0.0, 1.0) for probability in (0.0, 0.2, 0.6, 0.99, 1.0)]
    monkeypatch.setitem(LINES, kind(said[0]), Line(-0.5, 0.6))
    found = [calibrated(one).probability for one in said]
    assert 0 < found[0] < found[1] < found[2] < found[3] < found[4] < 1
    assert found[2] == pytest.approx(expit(-0.5 + 0.6 * log_odds(0.6)))
