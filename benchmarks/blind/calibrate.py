"""Calibration lines of `drillid.discrepancy.verdicts.verdict` from sealed cases that the proof does not use.

Run it as `python -m benchmarks.blind.calibrate` at the root of the project, and again where the engine changes. With
`--world own --first 60000 --cases 200` it takes cases of development, whose simulations are kept in results/blind: only
the engine runs again. A world is given more than once to fit the lines to both.
"""

from collections.abc import Iterable
from typing import Annotated

import numpy as np
import pandas as pd
import typer
from rich.console import Console
from scipy.optimize import minimize

from benchmarks.blind.blocks import blocks
from benchmarks.blind.run import run
from benchmarks.blind.scores import claims
from benchmarks.blind.world import WORLDS
from drillid.arrays import Floats
from drillid.discrepancy.verdicts.verdict import CALIBRATION, CalibrationLine, log_odds
from drillid.errors import SettingsError

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


def _refuse_blocks(world: str, first: int, cases: int) -> None:
    seeds = range(first, first + cases)
    for block in blocks():
        if block.world == world and first < block.seeds.stop and block.first < seeds.stop:
            what = f"seeds {block.first} to {block.seeds.stop - 1} of the {world} world are a block of the proof"
            raise SettingsError("calibration", what, "Take others: what was calibrated on proves nothing")


def main(
    world: Annotated[list[str] | None, typer.Option(help=f"Worlds of the cases: {', '.join(WORLDS)}; own.")] = None,
    first: Annotated[int, typer.Option(help="Seed of the first case, below those of the proof's blocks.")] = FIRST,
    cases: Annotated[int, typer.Option(help="Cases of each world; about half have no hidden cause.")] = 300,
) -> None:
    """Run the engine on sealed cases, and print the lines that calibrate its probabilities."""
    worlds = world or ["own"]
    for each in worlds:
        _refuse_blocks(each, first, cases)
    verdicts = pd.concat([claims(run(cases, first, each)["engine"]) for each in worlds])
    console = Console()
    for kind, line in calibration_lines(verdicts).items():
        count = int((verdicts["kind"] == kind).sum())
        text = f'"{kind}": CalibrationLine({line.intercept}, {line.slope}),  # {count} verdicts'
        console.print(text, highlight=False)


if __name__ == "__main__":
    typer.run(main)
