"""Lines of `drillid.discrepancy.verdicts.verdict` from sealed cases that the proof does not use.

Run it as `python -m benchmarks.blind.calibrate` at the root of the project, and again where the engine changes.
"""

from collections.abc import Iterable
from typing import Annotated

import numpy as np
import pandas as pd
import typer
from rich.console import Console
from scipy.optimize import minimize

from benchmarks.blind.run import run
from benchmarks.blind.scores import claims
from drillid.arrays import Floats
from drillid.discrepancy.verdicts.verdict import LINES, Line, log_odds

FIRST = 1_000_000
"""Seed of the first case, far from those of the proof."""
_PRIOR = Line(3.0, 1.0)
"""Standard deviations of intercept and slope about 0 and 1, for kinds of verdict that are rare."""


def line(posterior: Floats, right: Floats) -> Line:
    """Most likely line of the log odds of being right against those of the posterior (logistic regression)."""

    def cost(figures: Floats) -> float:
        odds = figures[0] + figures[1] * posterior
        pulls = (figures[0] / _PRIOR.intercept) ** 2 + ((figures[1] - 1) / _PRIOR.slope) ** 2
        return float(np.sum(np.logaddexp(0.0, odds) - right * odds) + pulls / 2)

    found = minimize(cost, np.array([0.0, 1.0]), bounds=[(None, None), (0.05, None)])
    return Line(*(round(float(value), 2) for value in found.x))


def lines(found: pd.DataFrame) -> dict[str, Line]:
    """Lines of all kinds of verdict."""
    fitted = {}
    for kind, now in LINES.items():
        own = found[found["kind"] == kind]
        fitted[kind] = line(uncalibrated(own["stated"], now), own["right"].to_numpy())
    return fitted


def uncalibrated(stated: Iterable[float], now: Line) -> Floats:
    """Log odds of the posterior behind probabilities that a line has made of it."""
    return (np.array([log_odds(value) for value in stated]) - now.intercept) / now.slope


def main(cases: Annotated[int, typer.Option(help="How many; about half of them hide nothing.")] = 300) -> None:
    """Ask the engine about cases, and print the lines that make its probabilities true."""
    table, _ = run(cases, FIRST)
    found, console = claims(table), Console()
    for kind, one in lines(found).items():
        count = int((found["kind"] == kind).sum())
        console.print(f'"{kind}": Line({one.intercept}, {one.slope}),  # {count} verdicts', highlight=False)


if __name__ == "__main__":
    typer.run(main)
