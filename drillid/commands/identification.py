"""`drillid fit` and `drillid tune`: one well's logs to parameters and control settings, without the workflow."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

import typer

from drillid.commands.output import (
    Json,
    check_files,
    check_output,
    faults_told,
    print_json,
    print_rows,
    records,
)
from drillid.errors import SettingsError, writing

if TYPE_CHECKING:
    from drillid.identification import Identification

_RPM_PER_KN_M = 30e3 / math.pi


def add_identification_commands(app: typer.Typer) -> None:
    """Add the commands of this module to the command line."""
    app.command("fit")(fit_logs)
    app.command("tune")(tune_control)


Family = Literal["proportional integral", "inertia compensation", "impedance matching"]
"""As `drillid.control.tuning` has them, whose import would slow down every command."""
Logs = Annotated[list[Path], typer.Argument(help="Raw log files of one well.")]
RigFile = Annotated[Path, typer.Option(help="Rig description, as explained in config/README.md.")]
Configuration = Annotated[
    Path | None, typer.Option("--configfile", help="Configuration of a run, for settings other than the defaults.")
]


def fit_logs(
    logs: Logs,
    rig: RigFile,
    configuration: Configuration = None,
    verdicts: Annotated[bool, typer.Option("--verdicts", help="Also examine what the fits leave unexplained.")] = False,
    table: Annotated[Path | None, typer.Option(help="CSV file to write the parameters to.")] = None,
    plot: Annotated[Path | None, typer.Option(help="PNG, SVG or PDF of measured and fitted mobility.")] = None,
    as_json: Json = False,
) -> None:
    """Fit the eight parameters of the transmission line to every window of a well's logs.

    Exit code 1 if the rig description or the logs cannot be used, or the logs hold no window.

    Example: drillid fit stand.csv --rig rig.yaml --plot mobility.png
    """
    with faults_told():
        if plot is not None:
            check_format(plot)
        for output in (plot, table):
            check_output(output)
        identification = _identified(logs, rig, configuration)
        found = identification.verdicts if verdicts else None
        if plot is not None:
            from drillid.figures.layout import save

            with writing(plot):
                save(identification.draw("command_mobility_fitted"), plot, identification.settings.figures.dpi)
        if table is not None:
            with writing(table):
                identification.parameters.to_csv(table, index=False)
    if as_json:
        content = {"parameters": identification.parameters, "problems": identification.problems}
        content |= {} if found is None else {"verdicts": found}
        print_json({name: records(frame) for name, frame in content.items()})
        return
    _print_parameters(identification)
    if found is not None:
        columns = ("verdict", "probability", "from_m", "to_m", "size", "unit", "evidence")
        print_rows(columns, [[_cell(value) for value in row] for row in found[list(columns)].to_numpy()])
    for row in identification.problems.itertuples(index=False):
        typer.echo(f"{row.stage}: {row.where}: {row.what}. {row.remedy}", err=True)


def tune_control(
    logs: Logs,
    rig: RigFile,
    family: Annotated[Family, typer.Option(help="What the rig's controller can do.")] = "proportional integral",
    configuration: Configuration = None,
    as_json: Json = False,
) -> None:
    """Find the speed-control settings that damp the bit's vibration most and keep the loop's margins.

    They are tuned to the last window that was fitted, over the whole range of its uncertainty.

    Example: drillid tune stand.csv --rig rig.yaml --family "impedance matching"
    """
    with faults_told():
        tuning = _identified(logs, rig, configuration).tuned(family)
    settings = tuning.in_units()
    stable = math.isfinite(tuning.present)
    peaks = {"bit_mobility_now": tuning.present if stable else None, "bit_mobility_tuned": tuning.value}
    gain, phase = float(tuning.margins.gain.min()), math.degrees(tuning.margins.phase.min())
    if as_json:
        named = {name: {"value": value, "unit": unit} for name, (value, unit) in settings.items()}
        print_json({"settings": named, **peaks, "unit": "rad/(N m s)", "gain_margin": gain, "phase_margin_deg": phase})
        return
    print_rows(("setting", "value", "unit"), [(name, f"{value:.4g}", unit) for name, (value, unit) in settings.items()])
    present = f"{tuning.present * _RPM_PER_KN_M:.2f}" if stable else "unstable"
    typer.echo(
        f"Largest bit mobility {present} → {tuning.value * _RPM_PER_KN_M:.2f} rpm/(kN m); "
        f"gain margin {gain:.1f}, phase margin {phase:.0f}°, at worst within the fit's uncertainty"
    )


def _identified(logs: Sequence[Path], rig: Path, configuration: Path | None) -> Identification:
    check_files(logs)
    from drillid.config.settings import Settings
    from drillid.identification import identify

    tell_of_compilation()
    return identify(logs, rig, Settings.of_run(configuration) if configuration else Settings())


def check_format(figure: Path) -> None:
    """Refuse a file that no figure can be written into, before anything is computed."""
    from drillid.figures.layout import FORMATS

    if figure.suffix.lower().removeprefix(".") not in FORMATS:
        raise SettingsError(str(figure), "is not a figure file", f"End its name in one of {', '.join(FORMATS)}")


def tell_of_compilation() -> None:
    """Say why the first use takes long."""
    from drillid.compiled import is_compiled

    if not is_compiled("physics", "fits"):
        typer.echo("drillid: compiling its kernels, once after installation; this takes a few minutes …", err=True)


def _print_parameters(identification: Identification) -> None:
    """One row per window: every parameter with its standard error."""
    parameters = identification.parameters
    units = dict(zip(parameters["parameter"], parameters["unit"], strict=True))
    columns = ("window", "depth [m]", *(f"{name} [{unit}]" for name, unit in units.items()), "χ²/dof", "")
    rows = []
    for window, of_window in parameters.groupby("window"):
        values = [f"{row.value:.4g} ± {row.standard_error:.2g}" for row in of_window.itertuples(index=False)]
        first = of_window.iloc[0]
        verdict = "" if first["accepted"] else "not accepted"
        rows.append([str(window), f"{first['hole_depth']:.1f}", *values, f"{first['chi2_per_dof']:.2f}", verdict])
    print_rows(columns, rows)


def _cell(value: object) -> str:
    return f"{value:.3g}" if isinstance(value, float) else str(value)
