"""Stated probabilities, and what detections are worth on held-out windows."""

import numpy as np
import pytest
from scipy.special import expit

from benchmarks.blind.calibrate import line
from drillid.discrepancy import Verdict
from drillid.discrepancy.detectors.detection import Detection
from drillid.discrepancy.detectors.pooling import detection_gain
from drillid.discrepancy.predictive_gain import PredictiveGain
from drillid.discrepancy.verdicts.verdict import LINES, Line, calibrated, kind, log_odds


def test_a_line_is_found_again_from_verdicts_that_follow_it() -> None:
    random = np.random.default_rng(5)
    posterior = random.uniform(-6, 10, 20000)
    right = (random.random(posterior.size) < expit(-0.7 + 0.4 * posterior)).astype(float)
    found = line(posterior, right)
    assert found.intercept == pytest.approx(-0.7, abs=0.1)
    assert found.slope == pytest.approx(0.4, abs=0.03)


def test_a_few_verdicts_leave_the_line_near_the_posterior() -> None:
    found = line(np.array([2.0]), np.array([1.0]))
    assert 0.5 < found.slope < 2


@pytest.mark.parametrize("name", ["none", "unknown", "drive_lag|recorder_filter"])
def test_more_sure_stays_more_sure_and_a_probability_one(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    said = [Verdict(name, "", probability, 0.0, 1.0) for probability in (0.0, 0.2, 0.6, 0.99, 1.0)]
    monkeypatch.setitem(LINES, kind(said[0]), Line(-0.5, 0.6))
    found = [calibrated(one).probability for one in said]
    assert 0 < found[0] < found[1] < found[2] < found[3] < found[4] < 1
    assert found[2] == pytest.approx(expit(-0.5 + 0.6 * log_odds(0.6)))


def detections(*told: tuple[float, float, float]) -> list[Detection]:
    return [Detection("torque_limit", row, 1.0, size, error, ratio) for row, (size, error, ratio) in enumerate(told)]


def test_windows_that_agree_gain_their_likelihood_less_the_error_of_the_other() -> None:
    found = detection_gain(detections((5.0, 0.1, 20.0), (5.0, 0.1, 30.0)))
    # what predicts has the error of one window, so that the deviation is √2 of it
    assert found.value == pytest.approx(25.0 - np.log(2.0) / 2)
    assert found.error == pytest.approx(np.sqrt(2 * 20 + 1 + 2 * 30 + 1) / 2)
    assert found.windows == 2


def test_a_window_that_alone_tells_the_size_keeps_its_likelihood_less_one() -> None:
    found = detection_gain(detections((7000.0, 40.0, 24.0), (6900.0, np.inf, 0.1), (np.nan, np.inf, 0.0)))
    assert found.value == pytest.approx((24.0 - 1 + 0.1) / 3)


def test_windows_that_contradict_each_other_lose() -> None:
    apart = detection_gain(detections((5.0, 0.1, 2.0), (-5.0, 0.1, 2.0), (5.0, 0.1, 2.0), (-5.0, 0.1, 2.0)))
    assert apart.value < 2.0


def test_gains_on_separate_data_add_up_and_their_errors_in_squares() -> None:
    both = PredictiveGain(2.0, 3.0, 3).joined(PredictiveGain(4.0, 4.0, 3))
    assert (both.value, both.error) == pytest.approx((6.0, 5.0))
    assert PredictiveGain(2.0, 3.0, 3).joined(detection_gain([])) == PredictiveGain(2.0, 3.0, 3)


@pytest.mark.parametrize(("deviations", "shown"), [(0.0, 0.0), (1.0, 0.0), (3.0, 0.55), (4.0, 0.8)])
@pytest.mark.parametrize("windows", [2, 8, 24])
def test_the_lower_end_of_a_gain_holds_in_95_percent_of_sets(windows: int, deviations: float, shown: float) -> None:
    """Windows that see a cause at so many standard deviations together, weighed on each other.

    Symmetric in the gain itself, the interval would show one at three deviations in about one set of six.
    """
    generator, sets = np.random.default_rng(0), 2000
    seen = deviations / np.sqrt(windows) + generator.standard_normal((sets, windows))
    gains = [detection_gain(detections(*((size, 1.0, size**2 / 2) for size in one))) for one in seen]
    assert np.mean([one.low * windows > deviations**2 / 2 for one in gains]) < 0.05
    assert np.mean([one.low > 0 for one in gains]) >= shown
