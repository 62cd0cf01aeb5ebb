"""`drillid inspect`: what log files hold, and a draft of the rig description for them."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from drillid.commands.output import Json, check_output, faults_told, print_json, print_rows
from drillid.errors import writing

if TYPE_CHECKING:
    from drillid.inspection.contents import Contents
    from drillid.inspection.inspect import Inspection


def add_inspection_commands(app: typer.Typer) -> None:
    """Add the commands of this module to the command line."""
    app.command("inspect")(inspect_logs)


def inspect_logs(
    logs: Annotated[list[Path], typer.Argument(help="Log files of one well, both fast and slow.")],
    output: Annotated[Path | None, typer.Option(help="YAML file to write the draft rig description to.")] = None,
    name: Annotated[str, typer.Option(help="Name of the rig.")] = "Rig",
    zone: Annotated[str, typer.Option(help="Time zone of time stamps without one, such as Europe/Oslo.")] = "UTC",
    time_format: Annotated[
        str | None, typer.Option("--format", help="'day first', 'month first' or a strptime format of the times.")
    ] = None,
    unit: Annotated[str | None, typer.Option(help="Unit of times that are numbers, such as ms or excel.")] = None,
    start: Annotated[str | None, typer.Option(help="ISO time from which numeric times count.")] = None,
    configuration: Annotated[
        Path | None,
        typer.Option("--configfile", help="Configuration of a run, for settings other than the defaults."),
    ] = None,
    as_json: Json = False,
) -> None:
    """List the contents of log files, and draft the rig description that reads them.

    Lists channels with units, rates and gaps, how the times were read, the sweep found from its signal, and the windows
    that a run would use. Exit code 1 if no file can be read.

    Example: drillid inspect stand.csv depth.csv --zone Europe/Oslo --output config/rigs/rig7.yaml
    """
    from drillid.config.rig import Clock, LogFile
    from drillid.config.settings import Settings
    from drillid.inspection.inspect import inspect

    with faults_told():
        check_output(output)
        stated = {"zone": zone, "format": time_format, "unit": unit, "start": start}
        clock = Clock.checked(stated, "options of inspect")
        settings = Settings.of_run(configuration) if configuration else Settings()
        found = inspect(logs, name, clock, LogFile(), settings)
        if output is not None:
            with writing(output):
                output.write_text(found.draft, encoding="utf-8")
    if as_json:
        print_json(found.as_json())
        return
    _print(found)
    typer.echo(
        f"\nRig description written to {output}" if output else f"\nDraft of the rig description:\n\n{found.draft}"
    )


def _print(found: Inspection) -> None:
    for contents in found.files:
        _print_file(contents)
    for error in found.refused:
        typer.echo(f"refused: {error}", err=True)
    for where, what, remedy in found.problems:
        typer.echo(f"{where}: {what}. {remedy}")
    typer.echo(f"\n{found.windows} usable windows")
    for row in found.segments.to_dict("records"):
        used = row["reason"] or f"{row['windows']} window{'s' if row['windows'] != 1 else ''}"
        typer.echo(f"  {row['start']} {row['duration_s']:8.1f} s  {row['state']}: {used}")


def _print_file(contents: Contents) -> None:
    from drillid.records.grid import seconds_text

    place = f"{contents.path}, '{contents.table}'" if contents.table else str(contents.path)
    typer.echo(f"{place}: {contents.format}, {contents.rows} rows at {contents.rate:.4g} Hz")
    typer.echo(f"  from {contents.first} to {contents.last} UTC")
    for start, seconds in contents.gaps:
        typer.echo(f"  gap of {seconds_text(seconds)} s after {start}")
    for what, _ in contents.notes:
        typer.echo(f"  {what}")
    sweep = contents.sweep
    typer.echo("  no sweep was found" if sweep is None else f"  sweep in column '{sweep.column}': {sweep}")
    channels = {guess.column: name for name, guess in contents.channels.items()}
    rows = [
        (
            column.name,
            column.unit or "-",
            channels.get(column.name, ""),
            f"{column.low:.6g} to {column.high:.6g}",
            f"changes {column.changes_hz:.3g} times a second",
            f"{100 * column.missing:.0f} % missing" if column.missing else "",
        )
        for column in contents.columns
    ]
    print_rows(("column", "unit", "channel", "values", "rate", ""), rows)
