"""Write every file that is generated from the models and schemas."""

from pathlib import Path

import typer

from drillid.config.documents import write_documents
from drillid.discrepancy import rules

ROOT = Path(__file__).resolve().parents[1]


def main() -> None:
    """Write the pages of datasets and rules, the configuration with its page, the schemas and envs/drillid.yaml."""
    write_documents(ROOT)
    (ROOT / "docs" / "rules.md").write_text(rules.page())


if __name__ == "__main__":
    typer.run(main)
