"""Detections in records of the time-domain simulator: standard normal without their cause, of the right size with it.

The rig is small and its noise changes in level, as drilling noise does.
"""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from scipy.interpolate import CubicSpline
from scipy.stats import binom

from drillid.discrepancy.catalogue import SYMPTOMS
from drillid.discrepancy.detectors import detect as detecting
from drillid.discrepancy.detectors.change import ChangeDetector
from drillid.discrepancy.detectors.detect import detect, detectors
from drillid.discrepancy.detectors.detection import Detection
from drillid.discrepancy.detectors.detector import Inspection
from drillid.discrepancy.detectors.drive import ceiling_score
from drillid.discrepancy.detectors.pooling import detection_gain, pool
from drillid.discrepancy.detectors.recorder import RotatingErrors
from drillid.discrepancy.detectors.residual_record import ResidualRecord, WindowRecord
from drillid.discrepancy.detectors.score import Candidate, score, whitened
from drillid.discrepancy.gather import all_detections
from drillid.errors import EstimationError
from drillid.excitation.torques import SWEEP_PERIOD, coloured_noise, exponential_sweeps
from drillid.physics.limits import rate_limited, withheld_by_play
from drillid.physics.nonlinear import Cutting, DriveLimits, Gear, NonlinearRig, SpeedSensor, VaryingRig, Weakening
from drillid.physics.parameters import DAMPING_BHA
from drillid.simulation.recorder import Recorder, Tone
from drillid.simulation.simulate import SAMPLE_INTERVAL, simulate
from tests.simulated import LEAD_IN_S, RATE, SHALLOW, WINDOW_S, Truth

STEP = 0.005
SENSOR_NOISE = 0.002
SPEED = 10.5
RIG = NonlinearRig(SHALLOW.system)
LIGHT = replace(SHALLOW, pipe=replace(SHALLOW.pipe, kappa=20.0), collars=replace(SHALLOW.collars, kappa=20.0))
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


def records(
    rig: NonlinearRig | VaryingRig,
    seed: int,
    windows: int = 1,
    truth: Truth = SHALLOW,
    bit_torque: float | None = None,
    weight: float = 0.0,
    speed: float = SPEED,
    harder_rock: float = 0.0,
) -> list[WindowRecord]:
    """Successive windows under bit noise whose level wanders by 30 %; amid the first the rock may get harder, N m."""
    steps = round((LEAD_IN_S + windows * WINDOW_S) / STEP)
    generator = np.random.default_rng(seed)
    level = np.exp(coloured_noise(generator, steps, STEP, 0.3, 0.02))
    noise = level * coloured_noise(generator, steps, STEP, truth.bit_noise, 2.0)
    mean = truth.bit_torque if bit_torque is None else bit_torque
    result = simulate(
        rig,
        exponential_sweeps(np.arange(steps) * STEP, truth.sweep_amplitude),
        np.full(steps, speed),
        mean + noise + harder_rock * (np.arange(steps) * STEP > LEAD_IN_S + WINDOW_S / 2),
        mean_bit_torque=mean,
        weight_on_bit=weight,
        time_step=STEP,
    )
    reading = result.speed_reading + SENSOR_NOISE * generator.standard_normal(result.time.size)
    sweep = exponential_sweeps(result.time, truth.sweep_amplitude)
    return [
        WindowRecord(
            *(values[first : first + round(WINDOW_S * RATE)] for values in (sweep, reading, result.torque_command)),
            RATE,
            SWEEP_PERIOD,
            truth.parameters,
            truth.known,
        )
        for first in (round((LEAD_IN_S + number * WINDOW_S) * RATE) for number in range(windows))
    ]


def course(change: Callable[[float], NonlinearRig]) -> VaryingRig:
    """A rig that changes with the share of the one window that has passed."""
    return lambda time: change(min(max((time - LEAD_IN_S) / WINDOW_S, 0.0), 1.0))


def recorded(record: WindowRecord, recorder: Recorder) -> WindowRecord:
    """The same with the speed recorded otherwise."""
    return replace(record, speed=recorder.record(record.speed, SAMPLE_INTERVAL))


def between_rows(record: WindowRecord, places: np.ndarray) -> np.ndarray:
    """Sweep, speed and command at places (n,) in rows, on smooth curves through these, (3, n)."""
    channels = np.stack([record.sweep, record.speed, record.command])
    return np.asarray(CubicSpline(np.arange(record.sweep.size), channels, axis=1)(places))


def of_slower_samples(record: WindowRecord, interval: float, *, held: bool) -> WindowRecord:
    """The same with rows that hold samples at some interval, s, or lie on lines between them."""
    rows = np.arange(record.sweep.size)
    samples = np.arange(0, rows[-1], interval * RATE)
    place = np.floor(rows / (interval * RATE)) * interval * RATE if held else rows
    sweep, speed, command = (np.interp(place, samples, values) for values in between_rows(record, samples))
    return replace(record, sweep=sweep, speed=speed, command=command)


def of_random_ages(record: WindowRecord) -> WindowRecord:
    """The same with rows that are up to 12 ms old."""
    rows = np.arange(record.sweep.size)
    places = rows - 0.012 * RATE * np.random.default_rng(0).random(rows.size)
    sweep, speed, command = between_rows(record, places)
    return replace(record, sweep=sweep, speed=speed, command=command)


def detections_of(record: WindowRecord) -> dict[str, Detection]:
    return {detection.cause: detection for detection in detect(record)}


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


def _plain(record: WindowRecord, cause: str) -> Detection:
    """The detection of a cause that stands out, and more than that of any other."""
    detections = detections_of(record)
    assert detections[cause].score > 5
    assert detections[cause].score == max(
        detection.score for name, detection in detections.items() if name not in SYMPTOMS
    ), detections
    return detections[cause]


def _has_size(detection: Detection, size: float) -> bool:
    return abs(detection.size - size) < 3 * detection.size_error


def test_torque_limit() -> None:
    rig = replace(RIG, limits=DriveLimits(torque=1950.0))
    assert _has_size(_plain(records(rig, 50)[0], "torque_limit"), 1950.0)


@pytest.mark.parametrize(("name", "limit"), [("torque_limit", 1950.0), ("torque_rate_limit", 1500.0)])
@pytest.mark.parametrize("step", [0.0, 2.0])
def test_a_limit_shows_in_a_command_that_is_logged_behind_it(name: str, limit: float, step: float) -> None:
    """The torque follows that command, so that none is missing, and no jitter of the delay takes its evidence."""
    by_torque = name == "torque_limit"
    record = records(replace(RIG, limits=DriveLimits(**{"torque" if by_torque else "rate": limit})), 50)[0]
    command = np.clip(record.command, -limit, limit)
    if not by_torque:
        command = rate_limited(record.command, np.array([limit / record.rate]))[0]
    command = np.round(command / step) * step if step else command
    detections = detections_of(replace(record, command=command))
    assert detections[name].score > 8
    size, error = detections[name].size, detections[name].size_error
    assert abs(size - limit) < max(4 * error, 1e-6 * limit)
    assert error < 0.03 * limit
    assert "delay_jitter" not in detections


def test_a_command_without_a_limit_has_no_ceiling() -> None:
    for seed in (60, 61):
        command = records(RIG, seed)[0].command
        for logged in (command, np.round(command / 10) * 10, np.repeat(command[::5], 5)):
            for series in (logged, -logged, np.abs(np.diff(logged))):
                assert ceiling_score(series) is None


@pytest.mark.parametrize("seed", [52, 53])
def test_rate_limit_that_is_reached_most_of_the_time(seed: int) -> None:
    record = records(replace(RIG, limits=DriveLimits(rate=900.0)), seed)[0]
    assert np.mean(np.abs(np.gradient(record.command)) * RATE > 900.0) > 0.5
    detection = _plain(record, "torque_rate_limit")
    assert abs(detection.size - 900.0) < 3 * detection.size_error
    assert detection.size_error < 0.02 * 900.0


def test_torque_limit_without_logged_command() -> None:
    record = records(replace(RIG, limits=DriveLimits(torque=1900.0)), 50)[0]
    detection = detections_of(replace(record, command=np.full_like(record.command, np.nan)))["torque_limit"]
    assert np.isnan(detection.size)


def test_torque_rate_limit() -> None:
    rig = replace(RIG, limits=DriveLimits(rate=1500.0))
    assert _has_size(_plain(records(rig, 52)[0], "torque_rate_limit"), 1500.0)


def test_delay_jitter() -> None:
    top_drive = replace(SHALLOW.top_drive, delay_jitter=0.014)
    rig = replace(RIG, system=replace(SHALLOW.system, top_drive=top_drive))
    assert _has_size(_plain(records(rig, 60)[0], "delay_jitter"), 0.014**2)


def test_rows_that_a_slower_control_wrote_are_no_slew() -> None:
    (record,) = records(RIG, 5)
    assert "torque_rate_limit" not in detections_of(of_random_ages(record))
    for interval in (0.0125, 0.05):
        released = detections_of(of_slower_samples(record, interval, held=True)).get("torque_rate_limit")
        assert released is None or released.score < 3


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


@pytest.mark.parametrize("interval", [0.0125, 0.0275])
def test_jitter_shows_in_samples_that_held_rows_release(interval: float) -> None:
    top_drive = replace(SHALLOW.top_drive, delay_jitter=0.014)
    rig = replace(RIG, system=replace(SHALLOW.system, top_drive=top_drive))
    rows = of_slower_samples(records(rig, 60)[0], interval, held=True)
    assert _plain(rows, "delay_jitter").score > 5


def test_once_per_revolution() -> None:
    rig = replace(RIG, sensor=SpeedSensor(ripple=0.003))
    assert _has_size(_plain(records(rig, 53)[0], "once_per_revolution"), 0.003)


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
    assert _has_size(_plain(recorded(null_records[0], recorder), cause), size)


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
    assert _has_size(_plain(records(course(grown), 54, truth=truth)[0], "length_growth"), 60.0)


def _with_damping(damping: float) -> NonlinearRig:
    bit = replace(SHALLOW.bit, damping=damping)
    return replace(RIG, system=replace(SHALLOW.system, bit=bit))


QUIET = replace(SHALLOW, bit_noise=20.0, sweep_amplitude=400.0, bit=replace(SHALLOW.bit, damping=60.0))


@pytest.mark.parametrize("end", [90.0, 240.0])
def test_parameter_drift(end: float) -> None:
    drifting = course(lambda share: _with_damping(30.0 + (end - 30.0) * share))
    record = records(drifting, 55, truth=QUIET)[0]
    detection = _plain(record, "parameter_drift")
    assert _has_size(detection, end - 30.0)
    assert detection.size_error < 0.3 * detection.size
    assert detection.misfit < 3 < detections_of(record)["trend"].score


@pytest.mark.parametrize("after", [85.0, 200.0])
def test_regime_change(after: float) -> None:
    jumping = course(lambda share: _with_damping(35.0 if share < 0.43 else after))
    record = records(jumping, 56, truth=QUIET)[0]
    detection = _plain(record, "regime_change")
    assert _has_size(detection, after - 35.0)
    assert detection.size_error < 0.3 * detection.size
    evenly = detections_of(record)["parameter_drift"]
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


def test_a_bit_that_sticks_and_slips() -> None:
    weight, threshold = 1e5, 3.0
    steepness = 0.6 * float(SHALLOW.pipe.characteristic_admittance)
    dynamic = 0.5 * SHALLOW.bit_torque / weight
    static = dynamic + steepness * threshold * np.exp(6.5 / threshold) / weight
    rig = replace(RIG, cutting=Cutting(static, dynamic, Weakening(threshold)))
    detection = _plain(records(rig, 63, bit_torque=0.0, weight=weight, speed=6.5)[0], "stuck_slip_regimes")
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


LOOSE = NonlinearRig(LIGHT.system, gear=Gear(0.3, 0.3 * float(SHALLOW.top_drive.inertia), 1e6, 500.0))


def test_play_of_the_gear_shows_only_by_the_command_and_without_a_size() -> None:
    record = records(LOOSE, 64, truth=LIGHT, bit_torque=-130.0)[0]
    assert np.isnan(_plain(record, "gear_backlash").size)
    assert "gear_backlash" not in detections_of(replace(record, command=np.full_like(record.command, np.nan)))


def test_a_torque_that_changes_its_sign_without_play_is_no_play() -> None:
    plain = records(NonlinearRig(LIGHT.system), 65, 4, LIGHT, -130.0)
    assert max(detections_of(record)["gear_backlash"].score for record in plain) < 3


def test_teeth_part_for_as_long_as_the_motor_takes_to_cross_the_play() -> None:
    torque, inertia, play, step = 50.0, 400.0, 0.1, 1e-3
    reversed_at, samples = 500, 3000
    series = np.where(np.arange(samples) < reversed_at, torque, -torque)
    withheld = withheld_by_play(series, step, inertia, play / 2)
    apart = np.flatnonzero(withheld)
    assert apart[0] == reversed_at
    assert apart.size * step == pytest.approx(np.sqrt(2 * play * inertia / torque), abs=2 * step)
    assert withheld[apart[:-2]] == pytest.approx(torque)
    # when the teeth meet, the motor gives back what it gained
    assert withheld.sum() == pytest.approx(0.0, abs=1e-6 * torque / step)


def test_a_torque_that_keeps_its_sign_holds_the_teeth_together() -> None:
    assert not withheld_by_play(np.array([3.0, 1.0, 2.0]), 0.1, 100.0, 0.05).any()
    assert not withheld_by_play(np.array([-3.0, -1.0, -2.0]), 0.1, 100.0, 0.05).any()


def test_hardly_any_missing_torque_is_no_evidence(null_records: list[WindowRecord]) -> None:
    residual = ResidualRecord(null_records[0])
    noise = residual.error
    response = noise + 3 * np.random.default_rng(0).standard_normal(noise.size) * noise.std()
    missing, hardly_any = (
        Candidate("gear_backlash", share * response[None], np.array([np.nan]), one_sided=True) for share in (0.1, 0.01)
    )
    assert score(missing, noise, residual) is not None
    assert score(hardly_any, noise, residual) is None


def test_rate_limit_of_a_step() -> None:
    series = np.array([0.0, 1.0, 1.0, 1.0, 0.0])
    slow, fast = rate_limited(series, np.array([0.4, 2.0]))
    assert slow == pytest.approx([0.0, 0.4, 0.8, 1.0, 0.6])
    assert fast == pytest.approx(series)


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
