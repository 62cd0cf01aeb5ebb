"""Write every file that is generated from the models and schemas."""

from pathlib import Path

import typer

from drillid.config.documents import write_documents

ROOT = Path(__file__).resolve().parents[1]


def main() -> None:
    """Write docs/datasets.md, config/README.md and config.yaml, the schemas and envs/drillid.yaml again."""
    write_documents(ROOT)


if __name__ == "__main__":
    typer.run(main)
