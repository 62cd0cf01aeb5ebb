"""Commands on results that are there: draw a figure, write the report again, look around in wells."""

from __future__ import annotations

import contextlib
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from drillid.commands.output import Json, check_output, faults_told, print_json
from drillid.errors import SettingsError, writing

if TYPE_CHECKING:
    from drillid.config.settings import Settings

Configfile = Annotated[
    Path, typer.Option("--configfile", help="Configuration of the run that made the results, or the results folder.")
]
DEFAULT_CONFIGURATION = Path("config/config.yaml")
"""As `drillid.config.settings` has it, whose import would slow down every command."""


def add_result_commands(app: typer.Typer) -> None:
    """Add the commands of this module to the command line."""
    app.command("draw")(draw_figure)
    app.command("report")(write_pages)
    app.command("view")(view_wells)
    app.command("promote")(promote_learnt)


def _settings(run: Path) -> Settings:
    """Settings of a run by its configuration or by the folder of its results."""
    from drillid.config.settings import Settings
    from drillid.fleet.crate import settings_of

    return settings_of(run) if run.is_dir() else Settings.of_run(run)


def draw_figure(
    well: Annotated[str, typer.Argument(help="Name of a well in the sheets.")],
    figure: Annotated[str, typer.Argument(help="Name of a figure, such as parameters or evidence.")],
    output: Annotated[Path, typer.Option(help="PNG, SVG or PDF file.")],
    configfile: Configfile = DEFAULT_CONFIGURATION,
    dpi: Annotated[
        int, typer.Option(min=10, max=2400, help="Resolution of a PNG, and of the images in the other formats.")
    ] = 300,
    heading: Annotated[bool, typer.Option(help="Well, title and caption above the panels.")] = True,
) -> None:
    """Draw a figure of a well with results, in the format and at the resolution that a publication asks for.

    Exit code 1 if the well has no results, or there is no such figure; the message lists the figures.

    Example: drillid draw D01 parameters --configfile config/demo/config.yaml --output parameters.pdf --no-heading
    """
    from drillid.figures.data import stored_results
    from drillid.figures.layout import save
    from drillid.figures.stage import draw

    with faults_told():
        check_output(output)
        results = stored_results(_settings(configfile), well)
        with writing(output):
            save(draw(results, figure), output, dpi, heading=heading)
    typer.echo(output)


def write_pages(configfile: Configfile = DEFAULT_CONFIGURATION, as_json: Json = False) -> None:
    """Write the report again from existing results, without the workflow.

    The list of what is new since the last report stays as the run left it.

    Example: drillid report --configfile config/demo/config.yaml
    """
    from drillid.config.sheets import read_sheets
    from drillid.report.page import PAGES, write_report

    with faults_told():
        settings = _settings(configfile)
        results = Path(settings.results)
        if not (results / "problems.csv").is_file():
            remedy = f"Run the workflow first: drillid run --configfile {configfile}"
            raise SettingsError(str(results), "holds no results of a run", remedy)
        wells = list(read_sheets(settings))
        write_report(settings, results, wells)
    pages = [results / "report.html", *(results / PAGES / f"{well}.html" for well in wells)]
    if as_json:
        print_json({"report": pages[0], "wells": dict(zip(wells, pages[1:], strict=True))})
        return
    for page in pages:
        typer.echo(page)


def view_wells(
    runs: Annotated[
        list[Path] | None,
        typer.Argument(help="Results or configuration of one run, or of several to compare."),
    ] = None,
    port: Annotated[int, typer.Option(min=0, max=65535, help="Port on this machine; 0 for any free one.")] = 0,
    browser: Annotated[bool, typer.Option(help="Open the page in the browser.")] = True,
) -> None:
    """Explore wells in the browser: linked views of depth, frequency and time; compare two wells or two runs.

    Serves this machine only, until interrupted. Exit code 1 if no well has results.

    Example: drillid view results/demo
    """
    from drillid.report.explorer import start, wells

    chosen = runs or [DEFAULT_CONFIGURATION]
    with faults_told():
        known = wells({str(path): _settings(path) for path in chosen})
        if not known:
            raise SettingsError(", ".join(map(str, chosen)), "no well has results", "Run the workflow first")
        try:
            server = start(known, port)
        except OSError as error:
            raise SettingsError(f"port {port}", str(error), "Give another --port, or 0 for any free one") from error
    typer.echo(f"http://localhost:{server.port}/ shows {len(known)} wells; press Ctrl-C to stop")
    if browser:
        server.show("/")
    with contextlib.suppress(KeyboardInterrupt):
        server.io_loop.start()


def promote_learnt(
    examination: Annotated[Path, typer.Argument(help="Examination dataset of a well, examination.zarr.")],
    name: Annotated[str, typer.Argument(help="Name of the cause: lower-case words joined by underscores.")],
    output: Annotated[Path, typer.Option(help="Module to write.")],
    number: Annotated[int, typer.Option("--set", min=0, help="Set of windows in which it was learnt.")] = 0,
) -> None:
    """Write what was learnt in a set of windows as a catalogue module, to be reviewed, corrected and added.

    Example: drillid promote results/main/discrepancy/W1/examination.zarr soft_joint --output soft_joint.py
    """
    from drillid.discrepancy.learning.promotion import read_examination, write_module

    with faults_told():
        write_module(read_examination(examination), number, name, str(examination), output)
    typer.echo(f"written to {output}")
