"""What data sheets and tally say about a rig, as fits take it: given equipment, priors, the controller."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
import xarray as xr

from drillid.arrays import Floats
from drillid.datasets.store import Problem
from drillid.errors import EstimationError
from drillid.fits.window_fit import Prior
from drillid.physics.eight_parameters import KnownEquipment
from drillid.physics.equipment import Controller, polar_moment
from drillid.physics.parameters import DELAY, INERTIA_TD, LENGTH, POLAR_MOMENT
from drillid.physics.responses import laplace

if TYPE_CHECKING:
    from drillid.config.rig import Rig

_CONTRADICTION = 4.0
"""Standard deviations between log and data sheets that tolerances do not explain."""


@dataclass(frozen=True, eq=False)
class DataSheet:
    """What a rig's data sheets and tally say, each with its standard uncertainty; infinite where they are silent."""

    controller: Controller
    controller_relative: float = 0.02
    """Of both gains."""
    collar_length: float = 0.0
    """m; 0 without collars."""
    collar_polar_moment: float = 0.0
    """m⁴."""
    collar_relative: float = 0.1
    """Of the collars' inertia."""
    delay: float = 0.04
    """s."""
    delay_error: float = np.inf
    inertia_td: float = 1000.0
    """kg m²."""
    inertia_td_error: float = np.inf
    polar_moment: float = 1e-5
    """m⁴, of the pipe."""
    polar_moment_error: float = np.inf
    length_relative: float = np.inf
    """Of the pipe's length as waves see it."""
    clock_error: float = 0.002
    """s, between the clocks of speed and torque: sampling of the control, rows put on one grid."""

    @property
    def equipment(self) -> KnownEquipment:
        """What a fit of one window takes as given."""
        return KnownEquipment(self.controller, self.collar_length, self.collar_polar_moment)

    def prior(self, bit_depth: float) -> Prior:
        """Prior of a fit of one window, with the bit at `bit_depth` (m)."""
        length = bit_depth - self.collar_length
        stated = {place: (getattr(self, name), getattr(self, f"{name}_error")) for name, place in _STATED.items()}
        stated[LENGTH] = (length, self.length_relative * length)
        prior = Prior.silent()
        for place, (value, error) in stated.items():
            if np.isfinite(error):
                prior.value[place], prior.error[place] = value, error
        return prior


_STATED = {"delay": DELAY, "inertia_td": INERTIA_TD, "polar_moment": POLAR_MOMENT}
"""Parameters that data sheets state as such, and their places among the eight."""


def data_sheet(rig: Rig, controller: Controller, bit_depth: float) -> DataSheet:
    """Equipment and prior of a rig with the bit at `bit_depth` (m); `controller` is stated, or read from the log."""
    stated: dict[str, float] = {"controller_relative": rig.controller.relative if rig.controller else np.inf}
    if rig.drive_delay:
        stated |= {"delay": rig.drive_delay.value, "delay_error": rig.drive_delay.tolerance}
    if rig.top_drive_inertia:
        inertia = rig.top_drive_inertia
        stated |= {"inertia_td": inertia.value, "inertia_td_error": inertia.relative * inertia.value}
    if rig.pipe:
        moment = polar_moment(rig.pipe.outer_diameter, rig.pipe.inner_diameter)
        stated |= {"polar_moment": moment, "polar_moment_error": rig.pipe.relative * moment}
        stated["length_relative"] = rig.pipe.length_relative
    collars = rig.collars_at(bit_depth)
    if collars:
        stated |= {"collar_length": collars.length, "collar_relative": collars.relative}
        stated["collar_polar_moment"] = polar_moment(collars.outer_diameter, collars.inner_diameter)
    return DataSheet(controller, **stated)


def speed_controller(rig: Rig, spectra: xr.Dataset) -> Controller:
    """The controller on the rig's data sheets or, where they are silent, P and I read from the logged torque command.

    Raises
    ------
    EstimationError
        If the torque command is not logged either.
    """
    if rig.controller:
        stated = rig.controller
        return Controller(stated.proportional, stated.integral, stated.speed_filter, stated.torque_filter)
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
    """A row where the logged torque command shows other gains than the data sheets, beyond their tolerance."""
    if rig.controller is None:
        return []
    stated = np.array([rig.controller.proportional, rig.controller.integral])
    gains = logged_gains(spectra, speed_controller(rig, spectra))
    if not gains.size:
        return []
    found = np.median(gains, axis=0)
    error = np.hypot(rig.controller.relative * stated, np.std(gains, axis=0) / np.sqrt(len(gains)))
    if np.all(np.abs(found - stated) <= _CONTRADICTION * error):
        return []
    return [
        Problem(
            f"rig {rig.name}, controller",
            f"the logged command answers the speed with P {found[0]:.4g} N m s/rad and I {found[1]:.4g} N m/rad, "
            f"the data sheets say {stated[0]:.4g} and {stated[1]:.4g}",
            "Check sign and unit of the sweep, then the gains in the rig description, then for filters in the control",
        )
    ]
