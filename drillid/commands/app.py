"""All commands under one name."""

from typing import Annotated

import typer

import drillid
from drillid.commands.identification import add_identification_commands
from drillid.commands.inspection import add_inspection_commands
from drillid.commands.proof import add_proof_commands
from drillid.commands.results import add_result_commands
from drillid.commands.simulation import simulations
from drillid.commands.workflow import add_workflow_commands

app = typer.Typer(no_args_is_help=True, help="Torsional dynamics of drill strings, identified while drilling.")
app.add_typer(simulations, name="simulate")
add_workflow_commands(app)
add_inspection_commands(app)
add_identification_commands(app)
add_result_commands(app)
add_proof_commands(app)


def _print_version(asked: bool) -> None:
    if asked:
        typer.echo(f"drillid {drillid.__version__}")
        raise typer.Exit


Version = Annotated[bool, typer.Option("--version", callback=_print_version, is_eager=True, help="Print the version.")]


@app.callback()
def _commands(version: Version = False) -> None:
    """Torsional dynamics of drill strings, identified while drilling."""
