"""Whether the engine gives the same answers as before a change that is only to make it faster.

    python -m benchmarks.blind.compare answer before.jsonl --first 60000 --cases 80
    python -m benchmarks.blind.compare compare before.jsonl after.jsonl

Both runs examine the same evidence, which the first one keeps beside its file. Seeds are those of development.
"""

import json
import time
from dataclasses import asdict
from functools import partial
from pathlib import Path
from typing import Annotated, Any

import numpy as np
import typer
from rich.console import Console

from benchmarks.blind.draw import draw
from benchmarks.blind.engines import catalogue_of, kept_evidence
from benchmarks.blind.vocabulary import ERROR_RATE
from benchmarks.kept import pickled
from drillid.discrepancy.verdicts.engine import examine

_PROBABILITY, _SIZE, _PLACE = 0.01, 0.02, 60.0
"""Largest differences: of probabilities, of sizes as shares of their intervals, and of places, m."""
app = typer.Typer(add_completion=False)
Row = dict[str, Any]


@app.command()
def answer(
    file: Annotated[Path, typer.Argument(help="Written line by line; seeds in it are not examined again.")],
    first: Annotated[int, typer.Option(help="First seed.")] = 60_000,
    cases: Annotated[int, typer.Option(help="Number of seeds.")] = 80,
    folder: Annotated[Path, typer.Option(help="Of the evidence that is kept.")] = Path("results/blind/compared"),
) -> None:
    """Examine cases and write verdicts with the time of one core."""
    done = {row["seed"] for row in _read(file)} if file.is_file() else set()
    for seed in (seed for seed in range(first, first + cases) if seed not in done):
        case = draw(seed)
        evidence = pickled(folder / f"{seed}.pickle", partial(kept_evidence, case))
        begin = time.process_time()
        verdicts = examine(evidence, catalogue=catalogue_of(case), error_rate=ERROR_RATE, seed=seed).verdicts
        row = {"seed": seed, "windows": evidence.windows, "hidden": sorted(case.hidden_names)}
        row |= {"seconds": time.process_time() - begin, "verdicts": [asdict(verdict) for verdict in verdicts]}
        with file.open("a") as lines:
            lines.write(json.dumps(row, default=float) + "\n")


@app.command()
def compare(before: Path, after: Path) -> None:
    """Print what differs; the exit code is 1 where anything does."""
    console, known = Console(highlight=False), {row["seed"]: row for row in _read(before)}
    pairs = [(known[row["seed"]], row) for row in _read(after) if row["seed"] in known]
    found = {new["seed"]: different(old["verdicts"], new["verdicts"]) for old, new in pairs}
    for seed, what in found.items():
        if what:
            console.print(f"{seed}: {what}")
    seconds = [sum(row["seconds"] for row in rows) for rows in zip(*pairs, strict=True)] if pairs else [0.0, 0.0]
    same = sum(not what for what in found.values())
    console.print(f"{same} of {len(found)} the same; {seconds[0]:.1f} s before, {seconds[1]:.1f} s after")
    raise typer.Exit(int(same < len(found)))


def different(old: list[Row], new: list[Row]) -> str:
    """What differs between two lists of verdicts by more than the fits' tolerance; empty where nothing does."""
    names = [[verdict["verdict"] for verdict in verdicts] for verdicts in (old, new)]
    if names[0] != names[1]:
        return f"{', '.join(names[0])} became {', '.join(names[1])}"
    for one, other in zip(old, new, strict=True):
        width = max(np.nan_to_num(one["size_high"] - one["size_low"]), np.finfo(float).tiny)
        limits = {"probability": _PROBABILITY, "size": _SIZE * width, "location_m": _PLACE, "from_m": 1.0, "to_m": 1.0}
        for name, limit in limits.items():
            if not np.isclose(one[name], other[name], rtol=0, atol=limit, equal_nan=True):
                return f"{one['verdict']}: {name} {one[name]:.6g} became {other[name]:.6g}"
    return ""


def _read(file: Path) -> list[Row]:
    return [json.loads(line) for line in file.read_text().splitlines()]


if __name__ == "__main__":
    app()
