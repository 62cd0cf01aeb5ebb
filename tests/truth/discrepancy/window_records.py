"""Records of windows of a small rig whose noise changes in level, as drilling noise does, and their detections."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
from scipy.interpolate import CubicSpline

from drillid.discrepancy.catalogue import SYMPTOMS
from drillid.discrepancy.detectors.detect import detect
from drillid.discrepancy.detectors.detection import Detection
from drillid.discrepancy.detectors.residual_record import WindowRecord
from drillid.excitation.torques import SWEEP_PERIOD, coloured_noise, exponential_sweeps
from drillid.physics.nonlinear import NonlinearRig, VaryingRig
from drillid.simulation.recorder import Recorder
from drillid.simulation.simulate import SAMPLE_INTERVAL, simulate
from tests.simulated import LEAD_IN_S, RATE, SHALLOW, WINDOW_S, Truth

STEP = 0.005
SENSOR_NOISE = 0.002
SPEED = 10.5
RIG = NonlinearRig(SHALLOW.system)
LIGHT = replace(SHALLOW, pipe=replace(SHALLOW.pipe, kappa=20.0), collars=replace(SHALLOW.collars, kappa=20.0))


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
    """All detections in a record, by cause."""
    return {detection.cause: detection for detection in detect(record)}


def alone(record: WindowRecord, cause: str) -> Detection:
    """The detection of a cause that stands out, and more than that of any other."""
    return standing_out(detections_of(record), cause)


def standing_out(detections: dict[str, Detection], cause: str) -> Detection:
    """That of a cause among the detections of a record."""
    assert detections[cause].score > 5
    assert detections[cause].score == max(
        detection.score for name, detection in detections.items() if name not in SYMPTOMS
    ), detections
    return detections[cause]


def has_size(detection: Detection, size: float) -> bool:
    """Whether the size is that of a detection within its error."""
    return abs(detection.size - size) < 3 * detection.size_error
