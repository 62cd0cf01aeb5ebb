"""Detections of sensor and recorder: errors that turn with the shaft, coarse steps."""

from collections.abc import Mapping
from dataclasses import replace

import numpy as np
from scipy.fft import irfft, rfft
from scipy.ndimage import median_filter

from drillid.arrays import Complex, Floats
from drillid.discrepancy.detectors.detector import Detector, Inspection
from drillid.discrepancy.detectors.residual_record import TAPER_S, ResidualRecord
from drillid.discrepancy.detectors.score import Candidate, Score, normal_of_p_value, score, without
from drillid.discrepancy.rules import ROUNDING_MATERIAL
from drillid.physics.top_drive import control
from drillid.records.quality import quantisation_step

_NEIGHBOURS = 16
_UNREPEATED = 5
"""Parts of a window that stand for periods where the sweep does not repeat."""

_LOWEST = 0.5
"""Hz, below which the control's integral answers tapered ends for longer than a block of the noise, and clocks show
least."""
_CLEAR = 10.0
"""Power of the answer to the recorded speed per power of what the command has beside it, from which a line is taken as
recorded; at others it is computed from the sweep, as noise in what is looked for would make it seem smaller."""
_LINES = 61
"""Lines over which these powers are taken together."""
_ENDS = 2.0
"""Tapers at either end that are left out: the control's answer to a speed that fades is not a fading answer."""


class RevolutionDetector(Detector):
    """An error of the reading in proportion to the speed, once per revolution, to which the control responds."""

    def candidate(self, name: str, inspection: Inspection) -> Candidate:
        """Both quadratures of the error."""
        return Candidate(name, _turning(inspection.residual, 0), together=True)

    @classmethod
    def reviewed(
        cls, detectors: Mapping[str, Detector], scores: dict[str, Score], inspection: Inspection
    ) -> dict[str, Score]:
        """Scores beside those of errors that turn a little faster or slower."""
        return scores | {name: beside_neighbours(inspection.residual, scores[name]) for name in detectors}


class QuantisationDetector(Detector):
    """Coarse steps of the recorded speed."""

    def score(self, name: str, inspection: Inspection) -> Score | None:
        """A certain score where the steps' rounding is a good part of the noise; else None."""
        return quantisation_score(inspection.residual)


class ClockDriftDetector(Detector):
    """Clocks that run apart: by the logged command, or without one by the response to the sweep."""

    def candidate(self, name: str, inspection: Inspection) -> Candidate | None:
        """A delay that grows, for a record without a command whose sweep repeats."""
        residual = inspection.residual
        if residual.record.has_command or not residual.periods:
            return None
        duration = residual.samples / residual.record.rate
        delayed = residual.swept(-residual.s * residual.mobility)
        return Candidate(name, ((residual.passed - 0.5) * duration * delayed)[None])

    def score(self, name: str, inspection: Inspection) -> Score | None:
        """An offset that grows between speed and command, beside wrong gains and a steady offset."""
        if not inspection.residual.record.has_command:
            return None
        control_record = inspection.once(ControlRecord)
        offset = Candidate(name, control_record.trends[2:])
        return score(offset, control_record.error, inspection.residual, inflation=1.0)


class ControlTrendDetector(Detector):
    """A response of the control that changes in any way while the window lasts."""

    needs_command = True

    def score(self, name: str, inspection: Inspection) -> Score | None:
        """Trends of gain, integral gain and offset together."""
        control_record = inspection.once(ControlRecord)
        trends = Candidate(name, control_record.trends, together=True)
        return score(trends, control_record.error, inspection.residual)


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
    if rounding < ROUNDING_MATERIAL / (1 + ROUNDING_MATERIAL) * usual:
        return None
    return Score(normal_of_p_value(0.0), step, 1e-3 * step, normal_of_p_value(0.0) ** 2 / 2)


class ControlRecord:
    """The logged command against the control's response to the recorded speed."""

    def __init__(self, residual: ResidualRecord) -> None:
        inside, s = residual.inside & (residual.frequency > _LOWEST), residual.s
        stated = np.ravel(control(residual.system.top_drive.controller, s))
        speed, given, sweep = (
            rfft((series - series.mean()) * residual.taper)
            for series in (residual.speed, residual.command - residual.sweep, residual.sweep)
        )
        beyond = given + stated * speed
        response, missing = (
            median_filter(np.abs(lines) ** 2, _LINES, mode="nearest") for lines in (stated * speed, beyond)
        )
        moved = np.where(response > _CLEAR * missing, speed, residual.mobility * sweep)
        whole = np.minimum(residual.time, residual.time[::-1]) > _ENDS * TAPER_S

        def series(lines: Complex) -> Floats:
            return np.asarray(irfft(np.where(inside, lines, 0.0), residual.samples) * whole, dtype=float)

        earlier = series(-s * stated * moved)
        steady = np.stack([series(moved), series(moved / s), earlier])
        passed = residual.time - residual.time.mean()
        self.trends: Floats = without(passed * steady, steady)
        """(3, samples) N m, gain, integral gain and offset that grow, beside steady ones."""
        self.error: Floats = without(series(beyond)[None], steady)[0]
        """(samples,) N m, command that steady gains and a steady offset leave unexplained."""
