"""Command mobilities → fits of the paper's eight-parameter model, window by window and for stacks (table 1)."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from drillid.errors import EstimationError
from drillid.estimation import Measured, Prior, fit
from drillid.joint_dataset import joint_dataset
from drillid.mobility import sharing
from drillid.physics.equipment import Controller, polar_moment
from drillid.physics.model import DELAY, INERTIA_TD, LENGTH, POLAR_MOMENT, KnownEquipment
from drillid.physics.responses import laplace
from drillid.schema import PARAMETERS, WINDOW_COORDINATES, Gate
from drillid.store import Problem, WellFolders, window_place

if TYPE_CHECKING:
    from drillid.config import FitsSettings, Settings
    from drillid.rig import Rig
    from drillid.sheets import Well

Floats = NDArray[np.float64]

_CONTRADICTION = 4.0
"""Standard deviations between log and papers that tolerances do not explain."""
_REMEDY = "See its residuals; the other windows stand"


def known_equipment(rig: Rig, controller: Controller, bit_depth: float) -> KnownEquipment:
    """Controller and the tally's collars with the bit at `bit_depth` (m)."""
    collars = rig.collars_at(bit_depth)
    if collars is None:
        return KnownEquipment(controller)
    return KnownEquipment(controller, collars.length, polar_moment(collars.outer_diameter, collars.inner_diameter))


def knowledge(rig: Rig, bit_depth: float) -> Prior:
    """What the rig's papers say about the parameters with the bit at `bit_depth` (m)."""
    prior = Prior.silent()
    if rig.drive_delay:
        prior.value[DELAY], prior.error[DELAY] = rig.drive_delay.value, rig.drive_delay.tolerance
    if rig.top_drive_inertia:
        inertia = rig.top_drive_inertia
        prior.value[INERTIA_TD], prior.error[INERTIA_TD] = inertia.value, inertia.relative * inertia.value
    if rig.pipe:
        moment = polar_moment(rig.pipe.outer_diameter, rig.pipe.inner_diameter)
        prior.value[POLAR_MOMENT], prior.error[POLAR_MOMENT] = moment, rig.pipe.relative * moment
        collars = rig.collars_at(bit_depth)
        length = bit_depth - (collars.length if collars else 0.0)
        prior.value[LENGTH], prior.error[LENGTH] = length, rig.pipe.length_relative * length
    return prior


def speed_controller(rig: Rig, spectra: xr.Dataset) -> Controller:
    """The controller on the rig's papers or, where they are silent, P and I read from the logged torque command.

    Raises
    ------
    EstimationError
        If the torque command is not logged either.
    """
    if rig.controller:
        told = rig.controller
        return Controller(told.proportional, told.integral, told.speed_filter, told.torque_filter)
    gains = logged_gains(spectra, Controller(0.0))
    if not gains.size:
        raise EstimationError(rig.name, "neither describes its controller nor logs the command", "Add one of them")
    proportional, integral = np.median(gains, axis=0)
    return Controller(float(proportional), float(integral))


def stored_controller(fits: xr.Dataset) -> Controller:
    """The controller that the fits took as given."""
    prefix = "controller_"
    return Controller(
        **{str(name)[len(prefix) :]: value for name, value in fits.attrs.items() if str(name).startswith(prefix)}
    )


def logged_gains(spectra: xr.Dataset, filters: Controller) -> Floats:
    """P (N m s/rad) and I (N m/rad) of each window that logs the torque command, shape (windows with it, 2).

    The command less the sweep is −A H times the speed, without noise, whatever the string does:
    P + I/s is fitted to it by least squares, with the filters taken as given.
    """
    s = laplace(spectra["frequency"].values)
    taken_back = (spectra["sweep_power"] - spectra["cross_command"]) / spectra["cross_speed"]
    unfiltered = taken_back.values * (1 + s * filters.speed_filter) * (1 + s * filters.torque_filter)
    weight = np.abs(spectra["cross_speed"].values)
    design = np.stack([np.ones_like(s), 1 / s], axis=1) * weight[..., None]
    rows = np.concatenate([design.real, design.imag], axis=-2)
    target = np.concatenate([(unfiltered * weight).real, (unfiltered * weight).imag], axis=-1)
    logged = np.isfinite(target).all(axis=1) & np.isfinite(rows).all(axis=(1, 2))
    gains: Floats = np.matvec(np.linalg.pinv(rows[logged]), target[logged])
    return gains


def contradicted_controller(rig: Rig, spectra: xr.Dataset) -> list[Problem]:
    """A row where the logged torque command shows other gains than the papers, beyond their tolerance."""
    if rig.controller is None:
        return []
    told = np.array([rig.controller.proportional, rig.controller.integral])
    gains = logged_gains(spectra, speed_controller(rig, spectra))
    if not gains.size:
        return []
    found = np.median(gains, axis=0)
    error = np.hypot(rig.controller.relative * told, np.std(gains, axis=0) / np.sqrt(len(gains)))
    if np.all(np.abs(found - told) <= _CONTRADICTION * error):
        return []
    return [
        Problem(
            f"rig {rig.name}, controller",
            f"the logged command answers the speed with P {found[0]:.4g} N m s/rad and I {found[1]:.4g} N m/rad, "
            f"the papers say {told[0]:.4g} and {told[1]:.4g}",
            "Check sign and unit of the sweep, then the gains in the rig description, then for filters in the control",
        )
    ]


def measured_rows(mobility: xr.Dataset) -> list[Measured]:
    """The used frequencies of every row (window or stack) of a mobility dataset."""
    rows = []
    for row in range(mobility["command_mobility"].shape[0]):
        used = mobility["gate"].values[row] == Gate.USED
        freedom = mobility["degrees_of_freedom"].values[row, used]
        rows.append(
            Measured(
                mobility["frequency"].values[used],
                mobility["command_mobility"].values[row, used],
                mobility["command_mobility_variance"].values[row, used],
                freedom,
                sharing(freedom, mobility["averages"].values[row, used]),
            )
        )
    return rows


def process(well: Well, folders: WellFolders, settings: Settings) -> list[Problem]:
    """Fits of all windows and stacks of a well."""
    spectra = folders.read("spectra", "spectra").drop_dims(["spectrogram_time", "spectrogram_frequency"]).load()
    mobility, stacks = folders.read("mobility", "mobility").load(), folders.read("mobility", "stacks").load()
    bit_depth = folders.read("windows", "windows")["bit_depth"].values
    controller = speed_controller(well.rig, spectra)
    rows = measured_rows(mobility)
    fits = _fit_rows(rows, bit_depth, well.rig, controller, settings.fits, "window")
    fits = fits.assign_coords({name: mobility[name] for name in WINDOW_COORDINATES})
    gains = {f"controller_{name}": float(value) for name, value in vars(controller).items() if value is not None}
    folders.write("fits", "fits", fits, **gains)
    known = [known_equipment(well.rig, controller, depth) for depth in bit_depth]
    papers = knowledge(well.rig, float(bit_depth[0])) if settings.fits.use_knowledge else Prior.silent()
    joint, contradictions = joint_dataset(rows, known, bit_depth, papers, fits, settings.fits)
    folders.write("fits", "joint", joint)
    stack_depth = stacks["hole_depth"].values
    stack_fits = _fit_rows(measured_rows(stacks), stack_depth, well.rig, controller, settings.fits, "stack")
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
    priors = [knowledge(rig, depth) if settings.use_knowledge else Prior.silent() for depth in bit_depth]
    fits = [
        fit(measured, known_equipment(rig, controller, depth), prior, settings)
        for measured, depth, prior in zip(rows, bit_depth, priors, strict=True)
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
        "fit_probability": [result.probability for result in fits],
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
