"""The proof on sealed cases: `python -m benchmarks.blind`; simulations and answers are cached between runs."""

import json
import os
from pathlib import Path
from typing import Annotated

import numpy as np
import typer
from rich.console import Console
from rich.table import Table

from benchmarks.blind import blocks
from benchmarks.blind.document import write_page, write_part
from benchmarks.blind.figures import calibration_plot, confusion_plot, efficiency
from benchmarks.blind.run import run
from benchmarks.blind.scores import TARGETS, at_equal_alarms, confusion, holds, scores
from benchmarks.blind.world import FOLDER, WORLDS

RESULT = Path("results/blind.json")
FIRST = 60_000
"""Seed of the first case of a quick look; these seeds serve development."""
PREFIX = {"own": "", "other": "other_"}
"""Of a world's scores in RESULT."""
World = Annotated[str, typer.Option(help=f"World of the cases: {' or '.join(WORLDS)}.")]
First = Annotated[int, typer.Option(help="Seed of the first case.")]


def score_table(reached: dict[str, float], guessed: dict[str, float]) -> Table:
    """Scores beside their targets."""
    table = Table("score", "engine", "target", "holds", "at random")
    for name, value in reached.items():
        relation, target = TARGETS.get(name, ("", ""))
        meets = holds(name, value)
        verdict = "" if meets is None else "yes" if meets else "no"
        table.add_row(name, f"{value:.4g}", f"{relation} {target}", verdict, f"{guessed[name]:.4g}")
    return table


def main(
    world: World = "own",
    first: First = FIRST,
    cases: Annotated[int, typer.Option(help="Number of cases; about half of them have no hidden cause.")] = 40,
    minutes: Annotated[float, typer.Option(help="No case is begun later; the next run goes on from there.")] = np.inf,
) -> None:
    """Draw and hide causes, simulate, run the engine, and score its answers; a registered block goes into the page."""
    os.environ.setdefault("OMP_NUM_THREADS", "1")
    registration = blocks.registered(world, first, cases)
    tables = run(cases, first, world, blocks.engine_hash() + blocks.judge_hash(), minutes)
    judged, console = tables["engine"], Console()
    if judged.empty:
        console.print("No case was judged within the minutes given; the next run goes on where this one ended.")
        raise typer.Exit(code=1)
    reached, at_random = scores(judged), scores(tables["random"])
    beside = {
        name: at_equal_alarms(table, reached["false_alarm"]) for name, table in tables.items() if name != "engine"
    }
    console.print(score_table(reached, at_random))
    for name, row in confusion(judged).iterrows():
        named = ", ".join(f"{other} {count}" for other, count in row[row > 0].items())
        console.print(f"{name}: {named}", highlight=False)
    for name, found in beside.items():
        shown = ", ".join(f"{score} {value:.3g}" for score, value in found.items())
        console.print(f"{name} at the engine's rate of false alarms: {shown}", highlight=False)
    seconds = (reached["examine_s_median_wrong"], reached["examine_s_median_null"])
    console.print("{:.1f} s a set with something hidden, {:.1f} s a set without (median)".format(*seconds))
    folder = FOLDER / world
    folder.mkdir(parents=True, exist_ok=True)
    judged.to_csv(folder / "cases.csv", index=False)
    pictures = {"efficiency": efficiency, "calibration": calibration_plot, "confusion": confusion_plot}
    for name, draw_picture in pictures.items():
        draw_picture(judged, folder / f"{name}.png")
    _keep(world, reached, beside)
    if registration is None:
        console.print("This block is not registered under the present code: it proves nothing and is in no page.")
        return
    blocks.judged(registration, reached, len(judged))
    write_part(Path("docs"), folder, world, reached, at_random, judged, beside)
    write_page(Path("docs"))


def _keep(world: str, reached: dict[str, float], beside: dict[str, dict[str, float]]) -> None:
    """Write the scores of a world beside those of the other one."""
    kept = json.loads(RESULT.read_text()) if RESULT.is_file() else {}
    prefix = PREFIX[world]
    own = {name: value for name, value in kept.items() if name != "blocks" and _of_world(name) != world}
    found = {f"{prefix}{name}": None if np.isnan(value) else value for name, value in reached.items()}
    for engine, values in beside.items():
        found |= {f"{prefix}{engine}_{name}": value for name, value in values.items()}
    listed = [vars(block) for block in blocks.blocks()]
    RESULT.write_text(json.dumps({**own, **found, "blocks": listed}, indent=1) + "\n")


def _of_world(name: str) -> str:
    return "other" if name.startswith(PREFIX["other"]) else "own"


if __name__ == "__main__":
    typer.run(main)
