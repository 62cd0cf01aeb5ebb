"""Commands around the workflow: run it, check what it would be given, explain what it made."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, NoReturn

import typer

from drillid.commands.output import Json, faults_told, print_json, print_rows
from drillid.errors import writing

if TYPE_CHECKING:
    from drillid.config.settings import Settings
    from drillid.fleet.command import RunOutcome

Profile = Annotated[Path, typer.Option(help="Workflow profile.")]
Jobs = Annotated[str, typer.Option(help="Cores to use, or jobs on a cluster; the profile's number by default.")]
DEFAULT_PROFILE = Path("workflow/profiles/default")


def add_workflow_commands(app: typer.Typer) -> None:
    """Add the commands of this module to the command line."""
    passed_on = {"allow_extra_args": True, "ignore_unknown_options": True}
    app.command("run", context_settings=passed_on)(run_workflow)
    app.command("demo")(run_demo)
    app.command("init")(write_example)
    app.command("check")(check_configuration)
    app.command("explain")(explain_result)


def run_workflow(
    context: typer.Context,
    configfile: Annotated[Path | None, typer.Option(help="Configuration file; config/config.yaml by default.")] = None,
    profile: Profile = DEFAULT_PROFILE,
    jobs: Jobs = "",
    strict: Annotated[bool, typer.Option(help="Exit with code 3 if wells failed.")] = True,
    as_json: Json = False,
) -> None:
    """Run the workflow in this folder; further arguments are passed to Snakemake: targets, --dry-run, --until fits …

    Exit codes: 0 no well failed, 1 the run itself failed, 3 some wells failed, 128 + n stopped by signal n.

    Example: drillid run --configfile config/config.yaml --jobs 4
    """
    from drillid.fleet.command import run

    with faults_told():
        ended = run(context.args, profile, configfile, jobs, strict)
    _end(ended, as_json)


def _end(ended: RunOutcome, as_json: bool) -> NoReturn:
    if as_json:
        print_json({"exit_code": ended.code, **ended.wells})
    raise typer.Exit(ended.code)


def run_demo(profile: Profile = DEFAULT_PROFILE, jobs: Jobs = "", as_json: Json = False) -> None:
    """Simulate the raw logs of three small wells and process them into results/demo/report.html.

    Example: drillid demo
    """
    from drillid.fleet.command import run
    from drillid.fleet.installation import write_demo

    with faults_told():
        ended = run([], profile, write_demo(), jobs, strict=True)
    _end(ended, as_json)


def write_example(
    folder: Annotated[Path, typer.Argument(help="Folder to write the configuration into.")] = Path(),
) -> None:
    """Write a configuration with empty sheets into a folder, where `drillid run` can be started later.

    Example: drillid init my-wells
    """
    from drillid.fleet.installation import write_example as write

    with faults_told(), writing(folder / "config"):
        written = write(folder)
    typer.echo(
        "".join(f"written: {path}\n" for path in written) + "Describe each rig in config/rigs/<rig>.yaml", nl=True
    )


def check_configuration(
    configuration: Annotated[Path, typer.Argument(help="Configuration to check.")] = Path("config/config.yaml"),
    logs: Annotated[bool, typer.Option(help="Read every log as well.")] = True,
    as_json: Json = False,
) -> None:
    """List everything that a run would reject in the configuration, sheets, descriptions and logs.

    One row per finding: where, what, remedy. Exit code 1 if a log, a well or the run would fail.

    Example: drillid check config/config.yaml
    """
    from drillid.records.check import Checked, Finding, check

    checked, findings = Checked(), list[Finding]()

    def rows() -> Iterator[tuple[str, str, str, str]]:
        for finding in check(configuration, checked, logs=logs, later_stages=[_weigh_causes]):
            findings.append(finding)
            yield finding.row

    columns = ("kind", "where", "what", "remedy")
    if as_json:
        print_json([dict(zip(columns, row, strict=True)) for row in rows()])
    else:
        print_rows(columns, rows())
    typer.echo(checked.summary(findings), err=True)
    fails = sum(finding.fails for finding in findings)
    raise typer.Exit(int(fails > 0))


def _weigh_causes(settings: Settings) -> None:
    if settings.discrepancy.cause_weights:
        from drillid.discrepancy.base_rates import stated_base_rates

        stated_base_rates(settings.discrepancy)


def explain_result(
    path: Annotated[Path, typer.Argument(help="A dataset, table or figure of a well, such as depth.zarr.")],
    as_json: Json = False,
) -> None:
    """Show the provenance of a result: stages, code, settings, versions and the checksums of the logs.

    Example: drillid explain results/demo/depth/D01/depth.zarr
    """
    from drillid.fleet.explain import explain, stages_behind

    with faults_told():
        if as_json:
            print_json(stages_behind(path))
        else:
            typer.echo(explain(path))
