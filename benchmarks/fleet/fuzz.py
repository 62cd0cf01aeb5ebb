"""Mutated files through every reader, as far as `python -m benchmarks.fuzz` has come."""

import json
from pathlib import Path

from rich.console import Console

from benchmarks.parts import Measurement
from benchmarks.result import Result

FILE = Path("results/fuzz.json")
_FILES = 100_000


def measure(console: Console) -> Measurement:
    """The figures of the series, which takes hours from nothing and is run by itself."""
    if not FILE.is_file():
        console.print(f"There is no {FILE}: run python -m benchmarks.fuzz first")
        return Measurement()
    found = json.loads(FILE.read_text())
    return Measurement(
        [
            Result("fuzzed_files", "mutated files", found["fuzzed_files"], least=_FILES),
            Result("fuzz_failures", "of them with anything but an error of drillid", found["fuzz_failures"], most=0),
        ]
    )
