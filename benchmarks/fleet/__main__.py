"""`make bench-fleet`, or `python -m benchmarks.fleet plan` for a part of it; figures go to results/bench-fleet.json.

Where real wells are needed, they are simulated once and kept in results/bench-fleet.
"""

import typer

from benchmarks.fleet.measurement import FILE
from benchmarks.parts import command

PARTS = ("plan", "cost", "overhead", "speedup", "flat", "nightly", "extrapolation", "kills", "fuzz", "pages")

if __name__ == "__main__":
    typer.run(command("benchmarks.fleet", PARTS, "What a fleet costs and survives", FILE))
