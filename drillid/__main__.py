"""Commands of drillid: simulations that need no workflow."""

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

    Exit codes: 0 all wells done, 1 a fault of workflow or machine, 3 wells failed, 128 + n ended by signal n.
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
