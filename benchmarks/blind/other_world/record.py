"""Rows of a log from a simulated window: the controller's samples as a slower, unsynchronised recorder keeps them."""

import numpy as np
from scipy.interpolate import make_interp_spline
from scipy.signal import bilinear, butter, lfilter, lfilter_zi

from benchmarks.blind.other_world.rig import Recording
from benchmarks.blind.other_world.simulate import Simulation
from drillid.arrays import Floats

RATE = 50.0
"""Hz, of rows."""


def record(result: Simulation, recording: Recording, first: float, seconds: float, phase: float) -> dict[str, Floats]:
    """Channels sweep, speed and command of a window, each (rows,) in SI units at RATE.

    The recorder keeps what the controller has computed at its readings, for all channels alike. The speed may come
    from a device of its own, with another clock, filter or rate.

    Parameters
    ----------
    first, seconds : s, time of the first row in the simulation, and length of the log
    phase : rad, of a tone at that time
    """
    rows = first + np.arange(round(seconds * RATE)) / RATE
    shown = rows + recording.phase
    speed = _speed_samples(result, recording, first + seconds / 2)
    kept = {
        "sweep": _kept(result.sweep, result.interval, shown, recording.kind),
        "command": _kept(result.command, result.interval, shown, recording.kind),
        "speed": _kept(speed, result.interval, shown, recording.kind),
    }
    tone = recording.tone * np.sin(2 * np.pi * recording.tone_frequency * (rows - first) + phase)
    value = recording.scale * (kept["speed"] + tone)
    step = recording.resolution
    kept["speed"] = step * np.rint(value / step) if step > 0 else value
    return kept


def _kept(samples: Floats, interval: float, times: Floats, kind: str) -> Floats:
    """Samples at an interval (s) as they stand at some times: the last one, or on a line to the next."""
    place = times / interval
    whole = np.clip(np.floor(place + 1e-9).astype(int), 0, samples.size - 1)
    if kind == "hold":
        return np.asarray(samples[whole], dtype=float)
    after = np.minimum(whole + 1, samples.size - 1)
    return np.asarray(samples[whole] + (place - whole) * (samples[after] - samples[whole]), dtype=float)


def _speed_samples(result: Simulation, recording: Recording, middle: float) -> Floats:
    """The recorded speed at the times of the controller's readings; clocks agree in the middle of the window."""
    every = round(result.interval / result.step)
    readings = np.arange(result.reading.size) * result.interval
    noise = result.reading - result.speed[::every]
    signal = _filtered(result.speed, recording, result.step)
    times = readings - recording.offset - recording.drift * (readings - middle)
    if recording.held > 0:
        times = np.floor((times + recording.phase) / recording.held) * recording.held - recording.phase
    fine = np.arange(signal.size) * result.step
    return np.asarray(make_interp_spline(fine, signal)(np.clip(times, 0.0, fine[-1])) + noise, dtype=float)


def _filtered(speed: Floats, recording: Recording, step: float) -> Floats:
    """A Butterworth low pass by the trapezoidal rule, in steady state at the begin."""
    if recording.filter_time == 0:
        return speed
    analogue = butter(recording.filter_order, 1 / recording.filter_time, analog=True)
    forward, backward = bilinear(*analogue, fs=1 / step)
    passed, _ = lfilter(forward, backward, speed, zi=lfilter_zi(forward, backward) * speed[0])
    return np.asarray(passed, dtype=float)
