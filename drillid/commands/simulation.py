"""`drillid simulate`: rigs in time."""

import math
from pathlib import Path
from typing import Annotated

import typer

from drillid.commands.output import Json, faults_told, print_json

simulations = typer.Typer(no_args_is_help=True, help="Simulate a rig in time.")


def _finite(number: float) -> float:
    if not math.isfinite(number):
        raise typer.BadParameter("it is not a finite number")
    return number


Depth = Annotated[float, typer.Option(callback=_finite, help="Depth of the bit along the hole, m.")]


@simulations.callback()
def _simulations() -> None:
    """Simulate a rig in time."""


@simulations.command("start-up")
def simulate_start_up(
    well: Annotated[Path, typer.Argument(help="YAML description of top drive, string, mud and friction.")],
    depth: Depth,
    survey: Annotated[
        Path, typer.Option(help="CSV with depth_m, inclination_deg and, where the hole turns, azimuth_deg.")
    ],
    top_speed: Annotated[
        Path | None, typer.Option(help="CSV with t_s and td_rpm_measured for the top drive to follow.")
    ] = None,
    rpm: Annotated[float, typer.Option(min=0.0, help="Speed after the ramp, if no file is given.")] = 70.0,
    ramp: Annotated[float, typer.Option(min=1.0, help="Duration of the ramp, s.")] = 15.0,
    duration: Annotated[float, typer.Option(min=5.0, max=3600.0, help="Duration, s, if no file is given.")] = 60.0,
    output: Annotated[Path, typer.Option(help="CSV file to write.")] = Path("results/start_up.csv"),
    as_json: Json = False,
) -> None:
    """Simulate the start of rotation off bottom of a described well, at any depth of any hole.

    The output has the columns t_s, td_rpm, torque_knm (of the drive, including that of its own inertia), bit_rpm (as
    in a downhole record, whose half-second statistics are stamped at their end) and bit_rpm_now (of the bit).

    Example: drillid simulate start-up benchmarks/field/well_b.yaml --depth 2200 --survey survey.csv
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
    if as_json:
        print_json({"output": output, "summary": summary(simulated, depth).splitlines()})
        return
    typer.echo(summary(simulated, depth))
    typer.echo(f"written to {output}")


@simulations.command("fit-start-up")
def fit_start_up(
    well: Annotated[Path, typer.Argument(help="YAML description of top drive, string, mud and friction.")],
    log: Annotated[
        Path,
        typer.Argument(
            help="CSV with t_s, td_rpm_measured, torque_knm_measured and, where measured, bit_rpm_min_measured and "
            "bit_rpm_max_measured."
        ),
    ],
    depth: Depth,
    survey: Annotated[
        Path, typer.Option(help="CSV with depth_m, inclination_deg and, where the hole turns, azimuth_deg.")
    ],
    seen: Annotated[float, typer.Option(min=0.1, max=1.0, help="Share of the log used for the fit.")] = 0.6,
    fitted: Annotated[
        str, typer.Option(help="What to fit, separated by commas; by default what also holds elsewhere.")
    ] = "",
    evaluations: Annotated[int, typer.Option(min=1, help="Largest number of simulations in the fit.")] = 300,
    output: Annotated[Path, typer.Option(help="YAML file with the fitted values.")] = Path("results/fitted.yaml"),
    as_json: Json = False,
) -> None:
    """Fit a described well to the first part of a measured start of rotation, and judge it on the rest.

    Example: drillid simulate fit-start-up well.yaml log.csv --depth 1733 --survey survey.csv --output fitted.yaml
    """
    from drillid.config.described_well import DescribedWell, write_fitted
    from drillid.simulation.start_up_files import read_start_up, read_survey

    with faults_told():
        described, measured = DescribedWell.from_yaml(well), read_start_up(log)
        names = tuple(name.strip() for name in fitted.split(",")) if fitted else ()
        before = described.model(read_survey(survey), depth, names)
        last = seen * measured.duration
        after = before.fit(measured, last, evaluations)
        spans = [(0.0, last), *([(last, measured.duration)] if seen < 1 else [])]
        errors = [
            {"model": name, "from_s": begin, "to_s": end, "torque_knm": torque, "bit_rpm": bit}
            for name, model in (("described", before), ("fitted", after))
            for (begin, end), (torque, bit) in zip(spans, model.misfits(measured, spans), strict=True)
        ]
        write_fitted(well, after.friction, after.equipment.pipe_shear_modulus, output)
    if as_json:
        known = [{name: None if value != value else value for name, value in row.items()} for row in errors]
        print_json({"output": output, "errors": known})
        return
    line = "{model:9} {from_s:5.1f} to {to_s:5.1f} s: torque {torque_knm:5.2f} kN m, bit {bit_rpm:5.1f} rpm rms"
    for row in errors:
        typer.echo(line.format(**row))
    typer.echo(f"written to {output}")


@simulations.command("window")
def simulate_window(
    results: Annotated[Path, typer.Argument(help="Folder of a run's results.")],
    well: Annotated[str, typer.Argument(help="Name of a well in that folder.")],
    window: Annotated[int, typer.Option(min=0, help="Number of an examined window of the well.")] = 0,
    output: Annotated[Path, typer.Option(help="CSV file to write.")] = Path("results/window.csv"),
    as_json: Json = False,
) -> None:
    """Simulate a drilled window in time, with the rig identified in it and what was named or learnt.

    The output has the columns t_s, torque_sweep_knm and td_rpm_measured as recorded, and td_rpm, torque_command_knm and
    bit_rpm as simulated under that sweep.

    Example: drillid simulate window results/main W1 --window 3
    """
    from drillid.discrepancy.products.simulated_window import simulated_window

    with faults_told():
        simulated = simulated_window(results, well, window)
        simulated.write(output)
    if as_json:
        print_json({"output": output, "summary": simulated.summary.splitlines()})
        return
    typer.echo(simulated.summary)
    typer.echo(f"written to {output}")
