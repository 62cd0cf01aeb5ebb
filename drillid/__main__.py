"""Commands of drillid: simulations that need no workflow."""

import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Annotated

import typer

from drillid.errors import DrillidError

app = typer.Typer(no_args_is_help=True, add_completion=False, help="Torsional dynamics of drill strings.")
simulations = typer.Typer(no_args_is_help=True, help="Simulate a rig in time.")
app.add_typer(simulations, name="simulate")


@app.callback()
def _commands() -> None:
    """Torsional dynamics of drill strings. The workflow itself runs by `make run`."""


@app.command("run", context_settings={"allow_extra_args": True, "ignore_unknown_options": True})
def run_workflow(
    context: typer.Context,
    configfile: Annotated[Path | None, typer.Option(help="Configuration; config/config.yaml by default.")] = None,
    profile: Annotated[Path, typer.Option(help="Workflow profile.")] = Path("workflow/profiles/default"),
    jobs: Annotated[str, typer.Option(help="Cores to use, or jobs on a cluster; the profile's by default.")] = "",
    strict: Annotated[bool, typer.Option(help="End with code 3 where wells failed.")] = True,
) -> None:
    """Run the workflow of this folder; all other words go to Snakemake: targets, --dry-run, --until fits …

    Exit codes: 0 no well failed, 1 a fault of workflow, program or machine, 3 wells failed, 128 + n ended by signal n.
    """
    from drillid.fleet.command import run

    try:
        code = run(context.args, profile, configfile, jobs, strict)
    except DrillidError as error:
        typer.echo(f"drillid: {error}", err=True)
        raise typer.Exit(1) from None
    raise typer.Exit(code)


@app.command("explain")
def explain_result(
    path: Annotated[Path, typer.Argument(help="A dataset, table or figure of a well, such as depth.zarr.")],
) -> None:
    """How a result came to be: stages, code, settings, checksums of the logs and versions behind it."""
    from drillid.fleet.explain import explain

    try:
        typer.echo(explain(path))
    except DrillidError as error:
        typer.echo(f"drillid: {error}", err=True)
        raise typer.Exit(1) from None


@app.command("check")
def check_configuration(
    configuration: Annotated[Path, typer.Argument(help="Configuration that a run would be given.")] = Path(
        "config/config.yaml"
    ),
    logs: Annotated[bool, typer.Option(help="Read every log as well.")] = True,
) -> None:
    """Look for whatever a run would reject: in configuration, sheets, rig descriptions and every log.

    One row per finding: where, what, remedy. Exit code 1 where a log, a well or the run would fail.
    """
    from drillid.records.check import Checked, check

    checked, findings = Checked(), []
    for finding in check(configuration, checked, logs=logs):
        findings.append(finding)
        if not sys.stdout.isatty():
            typer.echo("\t".join(finding.row))
    if findings and sys.stdout.isatty():
        _print_table(("", "where", "what", "remedy"), [finding.row for finding in findings])
    fails = sum(finding.fails for finding in findings)
    typer.echo(
        f"{checked}: {fails} of {len(findings)} findings would fail" if findings else f"{checked}: sound", err=True
    )
    raise typer.Exit(int(fails > 0))


def _print_table(columns: Sequence[str], rows: Sequence[Sequence[str]]) -> None:
    """A table as wide as the terminal."""
    from rich.console import Console
    from rich.table import Table
    from rich.text import Text

    table = Table(*columns, show_lines=True)
    for row in rows:
        table.add_row(*map(Text, row))
    Console().print(table)


@app.command("init")
def write_example(
    folder: Annotated[Path, typer.Argument(help="Folder to write the configuration into.")] = Path(),
) -> None:
    """Write a configuration with empty sheets, to be filled in, into a folder from which `drillid run` is started."""
    from drillid.fleet.installation import write_example as write

    try:
        written = write(folder)
    except DrillidError as error:
        typer.echo(f"drillid: {error}", err=True)
        raise typer.Exit(1) from None
    typer.echo(
        "".join(f"written: {path}\n" for path in written) + "Describe each rig in config/rigs/<rig>.yaml", nl=True
    )


@simulations.command("start-up")
def simulate_start_up(
    well: Annotated[Path, typer.Argument(help="YAML description of top drive, string, mud and friction.")],
    depth: Annotated[float, typer.Option(help="Depth of the bit along the hole, m.")],
    survey: Annotated[
        Path, typer.Option(help="CSV with depth_m, inclination_deg and, where the hole turns, azimuth_deg.")
    ],
    top_speed: Annotated[
        Path | None, typer.Option(help="CSV with t_s and td_rpm_measured that the top drive follows.")
    ] = None,
    rpm: Annotated[float, typer.Option(min=0.0, help="Speed after the ramp, where no file is given.")] = 70.0,
    ramp: Annotated[float, typer.Option(min=1.0, help="Seconds of the ramp.")] = 15.0,
    duration: Annotated[float, typer.Option(min=5.0, max=3600.0, help="Seconds, where no file is given.")] = 60.0,
    output: Annotated[Path, typer.Option(help="CSV that is written.")] = Path("results/start_up.csv"),
) -> None:
    """Start of rotation off bottom of a described well, at any depth of any hole.

    The output has the columns t_s, td_rpm, torque_knm (of the drive, its own inertia's included), bit_rpm (as a
    downhole record shows it, whose half-second statistics are stamped at their end) and bit_rpm_now (of the bit).
    """
    from drillid.config.described_well import DescribedWell
    from drillid.simulation.start_up import rig_at, start_up
    from drillid.simulation.start_up_files import ramped_speed, read_survey, read_top_speed, summary, write_start_up

    try:
        described = DescribedWell.from_yaml(well)
        first_time, speed = (0.0, ramped_speed(rpm, ramp, duration)) if top_speed is None else read_top_speed(top_speed)
        rig = rig_at(depth, read_survey(survey), described.described_equipment, described.described_friction)
        simulated = start_up(rig, speed)
        write_start_up(simulated, speed, output, first_time)
    except DrillidError as error:
        typer.echo(f"drillid: {error}", err=True)
        raise typer.Exit(1) from None
    typer.echo(summary(simulated, depth))
    typer.echo(f"written to {output}")


if __name__ == "__main__":
    app(prog_name="drillid")
