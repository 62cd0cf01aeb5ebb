"""What one part of the benchmark measures, and the file that collects all parts."""

import json
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from benchmarks.result import Result
from drillid.fleet.manifest import write_whole

FILE = Path("results/bench-fleet.json")
FOLDER = Path("results/bench-fleet")
"""Where parts keep what they simulate and run."""


@dataclass(frozen=True)
class Measurement:
    """What one part measures.

    tables : further content of the file, by its key
    """

    results: Sequence[Result] = ()
    tables: dict[str, Any] = field(default_factory=dict)


def record(measured: Measurement, file: Path = FILE) -> None:
    """Put the measurement into a file, which is written whole; the keys of other parts are kept."""
    kept = json.loads(file.read_text()) if file.is_file() else {}
    content = kept | {result.key: result.value for result in measured.results} | measured.tables
    file.parent.mkdir(parents=True, exist_ok=True)
    write_whole(file, json.dumps(content, indent=2) + "\n")
