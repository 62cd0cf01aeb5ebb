"""`make learn`, or `python -m benchmarks.learn PART` for a part of it; figures go to results/learn.json.

Simulated wells are kept in results/learn.
"""

import typer

from benchmarks.learn.measurement import FILE
from benchmarks.parts import command

PARTS = ("recovered", "laws", "field_start", "fleets")

if __name__ == "__main__":
    typer.run(command("benchmarks.learn", PARTS, "What is learnt", FILE))
