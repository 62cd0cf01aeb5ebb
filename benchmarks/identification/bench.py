"""All results of identification in one run: what is reached, what was aimed at, and a comparison with other tools.

`make bench`, or `python -m benchmarks.identification.bench` at the root of the project. Everything is measured on
data from the
time-domain simulator. Times are processor times of one core. The results go to results/bench.json as well.
"""

import json
from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np
import typer
from rich.console import Console
from rich.table import Table

from benchmarks.identification import comparison, fits, joint, peers, spectra, throughput
from benchmarks.identification.accuracy import LEVEL, WINDOWS, Accuracy
from benchmarks.identification.bound import Noise
from benchmarks.identification.windows import SimulatedWindow, simulated_windows
from benchmarks.result import Result, result_table
from drillid.figures.captions import DISPLAYED_PARAMETERS
from drillid.physics.parameters import PARAMETERS

FILE = Path("results/bench.json")


def single_windows(console: Console, _: Sequence[SimulatedWindow]) -> list[Result]:
    """Residuals of the true model, spread and coverage."""
    accuracy = Accuracy.of(simulated_windows(WINDOWS))
    residuals, spread = accuracy.residuals, accuracy.spread
    console.print(
        f"Whitened residuals of the true model, refused at the {100 * LEVEL:g} % level: as not normal "
        f"{100 * residuals.not_normal:.1f} % of windows, as not white {100 * residuals.not_white:.1f} %; "
        f"random errors make that up to {100 * residuals.credible_share:.1f} %."
    )
    console.print(_spread_table(accuracy))
    return [
        Result("chi2_per_dof", "χ² per degree of freedom of the true model", residuals.chi2_per_dof, 0.97, 1.03),
        Result("spread_over_crb_max", "largest error over Cramér–Rao bound", spread.over_bound_max, most=1.10),
        Result("coverage95_min", "least coverage of 95 % intervals", float(spread.coverage.min()), 0.92, 0.98),
        Result("coverage95_max", "largest coverage of 95 % intervals", float(spread.coverage.max()), 0.92, 0.98),
    ]


def _spread_table(accuracy: Accuracy) -> Table:
    spread = accuracy.spread
    table = Table(
        title="Root mean square error over Cramér–Rao bound, and coverage of 95 % intervals in %, by bit noise",
        caption="In brackets: one window does not identify the parameter, so that the bound does not apply. "
        "Over the errors of the estimate that reaches the bound, on the same noise; "
        f"without that the largest is {spread.plain_max:.2f}.",
    )
    table.add_column("bit noise, N m")
    for name in PARAMETERS:
        table.add_column(DISPLAYED_PARAMETERS[name].name, justify="right")
    for row, level in enumerate(spread.levels):
        cells = [
            (f"{ratio:.2f} / {100 * covered:.1f}" if identifiable else f"({ratio:.2f}) / {100 * covered:.1f}")
            for ratio, covered, identifiable in zip(
                spread.over_bound[row], spread.covered[row], spread.identifiable[row], strict=True
            )
        ]
        table.add_row(f"{level:g}", *cells)
    table.add_row("all", *[f"{100 * covered:.1f}" for covered in spread.coverage])
    return table


def joint_windows(console: Console, _: Sequence[SimulatedWindow]) -> list[Result]:
    """Joint fits over 24 windows."""
    rows = joint.repeats()
    accuracy = joint.joint_accuracy(joint.joint_fits(rows), rows)
    ratios = ", ".join(f"{DISPLAYED_PARAMETERS[name].name} {ratio:.2f}" for name, ratio in accuracy.over_bound.items())
    console.print(f"Joint fits of {joint.WINDOWS} windows, error over joint bound: {ratios}.")
    return [Result("joint_over_bound_max", "joint fit, error over joint bound", accuracy.over_bound_max, most=1.15)]


def random_rigs(console: Console, _: Sequence[SimulatedWindow]) -> list[Result]:
    """Share of random rigs whose fit ends in the global optimum."""
    share = fits.global_optimum_share()
    return [Result("global_optimum_share", "random rigs fitted to the global optimum, share", share, 0.99, 1.0)]


def other_tools(console: Console, windows: Sequence[SimulatedWindow]) -> list[Result]:
    """Speed of one fit, and the comparison with other tools."""
    outcomes = comparison.compared(windows)
    console.print(comparison.table(outcomes, windows, Noise.of(windows)))
    console.print(peers.WHY_NOT)
    speed, whole = comparison.Speed.of(windows), np.median(outcomes[0].fit_ms)
    console.print(
        f"One fit by drillid: {speed.cold:.2f} ms from a cold start, with 95 % intervals {whole:.2f} ms; "
        f"{speed.close:.2f} ms from the start that the other tools get, and that is compared with theirs."
    )
    others = {found.way: float(np.median(found.fit_ms)) for found in outcomes}
    return [
        Result("fit_ms_median", "one fit from a cold start, ms", speed.cold, most=3.0),
        Result(
            "fit_speedup_lmfit",
            "times faster than lmfit from the same start",
            others[peers.LMFIT] / speed.close,
            20.0,
        ),
        Result(
            "fit_speedup_least_squares",
            "times faster than scipy's least_squares from the same start",
            others[peers.LEAST_SQUARES] / speed.close,
            20.0,
        ),
    ]


def spectra_speed(console: Console, _: Sequence[SimulatedWindow]) -> list[Result]:
    """Time of the spectra of one window."""
    return [
        Result("welch_over_fft", "Welch's averages over a bare scipy.fft", spectra.welch_over_fft(), most=3.0),
        Result("lpm_ms", "local polynomials, ms a window", spectra.lpm_ms(), most=15.0),
    ]


def whole_wells(console: Console, windows: Sequence[SimulatedWindow]) -> list[Result]:
    """Real-time factor and growth with the length of the log."""
    # the short well's time is short, so that it takes more of them for a steady median
    short, long = throughput.passages(windows, "short", 7), throughput.passages(windows, "long", 3)
    spent, memory = (throughput.growth(short, long, quantity) for quantity in ("seconds", "megabytes"))
    workflow = throughput.passages(windows, "short", 1, "stages")[0]
    console.print(
        f"The workflow's stages {', '.join(throughput.STAGES)}, with spectrograms, stacks, joint fits and all of their "
        f"files: {workflow.real_time_factor:,.0f} times real time."
    )
    return [
        Result(
            "real_time_factor",
            "from regular record to fitted parameters, times real time",
            float(np.median([one.real_time_factor for one in long])),
            20_000.0,
        ),
        Result("time_growth_10x", "time for ten times the log", spent, most=10.5),
        Result("memory_growth_10x", "memory for ten times the log", memory, most=1.1),
    ]


PARTS: tuple[Callable[[Console, Sequence[SimulatedWindow]], list[Result]], ...] = (
    single_windows,
    joint_windows,
    random_rigs,
    other_tools,
    spectra_speed,
    whole_wells,
)


def main() -> None:
    """Measure, print and write everything."""
    console = Console()
    windows = simulated_windows()
    results: list[Result] = []
    for part in PARTS:
        console.rule(part.__doc__ or "")
        results += part(console, windows)
    console.print(result_table("What identification reaches", results))
    FILE.parent.mkdir(parents=True, exist_ok=True)
    FILE.write_text(json.dumps({result.key: result.value for result in results}, indent=2) + "\n")
    console.print(f"Written to {FILE}")


if __name__ == "__main__":
    typer.run(main)
