"""Evidence about a set of windows, from what the stages have made of a well and its rig's data sheets."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
import xarray as xr

from drillid.arrays import Floats
from drillid.datasets.codes import Gate
from drillid.discrepancy.detectors.detect import detect
from drillid.discrepancy.detectors.detection import Detection
from drillid.discrepancy.detectors.residual_record import WindowRecord
from drillid.discrepancy.evidence import Evidence, Knowledge, OperatingPoints
from drillid.errors import EstimationError
from drillid.fits.datasheet import knowledge, known_equipment, speed_controller
from drillid.fits.window_fit import Prior, fit, measured_rows
from drillid.mobility.gate import gated_mobility
from drillid.mobility.responses import closed_loop_responses
from drillid.physics.equipment import Controller
from drillid.physics.parameters import DELAY, INERTIA_TD, LENGTH, PARAMETERS, POLAR_MOMENT
from drillid.spectra.cross_spectra import stacked
from drillid.spectra.local_polynomial import local_spectra
from drillid.spectra.periodic import line_spectra, sweep_period
from drillid.spectra.stage import is_usual, usual_sweep
from drillid.windows.channels import sample_rate, window_channels

if TYPE_CHECKING:
    from drillid.config.rig import Rig
    from drillid.config.settings import Settings
    from drillid.spectra.cross_spectra import Spectra


_CLOCK_ERROR = 0.002
"""s, between channels of one log whose rows were put on one grid."""
_DATA_SHEET = {"delay": DELAY, "inertia_td": INERTIA_TD, "polar_moment": POLAR_MOMENT}
"""Figures that data sheets tell as such, and their places among the eight parameters."""


def gather_well(
    rig: Rig, records: xr.Dataset, windows: xr.Dataset, spectra: xr.Dataset, mobility: xr.Dataset, fits: xr.Dataset
) -> Evidence:
    """Evidence from the datasets of a well's stages; every dataset holds the same windows.

    Detections are read where a window has a fit. The windows must share one bottom-hole assembly.
    """
    depth = windows["bit_depth"].values
    controller = speed_controller(rig, spectra)
    known = rig_knowledge(rig, controller, float(np.nanmedian(depth)))
    operating_points = OperatingPoints(
        *(
            windows[name].values.astype(float)
            for name in ("hole_depth", "bit_depth", "speed", "torque", "weight_on_bit")
        )
    )
    rate = sample_rate(records)
    fitted = fits["value"].values
    kept = []
    for row in range(depth.size):
        sweep, speed, command = window_channels(records, windows, row)
        finite = all(np.isfinite(values).all() for values in (fitted[row], sweep, speed))
        period = float(spectra["sweep_period"][row])
        kept.append(WindowRecord(sweep, speed, command, rate, period, fitted[row], known.equipment) if finite else None)
    return assembled(mobility, operating_points, known, fitted, all_detections(kept))


def rig_knowledge(rig: Rig, controller: Controller, bit_depth: float) -> Knowledge:
    """What a rig's data sheets say with the bit at `bit_depth` (m); `controller` is theirs, or read from the log."""
    data_sheet, collars = knowledge(rig, bit_depth), rig.collars_at(bit_depth)
    known = known_equipment(rig, controller, bit_depth)
    told = {"controller_relative": rig.controller.relative if rig.controller else np.inf}
    for name, place in _DATA_SHEET.items():
        if np.isfinite(data_sheet.value[place]):
            told[name], told[f"{name}_error"] = float(data_sheet.value[place]), float(data_sheet.error[place])
    if collars:
        told["collar_relative"] = collars.relative
    if rig.pipe:
        told["length_relative"] = rig.pipe.length_relative
    collar = {"collar_length": known.collar_length, "collar_polar_moment": known.collar_polar_moment}
    return Knowledge(controller, clock_error=_CLOCK_ERROR, **told, **collar)


def prior(known: Knowledge, bit_depth: float) -> Prior:
    """What a fit of one window takes from the data sheets, with the bit at `bit_depth` (m)."""
    length = bit_depth - known.collar_length
    told = {place: (getattr(known, name), getattr(known, f"{name}_error")) for name, place in _DATA_SHEET.items()}
    told[LENGTH] = (length, known.length_relative * length)
    value, error = np.full((2, len(PARAMETERS)), np.nan)
    for place, (figure, deviation) in told.items():
        if np.isfinite(deviation):
            value[place], error[place] = figure, deviation
    return Prior(value, error)


def all_detections(records: Sequence[WindowRecord | None]) -> tuple[Detection, ...]:
    """Detections of all windows that have a fit; None stands for one without."""
    read = (detect(record, window) for window, record in enumerate(records) if record is not None)
    return tuple(detection for detections in read for detection in detections)


def assembled(
    mobility: xr.Dataset,
    operating_points: OperatingPoints,
    known: Knowledge,
    fitted: Floats,
    detections: tuple[Detection, ...],
) -> Evidence:
    """Evidence from mobilities (window, frequency) and the eight parameters of each window, (window, 8)."""
    control = mobility["control_response"].values
    logged = bool(np.isfinite(control).any())
    return Evidence(
        frequency=mobility["frequency"].values,
        mobility=mobility["command_mobility"].values,
        variance=mobility["command_mobility_variance"].values,
        degrees_of_freedom=mobility["degrees_of_freedom"].values,
        used=mobility["gate"].values == Gate.USED,
        operating_points=operating_points,
        knowledge=known,
        fitted=fitted,
        control=control if logged else None,
        control_variance=mobility["control_response_variance"].values if logged else None,
        control_rounding=mobility["control_response_rounding"].values if logged else None,
        detections=detections,
    )


@dataclass(frozen=True, eq=False)
class Series:
    """One window's channels, each (samples,)."""

    sweep: Floats
    """N m."""
    speed: Floats
    """rad/s."""
    command: Floats
    """N m, sweep included; NaN where it is not logged."""


def gather(
    windows: Sequence[Series], rate: float, operating_points: OperatingPoints, knowledge: Knowledge, settings: Settings
) -> Evidence:
    """Evidence from time series: spectra, gate, a fit and the detections of each window.

    Parameters
    ----------
    rate : Hz
    operating_points : how each of the windows was drilled
    settings : of spectra, mobility and fits

    Raises
    ------
    EstimationError
        If there are not as many conditions as windows, or no frequency passes the gate.
    """
    if len(windows) != operating_points.bit_depth.size or not windows:
        raise EstimationError(
            "evidence",
            f"{len(windows)} windows and {operating_points.bit_depth.size} conditions",
            "Give one for each window",
        )
    periods = np.array([sweep_period(one.sweep, rate, settings.spectra.frequency_minimum_hz) for one in windows])
    spectra = _spectra(windows, rate, periods, settings)
    mobility = gated_mobility(spectra, settings.mobility).merge(closed_loop_responses(spectra))
    known = knowledge.equipment
    fitted = np.stack(
        [
            fit(measured, known, prior(knowledge, float(depth)), settings.fits).value
            for measured, depth in zip(measured_rows(mobility), operating_points.bit_depth, strict=True)
        ]
    )
    rows = zip(windows, periods, fitted, strict=True)
    records = [
        WindowRecord(*_channels(one), rate, float(period), own, known) if np.isfinite(own).all() else None
        for one, period, own in rows
    ]
    return assembled(mobility, operating_points, knowledge, fitted, all_detections(records))


def _channels(window: Series) -> tuple[Floats, Floats, Floats]:
    return window.sweep, window.speed, window.command


def _spectra(windows: Sequence[Series], rate: float, periods: Floats, settings: Settings) -> xr.Dataset:
    """Spectra (window, frequency) on the grid of the usual sweep; `periods` are (window,)."""
    usual, frequency = usual_sweep(periods, settings.spectra, rate)
    lines = settings.spectra.noise_lines

    def of(window: Series, repeats: bool) -> Spectra:
        if repeats:
            return line_spectra(*_channels(window), rate, usual, frequency, lines)
        return local_spectra(*_channels(window), rate, frequency, lines // 4)

    return stacked([of(*row) for row in zip(windows, is_usual(periods, usual, rate), strict=True)], frequency)
