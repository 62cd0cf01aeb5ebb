"""Write the stored numbers and images of the status quo again: `python -m tests.baselines.make`, or names of some.

Look at the difference (`git diff tests/baselines`) before it is committed: each line of it is a change of behaviour.
"""

import json
from pathlib import Path
from typing import Annotated

import typer

from tests.baselines.images import write_images
from tests.baselines.values import BASELINES

FOLDER = Path(__file__).parent
IMAGES = "figures"


def main(names: Annotated[list[str] | None, typer.Argument(help="Which to write; all by default.")] = None) -> None:
    """Compute the numbers and store each set as JSON beside this file; `figures` are images in a folder."""
    unknown = set(names or ()) - {*BASELINES, IMAGES}
    if unknown:
        raise typer.BadParameter(f"{', '.join(sorted(unknown))}: there are {', '.join([*BASELINES, IMAGES])}")
    if not names or IMAGES in names:
        typer.echo(f"{IMAGES}: {write_images()} images")
    for name in (each for each in names or BASELINES if each != IMAGES):
        values, data = BASELINES[name]
        if data is not None and not data.exists():
            typer.echo(f"{name}: left as it is, {data} is not there")
            continue
        path = FOLDER / f"{name}.json"
        path.write_text(json.dumps(values(), indent=2, ensure_ascii=False) + "\n")
        typer.echo(f"{name}: {path}")


if __name__ == "__main__":
    typer.run(main)
