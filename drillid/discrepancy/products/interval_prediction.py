"""Predicted speed in a flagged interval: by what is usual in the run, and by the interval's other windows."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from drillid.arrays import Booleans, Floats, Integers
from drillid.datasets.codes import Gate
from drillid.discrepancy.products.prediction import driven, mean_period
from drillid.fits.datasheet import data_sheet, stored_controller
from drillid.physics.eight_parameters import drilling_system
from drillid.physics.parameters import DAMPING_BHA, INERTIA_BHA
from drillid.physics.responses import command_mobility, laplace
from drillid.windows.channels import sample_rate, window_channels

if TYPE_CHECKING:
    from drillid.discrepancy.sets import WellData

PREDICTION_COLUMNS = ("error_by_usual", "error_by_interval", "speed_noise")
"""Columns of intervals.csv, rad/s."""
NOT_PREDICTED = (float("nan"),) * 3
"""Where an interval has a single window, or its sweep does not repeat."""


def interval_prediction(data: WellData, inside: Booleans, usual: Booleans) -> tuple[float, float, float]:
    """Errors of the predicted speed of the interval's middle window, and its noise, rad/s rms over a sweep's period.

    Damping and inertia of the assembly are first those of the run's usual windows, then those of the interval's other
    windows; all else is the window's own.

    Parameters
    ----------
    inside, usual : windows of the interval and of the rest of its run that have an accepted fit
    """
    rows = np.flatnonzero(inside)
    if rows.size < 2 or not usual.any():
        return NOT_PREDICTED
    row = int(rows[rows.size // 2])
    channels = window_channels(data.records, data.windows, row, ("torque_sweep", "speed"))
    period, used = float(data.spectra["sweep_period"][row]), data.mobility["gate"].values[row] == Gate.USED
    if not period > 0 or not np.isfinite(channels).all() or not used.any():
        return NOT_PREDICTED
    frequency, rate = data.mobility["frequency"].values[used], sample_rate(data.records)
    band = float(frequency.min()), float(frequency.max())
    sweep, _ = mean_period(channels[0], rate, period, band)
    measured, noise = mean_period(channels[1], rate, period, band)
    errors = [
        float(np.sqrt(np.mean((measured - _predicted(data, row, members, sweep, period, band)) ** 2)))
        for members in (np.flatnonzero(usual), rows[rows != row])
    ]
    return errors[0], errors[1], noise


def _predicted(
    data: WellData, row: int, members: Integers, sweep: Floats, period: float, band: tuple[float, float]
) -> Floats:
    """Speed over a period (points,) with damping and inertia of the assembly as in other windows."""
    parameters = data.fits["value"].values[row].copy()
    for place in (DAMPING_BHA, INERTIA_BHA):
        values, errors = (data.fits[name].values[members, place] for name in ("value", "standard_error"))
        parameters[place] = np.average(values, weights=errors**-2.0)
    controller = stored_controller(data.fits.isel(window=row))
    known = data_sheet(data.rig, controller, float(data.windows["bit_depth"][row])).equipment
    system = drilling_system(parameters, known)
    return driven(lambda frequency: np.asarray(command_mobility(system, laplace(frequency))), sweep, period, band)
