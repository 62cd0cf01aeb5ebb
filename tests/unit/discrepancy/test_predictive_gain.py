"""What detections are worth on held-out windows."""

import numpy as np
import pytest

from drillid.discrepancy.detectors.detection import Detection
from drillid.discrepancy.detectors.pooling import detection_gain
from drillid.discrepancy.learning.offer import joined
from drillid.discrepancy.predictive_gain import NO_PREDICTIVE_GAIN, PredictiveGain


def detections(*measured: tuple[float, float, float]) -> list[Detection]:
    return [
        Detection("torque_limit", row, 1.0, size, error, ratio) for row, (size, error, ratio) in enumerate(measured)
    ]


def test_windows_that_agree_gain_their_likelihood_less_the_error_of_the_other() -> None:
    gain = detection_gain(detections((5.0, 0.1, 20.0), (5.0, 0.1, 30.0)))
    # the prediction has the error of one window too, so that the difference has √2 of it
    assert gain.value == pytest.approx(25.0 - np.log(2.0) / 2)
    assert gain.error == pytest.approx(np.sqrt(2 * 20 + 1 + 2 * 30 + 1) / 2)
    assert gain.windows == 2


def test_a_window_that_alone_determines_the_size_keeps_its_likelihood_less_one() -> None:
    gain = detection_gain(detections((7000.0, 40.0, 24.0), (6900.0, np.inf, 0.1), (np.nan, np.inf, 0.0)))
    assert gain.value == pytest.approx((24.0 - 1 + 0.1) / 3)


def test_windows_without_which_nothing_is_learnt_have_judged_as_well() -> None:
    parts = [PredictiveGain(2.0, 0.3, 6), NO_PREDICTIVE_GAIN, PredictiveGain(4.0, 0.4, 6), NO_PREDICTIVE_GAIN]
    gain = joined(parts, 24)
    assert (gain.value, gain.error) == (pytest.approx(1.5), pytest.approx(0.125))
    assert gain.windows == 24
    halves = joined([PredictiveGain(2.0, 0.3, 0), PredictiveGain(4.0, 0.4, 0)], 1)
    assert (halves.value, halves.windows) == (pytest.approx(6.0), 0)


def test_windows_that_contradict_each_other_lose() -> None:
    gain = detection_gain(detections((5.0, 0.1, 2.0), (-5.0, 0.1, 2.0), (5.0, 0.1, 2.0), (-5.0, 0.1, 2.0)))
    assert gain.value < 2.0


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
    sizes = deviations / np.sqrt(windows) + generator.standard_normal((sets, windows))
    gains = [detection_gain(detections(*((size, 1.0, size**2 / 2) for size in row))) for row in sizes]
    assert np.mean([gain.low * windows > deviations**2 / 2 for gain in gains]) < 0.05
    assert np.mean([gain.low > 0 for gain in gains]) >= shown
