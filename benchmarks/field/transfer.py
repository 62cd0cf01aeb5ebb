"""What of the field well's model holds elsewhere: descriptions fitted to its first seconds, judged on the rest.

`python -m benchmarks.field.transfer` prints the misfit of two models that were fitted to 0–28 s, there and on the
17 s after them, which had no part in the fits; `--fit` fits them again, from where they stand.

The published shear modulus of the pipe, 61 GPa, was found beside an inertia of the assembly that is π times too large.
With the inertia of the tally it makes the string too soft, which a lighter assembly makes up for at this depth alone,
as pipe is added below it and no assembly. With a modulus of its own the pipe comes out as stiff as steel with tool
joints, the assembly keeps its inertia, pipe and assembly share one friction of rest, and the pipe needs no breakaway.
"""

from dataclasses import replace
from typing import Annotated

import typer

from benchmarks.field.log import FieldLog, read_field_log
from benchmarks.field.start_up import DATA, DEPTH, FITTED_S, REST_FRICTION
from benchmarks.field.well_b import EQUIPMENT, FRICTION, PUBLISHED, SURVEY
from drillid.simulation.start_up_fit import BOUNDS, StartUpModel

SEEN_S = 28.0
"""The fits end here."""
DESCRIBED = StartUpModel(EQUIPMENT, SURVEY, DEPTH, FRICTION)
"""The well's description, fitted to 0–45 s."""
MODELS = {
    "published stiffness, lighter assembly": StartUpModel(
        PUBLISHED,
        SURVEY,
        DEPTH,
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
        tuple(name for name in BOUNDS if name != "modulus"),
        one_rest=False,
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
        equipment=replace(EQUIPMENT, pipe_shear_modulus=75.23e9),
    ),
}
"""Models fitted to the time before SEEN_S."""


def table(log: FieldLog) -> str:
    """Text of one row per model."""
    lines = [f"{'fitted to 0–28 s':50} {'fitted':>6} {'torque':>7} {'bit':>6}   {'28–45 s: torque':>15} {'bit':>6}"]
    for name, model in MODELS.items():
        seen, unseen = model.misfits(log, [(0.0, SEEN_S), (SEEN_S, FITTED_S)])
        fitted = len(model.fitted)
        lines.append(f"{name:50} {fitted:6} {seen[0]:7.2f} {seen[1]:6.1f}   {unseen[0]:15.2f} {unseen[1]:6.1f}")
    (whole,) = DESCRIBED.misfits(log, [(0.0, FITTED_S)])
    lines.append(f"well_b.yaml, fitted to 0–45 s, there: torque {whole[0]:.2f} kN m, bit {whole[1]:.1f} rpm")
    return "\n".join([*lines, "torque in kN m rms, bit speed in rpm rms, over friction of 98.5, 100 and 101.5 %"])


def main(again: Annotated[bool, typer.Option("--fit", help="Fit each model again.")] = False) -> None:
    """Print the table."""
    log = read_field_log(DATA)
    if again:
        for name, model in MODELS.items():
            MODELS[name] = model.fit(log, SEEN_S)
            print(name, MODELS[name], flush=True)
        print("well_b.yaml", DESCRIBED.fit(log, FITTED_S), flush=True)
    print(table(log))


if __name__ == "__main__":
    typer.run(main)
