"""Draw the gallery of docs from the results of `make demo`: every figure of one of its wells, with its caption."""

from pathlib import Path
from typing import Annotated

import typer

from drillid.config.settings import Settings
from drillid.figures.captions import FIGURES
from drillid.figures.data import stored_results
from drillid.figures.layout import save
from drillid.figures.stage import draw

DOCS = Path(__file__).resolve().parents[1] / "docs"
WELL = "D01"
_CONFIGURATION = Path("config/demo/config.yaml")
_DPI = 66


def page() -> str:
    """The page; its pictures lie in the folder beside it."""
    parts = [
        "<!-- Written by `make gallery`; edit scripts/write_gallery.py instead. -->",
        "# Gallery",
        f"Every figure of a well, here of {WELL} of `make demo`, a simulated well that drills through a wash-out "
        "between 2990 and 3050 m. A run writes them to `<results>/figures/<well>`. One of them for a publication, as "
        "PNG, SVG or PDF:",
        f"    drillid draw {WELL} parameters --configfile {_CONFIGURATION} --output parameters.pdf --no-heading",
    ]
    for name, text in FIGURES.items():
        caption = text.caption.replace("<", "&lt;")
        parts += [f"## {text.title}", f"`{name}`: {caption}", f"![{text.title}](gallery/{name}.png)"]
    return "\n\n".join(parts) + "\n"


def main(folder: Annotated[Path, typer.Argument(help="Folder of the page.")] = DOCS) -> None:
    """Draw every figure and write the page; the results of `make demo` must be there."""
    results = stored_results(Settings.of_run(_CONFIGURATION), WELL)
    pictures = folder / "gallery"
    pictures.mkdir(parents=True, exist_ok=True)
    for path in pictures.glob("*.png"):
        path.unlink()
    for name in FIGURES:
        save(draw(results, name), pictures / f"{name}.png", _DPI)
    (folder / "gallery.md").write_text(page(), encoding="utf-8")


if __name__ == "__main__":
    typer.run(main)
