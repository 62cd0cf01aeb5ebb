"""Command mobilities → fits of the paper's eight-parameter model, window by window and for stacks (table 1)."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import xarray as xr

from drillid.arrays import Floats
from drillid.datasets.measured import WINDOW_COORDINATES
from drillid.datasets.reuse import completed, row_keys
from drillid.datasets.store import Problem, WellFolders, window_place
from drillid.fits.datasheet import contradicted_controller, data_sheet, speed_controller
from drillid.fits.joint.dataset import joint_dataset
from drillid.fits.window_fit import Measured, Prior, fit, measured_rows
from drillid.physics.equipment import Controller
from drillid.physics.parameters import PARAMETERS

if TYPE_CHECKING:
    from drillid.config.rig import Rig
    from drillid.config.settings import FitsSettings, Settings
    from drillid.config.sheets import Well

_REMEDY = "See its residuals; the other windows stand"


def process(well: Well, folders: WellFolders, settings: Settings) -> list[Problem]:
    """Fits of all windows and stacks of a well."""
    spectra = folders.read("spectra", "spectra").drop_dims(["spectrogram_time", "spectrogram_frequency"]).load()
    mobility, stacks = folders.read("mobility", "mobility").load(), folders.read("mobility", "stacks").load()
    bit_depth = folders.read("windows", "windows")["bit_depth"].values
    controller = speed_controller(well.rig, spectra)
    rows = measured_rows(mobility)

    def completed_fits(name: str, contents: xr.Dataset, depth: Floats, dimension: str) -> xr.Dataset:
        of_rows = zip(contents["key"].values.tolist(), depth.tolist(), strict=True)
        keys, measured = row_keys(folders.basis, list(of_rows), vars(controller)), measured_rows(contents)

        def make(missing: list[int]) -> xr.Dataset:
            chosen = [measured[row] for row in missing]
            return _fit_rows(chosen, depth[missing], well.rig, controller, settings.fits, dimension)

        return completed(folders.earlier("fits", name), keys, dimension, make)

    fits = completed_fits("fits", mobility, bit_depth, "window")
    fits = fits.assign_coords({name: mobility[name] for name in WINDOW_COORDINATES})
    gains = {f"controller_{name}": float(value) for name, value in vars(controller).items() if value is not None}
    folders.write("fits", "fits", fits, **gains)
    known = [data_sheet(well.rig, controller, depth).equipment for depth in bit_depth]
    first = data_sheet(well.rig, controller, float(bit_depth[0]))
    prior = first.prior(float(bit_depth[0])) if settings.fits.use_data_sheets else Prior.silent()
    joint, contradictions = joint_dataset(rows, known, bit_depth, prior, fits, settings.fits)
    folders.write("fits", "joint", joint)
    stack_fits = completed_fits("stack_fits", stacks, stacks["hole_depth"].values, "stack")
    coordinates = {name: stacks[name] for name in ("stack", "hole_depth", "first_window", "last_window")}
    folders.write("fits", "stack_fits", stack_fits.assign_coords(coordinates))
    refused = [
        Problem(window_place(fits, row), reason, _REMEDY)
        for row, reason in enumerate(fits["reason"].values.tolist())
        if reason
    ]
    refused += [
        Problem(f"stack of windows {int(first)} to {int(last)}", reason, _REMEDY)
        for first, last, reason in zip(
            stacks["first_window"].values,
            stacks["last_window"].values,
            stack_fits["reason"].values.tolist(),
            strict=True,
        )
        if reason
    ]
    return [*contradicted_controller(well.rig, spectra), *refused, *contradictions]


def _fit_rows(
    rows: list[Measured], bit_depth: Floats, rig: Rig, controller: Controller, settings: FitsSettings, dimension: str
) -> xr.Dataset:
    """Fits of measured mobilities, one at each bit depth."""
    sheets = [data_sheet(rig, controller, depth) for depth in bit_depth]
    priors = [
        sheet.prior(depth) if settings.use_data_sheets else Prior.silent()
        for sheet, depth in zip(sheets, bit_depth, strict=True)
    ]
    fits = [
        fit(measured, sheet.equipment, prior, settings)
        for measured, sheet, prior in zip(rows, sheets, priors, strict=True)
    ]
    size = len(PARAMETERS)
    columns = {
        "value": [result.value for result in fits],
        "standard_error": [result.error for result in fits],
        "interval_lower": [result.lower for result in fits],
        "interval_upper": [result.upper for result in fits],
        "status": [result.status for result in fits],
        "at_bound": [result.at_bound for result in fits],
        "prior": [prior.value for prior in priors],
        "prior_error": [prior.error for prior in priors],
    }
    scalars = {
        "chi2_per_dof": [result.chi2_per_dof for result in fits],
        "residual_dof": [result.residual_dof for result in fits],
        "mismatch": [result.mismatch for result in fits],
        "fit_p_value": [result.probability for result in fits],
        "accepted": np.array([result.accepted for result in fits], dtype=bool),
        "reason": np.array([result.reason for result in fits], dtype=object),
    }
    correlation = np.array([result.correlation for result in fits]).reshape(-1, size, size)
    return xr.Dataset(
        {name: ((dimension, "parameter"), np.array(values).reshape(-1, size)) for name, values in columns.items()}
        | {name: (dimension, np.asarray(values)) for name, values in scalars.items()}
        | {"correlation": ((dimension, "parameter", "parameter_"), correlation)},
        {"parameter": list(PARAMETERS), "parameter_": list(PARAMETERS)},
    )
