"""`python -m benchmarks.fuzz`: mutated files of every format; figures to JSON, faults to the terminal."""

import json
import time
from collections import Counter
from pathlib import Path
from typing import Annotated, Any

import typer

from benchmarks.fuzz.series import Outcome, attempt, series
from benchmarks.fuzz.trial import known_suffixes

_PRINT_EVERY_S = 30.0
_SHOWN = 20


def figures(outcomes: list[Outcome], seconds: float) -> dict[str, Any]:
    """What is written: files, failures, and both by format."""
    failures = [outcome for outcome in outcomes if outcome.fault]
    return {
        "fuzzed_files": len(outcomes),
        "fuzz_failures": len(failures),
        "files_by_format": dict(Counter(outcome.suffix for outcome in outcomes)),
        "failures_by_format": dict(Counter(outcome.suffix for outcome in failures)),
        "endings": dict(Counter(outcome.ended or "fault" for outcome in outcomes)),
        "largest_s": max((outcome.seconds for outcome in outcomes), default=0.0),
        "largest_mb": max((outcome.megabytes for outcome in outcomes), default=0.0),
        "faults": {
            fault: [one.number for one in failures if one.fault == fault][:_SHOWN] for fault in _faults(failures)
        },
        "seconds": round(seconds, 1),
    }


def _faults(failures: list[Outcome]) -> list[str]:
    return [fault for fault, _ in Counter(outcome.fault for outcome in failures).most_common()]


def main(
    files: Annotated[int, typer.Option(help="Mutated files.")] = 100_000,
    seed: Annotated[int, typer.Option(help="Another seed makes other files.")] = 1,
    only: Annotated[int | None, typer.Option(help="Number of one file, whose error is shown.")] = None,
    first: Annotated[int, typer.Option(help="Number of the first file.")] = 0,
    keep: Annotated[Path | None, typer.Option(help="Folder for files that fail.")] = None,
    output: Annotated[Path, typer.Option(help="File for the figures.")] = Path("results/fuzz.json"),
) -> None:
    """Fuzz every reader, records and windows; fails where anything but errors of drillid comes of it."""
    if only is not None:
        typer.echo(attempt(only, seed))
        return
    typer.echo(f"{files} files of {', '.join(known_suffixes())}")
    outcomes, begin, printed = list[Outcome](), time.monotonic(), time.monotonic()
    for outcome in series(first, first + files, seed, keep):
        outcomes.append(outcome)
        if outcome.fault and sum(one.fault == outcome.fault for one in outcomes) == 1:
            typer.echo(f"{outcome.number}{outcome.suffix} ({', '.join(outcome.mutations)}): {outcome.fault}")
        if time.monotonic() - printed > _PRINT_EVERY_S:
            printed = time.monotonic()
            typer.echo(f"{len(outcomes)} files, {sum(bool(one.fault) for one in outcomes)} failures")
    found = figures(outcomes, time.monotonic() - begin)
    output.parent.mkdir(parents=True, exist_ok=True)
    output.write_text(json.dumps(found, indent=1) + "\n")
    typer.echo(f"{found['fuzzed_files']} files, {found['fuzz_failures']} failures: {output}")
    if found["fuzz_failures"]:
        raise typer.Exit(1)


if __name__ == "__main__":
    typer.run(main)
