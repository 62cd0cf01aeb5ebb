"""Detections in records of the time-domain simulator: standard normal without their cause, of the right size with it.

Those of what the top drive does to its command are in `test_drive_detectors`.
"""

from dataclasses import replace

import numpy as np
import pytest
from scipy.stats import binom

from drillid.discrepancy.detectors import detect as detecting
from drillid.discrepancy.detectors.change import ChangeDetector
from drillid.discrepancy.detectors.detect import detect, detectors
from drillid.discrepancy.detectors.detection import Detection
from drillid.discrepancy.detectors.detector import Inspection
from drillid.discrepancy.detectors.drive import TorqueLimitDetector
from drillid.discrepancy.detectors.pooling import detection_gain, pool
from drillid.discrepancy.detectors.recorder import RotatingErrors
from drillid.discrepancy.detectors.residual_record import ResidualRecord, WindowRecord
from drillid.discrepancy.detectors.score import Candidate, score, whitened
from drillid.discrepancy.gather import all_detections
from drillid.errors import EstimationError
from drillid.excitation.torques import SWEEP_PERIOD
from drillid.physics.nonlinear import Cutting, NonlinearRig, SpeedSensor, Weakening
from drillid.physics.parameters import DAMPING_BHA
from drillid.simulation.recorder import Recorder, Tone
from drillid.simulation.simulate import SAMPLE_INTERVAL
from tests.simulated import SHALLOW
from tests.truth.discrepancy.window_records import (
    RIG,
    SPEED,
    alone,
    course,
    detections_of,
    has_size,
    of_random_ages,
    of_slower_samples,
    recorded,
    records,
    standing_out,
)

NULL_RUNS, NULL_WINDOWS = 5, 12
ALWAYS = (
    "length_growth",
    "clock_drift",
    "parameter_drift",
    "regime_change",
    "stribeck_cutting",
    "coulomb_contact",
    "once_per_revolution",
    "delay_jitter",
    "line",
    "trend",
    "control_trend",
)
"""Causes and symptoms that every window of steady drilling can show."""


@pytest.fixture(scope="session")
def null_records() -> list[WindowRecord]:
    return [record for seed in range(NULL_RUNS) for record in records(RIG, seed, NULL_WINDOWS)]


@pytest.fixture(scope="session")
def null_detections(null_records: list[WindowRecord]) -> list[dict[str, Detection]]:
    return [detections_of(record) for record in null_records]


@pytest.fixture
def _tones_alone(monkeypatch: pytest.MonkeyPatch) -> None:
    """No other cause is looked for."""
    monkeypatch.setattr(detecting, "detectors", lambda: {"aliased_tone": detectors()["aliased_tone"]})


@pytest.fixture
def _jitter_alone(monkeypatch: pytest.MonkeyPatch) -> None:
    """No other cause is looked for."""
    monkeypatch.setattr(detecting, "detectors", lambda: {"delay_jitter": detectors()["delay_jitter"]})


@pytest.mark.parametrize("cause", ALWAYS)
def test_scores_are_standard_normal_without_causes(null_detections: list[dict[str, Detection]], cause: str) -> None:
    scores = np.array([detections[cause].score for detections in null_detections])
    # three standard errors of mean and deviation; a score may be conservative, but not liberal
    assert -0.6 < scores.mean() < 3 / np.sqrt(scores.size)
    assert 0.6 < scores.std() < 1 + 3 / np.sqrt(2 * scores.size)


def test_no_more_detections_than_the_error_rate_allows(null_detections: list[dict[str, Detection]]) -> None:
    # a tone and its line have one score
    scores = np.array(
        [score for detections in null_detections for score in {detection.score for detection in detections.values()}]
    )
    assert np.count_nonzero(scores > 2.326) <= binom.ppf(0.999, scores.size, 0.01)
    assert np.count_nonzero(scores > 3.719) <= 1


def test_windows_without_the_causes_place_have_no_such_detection(null_detections: list[dict[str, Detection]]) -> None:
    for detections in null_detections:
        assert not {"quantisation", "stuck_slip_regimes", "gear_backlash"} & set(detections)


@pytest.mark.usefixtures("_jitter_alone")
@pytest.mark.parametrize("interval", [0.0075, 0.0125, 0.0175, 0.0275, 0.0325])
def test_samples_that_held_rows_release_are_no_jitter(null_records: list[WindowRecord], interval: float) -> None:
    rows = [of_slower_samples(record, interval, held=True) for record in null_records[:12]]
    scores = [detection.score for detection in all_detections(rows)]
    assert len(scores) == 12
    assert np.sum(scores) / np.sqrt(12) < 3
    assert max(scores) < 3.5


@pytest.mark.usefixtures("_jitter_alone")
def test_in_rows_of_random_ages_no_jitter_is_sought() -> None:
    (record,) = records(RIG, 5)
    assert not detections_of(of_random_ages(record))


def test_once_per_revolution() -> None:
    rig = replace(RIG, sensor=SpeedSensor(ripple=0.003))
    assert has_size(alone(records(rig, 53)[0], "once_per_revolution"), 0.003)


@pytest.mark.parametrize(
    ("cause", "size", "recorder"),
    [
        ("clock_drift", 4e-5, Recorder(SAMPLE_INTERVAL, clock_drift=4e-5, clock_offset=-0.012)),
        ("clock_drift", -4e-5, Recorder(SAMPLE_INTERVAL, clock_drift=-4e-5, clock_offset=0.012)),
        ("aliased_tone", 0.01, Recorder(SAMPLE_INTERVAL, tones=(Tone(0.9137, 0.01),))),
        ("aliased_tone", 0.002, Recorder(SAMPLE_INTERVAL, tones=(Tone(8.3137, 0.002),))),
        # upon a harmonic of the sweep, and a little off it
        ("aliased_tone", 0.01, Recorder(SAMPLE_INTERVAL, tones=(Tone(1.3, 0.01),))),
        ("aliased_tone", 0.01, Recorder(SAMPLE_INTERVAL, tones=(Tone(2.7355, 0.01),))),
        ("quantisation", 0.05, Recorder(SAMPLE_INTERVAL, resolution=0.05)),
    ],
)
def test_what_the_recorder_does(null_records: list[WindowRecord], cause: str, size: float, recorder: Recorder) -> None:
    assert has_size(alone(recorded(null_records[0], recorder), cause), size)


@pytest.mark.parametrize(
    "recorder",
    [
        Recorder(SAMPLE_INTERVAL, clock_offset=0.05),
        Recorder(SAMPLE_INTERVAL, filter_frequency=3.0),
        Recorder(SAMPLE_INTERVAL, scale=1.1),
        Recorder(SAMPLE_INTERVAL, resolution=1e-4),
    ],
    ids=["clock offset", "filter", "scale", "fine steps"],
)
def test_linear_defects_of_the_record_give_no_detection(null_records: list[WindowRecord], recorder: Recorder) -> None:
    assert max(detection.score for detection in detect(recorded(null_records[0], recorder))) < 3.719


def test_clocks_that_drift_apart_show_as_a_control_whose_response_changes(null_records: list[WindowRecord]) -> None:
    drifting = Recorder(SAMPLE_INTERVAL, clock_drift=4e-5, clock_offset=-0.012)
    assert detections_of(recorded(null_records[0], drifting))["control_trend"].score > 5


def test_a_wrong_linear_model_gives_no_detection(null_records: list[WindowRecord]) -> None:
    wrong = SHALLOW.parameters * np.array([2.0, 2.0, 1.1, 0.8, 1.3, 1.1, 3.0, 1.5])
    for record in null_records[:4]:
        assert max(detection.score for detection in detect(replace(record, fitted=wrong))) < 3.719


def test_length_growth() -> None:
    def grown(share: float) -> NonlinearRig:
        pipe = replace(SHALLOW.pipe, length=SHALLOW.pipe.length + 60.0 * (share - 0.5))
        return replace(RIG, system=replace(SHALLOW.system, string=(pipe, SHALLOW.collars)))

    truth = replace(SHALLOW, bit_noise=20.0, sweep_amplitude=400.0)
    assert has_size(alone(records(course(grown), 54, truth=truth)[0], "length_growth"), 60.0)


def _with_damping(damping: float) -> NonlinearRig:
    bit = replace(SHALLOW.bit, damping=damping)
    return replace(RIG, system=replace(SHALLOW.system, bit=bit))


QUIET = replace(SHALLOW, bit_noise=20.0, sweep_amplitude=400.0, bit=replace(SHALLOW.bit, damping=60.0))


@pytest.mark.parametrize("end", [90.0, 240.0])
def test_parameter_drift(end: float) -> None:
    drifting = course(lambda share: _with_damping(30.0 + (end - 30.0) * share))
    detections = detections_of(records(drifting, 55, truth=QUIET)[0])
    detection = standing_out(detections, "parameter_drift")
    assert has_size(detection, end - 30.0)
    assert detection.size_error < 0.3 * detection.size
    assert detection.misfit < 3 < detections["trend"].score


@pytest.mark.parametrize("after", [85.0, 200.0])
def test_regime_change(after: float) -> None:
    jumping = course(lambda share: _with_damping(35.0 if share < 0.43 else after))
    detections = detections_of(records(jumping, 56, truth=QUIET)[0])
    detection = standing_out(detections, "regime_change")
    assert has_size(detection, after - 35.0)
    assert detection.size_error < 0.3 * detection.size
    evenly = detections["parameter_drift"]
    assert detection.misfit < 3 < evenly.misfit
    # the wrong course leaves half the square of their separation more than the right one, in the mean
    assert detection.log_ratio - evenly.log_ratio == pytest.approx(
        detection.separation**2 / 2, abs=3 * detection.separation
    )


def test_a_large_drift_shows_more_along_its_course_than_by_its_derivative() -> None:
    noisy = replace(QUIET, bit_noise=120.0)
    record = records(course(lambda share: _with_damping(20.0 + 600.0 * share)), 58, truth=noisy)[0]
    residual = ResidualRecord(record)
    straight = ChangeDetector(DAMPING_BHA).candidate("parameter_drift", Inspection(residual))
    by_derivative = score(whitened(straight, residual), residual.error, residual)
    assert by_derivative is not None
    assert detections_of(record)["parameter_drift"].score > by_derivative.normal + 1


def test_harder_rock_is_no_cause_and_hides_none() -> None:
    in_harder_rock = records(RIG, 57, harder_rock=1500.0)[0]
    assert max(detection.score for detection in detect(in_harder_rock)) < 3.719
    tone = recorded(in_harder_rock, Recorder(SAMPLE_INTERVAL, tones=(Tone(1.3137, 0.02),)))
    assert detections_of(tone)["aliased_tone"].score > 4


def test_a_tone_is_a_line(null_records: list[WindowRecord]) -> None:
    tone = Recorder(SAMPLE_INTERVAL, tones=(Tone(8.3137, 0.002),))
    assert detections_of(recorded(null_records[0], tone))["line"].score > 4


@pytest.mark.usefixtures("_tones_alone")
@pytest.mark.parametrize(("frequency", "seen"), [(8.3137, True), (8.3017, True), (8.3, False)])
def test_windows_tell_a_faint_tone_together_unless_it_repeats_with_the_sweep(
    null_records: list[WindowRecord], frequency: float, seen: bool
) -> None:
    tone = Recorder(SAMPLE_INTERVAL, tones=(Tone(frequency, 5e-5),))
    own = [detections_of(recorded(record, tone))["aliased_tone"] for record in null_records[:NULL_WINDOWS]]
    assert max(detection.score for detection in own) < 3.719
    pooled = pool(own)[0]
    assert (pooled.p_value < 1e-3) is seen
    assert pooled.size == pytest.approx(5e-5, rel=0.3) or not seen
    assert pooled.size_error < 0.3 * pooled.size or not seen
    assert detection_gain(own).low > 0 or not seen


@pytest.mark.usefixtures("_tones_alone")
def test_images_of_the_sweep_in_held_rows_are_no_tone(null_records: list[WindowRecord]) -> None:
    held = [of_slower_samples(record, 0.0325, held=True) for record in null_records[:8]]
    [pooled] = [each for each in pool(all_detections(held)) if each.cause == "aliased_tone"]
    assert pooled.p_value > 0.01


@pytest.mark.usefixtures("_tones_alone")
def test_images_of_the_speed_where_it_alone_is_held_are_no_tone(null_records: list[WindowRecord]) -> None:
    held = [replace(r, speed=of_slower_samples(r, 0.0281, held=True).speed) for r in null_records[:NULL_WINDOWS]]
    [pooled] = [each for each in pool(all_detections(held)) if each.cause == "aliased_tone"]
    assert pooled.p_value > 0.01


def test_a_bit_that_sticks_and_slips() -> None:
    weight, threshold = 1e5, 3.0
    steepness = 0.6 * float(SHALLOW.pipe.characteristic_admittance)
    dynamic = 0.5 * SHALLOW.bit_torque / weight
    static = dynamic + steepness * threshold * np.exp(6.5 / threshold) / weight
    rig = replace(RIG, cutting=Cutting(static, dynamic, Weakening(threshold)))
    detection = alone(records(rig, 63, bit_torque=0.0, weight=weight, speed=6.5)[0], "stuck_slip_regimes")
    assert detection.size > 1


def test_torque_that_falls_with_speed() -> None:
    weight, threshold, size = 1e5, 5.25, 18.0
    fall = size * (10 / SPEED) ** 2 * threshold * np.exp(SPEED / threshold)
    dynamic = 0.3 * SHALLOW.bit_torque / weight
    cutting = Cutting(dynamic + fall / weight, dynamic, Weakening(threshold))
    rest = SHALLOW.bit_torque - cutting.torque(weight, SPEED)
    truth = replace(SHALLOW, bit_noise=120.0)
    detections = detections_of(
        records(replace(RIG, cutting=cutting), 62, truth=truth, bit_torque=rest, weight=weight)[0]
    )
    assert max(detections["stribeck_cutting"].score, detections["coulomb_contact"].score) > 5


def test_hardly_any_missing_torque_is_no_evidence(null_records: list[WindowRecord]) -> None:
    residual = ResidualRecord(null_records[0])
    noise = residual.error
    response = noise + 3 * np.random.default_rng(0).standard_normal(noise.size) * noise.std()
    missing, hardly_any = (
        Candidate("gear_backlash", share * response[None], np.array([np.nan]), one_sided=True) for share in (0.1, 0.01)
    )
    assert score(missing, noise, residual) is not None
    nothing = score(hardly_any, noise, residual)
    assert nothing is not None
    assert nothing.normal < 0 == nothing.log_ratio


def test_windows_in_which_no_limit_is_possible_were_looked_at(null_records: list[WindowRecord]) -> None:
    """To pool the other windows alone would select those whose noise looks like a limit."""
    residual, generator = ResidualRecord(null_records[0]), np.random.default_rng(1)
    columns = generator.standard_normal((3, residual.error.size))
    # half of a limit would lie three standard deviations off, so that every other window has none
    columns *= 6 / np.linalg.norm(columns, axis=1)[:, None]
    limit, p_values = Candidate("torque_limit", columns, np.array([1.0, 2.0, 3.0]), one_sided=True), []
    for _ in range(60):
        windows = []
        for window in range(24):
            found = score(limit, generator.standard_normal(residual.error.size), residual, inflation=1.0)
            assert found is not None
            windows.append(
                Detection("torque_limit", window, found.normal, found.size, found.size_error, found.log_ratio)
            )
        p_values.append(pool(windows)[0].p_value)
    assert 0.1 < np.mean(np.array([each.size for each in windows]) > 0) < 0.9
    assert np.count_nonzero(np.array(p_values) < 0.1) <= binom.ppf(0.999, len(p_values), 0.1)


@pytest.mark.parametrize("step", [10.0, 20.0, 50.0])
def test_a_coarsely_rounded_command_shows_no_limit(null_records: list[WindowRecord], step: float) -> None:
    command = np.round(null_records[0].command / step) * step
    detections = detections_of(replace(null_records[0], command=command))
    assert all(detections[name].score < 4 for name in ("torque_limit", "torque_rate_limit") if name in detections)


def test_about_an_unknown_mean_limits_below_it_are_tried(null_records: list[WindowRecord]) -> None:
    record = null_records[0]
    detector = detectors()["torque_limit"]
    assert isinstance(detector, TorqueLimitDetector)
    unlogged = replace(record, command=np.full_like(record.command, np.nan))
    tried = {name: detector.limits(ResidualRecord(one)) for name, one in (("logged", record), ("unlogged", unlogged))}
    assert tried["unlogged"].min() < 0 < tried["logged"].min()
    assert np.all(np.diff(tried["unlogged"]) < 0)


@pytest.mark.parametrize("cut", [0.0, 0.01])
def test_what_repeats_has_no_line_at_the_sweeps_harmonics(null_records: list[WindowRecord], cut: float) -> None:
    """Whether or not a period is a whole number of samples."""
    residual = ResidualRecord(replace(null_records[0], period=SWEEP_PERIOD - cut))
    noise = np.random.default_rng(0).standard_normal((2, residual.samples))
    left = residual.without_sweep(noise)
    removed = np.fft.rfft(noise - noise.mean(axis=1)[:, None] - left)
    of_band = np.flatnonzero(residual.harmonics)
    trend = np.abs(np.fft.rfft(residual.time - residual.time.mean()))
    others = np.setdiff1d(np.arange(removed.shape[1]), of_band)
    assert np.abs(removed[:, of_band]).mean() > 10
    assert (np.abs(removed[:, others]) <= 1e-3 * trend[others] + 1e-6).all()


def test_power_by_lines_is_that_of_the_whitened_columns(null_records: list[WindowRecord]) -> None:
    residual = ResidualRecord(null_records[0])
    errors = RotatingErrors(residual)
    columns = residual.whitened(errors.columns(3))
    products = columns @ residual.error
    assert errors.power(3) == pytest.approx(products @ np.linalg.solve(columns @ columns.T, products), rel=1e-9)


def test_channels_of_different_length_are_refused(null_records: list[WindowRecord]) -> None:
    with pytest.raises(EstimationError, match="differ in length"):
        replace(null_records[0], sweep=null_records[0].sweep[:-1])
    with pytest.raises(EstimationError, match="not finite"):
        replace(null_records[0], fitted=np.full(8, np.nan))
