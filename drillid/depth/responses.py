"""Command mobility, bit mobility and step responses of every identified model."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np
import xarray as xr

from drillid.arrays import Floats
from drillid.discrepancy.catalogue import WindowModel
from drillid.errors import EstimationError
from drillid.fits.datasheet import data_sheet
from drillid.physics.eight_parameters import drilling_system
from drillid.physics.responses import bit_mobility, laplace
from drillid.physics.sensor import Recording
from drillid.physics.time_responses import bit_step_response

if TYPE_CHECKING:
    from drillid.config.rig import Rig
    from drillid.config.settings import DepthSettings
    from drillid.physics.equipment import Controller, DrillingSystem


def identified_responses(
    rig: Rig,
    controller: Controller,
    parameters: Floats,
    bit_depth: Floats,
    frequency: Floats,
    settings: DepthSettings,
    extended: Mapping[int, WindowModel] | None = None,
) -> xr.Dataset:
    """Command mobility, bit mobility and bit-speed steps of every fitted model, stiff and as controlled.

    Steps of a system that is unstable within their duration are NaN.

    Parameters
    ----------
    parameters : shape (depth, 8), SI; rows of NaN give responses of NaN
    bit_depth : shape (depth,), m
    frequency : shape (frequency,), Hz
    extended : models of the rows in which a cause was named, which replace those of the parameters
    """
    s = laplace(frequency)
    rows = []
    for row, (values, depth) in enumerate(zip(parameters, bit_depth, strict=True)):
        window_model = (extended or {}).get(row)
        if window_model is None:
            window_model = WindowModel(
                drilling_system(values, data_sheet(rig, controller, float(depth)).equipment), Recording()
            )
        # complex arithmetic on the NaN of a fit without result would warn
        with np.errstate(invalid="ignore" if np.isnan(values).any() else "warn"):
            lag, steps = _steps(window_model.system, settings)
            responses = {
                "command_mobility_fitted": window_model.mobility(s),
                "bit_mobility_stiff": bit_mobility(window_model.system, s, stiff=True),
                "bit_mobility_controlled": bit_mobility(window_model.system, s),
            }
        rows.append(
            xr.Dataset(
                {name: ("frequency", response) for name, response in responses.items()}
                | {name: ("lag", step) for name, step in steps.items()},
                {"frequency": frequency, "lag": lag},
            )
        )
    return xr.concat(rows, "depth", coords="minimal", compat="override", join="exact")


def _steps(system: DrillingSystem, settings: DepthSettings) -> tuple[Floats, dict[str, Floats]]:
    """Lags, and bit speed after a step with the top drive clamped and as controlled."""
    duration, interval = settings.step_duration_s, settings.step_interval_s
    lag, steps = np.arange(0.0, duration + interval / 2, interval), {}
    for name, stiff in (("bit_step_stiff", True), ("bit_step_controlled", False)):
        try:
            steps[name] = bit_step_response(system, duration, interval, stiff=stiff)[1]
        except EstimationError:
            steps[name] = np.full(lag.size, np.nan)
    return lag, steps
