"""Detections of several windows, taken together."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.special import ndtr, ndtri

from drillid.arrays import Floats
from drillid.discrepancy.detectors.detection import Detection, SpectralLines
from drillid.discrepancy.detectors.pooling import PooledDetection, at_common_line, detection_gain, pool
from drillid.discrepancy.rules import LINE_KEPT, STAMPED_TO


def detections(cause: str, sizes: list[float], score: float = 1.5) -> list[Detection]:
    """One window's detection for each size, with the same two-sided score and error."""
    return [Detection(cause, window, score, size, 1.0, 0.0) for window, size in enumerate(sizes)]


def test_windows_that_agree_say_more_than_windows_that_do_not() -> None:
    agreed, opposed = (pool(detections("clock_drift", sizes))[0] for sizes in ([2.0] * 4, [2.0, -2.0] * 2))
    assert agreed.p_value < 0.01 < opposed.p_value


def test_one_window_keeps_its_p_value() -> None:
    # the sum and the strongest are the same here, and the smaller of two p-values is doubled
    assert pool(detections("clock_drift", [2.0]))[0].p_value == pytest.approx(2 * ndtr(-1.5))


def test_a_window_that_tells_the_size_better_counts_more() -> None:
    sharp, blunt = (
        Detection("parameter_drift", 0, score, 1.0, error, 0.0) for score, error in ((3.0, 0.1), (0.0, 10.0))
    )
    dull = Detection("parameter_drift", 0, 0.0, 1.0, 0.1, 0.0)
    assert pool([sharp, blunt])[0].p_value < pool([sharp, dull])[0].p_value
    assert pool([sharp, blunt])[0].p_value == pytest.approx(2 * ndtr(-3.0), rel=0.2)


def test_a_window_that_fits_too_well_hides_no_misfit_of_another() -> None:
    even, odd = (
        [Detection("parameter_drift", row, 5.0, 1.0, 0.1, 9.0, value) for row, value in enumerate(misfit)]
        for misfit in ((-7.0, 4.0), (0.0, 0.5))
    )
    assert pool(even)[0].closure < 0.001 < 0.1 < pool(odd)[0].closure
    assert pool(detections("clock_drift", [2.0]))[0].closure == 1.0


def test_a_jitter_finer_than_time_stamps_is_no_evidence() -> None:
    finer, coarser = ([(share * STAMPED_TO) ** 2] * 24 for share in (0.9, 1.1))
    assert pool(detections("delay_jitter", finer))[0].p_value == 1.0
    assert pool(detections("delay_jitter", coarser))[0].p_value < 1e-9


def test_windows_that_do_not_reach_a_limit_neither_tell_it_nor_deny_it() -> None:
    reached = Detection("torque_limit", 0, 10.0, 1894.0, 2.0, 52.0)
    below = [Detection("torque_limit", row, 0.4, 1816.0 - row, 14.0, 0.2) for row in range(1, 6)]
    pooled = pool([reached, *below])[0]
    assert (pooled.size, pooled.size_error) == pytest.approx((1894.0, 2.0))
    gain = detection_gain([reached, *below])
    assert gain.value == pytest.approx((52.0 - 1.0) / 6)
    assert gain.low > 0
    # where no window shows it clearly all of them tell as much as they can
    assert 1800 < pool(below)[0].size < 1816


def test_windows_without_a_size_do_not_vouch_for_those_that_scatter() -> None:
    scattered = [Detection("aliased_tone", row, 5.0, 0.01 * (row + 1), 0.001, 12.0) for row in range(4)]
    silent = [Detection("aliased_tone", row, 0.0, 0.0, np.inf, 0.0) for row in range(4, 24)]
    alone, among = pool(scattered)[0], pool([*scattered, *silent])[0]
    assert among.size_error == pytest.approx(alone.size_error)


def test_windows_that_do_not_tell_a_size_leave_it_to_the_others() -> None:
    with_size, without_size = (
        Detection("torque_rate_limit", 0, 5.0, size, error, 9.0) for size, error in ((5.0, 0.1), (np.nan, np.inf))
    )
    assert pool([with_size, without_size])[0].size == pytest.approx(5.0)


def tones(generator: np.random.Generator, windows: int, ratio: float, others: Floats | None = None) -> list[Detection]:
    """A tone upon one of 5000 lines, its power so many times the noise's, and other lines."""
    own = []
    for window in range(windows):
        noise = generator.standard_normal((5000, 2)) / np.sqrt(2)
        noise[1234] += np.sqrt(ratio) * np.array([np.cos(window), np.sin(window)])
        noise[:, 0] += 0.0 if others is None else np.sqrt(others)
        log_ratio = np.sum(noise**2, axis=1)
        place, best = np.flatnonzero(log_ratio > LINE_KEPT), int(np.argmax(log_ratio))
        size, error = np.sqrt(np.maximum(2 * log_ratio - 2, 0.0))[place], np.ones(place.size)
        kept = (values.astype(np.float32) for values in (log_ratio[place], size, error))
        lines = SpectralLines(1e-3, 5000, best, place.astype(np.int32), *kept)
        p_value = float(-np.expm1(5000 * np.log1p(-np.exp(-log_ratio[best]))))
        normal = float(ndtri(1 - p_value))
        own.append(Detection("aliased_tone", window, normal, 1.0, np.inf, float(log_ratio[best]), lines=lines))
    return own


def test_windows_that_share_a_faint_tone_say_more_than_each_for_itself() -> None:
    shared = pool(tones(np.random.default_rng(0), 12, 5.0))[0]
    assert shared.p_value < 1e-8
    assert shared.size == pytest.approx(np.sqrt(10.0), rel=0.15)
    assert (
        pool([replace(detection, lines=None) for detection in tones(np.random.default_rng(0), 12, 5.0)])[0].p_value
        > 1e-4
    )


def test_a_tone_that_is_shared_is_no_surer_by_p_value_than_it_says() -> None:
    generator = np.random.default_rng(1)
    p_values = np.array([pool(tones(generator, windows, 0.0))[0].p_value for windows in (2, 8, 24) for _ in range(100)])
    assert np.mean(p_values < 0.05) < 0.08
    assert np.mean(p_values < 0.3) < 0.35


def test_one_of_many_lines_of_all_heights_is_no_tone() -> None:
    generator = np.random.default_rng(2)
    heights = np.where(np.arange(5000) % 10 == 3, generator.lognormal(0.5, 0.5, 5000), 0.0)
    heights[1233] = 8.0
    alone = np.where(heights == 8.0, heights, 0.0)
    many, one = (at_common_line(tones(np.random.default_rng(3), 12, 0.0, lines)) for lines in (heights, alone))
    assert one is not None
    assert many is not None
    assert one[1] < 1e-8
    assert many[1] > 0.01


@pytest.mark.parametrize(("cause", "supports"), [("stribeck_cutting", True), ("length_growth", False)])
def test_a_detection_of_a_third_of_the_size_supports_a_cause_whose_law_is_not_known(cause: str, supports: bool) -> None:
    found = PooledDetection(cause, 1e-20, 40.0, 20.0, 2.0, 12)
    assert (found.evidence_for(60.0) > 0) is supports
    assert found.evidence_for(20.0) > 0 > found.evidence_for(-20.0)
    # a hundredth of it does not
    assert found.evidence_for(2000.0) < 0


def test_responses_that_hardly_tell_a_size_do_not_speak_against_the_detected_one() -> None:
    found = PooledDetection("regime_change", 1e-30, 60.0, 216.0, 24.0, 10)
    # 216 ± 24 against zero is 40.5; 8 standard deviations apart take 32 of them, half a standard deviation an eighth
    assert found.evidence_for(216.0) == pytest.approx(40.5)
    assert found.evidence_for(408.0) == pytest.approx(8.5)
    assert found.evidence_for(408.0, 383.25) == pytest.approx(40.375, abs=0.01)


def jumps(generator: np.random.Generator, windows: int, size: float) -> list[Detection]:
    """Detections of one jump at the third of four moments in all windows; each window takes its best moment."""
    shown = generator.standard_normal((windows, 4)) + size * (np.arange(4) == 2)
    best = np.take_along_axis(shown, np.argmax(np.abs(shown), axis=1)[:, None], axis=1)[:, 0]
    score = -ndtri(-np.expm1(4 * np.log1p(-2 * ndtr(-np.abs(best)))))
    return [
        Detection("regime_change", row, *values, by_shape=tuple((size, 1.0) for size in shown[row].tolist()))
        for row, values in enumerate(zip(score, best, np.ones(windows), best**2 / 2, strict=True))
    ]


def test_windows_that_share_the_moment_of_a_jump_say_more_than_each_for_itself() -> None:
    shared = jumps(np.random.default_rng(0), 12, 2.0)
    alone = [replace(detection, by_shape=()) for detection in shared]
    assert pool(shared)[0].p_value < 1e-4 * pool(alone)[0].p_value
    assert pool(shared)[0].size == pytest.approx(2.0, abs=3 / np.sqrt(12))
    assert detection_gain(shared).low > 0


def test_a_moment_that_is_shared_is_no_surer_by_p_value_than_it_says() -> None:
    generator = np.random.default_rng(1)
    p_values = np.array([pool(jumps(generator, 8, 0.0))[0].p_value for _ in range(2000)])
    for rate in (0.05, 0.01):
        assert np.mean(p_values < rate) < rate + 3 * np.sqrt(rate / p_values.size)
    assert np.mean(p_values < 0.05) > 0.01  # and not far less
