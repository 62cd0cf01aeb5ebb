"""The field well's start of rotation: what a viscous simulation gets wrong, and what each further part gains.

The models and their parameters are those of `benchmarks.field.start_up`, fitted to 0–45 s; the gain is that on
45–60 s, which had no part in the fits, and which
each model reaches from its own simulated past. What is compared are simulations in
time, whose errors are correlated over a cycle of stick-slip: a cycle counts as one value of each series.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from benchmarks.discoveries.jackknife import jackknife_error
from benchmarks.field.log import FieldLog
from benchmarks.field.start_up import BOUNDS, DEPTH, FITTED_S, JITTER
from benchmarks.field.well_b import PUBLISHED, SURVEY
from drillid.arrays import Floats
from drillid.physics.nonlinear import NonlinearRig
from drillid.simulation.start_up import RATE, WellFriction, rig_at, start_up
from drillid.statistics import TWO_SIDED
from drillid.units import RPM

CYCLE_S = 1 / 0.261
"""s; the measured torque's main line is at 0.261 Hz."""
_STEP = 0.01
"""Of the logarithm of a parameter, for derivatives."""
_SIMULATED_STEP = 0.01
"""s."""
SERIES = {"torque": (1e-3, "kN m rms"), "bit speed": (1 / RPM, "rpm rms")}
"""What is compared, with its unit per SI unit."""


@dataclass(frozen=True, eq=False)
class Misses:
    """Simulated less measured series of one model, (jitter, samples) each, in the units of SERIES."""

    friction: WellFriction
    fitted: tuple[str, ...]
    """Names of its parameters that were fitted."""
    miss: Mapping[str, Floats]

    def rms(self, series: str, first: float, last: float) -> float:
        """Between two times, s, over all friction factors."""
        cut = self.miss[series][:, round(first * RATE) : round(last * RATE) + 1]
        return float(np.sqrt(np.nanmean(cut**2)))

    def squares(self, series: str, first: float, last: float) -> Floats:
        """Mean squares of whole cycles between two times, (cycle,)."""
        cycles = int((last - first) / CYCLE_S)
        edges = np.round((last - CYCLE_S * np.arange(cycles, -1, -1)) * RATE).astype(int)
        power = np.mean(self.miss[series] ** 2, axis=0)
        return np.array([np.nanmean(power[a:b]) for a, b in pairwise(edges)])


def misses(friction: WellFriction, fitted: tuple[str, ...], log: FieldLog, stiffness: float = 1.0) -> Misses:
    """Simulate with all friction at each of JITTER.

    Parameters
    ----------
    stiffness : shear modulus of the pipe per that of its description
    """
    middle = (log.bit_slowest + log.bit_fastest) / 2
    rows: dict[str, list[Floats]] = {name: [] for name in SERIES}
    for factor in JITTER:
        rig = rig_at(DEPTH, SURVEY, PUBLISHED, replace(friction, sliding=friction.sliding * factor))
        made = start_up(_stiffened(rig, stiffness), log.top_speed, _SIMULATED_STEP)
        rows["torque"].append((made.torque - log.torque[: made.torque.size]) * SERIES["torque"][0])
        rows["bit speed"].append((made.recorded_bit_speed() - middle[: made.torque.size]) * SERIES["bit speed"][0])
    return Misses(friction, fitted, {name: np.array(each) for name, each in rows.items()})


def _stiffened(rig: NonlinearRig, stiffness: float) -> NonlinearRig:
    pipe, *assembly = rig.system.string
    stiffer = replace(pipe, shear_modulus=pipe.shear_modulus * stiffness)
    return replace(rig, system=replace(rig.system, string=(stiffer, *assembly)))


def gain(before: Misses, after: Misses, series: str, last: float = 60.0) -> tuple[float, float, float]:
    """Fall of the rms miss after the fitted interval, with a 90 % interval by a jackknife over cycles."""
    from scipy.stats import t

    squares = [one.squares(series, FITTED_S, last) for one in (before, after)]
    falls = np.sqrt(squares[0].mean()) - np.sqrt(squares[1].mean())
    count = squares[0].size
    left = [np.subtract(*(np.sqrt(np.delete(one, place).mean()) for one in squares)) for place in range(count)]
    error = jackknife_error(left) * t.ppf(0.95, count - 1)
    return float(falls), float(falls - error), float(falls + error)


def log_odds(before: Misses, after: Misses) -> float:
    """Log Bayes factor by Schwarz's criterion over 0–45 s, a cycle one value of each series (Schwarz 1978)."""
    cycles = FITTED_S / CYCLE_S
    ratios = [np.log(before.rms(name, 0, FITTED_S) / after.rms(name, 0, FITTED_S)) for name in SERIES]
    further = len(after.fitted) - len(before.fitted)
    return float(cycles * sum(ratios) - further / 2 * np.log(cycles * len(SERIES)))


def intervals(model: Misses, log: FieldLog) -> dict[str, tuple[float, float, float]]:
    """Fitted parameters with 95 % intervals by the curvature of the miss, all fitted together, a cycle one value.

    Bounds of the fit stand in as priors: a parameter that the miss does not hold is given the whole range.
    """
    scale = {name: model.rms(name, 0, FITTED_S) for name in SERIES}
    cut = slice(None, round(FITTED_S * RATE) + 1)

    def series(friction: WellFriction) -> Floats:
        found = misses(friction, model.fitted, log).miss
        both = np.concatenate([(found[name][:, cut] / scale[name]).ravel() for name in SERIES])
        return np.asarray(np.nan_to_num(both), dtype=float)

    columns = []
    for name in model.fitted:
        moved = [replace(model.friction, **{name: _inside(model.friction, name, step)}) for step in (_STEP, -_STEP)]
        width = np.log(getattr(moved[0], name) / getattr(moved[1], name))
        columns.append((series(moved[0]) - series(moved[1])) / width)
    jacobian = np.array(columns)
    information = jacobian @ jacobian.T / (CYCLE_S * RATE * len(JITTER))
    prior = np.diag([np.log(BOUNDS[name][1] / BOUNDS[name][0]) ** -2.0 for name in model.fitted])
    errors = np.sqrt(np.diag(np.linalg.inv(information + prior)))
    values = [getattr(model.friction, name) for name in model.fitted]
    return {
        name: (value, float(value * np.exp(-TWO_SIDED * error)), float(value * np.exp(TWO_SIDED * error)))
        for name, value, error in zip(model.fitted, values, errors, strict=True)
    }


def _inside(friction: WellFriction, name: str, step: float) -> float:
    """The parameter moved by a step, a breakaway not below 1."""
    value = float(getattr(friction, name) * np.exp(step))
    return max(value, 1.0) if name.endswith("breakaway") else value
