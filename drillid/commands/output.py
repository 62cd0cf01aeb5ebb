"""What all commands print: faults with their remedy, tables as wide as the terminal, JSON for programs."""

from __future__ import annotations

import contextlib
import json
import sys
from collections.abc import Hashable, Iterable, Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from drillid.errors import DrillidError, SettingsError, writing

if TYPE_CHECKING:
    import pandas as pd

Json = Annotated[bool, typer.Option("--json", help="Print JSON for programs instead of text.")]


@contextlib.contextmanager
def faults_told() -> Iterator[None]:
    """End the command with code 1 where the library refuses something, and say what, where and what to do."""
    try:
        yield
    except DrillidError as error:
        typer.echo(f"drillid: {error}", err=True)
        raise typer.Exit(1) from None


def check_output(path: Path | None) -> None:
    """Refuse a file that cannot be written, before anything is computed."""
    if path is not None:
        with writing(path):
            if path.is_dir():
                raise IsADirectoryError("it is a folder")


def check_files(logs: Sequence[Path]) -> None:
    """Refuse logs that are not there, and folders that are no zarr store."""
    for log in logs:
        if not log.exists():
            raise SettingsError(str(log), "does not exist", "Correct its path")
        if log.is_dir() and log.suffix != ".zarr":
            raise SettingsError(str(log), "is a folder, not a log file", "Name the files in it")


def print_rows(columns: Sequence[str], rows: Iterable[Sequence[str]]) -> None:
    """A table as wide as the terminal; lines with tabs, each as it comes, where the output goes elsewhere."""
    if not sys.stdout.isatty():
        for row in rows:
            typer.echo("\t".join(row))
        return
    from rich.console import Console
    from rich.table import Table
    from rich.text import Text

    table = Table(*columns, show_lines=True)
    for row in rows:
        table.add_row(*map(Text, row))
    if table.row_count:
        Console().print(table)


def records(table: pd.DataFrame) -> list[dict[Hashable, Any]]:
    """Rows of a table as JSON holds them: what is not known is null."""
    return table.astype(object).where(table.notna(), None).to_dict("records")


def print_json(content: Any) -> None:
    """One JSON document; times and other objects as text."""
    typer.echo(json.dumps(content, indent=1, default=str, ensure_ascii=False, allow_nan=False))
