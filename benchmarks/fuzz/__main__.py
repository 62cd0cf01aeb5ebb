"""`python -m benchmarks.fuzz`: mutated files of every format; figures to JSON, faults to the terminal."""

import json
import time
from collections import Counter
from dataclasses import asdict
from pathlib import Path
from typing import Annotated, Any

import typer

from benchmarks.fuzz.seeds import suffixes
from benchmarks.fuzz.series import Outcome, attempt, series

_PRINT_EVERY_S = 30.0
_SHOWN = 20


def figures(outcomes: list[Outcome]) -> dict[str, Any]:
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
    }


def _faults(failures: list[Outcome]) -> list[str]:
    return [fault for fault, _ in Counter(outcome.fault for outcome in failures).most_common()]


def kept(path: Path, stop: int) -> list[Outcome]:
    """Outcomes of an earlier run of the same series, as far as it came; a line that was cut short is dropped."""
    lines = path.read_text().splitlines(keepends=True) if path.exists() else []
    whole = [line for line in lines if line.endswith("\n")]
    path.write_text("".join(whole))
    found = [json.loads(line) for line in whole[:stop]]
    return [Outcome(**content | {"mutations": tuple(content["mutations"])}) for content in found]


def main(
    files: Annotated[int, typer.Option(help="Mutated files.")] = 100_000,
    seed: Annotated[int, typer.Option(help="Another seed makes other files.")] = 1,
    only: Annotated[int | None, typer.Option(help="Number of one file, whose error is shown.")] = None,
    again: Annotated[bool, typer.Option(help="Only those again that failed before.")] = False,
    folder: Annotated[Path, typer.Option(help="Folder for outcomes, figures and files that fail.")] = Path(
        "results/fuzz"
    ),
) -> None:
    """Fuzz every reader, records and windows; fails where anything but errors of drillid comes of it.

    What an earlier run of the same seed has done is kept; after a mend, `--again` or a new folder tries it anew.
    """
    if only is not None:
        typer.echo(attempt(only, seed))
        return
    folder.mkdir(parents=True, exist_ok=True)
    journal = folder / f"seed-{seed}.jsonl"
    outcomes = kept(journal, files)
    if again:
        outcomes = [attempt(one.number, seed) if one.fault else one for one in outcomes]
        journal.write_text("".join(json.dumps(asdict(one)) + "\n" for one in outcomes))
    typer.echo(f"{files} files of {', '.join(suffixes())}; {len(outcomes)} are done")
    printed = time.monotonic()
    with journal.open("a", buffering=1) as lines:
        for outcome in series(len(outcomes), files, seed, folder / "failed"):
            outcomes.append(outcome)
            lines.write(json.dumps(asdict(outcome)) + "\n")
            if outcome.fault and sum(one.fault == outcome.fault for one in outcomes) == 1:
                typer.echo(f"{outcome.number}{outcome.suffix} ({', '.join(outcome.mutations)}): {outcome.fault}")
            if time.monotonic() - printed > _PRINT_EVERY_S:
                printed = time.monotonic()
                typer.echo(f"{len(outcomes)} files, {sum(bool(one.fault) for one in outcomes)} failures")
    found = figures(outcomes)
    output = folder.with_suffix(".json")
    output.write_text(json.dumps(found, indent=1) + "\n")
    typer.echo(f"{found['fuzzed_files']} files, {found['fuzz_failures']} failures: {output}")
    if found["fuzz_failures"]:
        raise typer.Exit(1)


if __name__ == "__main__":
    typer.run(main)
