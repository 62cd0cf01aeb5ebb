"""`drillid blind`: the sealed proof of the discovery engine, which lies in the checkout's benchmarks."""

import subprocess
import sys
from pathlib import Path

import typer

from drillid.commands.output import faults_told
from drillid.errors import SettingsError


def add_proof_commands(app: typer.Typer) -> None:
    """Add the commands of this module to the command line."""
    passed_on = {"allow_extra_args": True, "ignore_unknown_options": True, "help_option_names": []}
    app.command("blind", context_settings=passed_on)(run_blind)


def run_blind(context: typer.Context) -> None:
    """Test the discovery engine on hidden causes, drawn and simulated; `drillid blind --help` lists the options.

    Example: drillid blind --cases 40
    """
    if "--help" in context.args and not Path("benchmarks/blind").is_dir():
        typer.echo(context.get_help())
        raise typer.Exit
    with faults_told():
        if not Path("benchmarks/blind").is_dir():
            remedy = "Start it in a checkout of the repository; the installed package does not contain the benchmarks"
            raise SettingsError(str(Path.cwd()), "holds no benchmarks/blind", remedy)
    raise typer.Exit(subprocess.run([sys.executable, "-m", "benchmarks.blind", *context.args], check=False).returncode)
