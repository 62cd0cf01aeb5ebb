"""What of the field well's model holds elsewhere: descriptions fitted to its first seconds, judged on the rest.

`python -m benchmarks.field.transfer` prints the misfit of two models that were fitted to 0–28 s, there and on the
17 s after them, which had no part in the fits; `--fit` fits them again, from where they stand.

The published shear modulus of the pipe, 61 GPa, was found beside an inertia of the assembly that is π times too large.
With the inertia of the tally it makes the string too soft, which a lighter assembly makes up for at this depth alone,
as pipe is added below it and no assembly. With a modulus of its own the pipe comes out as stiff as steel with tool
joints, the assembly keeps its inertia, pipe and assembly share one friction of rest, and the pipe needs no breakaway.
"""

from dataclasses import dataclass, replace
from typing import Annotated

import numpy as np
import typer

from benchmarks.field.log import FieldLog, misfit, read_field_log
from benchmarks.field.start_up import BOUNDS, DATA, DEPTH, FITTED_S, FITTING_STEP, JITTER, REST_FRICTION
from benchmarks.field.well_b import EQUIPMENT, FRICTION, PUBLISHED, SURVEY
from drillid.arrays import Floats
from drillid.simulation.start_up import RATE, WellFriction, rig_at, start_up

SEEN_S = 28.0
"""The fits end here."""
PUBLISHED_MODULUS = PUBLISHED.pipe_shear_modulus / 1e9
"""GPa."""
_BOUNDS = BOUNDS | {"modulus": (50.0, 100.0), "assembly_inertia": (0.57, 2.0)}
_EVALUATIONS, _STEP = 300, 0.06


@dataclass(frozen=True)
class Model:
    """A model with what is fitted of it."""

    friction: WellFriction
    modulus: float
    """GPa, of the pipe."""
    fitted: tuple[str, ...]
    one_rest: bool = False
    """Whether pipe and assembly have one friction of rest."""

    def with_values(self, values: Floats) -> "Model":
        """The same with other values of what is fitted."""
        found = dict(zip(self.fitted, values.tolist(), strict=True))
        modulus = found.pop("modulus", self.modulus)
        if self.one_rest:
            found["assembly_rest"] = found.get("rest", self.friction.rest)
        return replace(self, friction=replace(self.friction, **found), modulus=modulus)

    @property
    def values(self) -> Floats:
        """Of what is fitted."""
        return np.array([self.modulus if name == "modulus" else getattr(self.friction, name) for name in self.fitted])


_OWN = ("sliding", "assembly_sliding", "assembly_breakaway", "threshold", "rest", "rest_angle", "kappa")
DESCRIBED = Model(FRICTION, EQUIPMENT.pipe_shear_modulus / 1e9, (*_OWN, "modulus"), one_rest=True)
"""The well's description, fitted to 0–45 s."""
MODELS = {
    "published stiffness, lighter assembly": Model(
        replace(
            REST_FRICTION,
            sliding=0.1778,
            breakaway=1.0203,
            assembly_sliding=1.3525,
            assembly_breakaway=1.4101,
            threshold=2.5041,
            rest=0.3328,
            assembly_rest=0.2199,
            rest_angle=10.328,
            kappa=25.26,
            assembly_inertia=0.6436,
        ),
        PUBLISHED_MODULUS,
        tuple(BOUNDS),
    ),
    "stated inertia, stiffer pipe, one friction of rest": replace(
        DESCRIBED,
        friction=replace(
            FRICTION,
            sliding=0.1391,
            assembly_sliding=1.9732,
            assembly_breakaway=1.2725,
            threshold=3.3127,
            rest=0.4505,
            assembly_rest=0.4505,
            rest_angle=18.05,
            kappa=37.48,
        ),
        modulus=75.23,
    ),
}
"""Models fitted to the time before SEEN_S."""


def misfits(model: Model, log: FieldLog, spans: tuple[tuple[float, float], ...]) -> Floats:
    """Misfit of torque (kN m) and bit speed (rpm) in spans of time (s), over all friction factors, (span, 2)."""
    equipment = replace(EQUIPMENT, pipe_shear_modulus=model.modulus * 1e9)
    speed = log.top_speed[: round(max(last for _, last in spans) * RATE) + 1]
    rows = []
    for factor in JITTER:
        friction = replace(model.friction, sliding=model.friction.sliding * factor)
        made = start_up(rig_at(DEPTH, SURVEY, equipment, friction), speed, FITTING_STEP)
        found = [misfit(log, made.torque, made.recorded_bit_speed(), *span) for span in spans]
        rows.append([(each.torque_rms, each.bit_rms) for each in found])
    return np.asarray(np.sqrt(np.mean(np.square(rows), axis=0)), dtype=float)


def fit(model: Model, log: FieldLog, last: float) -> Model:
    """Fit a model from where it stands to the first seconds by the simplex of Nelder and Mead (1965)."""
    from scipy.optimize import minimize

    cut = FieldLog(*(series[: round(last * RATE) + 1] for series in vars(log).values()))

    def cost(logarithms: Floats) -> float:
        trial = model.with_values(np.exp(logarithms))
        torque, bit = misfits(trial, cut, ((0.0, last),))[0]
        return float((torque / 1.9) ** 2 + (bit / 21.0) ** 2)

    bounds = np.log([_BOUNDS[name] for name in model.fitted])
    start = np.clip(np.log(model.values), *bounds.T)
    signs = np.where(np.arange(start.size) % 2, _STEP, -_STEP)
    options = {"maxfev": _EVALUATIONS, "initial_simplex": np.vstack([start, start + np.diag(signs)])}
    result = minimize(cost, start, method="Nelder-Mead", bounds=bounds, options=options)
    return model.with_values(np.exp(result.x))


def table(log: FieldLog) -> str:
    """Text of one row per model."""
    lines = [f"{'fitted to 0–28 s':50} {'fitted':>6} {'torque':>7} {'bit':>6}   {'28–45 s: torque':>15} {'bit':>6}"]
    for name, model in MODELS.items():
        seen, unseen = misfits(model, log, ((0.0, SEEN_S), (SEEN_S, FITTED_S)))
        fitted = len(model.fitted)
        lines.append(f"{name:50} {fitted:6} {seen[0]:7.2f} {seen[1]:6.1f}   {unseen[0]:15.2f} {unseen[1]:6.1f}")
    (whole,) = misfits(DESCRIBED, log, ((0.0, FITTED_S),))
    lines.append(f"well_b.yaml, fitted to 0–45 s, there: torque {whole[0]:.2f} kN m, bit {whole[1]:.1f} rpm")
    return "\n".join([*lines, "torque in kN m rms, bit speed in rpm rms, over friction of 98.5, 100 and 101.5 %"])


def main(again: Annotated[bool, typer.Option("--fit", help="Fit each model again.")] = False) -> None:
    """Print the table."""
    log = read_field_log(DATA)
    if again:
        for name, model in MODELS.items():
            MODELS[name] = fit(model, log, SEEN_S)
            print(name, MODELS[name], flush=True)
        print("well_b.yaml", fit(DESCRIBED, log, FITTED_S), flush=True)
    print(table(log))


if __name__ == "__main__":
    typer.run(main)
