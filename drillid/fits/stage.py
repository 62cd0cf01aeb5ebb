"""Command mobilities → fits of the paper's eight-parameter model, window by window and for stacks (table 1)."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
import xarray as xr

from drillid.arrays import Floats, Indices
from drillid.datasets.measured import WINDOW_COORDINATES
from drillid.datasets.reuse import completed, row_keys
from drillid.datasets.store import Problem, WellFolders, windows_place
from drillid.fits.datasheet import (
    DataSheet,
    contradicted_controller,
    data_sheet,
    logs_command,
    stated_controller,
    with_logged_gains,
)
from drillid.fits.joint.coordinates import GAINS
from drillid.fits.joint.dataset import joint_dataset
from drillid.fits.window_fit import Measured, Prior, fit, measured_rows
from drillid.physics.equipment import Controller
from drillid.physics.parameters import PARAMETERS
from drillid.physics.top_drive import with_gains

if TYPE_CHECKING:
    from drillid.config.listing import Well
    from drillid.config.rig import Rig
    from drillid.config.settings import FitsSettings, Settings

_REMEDY = "See its residuals; the other windows stand"


def process(well: Well, folders: WellFolders, settings: Settings) -> list[Problem]:
    """Fits of all windows and stacks of a well."""
    spectra = folders.read("spectra", "spectra").drop_dims(["spectrogram_time", "spectrogram_frequency"]).load()
    mobility, stacks = folders.read("mobility", "mobility").load(), folders.read("mobility", "stacks").load()
    bit_depth = folders.read("windows", "windows")["bit_depth"].values
    controller, numbers = stated_controller(well.rig, spectra), spectra["window"].values
    rows, reads_own = measured_rows(mobility), logs_command(spectra) & (well.rig.controller is None)
    of_well = with_logged_gains(data_sheet(well.rig, controller, bit_depth[0]), spectra)

    def completed_fits(
        name: str, contents: xr.Dataset, depth: Floats, members: list[Indices], dimension: str
    ) -> xr.Dataset:
        # gains read from a fit's own windows depend on no others, so earlier fits stay unchanged as a well grows
        own_gains = [bool(reads_own[windows].any()) for windows in members]
        stated = vars(controller) | ({} if well.rig.controller else {"errors": of_well.gain_errors})
        gains = [None if own else stated for own in own_gains]
        of_rows = zip(contents["key"].values.tolist(), depth.tolist(), gains, strict=True)
        keys, measured = row_keys(folders.basis, list(of_rows)), measured_rows(contents)

        def make(missing: list[int]) -> xr.Dataset:
            own = {row: spectra.isel(window=members[row]) for row in missing}
            known = {row: stated_controller(well.rig, own[row]) if own_gains[row] else controller for row in missing}
            sheets = [_own_sheet(well.rig, known[row], of_well.gain_errors, depth[row], own[row]) for row in missing]
            return _fit_rows([measured[row] for row in missing], depth[missing], sheets, settings.fits, dimension)

        return completed(folders.earlier("fits", name), keys, dimension, make)

    own = [np.array([row]) for row in range(numbers.size)]
    fits = completed_fits("fits", mobility, bit_depth, own, "window")
    fits = fits.assign_coords({name: mobility[name] for name in WINDOW_COORDINATES})
    control = {f"controller_{name}": float(value) for name, value in vars(controller).items() if value is not None}
    folders.write("fits", "fits", fits, **control)
    sheets = _sheets(well.rig, of_well, bit_depth)
    known, prior = [sheet.equipment for sheet in sheets], _prior(sheets[0], bit_depth[0], settings.fits)
    joint, contradictions = joint_dataset(rows, known, bit_depth, prior, fits, settings.fits)
    folders.write("fits", "joint", joint)
    ends = zip(stacks["first_window"].values, stacks["last_window"].values, strict=True)
    stacked = [np.flatnonzero((numbers >= first) & (numbers <= last)) for first, last in ends]
    stack_depth = np.array([bit_depth[windows].mean() for windows in stacked])
    stack_fits = completed_fits("stack_fits", stacks, stack_depth, stacked, "stack")
    coordinates = {name: stacks[name] for name in ("stack", "hole_depth", "first_window", "last_window")}
    folders.write("fits", "stack_fits", stack_fits.assign_coords(coordinates), **control)
    reasons = fits["reason"].values
    refused = [
        Problem(windows_place(fits, np.flatnonzero(reasons == reason).tolist()), reason, _REMEDY)
        for reason in dict.fromkeys(reasons.tolist())
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


def _own_sheet(
    rig: Rig, controller: Controller, errors: tuple[float, float] | None, depth: float, spectra: xr.Dataset
) -> DataSheet:
    """The data sheet of a fit at a depth, with what its own windows' spectra tell of the gains.

    Parameters
    ----------
    errors : of the gains by all windows of the well, which those without a logged command take over where the rig
        states none
    """
    sheet = with_logged_gains(data_sheet(rig, controller, depth), spectra)
    is_known = sheet.gain_errors is not None or rig.controller is not None
    return sheet if is_known else replace(sheet, gain_errors=errors)


def _sheets(rig: Rig, known: DataSheet, bit_depth: Floats) -> list[DataSheet]:
    """The data sheets at each bit depth, with the controller of a known one."""
    return [
        replace(data_sheet(rig, known.controller, depth), gain_errors=known.gain_errors) for depth in bit_depth.tolist()
    ]


def _prior(sheet: DataSheet, bit_depth: float, settings: FitsSettings) -> Prior:
    """Prior of a fit; if data sheets are not to be used, of the gains alone, as the control is known from them."""
    prior = sheet.prior(bit_depth)
    return prior if settings.use_data_sheets else replace(Prior.silent(), gains=prior.gains)


def _fit_rows(
    rows: list[Measured], bit_depth: Floats, sheets: list[DataSheet], settings: FitsSettings, dimension: str
) -> xr.Dataset:
    """Fits of measured mobilities, one at each bit depth."""
    priors = [_prior(sheet, depth, settings) for sheet, depth in zip(sheets, bit_depth.tolist(), strict=True)]
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
    controllers = [with_gains(sheet.controller, result.gains) for sheet, result in zip(sheets, fits, strict=True)]
    gains = np.array([[controller.proportional, controller.integral] for controller in controllers])
    return xr.Dataset(
        {name: ((dimension, "parameter"), np.array(values).reshape(-1, size)) for name, values in columns.items()}
        | {name: (dimension, np.asarray(values)) for name, values in scalars.items()}
        | {"correlation": ((dimension, "parameter", "parameter_"), correlation)}
        | {"gain_value": ((dimension, "gain"), gains.reshape(-1, len(GAINS)))},
        {"parameter": list(PARAMETERS), "parameter_": list(PARAMETERS), "gain": list(GAINS)},
    )
