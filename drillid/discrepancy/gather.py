"""Evidence about a set of windows, from the datasets of the stages and the rig's data sheet."""

from __future__ import annotations

import functools
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np
import xarray as xr

from drillid.arrays import Booleans, Floats, Integers
from drillid.datasets.codes import Gate
from drillid.datasets.memory import WellInMemory
from drillid.datasets.reuse import Memo
from drillid.discrepancy.detectors.detect import detect
from drillid.discrepancy.detectors.detection import Detection
from drillid.discrepancy.detectors.residual_record import WindowRecord
from drillid.discrepancy.detectors.set_point import holds_set_point, set_point_detection, speed_ratio
from drillid.discrepancy.evidence import Evidence, OperatingPoints
from drillid.errors import EstimationError
from drillid.fits.datasheet import (
    DataSheet,
    data_sheet,
    stated_controller,
    stored_controllers,
    with_held_control,
    with_logged_gains,
)
from drillid.fits.window_fit import fit, measured_rows, with_fitted_gains
from drillid.mobility.gate import gated_mobility
from drillid.mobility.responses import closed_loop_responses
from drillid.records.slower_samples import released
from drillid.spectra.cross_spectra import stacked
from drillid.spectra.local_polynomial import local_spectra
from drillid.spectra.period import sweep_period
from drillid.spectra.periodic import line_spectra
from drillid.spectra.stage import is_usual, usual_sweep
from drillid.windows.channels import sample_rate, window_channels

if TYPE_CHECKING:
    from drillid.config.rig import Rig
    from drillid.config.settings import Settings
    from drillid.spectra.cross_spectra import Spectra

_SHOWING = 3
"""Number of windows of a set from whose rows the interval of the control is read."""


def gather_well(
    rig: Rig,
    records: xr.Dataset,
    windows: xr.Dataset,
    spectra: xr.Dataset,
    mobility: xr.Dataset,
    fits: xr.Dataset,
    memo: Memo | None = None,
) -> Evidence:
    """Evidence from the datasets of a well's stages, which hold the same windows.

    Windows with a fit have detections. All windows must share one bottom-hole assembly.

    Parameters
    ----------
    memo : of detections in windows that have not changed since; None where nothing is kept
    """
    depth = windows["bit_depth"].values
    sheet = data_sheet(rig, stated_controller(rig, spectra), float(np.nanmedian(depth)))
    operating_points = OperatingPoints(
        *(
            windows[name].values.astype(float)
            for name in ("hole_depth", "bit_depth", "speed", "torque", "weight_on_bit")
        )
    )
    rate = sample_rate(records)
    fitted, periods = fits["value"].values, spectra["sweep_period"].values.tolist()

    def detected(row: int) -> list[dict[str, Any]]:
        sweep, speed, command = window_channels(records, windows, row)
        if not all(np.isfinite(values).all() for values in (fitted[row], sweep, speed)):
            return []
        record = WindowRecord(sweep, speed, command, rate, periods[row], fitted[row], known[row])
        return [detection.content() for detection in detect(record)]

    shown = np.flatnonzero(np.isfinite(fitted).all(axis=1))[:_SHOWING]
    channels = (window_channels(records, windows, int(row)) for row in shown)
    sheet = with_held_control(sheet, [released(read, rate).interval for read in channels], rate, _highest(spectra))
    known = [replace(sheet.equipment, controller=controller) for controller in stored_controllers(fits)]
    memo = memo or Memo(WellInMemory(), "discrepancy")
    contents = [windows["key"].values.tolist(), fitted.tolist(), periods, map(repr, known)]
    found = [
        memo.result(memo.key("detections", content, rate), functools.partial(detected, row))
        for row, content in enumerate(zip(*contents, strict=True))
    ]
    detections = [Detection.of(each, row) for row, of_window in enumerate(found) for each in of_window]
    if holds_set_point(sheet.controller):
        ratios = [
            memo.result(memo.key("set point", key), functools.partial(_speed_ratio, records, windows, row))
            for row, key in enumerate(contents[0])
        ]
        of_set = set_point_detection(np.array(ratios))
        detections += [] if of_set is None else [of_set]
    return assembled(mobility, operating_points, sheet, fitted, tuple(detections))


def _highest(spectra: xr.Dataset) -> float:
    """Highest frequency of the responses, Hz."""
    return float(spectra["frequency"].values.max())


def _speed_ratio(records: xr.Dataset, windows: xr.Dataset, row: int) -> float:
    return speed_ratio(*window_channels(records, windows, row, ("speed", "speed_set")))


def all_detections(records: Sequence[WindowRecord | None]) -> tuple[Detection, ...]:
    """Detections of all windows that have a fit; None stands for a window without one."""
    by_window = (detect(record, window) for window, record in enumerate(records) if record is not None)
    return tuple(detection for detections in by_window for detection in detections)


def assembled(
    mobility: xr.Dataset,
    operating_points: OperatingPoints,
    sheet: DataSheet,
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
        used=_used(mobility["gate"].values),
        operating_points=operating_points,
        data_sheet=sheet,
        fitted=fitted,
        control=control if logged else None,
        control_variance=mobility["control_response_variance"].values if logged else None,
        control_rounding=mobility["control_response_rounding"].values if logged else None,
        detections=detections,
    )


def _used(gate: Integers) -> Booleans:
    """Which frequencies of the windows (W, F) count: those of bands that most windows find coherent, in all of them.

    A band near the limit passes in windows in which it happens to be coherent; selecting those would select noise.
    Where no band passes in most windows, each window has its own.
    """
    incoherent, coherent = gate == Gate.TOO_INCOHERENT, gate == Gate.USED
    passing = coherent.sum(axis=0) > incoherent.sum(axis=0)
    return np.asarray((coherent | incoherent) & passing if passing.any() else coherent, dtype=bool)


@dataclass(frozen=True, eq=False)
class Series:
    """One window's channels, each (samples,)."""

    sweep: Floats
    """N m."""
    speed: Floats
    """rad/s."""
    command: Floats
    """N m, including the sweep; NaN where it is not logged."""


def gather(
    windows: Sequence[Series],
    rate: float,
    operating_points: OperatingPoints,
    sheet: DataSheet,
    settings: Settings,
    *,
    detecting: bool = True,
) -> Evidence:
    """Evidence from time series: spectra, gate, a fit and the detections of each window.

    Parameters
    ----------
    rate : Hz
    operating_points : of each window
    settings : of spectra, mobility and fits
    detecting : whether to look for detections, which take most of the time

    Raises
    ------
    EstimationError
        If there are not as many operating points as windows, or no frequency passes the gate.
    """
    if len(windows) != operating_points.bit_depth.size or not windows:
        raise EstimationError(
            "evidence",
            f"{len(windows)} windows and {operating_points.bit_depth.size} operating points",
            "Give one for each window",
        )
    samples = [released(np.stack(_channels(window)), rate) for window in windows]
    channels = [each.channels for each in samples]
    periods = np.array([sweep_period(sweep, rate, settings.spectra.frequency_minimum_hz) for sweep, _, _ in channels])
    spectra = _spectra(channels, rate, periods, settings)
    mobility = gated_mobility(spectra, settings.mobility).merge(closed_loop_responses(spectra))
    sheet = with_held_control(sheet, [each.interval for each in samples], rate, _highest(spectra))
    known = with_logged_gains(sheet, spectra)
    fits = [
        fit(measured, known.equipment, known.prior(float(depth)), settings.fits)
        for measured, depth in zip(measured_rows(mobility), operating_points.bit_depth, strict=True)
    ]
    records = [
        WindowRecord(*_channels(window), rate, float(period), own.value, with_fitted_gains(known.equipment, own.gains))
        if detecting and np.isfinite(own.value).all()
        else None
        for window, period, own in zip(windows, periods, fits, strict=True)
    ]
    fitted = np.stack([own.value for own in fits])
    return assembled(mobility, operating_points, sheet, fitted, all_detections(records))


def _channels(window: Series) -> tuple[Floats, Floats, Floats]:
    return window.sweep, window.speed, window.command


def _spectra(windows: Sequence[Floats], rate: float, periods: Floats, settings: Settings) -> xr.Dataset:
    """Spectra (window, frequency) on the grid of the usual sweep.

    Parameters
    ----------
    windows : sweep, speed and command of each, (3, samples)
    periods : (window,) s
    """
    usual, frequency = usual_sweep(periods, settings.spectra, rate)
    lines = settings.spectra.noise_lines

    def of(channels: Floats, period: float) -> Spectra:
        sweep, speed, command = channels
        if is_usual(np.asarray(period), usual, rate):
            return line_spectra(sweep, speed, command, rate, period, frequency, lines)
        return local_spectra(sweep, speed, command, rate, frequency, lines // 4)

    return stacked([of(*row) for row in zip(windows, periods.tolist(), strict=True)], frequency)
