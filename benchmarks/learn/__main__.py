"""`make learn`, or `python -m benchmarks.learn PART` for a part of it; figures go to results/learn.json.

Simulated wells are kept in results/learn.
"""

import importlib
from typing import Annotated

import typer
from rich.console import Console

from benchmarks.learn.measurement import FILE, record
from benchmarks.result import Result, result_table

PARTS: tuple[str, ...] = (
    "recovered",
    "field_start",
    "fleets",
)
"""Modules of this folder, each with a function `measure` that takes the console and returns a Measurement."""


def main(
    parts: Annotated[list[str] | None, typer.Argument(help=f"Some of: {', '.join(PARTS)}; all by default.")] = None,
) -> None:
    """Measure, print and write what is learnt."""
    unknown = [part for part in parts or () if part not in PARTS]
    if unknown:
        raise typer.BadParameter(f"no part {', '.join(unknown)}; there are {', '.join(PARTS)}")
    console, results = Console(), list[Result]()
    for part in parts or PARTS:
        module = importlib.import_module(f"benchmarks.learn.{part}")
        console.rule((module.__doc__ or "").splitlines()[0])
        measured = module.measure(console)
        record(measured)
        results += measured.results
    console.print(result_table("What is learnt", results))
    console.print(f"Written to {FILE}")


if __name__ == "__main__":
    typer.run(main)
