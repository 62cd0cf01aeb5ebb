"""The model of every window, and its command mobility, bit mobility and step responses."""

from __future__ import annotations

import contextlib
from collections.abc import Mapping, Sequence
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
    from drillid.physics.equipment import Controller


def identified_models(
    rig: Rig,
    controllers: Sequence[Controller],
    parameters: Floats,
    bit_depth: Floats,
    extended: Mapping[int, WindowModel] | None = None,
) -> list[WindowModel | None]:
    """Model of every window; None where a fit has no result.

    Parameters
    ----------
    controllers : of each depth
    parameters : shape (depth, 8), SI
    bit_depth : shape (depth,), m
    extended : models of the rows in which a cause was named, which replace those of the parameters
    """

    def model(row: int, controller: Controller, values: Floats, depth: float) -> WindowModel | None:
        if extended is not None and row in extended:
            return extended[row]
        if np.isnan(values).any():
            return None
        return WindowModel(drilling_system(values, data_sheet(rig, controller, depth).equipment), Recording())

    each = zip(controllers, parameters, bit_depth.tolist(), strict=True)
    return [model(row, *given) for row, given in enumerate(each)]


RESPONSES = (
    *("command_mobility_fitted", "bit_mobility_stiff", "bit_mobility_controlled"),
    *("bit_step_stiff", "bit_step_controlled"),
)
"""Variables of the responses, along depth."""


def identified_responses(
    models: Sequence[WindowModel | None], frequency: Floats, settings: DepthSettings
) -> xr.Dataset:
    """Command mobility, bit mobility and bit-speed steps of every model, stiff and as controlled; NaN without a model.

    Steps of a system that is unstable within their duration are NaN.

    Parameters
    ----------
    frequency : shape (frequency,), Hz
    """
    rows = [_responses(window_model, frequency, settings) for window_model in models]
    return xr.concat(rows, "depth", coords="minimal", compat="override", join="exact")


def _responses(window_model: WindowModel | None, frequency: Floats, settings: DepthSettings) -> xr.Dataset:
    """Responses of one window's model."""
    duration, interval = settings.step_duration_s, settings.step_interval_s
    lag, s = np.arange(0.0, duration + interval / 2, interval), laplace(frequency)
    missing, no_step = np.full(frequency.size, complex(np.nan, np.nan)), np.full(lag.size, np.nan)
    responses = dict.fromkeys(("command_mobility_fitted", "bit_mobility_stiff", "bit_mobility_controlled"), missing)
    steps = dict.fromkeys(("bit_step_stiff", "bit_step_controlled"), no_step)
    if window_model is not None:
        system, continuous = window_model.system, window_model.continuous_system
        responses["command_mobility_fitted"] = window_model.mobility(s)
        for end, stiff in (("stiff", True), ("controlled", False)):
            responses[f"bit_mobility_{end}"] = bit_mobility(system, s, stiff=stiff)
            with contextlib.suppress(EstimationError):
                steps[f"bit_step_{end}"] = bit_step_response(continuous, duration, interval, stiff=stiff)[1]
    return xr.Dataset(
        {name: ("frequency", response) for name, response in responses.items()}
        | {name: ("lag", step) for name, step in steps.items()},
        {"frequency": frequency, "lag": lag},
    )
