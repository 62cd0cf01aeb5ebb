"""What the simulations get wrong on real data and on the shared wells, and why: one table.

`make discoveries` prints it, writes results/discoveries.csv and draws a figure for each source of data into
results/discoveries. The wells' verdicts are those of the workflow's discrepancy stage. The motor bench is weighed by
the same reckoning on its own model, the field well in time. What is absent is said, and the rest goes on.
"""

from collections.abc import Callable
from pathlib import Path
from typing import Annotated

import typer

from benchmarks.discoveries import field_rows as discoveries_field_rows
from benchmarks.discoveries import motor_rows as discoveries_motor_rows
from benchmarks.discoveries import wells as discoveries_wells
from benchmarks.discoveries.rows import Discovery, Part, printed, table

RESULTS = Path("results")


def discover(folder: Path, wells: Path) -> list[Part]:
    """All parts; a figure each into the folder."""
    folder.mkdir(parents=True, exist_ok=True)
    sources: tuple[Callable[[], Part], ...] = (
        lambda: discoveries_wells.discover(folder, wells),
        lambda: discoveries_motor_rows.discover(folder),
        lambda: discoveries_field_rows.discover(folder),
    )
    return [one() for one in sources]


def main(
    wells: Annotated[
        Path, typer.Option(help="Folder with the workflow's results of the wells.")
    ] = discoveries_wells.RESULTS,
    results: Annotated[Path, typer.Option(help="Folder that table and figures are written to.")] = RESULTS,
) -> None:
    """Weigh wells, motor bench and field start; print the table, write it and draw the figures."""
    parts = discover(results / "discoveries", wells)
    rows: list[Discovery] = [row for part in parts for row in part.rows]
    print(printed(rows))
    for part in parts:
        if part.absent:
            print(f"absent: {part.absent}")
    path = results / "discoveries.csv"
    table(rows).to_csv(path, index=False)
    print(f"written to {path}; drawn in " + ", ".join(str(one) for part in parts for one in part.figures))


if __name__ == "__main__":
    typer.run(main)
