"""Detections of sensor and recorder: errors once per revolution, coarse quantisation, clocks that drift apart."""

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
"""Parts of a window that take the place of periods where the sweep is not periodic."""

_LOWEST = 0.5
"""Hz, below which the control's integral responds to tapered ends for longer than a noise block, and clock errors are
least visible."""
_CLEAR = 10.0
"""Power of the response to the recorded speed relative to that of the rest of the command, above which a line is used
as recorded; other lines are computed from the sweep, as noise in the regressors would bias their coefficients low."""
_ABOVE_SENSOR = 100.0
"""The same for the recorded speed relative to the sensor's noise. The control reads that noise too, so that it is not
in the rest of the command; but drifting clocks do not produce it."""
_LINES = 61
"""Lines over which these powers are averaged (running median)."""
_ENDS = 2.0
"""Tapers omitted at either end: the control's response to a tapered speed is not its tapered response."""


class RevolutionDetector(Detector):
    """An error of the speed reading proportional to the speed, once per revolution, to which the control responds."""

    def candidate(self, name: str, inspection: Inspection) -> Candidate:
        """Both quadratures of the error."""
        return Candidate(name, inspection.cached(RotatingErrors).columns(0), together=True)

    @classmethod
    def reviewed(
        cls, detectors: Mapping[str, Detector], scores: dict[str, Score], inspection: Inspection
    ) -> dict[str, Score]:
        """Scores relative to errors of slightly higher or lower frequency."""
        errors = inspection.cached(RotatingErrors)
        return scores | {name: relative_to_neighbours(errors, scores[name]) for name in detectors}


class QuantisationDetector(Detector):
    """Coarse quantisation of the recorded speed."""

    def score(self, name: str, inspection: Inspection) -> Score | None:
        """The largest score where rounding is a substantial part of the noise; else None."""
        return quantisation_score(inspection.residual, inspection.logged.speed)


class ClockDriftDetector(Detector):
    """Clocks that drift apart: by the logged command, or without one by the response to the sweep."""

    accuracy = 0.05

    def candidate(self, name: str, inspection: Inspection) -> Candidate | None:
        """A growing delay, for a record with a periodic sweep and without a command."""
        residual = inspection.residual
        if residual.record.has_command or not residual.periods:
            return None
        duration = residual.samples / residual.record.rate
        delayed = residual.response_to_sweep(-residual.s * residual.mobility)
        return Candidate(name, ((residual.elapsed - 0.5) * duration * delayed)[None])

    def score(self, name: str, inspection: Inspection) -> Score | None:
        """A growing offset between speed and command, with wrong gains and a constant offset as nuisances."""
        if not inspection.residual.record.has_command:
            return None
        control_record = inspection.cached(ControlRecord)
        offset = Candidate(name, control_record.trends[2:])
        return score(offset, control_record.error, inspection.residual, inflation=1.0)


class ControlTrendDetector(Detector):
    """A response of the control that changes within the window."""

    needs_command = True

    def score(self, name: str, inspection: Inspection) -> Score | None:
        """Joint score of trends in gain, integral gain and offset."""
        control_record = inspection.cached(ControlRecord)
        trends = Candidate(name, control_record.trends, together=True)
        return score(trends, control_record.error, inspection.residual)


class RotatingErrors:
    """Recorded speed due to errors once per revolution, or of slightly higher or lower frequency."""

    def __init__(self, residual: ResidualRecord) -> None:
        speed, rate = residual.speed, residual.record.rate
        period = residual.record.period or residual.samples / rate / _UNREPEATED
        self.residual = residual
        self.error: Complex = speed * np.exp(1j * np.cumsum(speed) / rate)
        """(samples,) rad/s, both quadratures of an error once per revolution."""
        self.turn: Complex = np.exp(2j * np.pi * residual.time / period)
        """(samples,) one more revolution in a period of the sweep."""
        controller = residual.system.top_drive.controller
        self.sensitivity: Complex = 1 - residual.mobility * control(controller, residual.s)

    def columns(self, further: int) -> Floats:
        """Recorded speed (2, samples) due to both quadratures, rad/s.

        Parameters
        ----------
        further : revolutions in a period of the sweep by which the error turns more often than the shaft
        """
        error = self.error * self.turn**further
        waves = np.stack([error.real, error.imag])
        return self.residual.filtered(self.sensitivity, waves - waves.mean(axis=1)[:, None])

    def power(self, further: int) -> float:
        """Power of the residual record explained by both quadratures; its lines are those of the whitened columns."""
        residual = self.residual
        lines = residual.whitened_lines(self.columns(further))
        products = (lines @ np.conj(residual.error_lines)).real
        return float(products @ np.linalg.solve((lines @ np.conj(lines.T)).real, products)) * 2 / residual.samples


def relative_to_neighbours(errors: RotatingErrors, score_alone: Score) -> Score:
    """The score of an error once per revolution, tested against errors of slightly higher or lower frequency.

    Revolutions often coincide with a harmonic of the sweep, as with any integer speed in rpm and a sweep of two
    minutes; the neighbours lie on harmonics as well, with the same residual of the sweep. The power relative to the
    mean of ν neighbours follows F(2, 2ν).
    """
    steps = [side * step for step in range(1, _NEIGHBOURS + 1) for side in (-1, 1)]
    powers = [errors.power(step) for step in (0, *steps)]
    ratio = powers[0] / max(float(np.mean(powers[1:])), np.finfo(float).tiny)
    normal = normal_of_p_value(float(np.exp(-len(steps) * np.log1p(ratio / len(steps)))))
    log_ratio = min(score_alone.log_ratio, 0.5 * max(normal, 0.0) ** 2)
    return replace(score_alone, normal=min(score_alone.normal, normal), log_ratio=log_ratio)


def quantisation_score(residual: ResidualRecord, logged: Floats) -> Score | None:
    """Score of a quantisation step of the recorded speed whose rounding is a substantial part of the noise; else
    None.

    Parameters
    ----------
    logged : (samples,) rad/s, speed as it is logged
    """
    step = quantisation_step(logged)
    if step is None:
        return None
    # one-sided densities, (rad/s)²/Hz
    rounding = step**2 / 6 / residual.sample_rate
    density = 2 * residual.noise / (residual.record.rate * np.sum(residual.taper**2))
    median_density = float(np.median(density[residual.inside]))
    if rounding < ROUNDING_MATERIAL / (1 + ROUNDING_MATERIAL) * median_density:
        return None
    return Score(normal_of_p_value(0.0), step, 1e-3 * step, normal_of_p_value(0.0) ** 2 / 2)


class ControlRecord:
    """The logged command against the control's response to the recorded speed."""

    def __init__(self, residual: ResidualRecord) -> None:
        inside, s = residual.inside & (residual.frequency > _LOWEST), residual.s
        stated = np.ravel(control(residual.system.top_drive.controller, s))
        speed, feedback, sweep = (
            rfft((series - series.mean()) * residual.taper)
            for series in (residual.speed, residual.command - residual.sweep, residual.sweep)
        )
        deviation = feedback + stated * speed
        speed_power, response_power, deviation_power = (
            median_filter(np.abs(lines) ** 2, _LINES, mode="nearest") for lines in (speed, stated * speed, deviation)
        )
        clear = (response_power > _CLEAR * deviation_power) & (speed_power > _ABOVE_SENSOR * residual.sensor_floor)
        regressor = np.where(clear, speed, residual.mobility * sweep)
        untapered = np.minimum(residual.time, residual.time[::-1]) > _ENDS * TAPER_S

        def series(lines: Complex) -> Floats:
            return np.asarray(irfft(np.where(inside, lines, 0.0), residual.samples) * untapered, dtype=float)

        delayed = series(-s * stated * regressor)
        constant = np.stack([series(regressor), series(regressor / s), delayed])
        elapsed = residual.time - residual.time.mean()
        self.trends: Floats = without(elapsed * constant, constant)
        """(3, samples) N m, effects of growing gain, integral gain and offset, orthogonal to those of constant ones."""
        self.error: Floats = without(series(deviation)[None], constant)[0]
        """(samples,) N m, command not explained by constant gains and a constant offset."""
