"""`drillid simulate`: rigs in time."""

from pathlib import Path
from typing import Annotated

import typer

from drillid.commands.output import faults_told

simulations = typer.Typer(no_args_is_help=True, help="Simulate a rig in time.")


@simulations.callback()
def _simulations() -> None:
    """Simulate a rig in time."""


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

    with faults_told():
        described = DescribedWell.from_yaml(well)
        first_time, speed = (0.0, ramped_speed(rpm, ramp, duration)) if top_speed is None else read_top_speed(top_speed)
        rig = rig_at(depth, read_survey(survey), described.described_equipment, described.described_friction)
        simulated = start_up(rig, speed)
        write_start_up(simulated, speed, output, first_time)
    typer.echo(summary(simulated, depth))
    typer.echo(f"written to {output}")
