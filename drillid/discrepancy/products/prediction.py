"""Predictions of a held-out window by base and extended model, over frequency and in time."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from math import ceil
from typing import TYPE_CHECKING

import numpy as np

from drillid.arrays import Complex, Floats
from drillid.discrepancy.catalogue import WindowModel
from drillid.discrepancy.inference.coordinates import Extension, Point
from drillid.discrepancy.inference.held_out_gain import every_other_line, trained_without
from drillid.discrepancy.learning.examined_law import law_window
from drillid.physics.responses import laplace
from drillid.spectra.periodic import whole_periods

if TYPE_CHECKING:
    from drillid.discrepancy.verdicts.examination import Examination


PHASES = 2400
"""Points over one period of the sweep that are stored."""


@dataclass(frozen=True, eq=False)
class Prediction:
    """Prediction of one window by a model that was fitted without it."""

    window_model: WindowModel
    row: int
    """The window's row in the set, where parameters of `window_model` have one for each window."""

    def mobility(self, frequency: Floats) -> Complex:
        """Command mobility, (frequency,)."""
        response = np.asarray(self.window_model.mobility(laplace(frequency)))
        return np.asarray(response[self.row if response.shape[0] > 1 else 0], dtype=complex)


def held_out_predictions(examination: Examination, row: int | None = None) -> tuple[int, Prediction, Prediction]:
    """One window of a set, the middle one where none is given, and its prediction by base and extended model.

    Both are fitted to the other windows; damping and inertia at the bit and along the string, which vary from window
    to window, are then fitted to the held-out window by both alike. Of a single window every other frequency is held
    out.
    """
    model, extensions = examination.model, examination.extensions
    evidence = model.evidence
    if row is None:
        row = int(np.argsort(evidence.operating_points.hole_depth)[evidence.windows // 2])
    held = np.zeros(evidence.used.shape, dtype=bool)
    held[row] = every_other_line(evidence.used)[0] if evidence.windows == 1 else True

    def predicted(start: Point, present: tuple[Extension, ...]) -> Prediction:
        point = trained_without(model, held, start, present)
        return Prediction(model.window_model_at(point, present), row)

    base = predicted(examination.base.point, ())
    return row, base, predicted(examination.extended.point, extensions) if extensions else base


def mean_period(series: Floats, rate: float, period: float, band: tuple[float, float]) -> tuple[Floats, float]:
    """Mean over the whole periods in a record within a band, and its root-mean-square standard error.

    Parameters
    ----------
    series : (samples,)
    rate : Hz
    period : s
    band : lowest and highest frequency, Hz

    Returns
    -------
    mean : (points,) over one period, no fewer than the record has; a multiple of PHASES
    error : NaN for a single period
    """
    whole = whole_periods(series.size, rate, period)
    points = PHASES * ceil(period * rate / PHASES)
    time = (np.arange(whole * points) * period / points).reshape(whole, points)
    lines = np.fft.rfft(np.interp(time, np.arange(series.size) / rate, series), axis=1)
    frequency = np.arange(lines.shape[1]) / period
    periods = np.fft.irfft(np.where((frequency >= band[0]) & (frequency <= band[1]), lines, 0.0), points, axis=1)
    error = np.sqrt(np.mean(periods.var(axis=0, ddof=1)) / whole) if whole > 1 else np.nan
    return periods.mean(axis=0), float(error)


def at_phases(series: Floats) -> Floats:
    """One period (points,) at PHASES of its points."""
    return series[:: series.size // PHASES]


def driven(mobility: Callable[[Floats], Complex], sweep: Floats, period: float, band: tuple[float, float]) -> Floats:
    """Speed (rad/s) within a band over one period, as driven by a sweep (N m); both (points,).

    Parameters
    ----------
    mobility : command mobility at frequencies
    """
    lines = np.fft.rfft(sweep)
    frequency = np.arange(lines.size) / period
    inside = (frequency >= band[0]) & (frequency <= band[1])
    speed = np.zeros_like(lines)
    speed[inside] = lines[inside] * mobility(frequency[inside])
    return np.fft.irfft(speed, sweep.size)


def added_by_law(
    examination: Examination,
    row: int,
    channels: tuple[Floats, Floats],
    rate: float,
    band: tuple[float, float],
    points: int,
) -> Floats:
    """What the learnt law adds to the speed (rad/s) of a window within a band over one period of its sweep, (points,).

    Parameters
    ----------
    row : of the window in the set
    channels, rate : sweep (N m) and speed (rad/s) of the window, (samples,) each, and their rate, Hz
    """
    law = examination.law
    window = law_window(examination, row, lambda _: channels, rate)
    if law is None or window is None:
        return np.zeros(points)
    curve = law.spline.drawn(law.kind.mean(window))
    frequency, lines = window.s.imag / (2 * np.pi), law.kind.added(window, *curve)
    inside = (frequency >= band[0]) & (frequency <= band[1])
    spectrum = np.zeros(points // 2 + 1, dtype=complex)
    places = np.rint(frequency[inside] * window.seconds).astype(int)
    spectrum[places] = points * lines[inside]
    return np.asarray(np.fft.irfft(spectrum, points), dtype=float)
