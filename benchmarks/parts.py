"""Benchmarks in parts: what one part measures, the file that collects all of them, and the command that runs them."""

import importlib
import json
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Annotated, Any

import typer
from rich.console import Console

from benchmarks.result import Result, result_table
from drillid.fleet.manifest import write_whole


@dataclass(frozen=True)
class Measurement:
    """What one part measures.

    tables : further content of the file, by its key
    """

    results: Sequence[Result] = ()
    tables: dict[str, Any] = field(default_factory=dict)


def record(measured: Measurement, file: Path) -> None:
    """Put the measurement into a file, which is written whole; the keys of other parts are kept."""
    kept = json.loads(file.read_text()) if file.is_file() else {}
    content = kept | {result.key: result.value for result in measured.results} | measured.tables
    file.parent.mkdir(parents=True, exist_ok=True)
    write_whole(file, json.dumps(content, indent=2) + "\n")


def command(package: str, names: Sequence[str], title: str, file: Path) -> Callable[[list[str] | None], None]:
    """The command that runs some parts, or all, prints what they measure and puts it into a file.

    Parameters
    ----------
    package : that holds the parts
    names : modules of it, each with a function `measure` that takes the console and returns a Measurement
    """

    def main(
        parts: Annotated[list[str] | None, typer.Argument(help=f"Some of: {', '.join(names)}; all by default.")] = None,
    ) -> None:
        unknown = [part for part in parts or () if part not in names]
        if unknown:
            raise typer.BadParameter(f"no part {', '.join(unknown)}; there are {', '.join(names)}")
        console, results = Console(), list[Result]()
        for part in parts or names:
            module = importlib.import_module(f"{package}.{part}")
            console.rule((module.__doc__ or "").splitlines()[0])
            measured = module.measure(console)
            record(measured, file)
            results += measured.results
        console.print(result_table(title, results))
        console.print(f"Written to {file}")

    main.__doc__ = f"Measure, print and write {title[0].lower()}{title[1:]}."
    return main
