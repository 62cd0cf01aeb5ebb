"""Speed control tuned to an identified system: least vibration of the bit subject to the loop's margins."""

import itertools
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Any, Literal

import numpy as np

from drillid.arrays import Floats, Integers
from drillid.control.margins import Loops, Margins, is_stable_loop, margins
from drillid.errors import EstimationError, SettingsError
from drillid.physics.eight_parameters import KnownEquipment, drilling_system
from drillid.physics.equipment import Controller, DrillingSystem, ImpedanceMatching, of_window, window_shape
from drillid.physics.parameters import BOUNDS
from drillid.physics.responses import bit_mobility, laplace
from drillid.physics.stability import Loop, growing_poles
from drillid.physics.time_responses import bit_step_response

Family = Literal["proportional integral", "inertia compensation", "impedance matching"]
Goal = Literal["peak", "mean square", "decay"]

_LINES = 400
_REFINEMENTS = 5
"""Of the frequencies about each peak between these lines."""
_SHRINKAGE = 4.0
"""Of their spacing from one refinement to the next."""
_LAGS = (20.0, 0.05)
"""s, length and spacing of the step response of the goal "decay"."""
_EVALUATIONS = 160
_MOST_DRAWS = 100
_INFEASIBLE = 1e6
"""Cost of settings whose margins are too small; exceeds any goal relative to its present value."""

UNITS: Mapping[str, str] = {
    "proportional": "kN m/rpm",
    "integral": "kN m/rad",
    "compensated_inertia": "kg m^2",
    "compensation_filter": "s",
    "impedance": "rpm/(kN m)",
    "low_pass": "s",
    "high_pass": "s",
}
"""Units in which settings are usually entered on a rig's control panel."""
_SI_UNITS: Mapping[str, str] = {
    "proportional": "N m s/rad",
    "integral": "N m/rad",
    "compensated_inertia": "kg m^2",
    "compensation_filter": "s",
    "impedance": "rad/(N m s)",
    "low_pass": "s",
    "high_pass": "s",
}


@dataclass(frozen=True)
class RequiredMargins:
    """Margins that every sample of the system must keep."""

    gain: float = 2.0
    """Factor by which the gain may grow, or fall."""
    phase: float = np.pi / 6
    """rad."""
    sensitivity: float = 1.8
    """Largest sensitivity; 1 over the modulus margin."""

    def shortfall(self, actual: Margins) -> float:
        """Relative shortfall of the worst sample below these margins, summed; 0 where all are kept."""
        shortfalls = (
            np.max(self.gain / actual.gain - 1),
            np.max(self.gain * actual.gain_reduction - 1),
            np.max(self.phase / actual.phase - 1),
            np.max(actual.sensitivity / self.sensitivity - 1),
        )
        return float(sum(max(float(shortfall), 0.0) for shortfall in shortfalls))


@dataclass(frozen=True, eq=False)
class Tuning:
    """Tuned settings and their performance."""

    controller: Controller
    value: float
    """Goal of the worst sample; (rad/(N m s)), its square, or s² rad/(N m s), depending on the goal."""
    present: float
    """The same for the present controller; infinite where it is unstable."""
    margins: Margins
    """Margins of each sample."""

    def in_units(self, units: Mapping[str, str] = UNITS) -> dict[str, tuple[float, str]]:
        """Settings in the rig's units, without those that are switched off."""
        return in_units(self.controller, units)


def in_units(controller: Controller, units: Mapping[str, str] = UNITS) -> dict[str, tuple[float, str]]:
    """Settings of a controller with their units, 'rpm/(kN m)' for instance.

    Raises
    ------
    SettingsError
        If a unit is unknown or has another dimension.
    """
    from drillid.units import to_si_factor

    parts = [controller] if controller.matching is None else [controller, controller.matching]
    values = {name: getattr(part, name) for part in parts for name in _SI_UNITS if getattr(part, name, None)}
    converted = {}
    for name, value in values.items():
        unit = units.get(name, _SI_UNITS[name])
        try:
            converted[name] = (float(value) / to_si_factor(unit, _SI_UNITS[name]), unit)
        except ValueError as error:
            raise SettingsError(f"unit of {name}", str(error), f"Give a unit of {_SI_UNITS[name]}") from error
    return converted


def controlled_by(system: DrillingSystem, controller: Controller) -> DrillingSystem:
    """The system under another speed control."""
    return replace(system, top_drive=replace(system.top_drive, controller=controller))


def sampled_systems(
    value: Floats, covariance: Floats, equipment: KnownEquipment, count: int = 12, seed: int = 0
) -> DrillingSystem:
    """The system at a fit's values, and at draws from its posterior within the physical bounds.

    Parameters
    ----------
    value, covariance : (8,) and (8, 8), SI, in the order of the schema
    count : number of samples, the first of which is the fit itself

    Returns
    -------
    One description whose quantities have the shape (count, 1).

    Raises
    ------
    EstimationError
        If nearly all of the distribution lies outside the bounds.
    """
    generator = np.random.default_rng(seed)
    kept = [value]
    # parameters differ by twenty orders of magnitude, so that the unscaled covariance cannot be factorised
    deviation = np.sqrt(np.diag(covariance))
    scale = np.where(deviation > 0, deviation, 1.0)
    scaled = covariance / np.outer(scale, scale)
    for _ in range(_MOST_DRAWS):
        drawn = value + scale * generator.multivariate_normal(np.zeros(value.size), scaled, size=count)
        kept.extend(drawn[np.all((drawn >= BOUNDS[0]) & (drawn <= BOUNDS[1]), axis=1)])
        if len(kept) >= count:
            return drilling_system(np.stack(kept[:count]), equipment)
    raise EstimationError(
        "samples of the fit", "nearly all lie outside the physical bounds", "Fit more windows jointly"
    )


def first_sample(system: DrillingSystem) -> DrillingSystem:
    """The first sample in plain numbers, as the time-domain simulator needs them."""
    shape = window_shape(system)
    return of_window(system, (0,) * len(shape), shape)


def bit_vibration(system: DrillingSystem, goal: Goal, band: tuple[float, float]) -> Floats:
    """Value of the goal for each sample of the system.

    peak : largest |bit mobility| in the band, rad/(N m s)
    mean square : mean of its square over the band in Hz
    decay : ∫ t |bit speed| dt after a unit torque step at the bit, rad s/(N m)
    """
    if goal == "decay":
        lags, speed = bit_step_response(system, *_LAGS)
        return np.asarray(np.trapezoid(lags * np.abs(speed), lags, axis=-1), dtype=float)
    frequency = np.linspace(*band, _LINES)
    size = np.abs(bit_mobility(system, laplace(frequency)))
    return _peak(system, frequency, size) if goal == "peak" else np.asarray(np.mean(size**2, axis=-1), dtype=float)


def _peak(system: DrillingSystem, frequency: Floats, size: Floats) -> Floats:
    """Largest |bit mobility| of each sample (...), from its sizes (..., frequency) at evenly spaced frequencies.

    Beside a mode 1/|M|² is a parabola in frequency; each largest neighbour is the start of a search for its vertex.
    """
    ends = np.ones((*size.shape[:-1], 1), dtype=bool)
    rises = np.diff(size, axis=-1) > 0
    is_peak = np.concatenate([ends, rises], axis=-1) & np.concatenate([~rises, ends], axis=-1)
    # samples with fewer peaks than others have further lines among theirs
    peaks = np.argsort(np.where(is_peak, -size, 0.0), axis=-1)[..., : int(is_peak.sum(axis=-1).max())]
    centre, spacing, largest = frequency[peaks], float(frequency[1] - frequency[0]), size.max(axis=-1)
    for _ in range(_REFINEMENTS):
        places = np.clip(centre[..., None] + spacing * np.array([-1.0, 0.0, 1.0]), frequency[0], frequency[-1])
        s = laplace(places.reshape(*places.shape[:-2], -1))
        found = np.abs(bit_mobility(system, s)).reshape(places.shape)
        largest = np.maximum(largest, found.max(axis=(-2, -1)))
        centre = centre + spacing * _vertex(found)
        spacing /= _SHRINKAGE
    return np.asarray(largest, dtype=float)


def _vertex(size: Floats) -> Floats:
    """Place of the least 1/size² of three sizes (..., 3) at −1, 0 and 1, by a parabola within these."""
    before, at, after = np.moveaxis(size**-2.0, -1, 0)
    curvature = before - 2 * at + after
    downhill = np.sign(before - after)
    vertex: Floats = np.divide((before - after) / 2, curvature, out=downhill, where=curvature > 0)
    return np.clip(vertex, -1.0, 1.0)


def tune(
    system: DrillingSystem,
    family: Family = "proportional integral",
    goal: Goal = "peak",
    *,
    band: tuple[float, float] = (0.05, 3.0),
    required: RequiredMargins | None = None,
    stiffness: float = 12.0,
) -> Tuning:
    """Settings of a family that minimise the goal of the worst sample, with the margins kept by all samples.

    A coarse search over the settings' range is followed by Nelder and Mead's simplex. Filters of the present
    controller stay as they are.

    Parameters
    ----------
    system : of plain numbers, or of shape (sample, 1)
    band : Hz, in which the bit's mobility is evaluated
    stiffness : proportional gain of the inner speed control under impedance matching, per Y₀ of the pipe

    Raises
    ------
    EstimationError
        If no settings of the family keep the margins.
    """
    from scipy.optimize import minimize

    margins_to_keep, loops, growing = required or RequiredMargins(), Loops(system), growing_poles(system)
    build, axes = _family(system, family, stiffness)

    def vibration(candidate: Controller) -> float:
        return _worst_vibration(controlled_by(system, candidate), loops.under(candidate), growing, goal, band)

    present = vibration(system.top_drive.controller)
    unit = present if np.isfinite(present) else 1.0

    def cost(settings: Any) -> float:
        inside = [np.clip(setting, axis[0], axis[-1]) for setting, axis in zip(settings, axes, strict=True)]
        outside = float(np.sum(np.abs(np.asarray(settings) - inside)))
        candidate = build(*inside)
        shortfall = margins_to_keep.shortfall(margins(loops.under(candidate)))
        if shortfall + outside > 0:
            return _INFEASIBLE * (1 + shortfall + outside)
        return min(vibration(candidate) / unit, 10 * _INFEASIBLE)

    coarse = min(itertools.product(*axes), key=cost)
    if cost(coarse) >= _INFEASIBLE:
        raise EstimationError(
            f"control with {family}", "no settings keep the margins", "Relax the margins or shorten the drive's delay"
        )
    steps = [(axis[1] - axis[0]) / 2 for axis in axes]
    simplex = [np.array(coarse)] + [np.array(coarse) + step * np.eye(len(axes))[row] for row, step in enumerate(steps)]
    options = {"maxfev": _EVALUATIONS, "initial_simplex": np.stack(simplex), "xatol": 1e-3, "fatol": 1e-5}
    result = minimize(cost, coarse, method="Nelder-Mead", options=options)
    tuned = build(*result.x)
    return Tuning(tuned, float(result.fun) * unit, present, margins(loops.under(tuned)))


def _worst_vibration(
    system: DrillingSystem, loop: Loop, growing: Integers, goal: Goal, band: tuple[float, float]
) -> float:
    """Value of the goal for the worst sample; infinite where one is not stable, or at the limit of stability."""
    try:
        stable = is_stable_loop(loop, system.top_drive.controller, growing)
    except EstimationError:
        stable = False
    worst = float(np.max(bit_vibration(system, goal, band))) if stable else np.inf
    return worst if np.isfinite(worst) else np.inf


def _family(system: DrillingSystem, family: Family, stiffness: float) -> tuple[Callable[..., Controller], list[Floats]]:
    """Controller as a function of the settings, and the coarse grid of each setting, rising."""
    present = system.top_drive.controller
    pipe = float(np.mean(system.string[0].characteristic_admittance))
    inertia = float(np.mean(system.top_drive.inertia))
    gains, corners = np.log(np.geomspace(0.5, 20.0, 8)), np.log(np.geomspace(0.05, 3.0, 5))

    def soft(gain: float, corner: float, share: float = 0.0) -> Controller:
        proportional = pipe * float(np.exp(gain))
        filtered = 0.05 if share > 0 and not present.compensation_filter else present.compensation_filter
        return replace(
            present,
            proportional=proportional,
            integral=proportional * float(np.exp(corner)),
            compensated_inertia=share * inertia,
            compensation_filter=filtered,
            matching=None,
        )

    def matched(impedance: float, low_pass: float) -> Controller:
        matching = ImpedanceMatching(float(np.exp(impedance)) / pipe, inertia, float(np.exp(low_pass)), 5.0)
        stiff = stiffness * pipe
        return replace(present, proportional=stiff, integral=stiff, compensated_inertia=0.0, matching=matching)

    if family == "proportional integral":
        return soft, [gains, corners]
    if family == "inertia compensation":
        return soft, [gains, corners[1::2], np.linspace(0.0, 0.8, 5)]
    return matched, [np.log(np.geomspace(0.05, 2.0, 8)), np.log(np.geomspace(0.005, 0.3, 5))]
