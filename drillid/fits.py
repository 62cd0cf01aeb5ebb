"""Command mobility → the eight parameters of the damped transmission line (paper, table 1)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from drillid.errors import EstimationError
from drillid.mobility import sharing
from drillid.physics.equipment import Controller, polar_moment
from drillid.physics.model import (
    DELAY,
    INERTIA_TD,
    LENGTH,
    POLAR_MOMENT,
    KnownEquipment,
    command_mobility_with_derivatives,
)
from drillid.physics.responses import laplace
from drillid.schema import PARAMETERS, WINDOW_COORDINATES, Gate
from drillid.solver import solve_bounded
from drillid.starts import BOUNDS, SCALES, starting_points
from drillid.statistics import expected_ratio, sum_of_ratios_probability
from drillid.store import Problem, WellFolders

if TYPE_CHECKING:
    from drillid.config import FitsSettings, Settings
    from drillid.rig import Rig
    from drillid.sheets import Well

Floats = NDArray[np.float64]
Complex = NDArray[np.complex128]

_NEAR_BOUND = 0.01
"""Standard errors from a physical bound below which a value counts as at the bound."""
_LEAST_FREQUENCIES = 20
"""Frequencies below which eight parameters are not worth a fit."""


@dataclass(frozen=True)
class Measured:
    """One measured mobility at the frequencies that passed the gate; arrays of shape (frequency,)."""

    frequency: Floats
    mobility: Complex
    variance: Floats
    degrees_of_freedom: Floats
    sharing: Floats

    @property
    def weight(self) -> Floats:
        """Real weight per component: one over the deviation of real and imaginary part, variance uncertainty included."""
        return np.sqrt(2 / (self.variance * expected_ratio(self.degrees_of_freedom)))


@dataclass(frozen=True)
class Prior:
    """What the rig's papers say: value and standard uncertainty, shape (8,); NaN where they are silent."""

    value: Floats
    error: Floats

    @staticmethod
    def silent() -> Prior:
        """No knowledge."""
        return Prior(np.full(len(PARAMETERS), np.nan), np.full(len(PARAMETERS), np.nan))


@dataclass(frozen=True)
class Fit:
    """Result of a fit; a failure is a fit that is not accepted, with its reason."""

    value: Floats
    covariance: Floats
    at_bound: NDArray[np.bool_]
    chi2_per_dof: float
    residual_dof: float
    probability: float
    accepted: bool
    reason: str

    @staticmethod
    def refused(reason: str) -> Fit:
        """No fit at all."""
        size = len(PARAMETERS)
        nothing = np.full(size, np.nan)
        return Fit(nothing, np.full((size, size), np.nan), np.zeros(size, bool), np.nan, 0.0, np.nan, False, reason)


def fit(measured: Measured, known: KnownEquipment, prior: Prior, settings: FitsSettings) -> Fit:
    """Weighted least squares from several starting points that need no advance information.

    Residuals are the complex errors over their deviations, and the prior's pulls. Derivatives
    are exact. The covariance is the inverse of the curvature at the optimum.
    """
    if measured.frequency.size < _LEAST_FREQUENCIES:
        return Fit.refused(f"only {measured.frequency.size} frequencies passed the gate, of {_LEAST_FREQUENCIES} needed")
    problem = _LeastSquares(measured, known, prior)
    starts = starting_points(measured.frequency, measured.mobility, measured.variance, known, prior.value, settings.starts)
    points, costs = solve_bounded(problem.curvature, np.stack(starts) / SCALES, *(BOUNDS / SCALES))
    return _judge(problem, points[int(np.argmin(costs))], settings)


class _LeastSquares:
    """Half the sum of squared residuals and its exact derivatives in scaled parameters."""

    def __init__(self, measured: Measured, known: KnownEquipment, prior: Prior) -> None:
        self.measured, self.known = measured, known
        self.s = laplace(measured.frequency)
        informed = np.isfinite(prior.value)
        self.informed = informed
        self.prior_value = np.where(informed, prior.value, 0.0) / SCALES
        self.prior_weight = np.where(informed, SCALES / prior.error, 0.0)

    def curvature(self, scaled: Floats, _: NDArray[np.intp]) -> tuple[Floats, Floats, Floats]:
        """Cost (point,), gradient (point, 8) and Gauss–Newton Hessian (point, 8, 8)."""
        mobility, derivatives = command_mobility_with_derivatives(scaled * SCALES, self.known, self.s)
        error = (mobility - self.measured.mobility) * self.measured.weight
        rows = derivatives * (SCALES[:, None] * self.measured.weight)
        stacked = np.concatenate([rows.real, rows.imag], axis=-1)
        pulls = (scaled - self.prior_value) * self.prior_weight
        gradient = np.matvec(stacked, np.concatenate([error.real, error.imag], axis=-1)) + pulls * self.prior_weight
        hessian = stacked @ np.swapaxes(stacked, -1, -2) + np.diag(self.prior_weight**2)
        cost = 0.5 * (np.sum(np.abs(error) ** 2, axis=-1) + np.sum(pulls**2, axis=-1))
        return cost, gradient, hessian

    def chi2(self, scaled: Floats) -> float:
        """Sum of squared residuals without the prior's pulls."""
        mobility, _ = command_mobility_with_derivatives(scaled * SCALES, self.known, self.s)
        return float(np.sum(np.abs((mobility - self.measured.mobility) * self.measured.weight) ** 2))

    def covariance(self, scaled: Floats) -> Floats:
        """Inverse of the curvature, in SI units, shape (8, 8)."""
        hessian = self.curvature(scaled[None], np.zeros(1, np.intp))[2][0]
        covariance: Floats = np.linalg.pinv(hessian, hermitian=True) * np.outer(SCALES, SCALES)
        return covariance


def _judge(problem: _LeastSquares, scaled: Floats, settings: FitsSettings) -> Fit:
    measured, value = problem.measured, scaled * SCALES
    covariance = problem.covariance(scaled)
    error = np.sqrt(np.diag(covariance))
    at_bound = np.minimum(value - BOUNDS[0], BOUNDS[1] - value) < _NEAR_BOUND * error
    total = problem.chi2(scaled)
    lost = (value.size - np.count_nonzero(at_bound | problem.informed)) / 2
    dof = 2 * (measured.frequency.size - lost)
    ratio = expected_ratio(measured.degrees_of_freedom)
    chance = sum_of_ratios_probability(
        float(np.mean(ratio)) * total / 2, measured.degrees_of_freedom, measured.sharing, fitted=lost
    )
    reason = _why_refused(value, error, chance, settings)
    return Fit(value, covariance, at_bound, total / dof, dof, chance, not reason, reason)


def _why_refused(value: Floats, error: Floats, chance: float, settings: FitsSettings) -> str:
    if not np.all(np.isfinite(error)):
        return "the data do not determine the parameters"
    for index in (LENGTH, POLAR_MOMENT, INERTIA_TD):
        name, unit = list(PARAMETERS)[index], list(PARAMETERS.values())[index][0]
        if min(value[index] - BOUNDS[0, index], BOUNDS[1, index] - value[index]) < error[index]:
            return f"{name} ended at the edge of what is searched, {value[index]:.4g} {unit}"
    if chance < settings.error_rate:
        return f"the residuals are larger than the noise allows (chance {chance:.1g})"
    return ""


def known_equipment(rig: Rig, controller: Controller, bit_depth: float) -> KnownEquipment:
    """Controller and the tally's collars with the bit at `bit_depth` (m)."""
    collars = rig.collars_at(bit_depth)
    if collars is None:
        return KnownEquipment(controller)
    return KnownEquipment(controller, collars.length, polar_moment(collars.outer_diameter, collars.inner_diameter))


def knowledge(rig: Rig) -> Prior:
    """What the rig's papers say about the parameters."""
    prior = Prior.silent()
    if rig.drive_delay:
        prior.value[DELAY], prior.error[DELAY] = rig.drive_delay.value, rig.drive_delay.tolerance
    if rig.top_drive_inertia:
        inertia = rig.top_drive_inertia
        prior.value[INERTIA_TD], prior.error[INERTIA_TD] = inertia.value, inertia.relative * inertia.value
    if rig.pipe:
        moment = polar_moment(rig.pipe.outer_diameter, rig.pipe.inner_diameter)
        prior.value[POLAR_MOMENT], prior.error[POLAR_MOMENT] = moment, rig.pipe.relative * moment
    return prior


def speed_controller(rig: Rig, spectra: xr.Dataset) -> Controller:
    """The controller on the rig's papers or, where they are silent, P and I read from the logged torque command.

    The command less the sweep is −A H times the speed, without noise: P + I/s is fitted to it by
    least squares over all windows.

    Raises
    ------
    EstimationError
        If the torque command is not logged either.
    """
    if rig.controller:
        told = rig.controller
        return Controller(told.proportional, told.integral, told.speed_filter, told.torque_filter)
    taken_back = ((spectra["sweep_power"] - spectra["cross_command"]) / spectra["cross_speed"]).values
    measured = np.median(taken_back.real, axis=0) + 1j * np.median(taken_back.imag, axis=0)
    if not np.isfinite(measured).all():
        raise EstimationError(rig.name, "neither describes its controller nor logs the torque command", "Add one of them")
    s = laplace(spectra["frequency"].values)
    design = np.stack([np.ones_like(s), 1 / s], axis=1)
    gains = np.linalg.lstsq(np.concatenate([design.real, design.imag]), np.concatenate([measured.real, measured.imag]))[0]
    return Controller(float(gains[0]), float(gains[1]))


def measured_rows(mobility: xr.Dataset, averages: Floats) -> list[Measured]:
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
                sharing(freedom, averages[row, used]),
            )
        )
    return rows


def process(well: Well, folders: WellFolders, settings: Settings) -> list[Problem]:
    """Fits of all windows and stacks of a well."""
    spectra = folders.read("spectra", "spectra").drop_dims(["spectrogram_time", "spectrogram_frequency"]).load()
    mobility, stacks = folders.read("mobility", "mobility").load(), folders.read("mobility", "stacks").load()
    bit_depth = folders.read("windows", "windows")["bit_depth"].values
    controller = speed_controller(well.rig, spectra)
    prior = knowledge(well.rig) if settings.fits.use_knowledge else Prior.silent()
    averages = spectra["averages"].values
    fits = [
        fit(measured, known_equipment(well.rig, controller, depth), prior, settings.fits)
        for measured, depth in zip(measured_rows(mobility, averages), bit_depth, strict=True)
    ]
    windows_fit = _dataset(fits, prior, "window").assign_coords({name: mobility[name] for name in WINDOW_COORDINATES})
    folders.write("fits", "fits", windows_fit, **_controller_attributes(controller))
    stack_averages = averages[stacks["first_window"].values] * (stacks["last_window"] - stacks["first_window"] + 1).values[:, None]
    stack_fits = [
        fit(measured, known_equipment(well.rig, controller, depth), prior, settings.fits)
        for measured, depth in zip(measured_rows(stacks, stack_averages), stacks["hole_depth"].values, strict=True)
    ]
    coordinates = {name: stacks[name] for name in ("stack", "hole_depth", "first_window", "last_window")}
    folders.write("fits", "stack_fits", _dataset(stack_fits, prior, "stack").assign_coords(coordinates))
    return [
        Problem(f"window {int(mobility['window'][row])} at {float(mobility['hole_depth'][row]):.1f} m", result.reason, _REMEDY)
        for row, result in enumerate(fits)
        if not result.accepted
    ]


_REMEDY = "See its residuals; the other windows stand"


def _controller_attributes(controller: Controller) -> dict[str, float]:
    return {f"controller_{name}": float(value) for name, value in vars(controller).items()}


def _dataset(fits: list[Fit], prior: Prior, row: str) -> xr.Dataset:
    size = len(PARAMETERS)
    covariance = np.array([result.covariance for result in fits]).reshape(-1, size, size)
    error = np.sqrt(np.diagonal(covariance, axis1=1, axis2=2))
    known = np.broadcast_to(prior.value, (len(fits), size)), np.broadcast_to(prior.error, (len(fits), size))
    dims = (row, "parameter")
    return xr.Dataset(
        {
            "value": (dims, np.array([result.value for result in fits]).reshape(-1, size)),
            "standard_error": (dims, error),
            "at_bound": (dims, np.array([result.at_bound for result in fits], dtype=bool).reshape(-1, size)),
            "prior": (dims, known[0]),
            "prior_error": (dims, known[1]),
            "correlation": ((row, "parameter", "parameter_"), covariance / (error[:, :, None] * error[:, None, :])),
            "chi2_per_dof": (row, np.array([result.chi2_per_dof for result in fits], dtype=float)),
            "residual_dof": (row, np.array([result.residual_dof for result in fits], dtype=float)),
            "fit_probability": (row, np.array([result.probability for result in fits], dtype=float)),
            "accepted": (row, np.array([result.accepted for result in fits], dtype=bool)),
            "reason": (row, np.array([result.reason for result in fits], dtype=str)),
        },
        {"parameter": list(PARAMETERS), "parameter_": list(PARAMETERS)},
    )
