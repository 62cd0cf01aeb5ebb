"""What the simulations get wrong on real data and on the shared wells, and why: one table.

`make discoveries` prints it, writes results/discoveries.csv and draws a figure for each source of data into
results/discoveries. The wells' verdicts are those of the workflow's discrepancy stage. The motor bench is weighed by
the same reckoning on its own model, the field well in time. What is absent is said, and the rest goes on.
"""

import argparse
from collections.abc import Callable
from pathlib import Path

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


def main() -> None:
    """Print the table, write it and draw the figures."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--wells", type=Path, default=discoveries_wells.RESULTS, help="results folder of the wells")
    parser.add_argument("--results", type=Path, default=RESULTS)
    options = parser.parse_args()
    parts = discover(options.results / "discoveries", options.wells)
    rows: list[Discovery] = [row for part in parts for row in part.rows]
    print(printed(rows))
    for part in parts:
        if part.absent:
            print(f"absent: {part.absent}")
    path = options.results / "discoveries.csv"
    table(rows).to_csv(path, index=False)
    print(f"written to {path}; drawn in " + ", ".join(str(one) for part in parts for one in part.figures))


if __name__ == "__main__":
    main()
