"""Detections of sensor and recorder: errors that turn with the shaft, coarse steps."""

from dataclasses import replace

import numpy as np
from scipy.fft import irfft, rfft
from scipy.ndimage import median_filter

from drillid.arrays import Complex, Floats
from drillid.discrepancy.detectors.residual_record import TAPER_S, ResidualRecord
from drillid.discrepancy.detectors.score import Candidate, Score, normal_of_p_value, score, without
from drillid.physics.top_drive import control
from drillid.records.quality import quantisation_step

_NEIGHBOURS = 16
_UNREPEATED = 5
"""Parts of a window that stand for periods where the sweep does not repeat."""
_MATERIAL = 1.0
"""Noise of rounding per noise of all else, in the middle of the band, from which steps change what is found."""

_LOWEST = 0.5
"""Hz, below which the control's integral answers tapered ends for longer than a block of the noise, and clocks show
least."""
_CLEAR = 10.0
"""Power of the answer to the recorded speed per power of what the command has beside it, from which a line is taken as
recorded; at others it is reckoned from the sweep, as noise in what is looked for would make it seem smaller."""
_LINES = 61
"""Lines over which these powers are taken together."""
_ENDS = 2.0
"""Tapers at either end that are left out: the control's answer to a speed that fades is not a fading answer."""


def revolution_candidate(residual: ResidualRecord) -> Candidate:
    """An error of the reading in proportion to the speed, once per revolution, that the control answers."""
    return Candidate("once_per_revolution", _turning(residual, 0), together=True)


def _turning(residual: ResidualRecord, further: int) -> Floats:
    """Reading (2, samples) of an error that turns with the shaft and so many times more in a period of the sweep."""
    speed, rate = residual.speed, residual.record.rate
    period = residual.record.period or residual.samples / rate / _UNREPEATED
    angle = np.cumsum(speed) / rate + 2 * np.pi * further * residual.time / period
    controller = residual.system.top_drive.controller
    seen = 1 - residual.mobility * control(controller, residual.s)
    waves = np.stack([speed * np.cos(angle), speed * np.sin(angle)])
    return residual.filtered(seen, waves - waves.mean(axis=1)[:, None])


def beside_neighbours(residual: ResidualRecord, found: Score) -> Score:
    """The score of an error once per revolution, judged beside errors that turn a little faster or slower.

    Revolutions often fall on a harmonic of the sweep, as with any whole number of them a minute and a sweep of two
    minutes; the neighbours lie on harmonics as well, and share whatever the sweep leaves there. The power of one of
    2ν neighbours follows F(2, 2ν).
    """
    steps = [sign * step for step in range(1, _NEIGHBOURS + 1) for sign in (-1, 1)]
    powers = [_power(residual, _turning(residual, step)) for step in (0, *steps)]
    ratio = powers[0] / max(float(np.mean(powers[1:])), np.finfo(float).tiny)
    normal = normal_of_p_value(float(np.exp(-len(steps) * np.log1p(ratio / len(steps)))))
    return replace(found, normal=min(found.normal, normal), log_ratio=min(found.log_ratio, 0.5 * max(normal, 0.0) ** 2))


def _power(residual: ResidualRecord, pair: Floats) -> float:
    """What a pair of columns explains of the record."""
    columns = residual.whitened(pair)
    products = columns @ residual.error
    return float(products @ np.linalg.solve(columns @ columns.T, products))


def quantisation_score(residual: ResidualRecord) -> Score | None:
    """Steps of the recorded speed, where their rounding is a good part of the noise; else None."""
    speed = residual.speed
    step = quantisation_step(speed)
    if step is None:
        return None
    # one-sided densities, (rad/s)²/Hz
    rounding = step**2 / 6 / residual.record.rate
    density = 2 * residual.noise / (residual.record.rate * np.sum(residual.taper**2))
    usual = float(np.median(density[residual.inside]))
    if rounding < _MATERIAL / (1 + _MATERIAL) * usual:
        return None
    return Score(normal_of_p_value(0.0), step, 1e-3 * step, normal_of_p_value(0.0) ** 2 / 2)


def control_scores(residual: ResidualRecord) -> dict[str, Score | None]:
    """Scores of an offset that grows, beside wrong gains and a steady offset, and of an answer that moves in any way;
    for records with a command.
    """
    inside, s = residual.inside & (residual.frequency > _LOWEST), residual.s
    told = np.ravel(control(residual.system.top_drive.controller, s))
    speed, given, sweep = (
        rfft((series - series.mean()) * residual.taper)
        for series in (residual.speed, residual.command - residual.sweep, residual.sweep)
    )
    beyond = given + told * speed
    answered, missing = (median_filter(np.abs(lines) ** 2, _LINES, mode="nearest") for lines in (told * speed, beyond))
    moved = np.where(answered > _CLEAR * missing, speed, residual.mobility * sweep)

    whole = np.minimum(residual.time, residual.time[::-1]) > _ENDS * TAPER_S

    def series(lines: Complex) -> Floats:
        return np.asarray(irfft(np.where(inside, lines, 0.0), residual.samples) * whole, dtype=float)

    earlier = series(-s * told * moved)
    beside = np.stack([series(moved), series(moved / s), earlier])
    passed = residual.time - residual.time.mean()
    moving = without(passed * beside, beside)
    left = without(series(beyond)[None], beside)[0]
    return {
        "clock_drift": score(Candidate("clock_drift", moving[2:]), left, residual, inflation=1.0),
        "control_trend": score(Candidate("control_trend", moving, together=True), left, residual),
    }
