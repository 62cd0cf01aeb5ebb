"""A measured start of rotation: a described well is fitted to its first part and judged on the rest.

A simulation that matches the phase of stick-slip cycles by chance loses it when friction changes by 1 %. Misfits are
therefore taken over simulations with all friction at 98.5, 100 and 101.5 %.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from drillid.arrays import Floats
from drillid.errors import SettingsError
from drillid.physics.nonlinear import NonlinearRig
from drillid.physics.soft_string import Survey
from drillid.simulation.start_up import RATE, StartUp, WellEquipment, WellFriction, rig_at, start_up
from drillid.units import RPM

JITTER = (0.985, 1.0, 1.015)
"""Factors on all friction."""
FITTING_STEP = 0.01
"""s; halving it changes misfits of the field well by about 0.02 kN m and 0.1 rpm."""
BOUNDS = {
    "sliding": (0.03, 0.6),
    "breakaway": (1.0, 5.0),
    "assembly_sliding": (0.3, 3.0),
    "assembly_breakaway": (1.0, 3.0),
    "threshold": (0.1, 15.0),
    "rest": (0.01, 2.0),
    "assembly_rest": (0.01, 2.0),
    "rest_angle": (1.0, 300.0),
    "kappa": (1.0, 5e4),
    "assembly_inertia": (0.5, 2.0),
    "modulus": (50.0, 100.0),
}
"""Parameters that may be fitted, on a logarithmic scale, with their bounds; the modulus is the pipe's, GPa."""
USUAL = ("sliding", "assembly_sliding", "assembly_breakaway", "threshold", "rest", "rest_angle", "kappa", "modulus")
"""Parameters fitted by default, which hold at other depths of a hole as well; the assembly keeps its inertia."""
TORQUE_SCALE, BIT_SCALE = 1.9, 21.0
"""kN m and rpm: misfits that count alike."""
_EVALUATIONS, _STEP, _TOO_FAST = 300, 0.06, 1e6
_STEP_FROM_BOUND = 0.25
"""First step of a parameter that starts at its lower bound, as zero does, per range."""


@dataclass(frozen=True, eq=False)
class MeasuredStartUp:
    """A measured start of rotation, (samples,) at RATE."""

    top_speed: Floats
    """rad/s."""
    torque: Floats
    """N m, of the drive."""
    bit_slowest: Floats
    """rad/s, least in each half second; NaN where it is not measured."""
    bit_fastest: Floats
    """rad/s, greatest in each half second."""

    def until(self, last: float) -> "MeasuredStartUp":
        """The part up to a time, s."""
        kept = slice(None, round(last * RATE) + 1)
        series = (self.top_speed, self.torque, self.bit_slowest, self.bit_fastest)
        return MeasuredStartUp(*(values[kept] for values in series))

    @property
    def duration(self) -> float:
        """Length of the log, s."""
        return (self.torque.size - 1) / RATE


@dataclass(frozen=True)
class Misfit:
    """Deviations of a simulation from the log over an interval of time."""

    torque_rms: float
    """kN m."""
    bit_rms: float
    """rpm, of the bit speed from the middle of the half-second extremes; NaN where it is not measured."""
    extremes_rms: float
    """rpm, of the simulated half-second extremes from the measured ones, both together."""


def misfit(log: MeasuredStartUp, torque: Floats, bit_speed: Floats, first: float = 0.0, last: float = 45.0) -> Misfit:
    """Misfit of a simulation between two times, s, over the measured samples."""
    from scipy.ndimage import maximum_filter1d, minimum_filter1d

    span = slice(round(first * RATE), min(round(last * RATE) + 1, torque.size))
    width = round(RATE / 2)
    middle = (log.bit_slowest + log.bit_fastest) / 2
    slowest, fastest = minimum_filter1d(bit_speed, width), maximum_filter1d(bit_speed, width)
    size = torque.size
    extremes = np.concatenate([(slowest - log.bit_slowest[:size])[span], (fastest - log.bit_fastest[:size])[span]])
    return Misfit(
        _rms((torque - log.torque[:size])[span]) / 1e3,
        _rms((bit_speed - middle[:size])[span]) / RPM,
        _rms(extremes) / RPM,
    )


def _rms(values: Floats) -> float:
    known = values[np.isfinite(values)]
    return float(np.sqrt(np.mean(known**2))) if known.size else float("nan")


@dataclass(frozen=True)
class StartUpModel:
    """A described well and the parameters of it that are fitted.

    Raises
    ------
    SettingsError
        If a parameter to be fitted has no bounds, or none is to be fitted.
    """

    equipment: WellEquipment
    survey: Survey
    depth: float
    """m, of the bit along the hole."""
    friction: WellFriction
    fitted: tuple[str, ...] = USUAL
    """Names from BOUNDS."""
    one_rest: bool = True
    """Whether pipe and assembly have the same increase of friction by rest."""

    def __post_init__(self) -> None:
        unknown = sorted(set(self.fitted) - set(BOUNDS))
        if unknown or not self.fitted:
            names = ", ".join(BOUNDS)
            raise SettingsError("fit of a start of rotation", f"{unknown} cannot be fitted", f"Name some of {names}")

    @property
    def values(self) -> Floats:
        """Values of the fitted parameters."""
        modulus = self.equipment.pipe_shear_modulus / 1e9
        return np.array([modulus if name == "modulus" else getattr(self.friction, name) for name in self.fitted])

    def with_values(self, values: Floats) -> "StartUpModel":
        """The same model with other values of the fitted parameters."""
        found = dict(zip(self.fitted, values.tolist(), strict=True))
        modulus = found.pop("modulus", self.equipment.pipe_shear_modulus / 1e9)
        if self.one_rest:
            found["assembly_rest"] = found.get("rest", self.friction.rest)
        equipment = replace(self.equipment, pipe_shear_modulus=1e9 * modulus)
        return replace(self, equipment=equipment, friction=replace(self.friction, **found))

    def rig(self, factor: float = 1.0) -> NonlinearRig:
        """The rig with all friction times a factor.

        Raises
        ------
        SettingsError
            If the bit cannot be at the depth; see `rig_at`.
        """
        friction = replace(self.friction, sliding=self.friction.sliding * factor)
        return rig_at(self.depth, self.survey, self.equipment, friction)

    def simulated(self, log: MeasuredStartUp, factor: float = 1.0) -> StartUp:
        """The start of rotation under the log's top-drive speed, with all friction times a factor."""
        return start_up(self.rig(factor), log.top_speed, FITTING_STEP)

    def squared_errors(self, log: MeasuredStartUp) -> Floats:
        """Squared errors of torque and bit speed in the units that count alike, averaged over JITTER, (samples,)."""
        middle = (log.bit_slowest + log.bit_fastest) / 2
        rows = []
        for factor in JITTER:
            made = self.simulated(log, factor)
            size = made.torque.size
            torque = (made.torque - log.torque[:size]) / 1e3 / TORQUE_SCALE
            bit = (made.recorded_bit_speed() - middle[:size]) / RPM / BIT_SCALE
            rows.append(torque**2 + np.nan_to_num(bit) ** 2)
        return np.asarray(np.mean(rows, axis=0), dtype=float)

    def misfits(self, log: MeasuredStartUp, spans: Sequence[tuple[float, float]]) -> Floats:
        """Misfit of torque (kN m) and bit speed (rpm) in spans of time (s), over all JITTER, (span, 2)."""
        cut = log.until(max(last for _, last in spans))
        rows = []
        for factor in JITTER:
            made = self.simulated(cut, factor)
            found = [misfit(cut, made.torque, made.recorded_bit_speed(), *span) for span in spans]
            rows.append([(each.torque_rms, each.bit_rms) for each in found])
        return np.asarray(np.sqrt(np.mean(np.square(rows), axis=0)), dtype=float)

    def fit(self, log: MeasuredStartUp, last: float, evaluations: int = _EVALUATIONS) -> "StartUpModel":
        """Fit to the log up to `last` (s), starting from this model, by the simplex of Nelder and Mead (1965)."""
        from scipy.optimize import minimize

        def cost(logarithms: Floats) -> float:
            try:
                ((torque, bit),) = self.with_values(np.exp(logarithms)).misfits(log, [(0.0, last)])
            except SettingsError:
                # waves too fast for the time step
                return _TOO_FAST
            return float((torque / TORQUE_SCALE) ** 2 + np.nan_to_num(bit / BIT_SCALE) ** 2)

        bounds = np.log([BOUNDS[name] for name in self.fitted])
        start = np.clip(np.log(np.maximum(self.values, 1e-9)), *bounds.T)
        steps = np.where(np.arange(start.size) % 2, _STEP, -_STEP)
        # a step below a bound would be clipped, so that the parameter never moved; close to it, it hardly acts
        steps = np.where(start - bounds[:, 0] < _STEP, _STEP_FROM_BOUND * np.ptp(bounds, axis=1), steps)
        options = {"maxfev": evaluations, "initial_simplex": np.vstack([start, start + np.diag(steps)])}
        result = minimize(cost, start, method="Nelder-Mead", bounds=bounds, options=options)
        return self.with_values(np.exp(result.x))
