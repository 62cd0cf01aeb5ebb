"""Data sheets and tally of a rig as the fits use them: known equipment, priors, the controller."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np
import xarray as xr

from drillid.arrays import Booleans, Complex, Floats
from drillid.datasets.store import Problem
from drillid.errors import EstimationError
from drillid.fits.window_fit import Prior
from drillid.physics.eight_parameters import KnownEquipment
from drillid.physics.equipment import Controller, polar_moment
from drillid.physics.parameters import DELAY, INERTIA_TD, LENGTH, POLAR_MOMENT
from drillid.physics.responses import laplace

if TYPE_CHECKING:
    from collections.abc import Sequence

    from drillid.config.rig import Rig

_CONTRADICTION = 4.0
"""Standard deviations between log and data sheets beyond which tolerances do not explain the difference."""
_LEAST_GAIN_ERROR = 1e-9
"""N m s/rad or N m/rad, used in place of zero."""
SHOWN_INTERVAL_ERROR = 1e-3
"""Relative error of a control interval seen in the logged rows: at least ten times that from one window of them."""
_SMOOTH = 8.0
"""Rows per period of the highest frequency from which unevenness shows."""
CLOCK_ERROR = 0.002
"""s, usual offset between the clocks of speed and torque."""
COMMAND_BANDS = 40
"""Number of bands with independent errors of the control's response; the errors are common to all windows."""


@dataclass(frozen=True, eq=False)
class DataSheet:
    """What a rig's data sheets and tally state, with standard uncertainties; infinite where they are silent."""

    controller: Controller
    controller_relative: float = 0.02
    """Relative standard uncertainty of both gains."""
    gain_errors: tuple[float, float] | None = None
    """Relative standard uncertainties of P and I where the logged command improves on the data sheet."""
    collar_length: float = 0.0
    """m; 0 without collars."""
    collar_polar_moment: float = 0.0
    """m⁴."""
    collar_relative: float = 0.1
    """Relative standard uncertainty of the collars' inertia."""
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
    """Relative standard uncertainty of the pipe's length as seen by waves."""
    clock_error: float = CLOCK_ERROR
    """s, between the clocks of speed and torque, from sampling of the control and from putting rows on one grid."""
    control_interval: float = np.nan
    """s, at which the control reads the speed and holds its command; NaN where data sheets are silent."""
    control_interval_relative: float = 0.03
    """Its relative standard uncertainty."""
    control_interval_is_taken: bool = False
    """Whether it is one of the usual intervals, taken where neither a document nor the rows tell it."""
    even_rows: float = np.nan
    """s, from row to row of logs whose rows are even and so show no interval of the control; NaN where they do, or
    cannot."""

    @property
    def tells_control_interval(self) -> bool:
        """Whether a document or the rows tell the interval of the control."""
        return bool(np.isfinite(self.control_interval)) and not self.control_interval_is_taken

    @property
    def equipment(self) -> KnownEquipment:
        """Equipment that a fit of one window takes as known."""
        return KnownEquipment(self.controller, self.collar_length, self.collar_polar_moment)

    def prior(self, bit_depth: float) -> Prior:
        """Prior of a fit of one window, with the bit at `bit_depth` (m)."""
        length = bit_depth - self.collar_length
        stated = {place: (getattr(self, name), getattr(self, f"{name}_error")) for name, place in _STATED.items()}
        stated[LENGTH] = (length, self.length_relative * length)
        errors = self.gain_errors or (self.controller_relative, self.controller_relative)
        prior = replace(Prior.silent(), gains=np.array(errors))
        for place, (value, error) in stated.items():
            if np.isfinite(error):
                prior.value[place], prior.error[place] = value, error
        return prior


_STATED = {"delay": DELAY, "inertia_td": INERTIA_TD, "polar_moment": POLAR_MOMENT}
"""Parameters that data sheets state directly, and their places among the eight."""


def data_sheet(rig: Rig, controller: Controller, bit_depth: float) -> DataSheet:
    """Equipment and prior of a rig with the bit at `bit_depth` (m); `controller` is stated, or read from the log."""
    stated: dict[str, Any] = {"controller_relative": rig.controller.relative if rig.controller else np.inf}
    if rig.drive_delay:
        stated |= {"delay": rig.drive_delay.value, "delay_error": rig.drive_delay.tolerance}
    if rig.control_interval:
        stated["control_interval"] = rig.control_interval
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


def stated_controller(rig: Rig, spectra: xr.Dataset) -> Controller:
    """The controller on the rig's data sheets or, where they are silent, P and I read from the logged torque command.

    Raises
    ------
    EstimationError
        If the torque command is not logged either, or in no window long enough for spectra.
    """
    if rig.controller:
        stated = rig.controller
        return Controller(stated.proportional, stated.integral, stated.speed_filter, stated.torque_filter)
    logged = logged_gains(spectra, Controller(0.0))
    if logged is None:
        if not spectra["cross_speed"].notnull().any():
            what = "does not describe its controller, and no window is long enough to read it from the logged command"
            raise EstimationError(rig.name, what, "Describe the controller, or log the sweep for longer")
        raise EstimationError(rig.name, "neither describes its controller nor logs the command", "Add one of them")
    proportional, integral = logged[0].tolist()
    return Controller(proportional, integral)


def with_logged_gains(sheet: DataSheet, spectra: xr.Dataset) -> DataSheet:
    """The data sheet with its gains and those from the logged command combined, weighted by their errors."""
    logged = logged_gains(spectra, sheet.controller)
    if logged is None:
        return sheet
    gains, covariance = logged
    stated = np.array([sheet.controller.proportional, sheet.controller.integral])
    precision = np.diag(1 / np.maximum(sheet.controller_relative * np.abs(stated), _LEAST_GAIN_ERROR) ** 2)
    together = np.linalg.inv(precision + np.linalg.inv(covariance))
    mean = stated + together @ np.linalg.solve(covariance, gains - stated)
    errors = np.sqrt(np.diag(together)) / np.maximum(np.abs(mean), _LEAST_GAIN_ERROR)
    controller = replace(sheet.controller, proportional=float(mean[0]), integral=float(mean[1]))
    return replace(sheet, controller=controller, gain_errors=(float(errors[0]), float(errors[1])))


def with_held_control(sheet: DataSheet, held: Sequence[float], rate: float, highest: float) -> DataSheet:
    """The data sheet with the interval of the control as the windows' logs tell it.

    Parameters
    ----------
    held : interval that each log shows, s; NaN where it shows none
    rate : rows per second
    highest : frequency of the sweep, Hz
    """
    shown = np.array(held)[np.isfinite(held)]
    if np.isfinite(sheet.control_interval):
        return sheet
    if shown.size:
        interval = float(np.median(shown))
        return replace(sheet, control_interval=interval, control_interval_relative=SHOWN_INTERVAL_ERROR)
    return replace(sheet, even_rows=1 / rate) if held and rate >= _SMOOTH * highest else sheet


def stored_controller(fit: xr.Dataset) -> Controller:
    """The controller of one window's fit, with the gains found there; `fit` is that row of the fits."""
    return stored_controllers(fit[["gain_value"]].expand_dims("window"))[0]


def stored_controllers(fits: xr.Dataset) -> list[Controller]:
    """The same of every window."""
    prefix = "controller_"
    known = {str(name)[len(prefix) :]: value for name, value in fits.attrs.items() if str(name).startswith(prefix)}
    controller = Controller(**known)
    return [
        replace(controller, proportional=proportional, integral=integral)
        for proportional, integral in fits["gain_value"].values.tolist()
    ]


def logged_gains(spectra: xr.Dataset, filters: Controller) -> tuple[Floats, Floats] | None:
    """P (N m s/rad) and I (N m/rad), (2,), from the logged torque command, and their covariance (2, 2).

    The command less the sweep is −A H times the speed, without the rig's noise, whatever the string does: P + I/s is
    fitted to it by least squares, with the filters taken as given and an offset between the clocks of command and
    speed, as large as is usual, left free. The gains are the median of all windows'. The residual is taken as an error
    common to all windows and independent in COMMAND_BANDS bands, from the sampling of the control and from
    interpolated rows; more windows do not reduce it. None where no command is logged.
    """
    s, logged = laplace(spectra["frequency"].values), logs_command(spectra)
    unfiltered = _taken_back(spectra) * (1 + s * filters.speed_filter) * (1 + s * filters.torque_filter)
    weight = np.abs(spectra["cross_speed"].values)
    if not logged.any():
        return None
    found = [_gains_of_window(*row, s) for row in zip(unfiltered[logged], weight[logged], strict=True)]
    gains, covariances = (np.stack(part) for part in zip(*found, strict=True))
    return np.median(gains, axis=0), np.mean(covariances, axis=0)


def logs_command(spectra: xr.Dataset) -> Booleans:
    """Whether the gains of the control can be read from each window's logged torque command, shape (window,)."""
    weight = spectra["cross_speed"].values
    return np.asarray(np.isfinite(_taken_back(spectra)).all(axis=1) & np.isfinite(weight).all(axis=1))


def _taken_back(spectra: xr.Dataset) -> Complex:
    """Reduction of the torque command per speed, as recorded, (window, frequency)."""
    taken_back = (spectra["sweep_power"] - spectra["cross_command"]) / spectra["cross_speed"]
    return np.asarray(taken_back.values)


def _gains_of_window(response: Complex, weight: Floats, s: Complex) -> tuple[Floats, Floats]:
    """P and I of one window (2,), with covariance (2, 2), from the control's response and its weight (frequency,)."""
    target = _real(response * weight)
    design = np.stack([_real(part * weight) for part in (np.ones_like(s), 1 / s)], axis=1)
    first = np.linalg.lstsq(design, target)[0]
    late = _real(s * (first[0] + first[1] / s) * weight)
    design = np.column_stack([design, late])
    lines = max(s.size / COMMAND_BANDS, 1.0)
    variance = float(np.mean((target - design @ np.linalg.lstsq(design, target)[0]) ** 2)) * lines
    # however well the command fits, a gain is known to 1e-6 of its size and of 1 N m s/rad at best
    variance = max(variance, 1e-12 * float(np.mean(target**2)), 1e-12 * float(np.mean(weight**2)))
    precision = design.T @ design / variance + np.diag([0.0, 0.0, CLOCK_ERROR**-2.0])
    covariance: Floats = np.asarray(np.linalg.inv(precision), dtype=float)
    return (covariance @ (design.T @ target) / variance)[:2], covariance[:2, :2]


def _real(values: Complex) -> Floats:
    """Real parts, then imaginary parts."""
    return np.concatenate([values.real, values.imag])


def contradicted_controller(rig: Rig, spectra: xr.Dataset) -> list[Problem]:
    """A problem row if the gains in the logged torque command differ from the data sheets beyond their tolerance."""
    if rig.controller is None:
        return []
    stated = np.array([rig.controller.proportional, rig.controller.integral])
    logged = logged_gains(spectra, stated_controller(rig, spectra))
    if logged is None:
        return []
    found, covariance = logged
    error = np.hypot(rig.controller.relative * stated, np.sqrt(np.diag(covariance)))
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
