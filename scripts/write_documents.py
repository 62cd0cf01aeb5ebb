"""Write every file that is generated from the models and schemas."""

from pathlib import Path

import typer
from typer.cli import get_docs_for_click

from drillid.commands import app
from drillid.config.documents import write_documents
from drillid.discrepancy import rules

ROOT = Path(__file__).resolve().parents[1]


def commands_page() -> str:
    """The command line with all its options."""
    command = typer.main.get_command(app)
    page = get_docs_for_click(obj=command, ctx=typer.Context(command), name="drillid", title="Commands")
    return f"<!-- Written by `make docs` from drillid/commands; edit that instead. -->\n{page.rstrip()}\n"


def main() -> None:
    """Write pages of datasets, rules and commands, the configuration with its page, schemas and envs/drillid.yaml."""
    write_documents(ROOT)
    (ROOT / "docs" / "rules.md").write_text(rules.page())
    (ROOT / "docs" / "commands.md").write_text(commands_page())


if __name__ == "__main__":
    typer.run(main)
