"""Start of rotation of a real well: the misfit of models of increasing detail, and of the authors' own simulation.

`python -m benchmarks.field.start_up` prints the table, draws the last model and writes results/field.json;
`python -m benchmarks.field.start_up --fit` fits each model again.

A simulation that matches the phase of stick-slip cycles by chance loses it when friction changes by 1 %. So every
model is fitted to, and its misfit computed from, three simulations with all friction at 98.5, 100 and 101.5 %; the
table gives this misfit and the one at 100 %. The last model is also simulated at a quarter of the time step.

The downhole sensor's half-second statistics are assumed to be stamped at the end of their half second. The stamping is
not documented; the authors' bit speed too is 11 rpm closer under this assumption.
"""

import json
from dataclasses import asdict, replace
from pathlib import Path
from typing import Annotated

import numpy as np
import typer

from benchmarks.field.log import FieldLog, read_field_log
from benchmarks.field.well_b import PUBLISHED, SURVEY
from drillid.arrays import Floats
from drillid.errors import DrillidError
from drillid.simulation.start_up import RATE, STATISTICS_DELAY, TIME_STEP, StartUp, WellFriction, rig_at, start_up
from drillid.simulation.start_up_fit import BOUNDS, FITTING_STEP, JITTER, Misfit, misfit
from drillid.units import RPM

DATA = Path(__file__).parents[3] / "shared" / "data" / "field" / "wellB_1733m_100Hz.csv"
DEPTH = 1733.0
FITTED_S = 45.0
RESULTS = Path("results")


REST_FRICTION = WellFriction(
    sliding=0.1639,
    breakaway=1.044,
    assembly_sliding=1.552,
    assembly_breakaway=1.377,
    threshold=3.218,
    rest=0.4429,
    assembly_rest=0.1598,
    rest_angle=6.028,
    kappa=26.26,
    assembly_inertia=0.6169,
)
"""That the assembly has 62 % of its stated inertia goes with the published stiffness of the pipe."""
LADDER: dict[str, tuple[WellFriction, tuple[str, ...]]] = {
    "viscous drag alone": (WellFriction(0.0, kappa=25137.0), ("kappa",)),
    "+ sliding friction": (WellFriction(0.2192, kappa=1.637), ("sliding", "kappa")),
    "+ breakaway": (
        WellFriction(0.1937, 1.0523, threshold=5.867, kappa=41.54),
        ("sliding", "breakaway", "threshold", "kappa"),
    ),
    "+ assembly's own friction and inertia": (
        WellFriction(0.1455, 1.2968, 1.9308, 1.0029, threshold=3.1105, kappa=559.6, assembly_inertia=0.7913),
        ("sliding", "breakaway", "assembly_sliding", "assembly_breakaway", "threshold", "kappa", "assembly_inertia"),
    ),
    "+ friction of rest, lost by slip": (REST_FRICTION, tuple(name for name in BOUNDS if name != "modulus")),
}
"""Models with the published stiffness of the pipe: parameters and names of the fitted ones, from the simplest to the
most detailed."""


def run(friction: WellFriction, log: FieldLog, time_step: float = TIME_STEP) -> StartUp:
    """Simulate the log's start of rotation."""
    return start_up(rig_at(DEPTH, SURVEY, PUBLISHED, friction), log.top_speed, time_step)


def simulated_misfit(log: FieldLog, simulated: StartUp) -> Misfit:
    """Misfit from 0 to 45 s, with the bit speed as recorded."""
    return misfit(log, simulated.torque, simulated.recorded_bit_speed(), 0.0, FITTED_S)


def jittered_misfits(friction: WellFriction, log: FieldLog, time_step: float = TIME_STEP) -> Floats:
    """Misfit of torque (kN m), bit speed and its extremes (rpm) with all friction scaled by JITTER, (factor, 3)."""
    rows = []
    for factor in JITTER:
        scaled = replace(friction, sliding=friction.sliding * factor)
        result = simulated_misfit(log, run(scaled, log, time_step))
        rows.append((result.torque_rms, result.bit_rms, result.extremes_rms))
    return np.array(rows)


def fit(
    start: WellFriction, names: tuple[str, ...], log: FieldLog, generations: int = 40, seed: int = 0
) -> WellFriction:
    """Fit named parameters by differential evolution to the jittered misfits, torque per 1.9 kN m, bit per 21 rpm."""
    from scipy.optimize import differential_evolution

    cut = FieldLog(*(series[: round(FITTED_S * RATE) + 1] for series in vars(log).values()))

    def cost(logarithms: Floats) -> float:
        candidate = replace(start, **dict(zip(names, np.exp(logarithms).tolist(), strict=True)))
        rows = jittered_misfits(candidate, cut, FITTING_STEP)
        return float(np.mean((rows[:, 0] / 1.9) ** 2 + (rows[:, 1] / 21.0) ** 2))

    bounds = np.log([BOUNDS[name] for name in names])
    first = np.clip(np.log([getattr(start, name) for name in names]), *bounds.T)
    result = differential_evolution(cost, bounds, maxiter=generations, popsize=8, rng=seed, x0=first, polish=False)
    return replace(start, **dict(zip(names, np.exp(result.x).tolist(), strict=True)))


def table(log: FieldLog) -> str:
    """Text of one row per model."""
    head = f"{'model':44} {'fitted':>6} {'torque':>7} {'bit':>6} {'extremes':>8}   {'jittered torque':>15} {'bit':>6}"
    time = np.arange(log.torque.size) / RATE
    late = np.interp(time - STATISTICS_DELAY, time, log.authors_bit_speed)
    lines = [head]
    for name, speed in (("authors, as published", log.authors_bit_speed), ("authors, stamps at the end", late)):
        lines.append(_row(name, "", misfit(log, log.authors_torque, speed, 0.0, FITTED_S)))
    for name, (friction, names) in LADDER.items():
        rows = jittered_misfits(friction, log)
        total = np.sqrt(np.mean(rows**2, axis=0))
        lines.append(_row(name, str(len(names)), Misfit(*rows[JITTER.index(1.0)])))
        lines[-1] += f"   {total[0]:15.2f} {total[1]:6.1f}"
    friction = list(LADDER.values())[-1][0]
    lines.append(
        _row("last model, a quarter of the time step", "", simulated_misfit(log, run(friction, log, TIME_STEP / 4)))
    )
    return "\n".join([*lines, "torque in kN m rms, bit speed in rpm rms, over 0 to 45 s"])


def _row(name: str, fitted: str, result: Misfit) -> str:
    return f"{name:44} {fitted:>6} {result.torque_rms:7.2f} {result.bit_rms:6.1f} {result.extremes_rms:8.1f}"


def draw(log: FieldLog, simulated: StartUp, path: Path) -> None:
    """Torque and bit speed, measured, simulated, and simulated by the authors."""
    import matplotlib as mpl

    mpl.use("Agg")
    import matplotlib.pyplot as plt

    figure, (torque, speed) = plt.subplots(2, 1, sharex=True, figsize=(11, 8), layout="constrained")
    time = np.arange(log.torque.size) / RATE
    torque.plot(time, log.torque / 1e3, "k", lw=0.8, label="measured")
    torque.plot(time, log.authors_torque / 1e3, color="0.7", lw=0.8, label="authors")
    torque.plot(simulated.time, simulated.torque / 1e3, "C1", lw=1.0, label="simulated")
    torque.set_ylabel("drive torque, kN m")
    speed.fill_between(time, log.bit_slowest / RPM, log.bit_fastest / RPM, color="0.4", alpha=0.5, lw=0)
    speed.plot(time, log.authors_bit_speed / RPM, color="0.7", lw=0.8)
    speed.plot(simulated.time, simulated.recorded_bit_speed() / RPM, "C1", lw=1.0)
    speed.set(xlabel="time, s", ylabel="bit speed, rpm (shade: half-second extremes)")
    torque.legend(ncols=3)
    for axis in (torque, speed):
        axis.axvline(FITTED_S, color="k", ls=":", lw=0.8)
        axis.grid(alpha=0.3)
    path.parent.mkdir(parents=True, exist_ok=True)
    figure.savefig(path, dpi=120)
    plt.close(figure)


def write(log: FieldLog, friction: WellFriction, folder: Path = RESULTS) -> None:
    """Write the figure and results/field.json of one model."""
    simulated = run(friction, log)
    result = simulated_misfit(log, simulated)
    draw(log, simulated, folder / "field.png")
    content = {
        "torque_rms_knm": result.torque_rms,
        "bit_rms_rpm": result.bit_rms,
        "extremes_rms_rpm": result.extremes_rms,
    }
    content |= dict(zip(("torque_rms_knm_jittered", "bit_rms_rpm_jittered"), _jittered(friction, log), strict=True))
    (folder / "field.json").write_text(
        json.dumps({**content, "statistics_delay_s": STATISTICS_DELAY, "parameters": asdict(friction)}, indent=2) + "\n"
    )


def _jittered(friction: WellFriction, log: FieldLog) -> list[float]:
    total: list[float] = np.sqrt(np.mean(jittered_misfits(friction, log) ** 2, axis=0))[:2].tolist()
    return total


def main(
    again: Annotated[bool, typer.Option("--fit", help="Fit each model again.")] = False,
) -> None:
    """Print the table, draw the last model and write its misfit and parameters."""
    try:
        log = read_field_log(DATA)
    except DrillidError as error:
        typer.echo(error, err=True)
        raise typer.Exit(1) from None
    if again:
        for name, (friction, names) in LADDER.items():
            LADDER[name] = (fit(friction, names, log), names)
            print(name, LADDER[name][0], flush=True)
    print(table(log))
    best = list(LADDER.values())[-1][0]
    write(log, best)
    print(f"drawn in {RESULTS / 'field.png'}; misfit and parameters in {RESULTS / 'field.json'}")


if __name__ == "__main__":
    typer.run(main)
