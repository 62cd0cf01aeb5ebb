"""Name a block before it is run: `python -m benchmarks.blind.register --world other --first 200000`."""

from typing import Annotated

import typer
from rich.console import Console

from benchmarks.blind.blocks import register, size


def main(
    first: Annotated[int, typer.Option(help="Seed of the first case, never used before.")],
    world: Annotated[str, typer.Option(help="own or other.")] = "own",
    cases: Annotated[int, typer.Option(help="Number of cases; 0 for what the power calculation gives.")] = 0,
) -> None:
    """Write down engine, judge, seeds and size of a block."""
    enough, needed = size()
    console = Console()
    for name, count in needed.items():
        console.print(f"{name} needs {count} cases", highlight=False)
    block = register(world, first, cases or enough)
    console.print(f"registered {block.cases} cases from seed {block.first} of the {world} world: commit {block.commit}")
    console.print(f"engine {block.engine}, judge {block.judge}; commit benchmarks/blind/blocks.json before the run")


if __name__ == "__main__":
    typer.run(main)
