"""Calibration lines of `drillid.discrepancy.verdicts.verdict` from sealed cases that the proof does not use.

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
from drillid.discrepancy.verdicts.verdict import CALIBRATION, CalibrationLine, log_odds

FIRST = 1_000_000
"""Seed of the first case, far from those of the proof."""
_PRIOR = CalibrationLine(3.0, 1.0)
"""Standard deviations of the normal prior on intercept and slope about 0 and 1, for rare kinds of verdict."""


def calibration_line(posterior: Floats, right: Floats) -> CalibrationLine:
    """Line of the log odds of being right against those of the posterior (logistic regression)."""

    def cost(line: Floats) -> float:
        odds = line[0] + line[1] * posterior
        pulls = (line[0] / _PRIOR.intercept) ** 2 + ((line[1] - 1) / _PRIOR.slope) ** 2
        return float(np.sum(np.logaddexp(0.0, odds) - right * odds) + pulls / 2)

    result = minimize(cost, np.array([0.0, 1.0]), bounds=[(None, None), (0.05, None)])
    return CalibrationLine(*(round(float(value), 2) for value in result.x))


def calibration_lines(verdicts: pd.DataFrame) -> dict[str, CalibrationLine]:
    """Calibration lines of all kinds of verdict."""
    fitted = {}
    for kind, current in CALIBRATION.items():
        own = verdicts[verdicts["kind"] == kind]
        fitted[kind] = calibration_line(uncalibrated(own["stated"], current), own["right"].to_numpy())
    return fitted


def uncalibrated(stated: Iterable[float], line: CalibrationLine) -> Floats:
    """Log odds of the posterior from probabilities calibrated by a line."""
    return (np.array([log_odds(value) for value in stated]) - line.intercept) / line.slope


def main(
    cases: Annotated[int, typer.Option(help="Number of cases; about half of them have no hidden cause.")] = 300,
) -> None:
    """Run the engine on sealed cases, and print the lines that calibrate its probabilities."""
    table = run(cases, FIRST)["engine"]
    verdicts, console = claims(table), Console()
    for kind, line in calibration_lines(verdicts).items():
        count = int((verdicts["kind"] == kind).sum())
        text = f'"{kind}": CalibrationLine({line.intercept}, {line.slope}),  # {count} verdicts'
        console.print(text, highlight=False)


if __name__ == "__main__":
    typer.run(main)
