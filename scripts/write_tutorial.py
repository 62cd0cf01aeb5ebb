"""Run the tutorials of docs and write their pages with figures; say where these differ from the pages kept in docs.

A script is in the percent format of Jupytext: `# %% [markdown]` begins a cell of text, `# %%` one of code. The code
runs as one program, without a kernel; a warning counts as an error.
"""

import contextlib
import io
import re
import warnings
from collections.abc import Iterator
from decimal import Decimal
from difflib import SequenceMatcher
from itertools import zip_longest
from pathlib import Path
from typing import Annotated, Any

import jupytext
import matplotlib
import typer
from matplotlib import pyplot
from matplotlib.figure import Figure
from nbformat import NotebookNode

from drillid.errors import SettingsError

DOCS = Path(__file__).resolve().parents[1] / "docs"
_MARK = "# %%"
_DPI = 110
_NUMBER = re.compile(r"-?\d+(?:\.\d+)?(?:e[+-]?\d+)?")
_RELATIVE_TOLERANCE = 0.02
"""Difference that another processor's rounding may make to a number at the end of a fit."""


def cells(script: str) -> list[NotebookNode]:
    """Cells of a script's text, with the number of lines above each as `metadata.line`.

    What is above the first mark is for editors and not part of any cell.

    Raises
    ------
    SettingsError
        If a cell is neither text nor code, or a cell of text has lines that are not comments.
    """
    mark = re.search(rf"^{_MARK}", script, re.MULTILINE)
    place = mark.start() if mark else len(script)
    found: list[NotebookNode] = jupytext.reads(script[place:], fmt="py:percent").cells if mark else []
    for cell in found:
        place = script.index(_MARK, place)
        text = "\n".join(f"# {line}".rstrip() for line in cell.source.splitlines())
        start = script.find({"markdown": text, "code": cell.source}.get(cell.cell_type, _MARK), place + len(_MARK))
        if start < 0 or cell.cell_type == "raw":
            raise SettingsError(
                f"script, line {script.count(chr(10), 0, place) + 1}",
                "is no cell of text or code",
                "Begin it with '# %% [markdown]' or '# %%', and every line of text with '#'",
            )
        cell.metadata["line"] = script.count("\n", 0, start)
        place = start
    return found


def write_page(script: Path, folder: Path) -> Path:
    """Run a script and write `<folder>/<script's name>.md`, with its figures in a folder of that name beside it.

    Figures are those of pyplot that are open after a cell, and others to which a cell has given a name. Files are named
    by a figure's label, `plt.figure("label")`, or else by that name.

    Raises
    ------
    Exception
        Whatever a cell raises, with the script's line.
    """
    figures = folder / script.stem
    figures.mkdir(parents=True, exist_ok=True)
    namespace: dict[str, Any] = {"__name__": "__main__", "__file__": str(script)}
    with _drawing_without_a_screen(), warnings.catch_warnings():
        warnings.simplefilter("error")
        parts = [_shown(cell, script, namespace, figures) for cell in cells(script.read_text())]
    note = f"<!-- Written by `make tutorial` from {script.name}; edit that instead. -->"
    text = "\n\n".join([note, *filter(None, parts)]) + "\n"
    for picture in figures.glob("*.png"):
        if f"({figures.name}/{picture.name})" not in text:
            picture.unlink()
    page = folder / f"{script.stem}.md"
    page.write_text(text)
    return page


def _shown(cell: NotebookNode, script: Path, namespace: dict[str, Any], figures: Path) -> str:
    """A cell as the page shows it; code is run."""
    source: str = cell.source
    if cell.cell_type == "markdown" or not source:
        return source
    printed, before = io.StringIO(), dict(namespace)
    with contextlib.redirect_stdout(printed):
        # blank lines above keep the script's line numbers in a traceback
        exec(compile("\n" * cell.metadata["line"] + source, str(script), "exec"), namespace)
    blocks = [f"```python\n{source}\n```"]
    if printed.getvalue():
        blocks.append(f"```text\n{printed.getvalue().rstrip()}\n```")
    drawn = {f"Figure {number}": pyplot.figure(number) for number in pyplot.get_fignums()}
    new = {name: value for name, value in namespace.items() if value is not before.get(name)}
    drawn |= {name: value for name, value in new.items() if isinstance(value, Figure) and value not in drawn.values()}
    return "\n\n".join([*blocks, *(_saved(name, figure, figures) for name, figure in drawn.items())])


def _saved(name: str, figure: Figure, figures: Path) -> str:
    """Write a figure and give the line that shows it."""
    label = str(figure.get_label()) or name
    file = re.sub(r"\W+", "_", label.lower()).strip("_") + ".png"
    figure.savefig(figures / file, dpi=_DPI, metadata={"Software": None}, pil_kwargs={"optimize": True})
    pyplot.close(figure)
    return f"![{label}]({figures.name}/{file})"


@contextlib.contextmanager
def _drawing_without_a_screen() -> Iterator[None]:
    """Draw figures in memory; pyplot's settings are restored afterwards."""
    pyplot.switch_backend("agg")
    with matplotlib.rc_context():
        try:
            yield
        finally:
            pyplot.close("all")


def differences(page: str, other: str) -> list[tuple[str, str]]:
    """Lines of two pages that differ by more than the last printed digits of a number.

    Parameters
    ----------
    page, other : whole texts
    """
    lines = page.splitlines(), other.splitlines()
    words = [[" ".join(_NUMBER.sub("#", line).split()) for line in each] for each in lines]
    found = []
    for kind, first, last, other_first, other_last in SequenceMatcher(None, *words, autojunk=False).get_opcodes():
        pairs = zip_longest(lines[0][first:last], lines[1][other_first:other_last], fillvalue="")
        found += [pair for pair in pairs if kind != "equal" or not _same_numbers(*pair)]
    return found


def _same_numbers(line: str, other: str) -> bool:
    pairs = zip(_NUMBER.findall(line), _NUMBER.findall(other), strict=True)
    return all(abs(float(one) - float(two)) <= _tolerance(one) for one, two in pairs)


def _tolerance(number: str) -> float:
    """Tolerance of a number: two steps of its last digit, and a share of its size."""
    return _RELATIVE_TOLERANCE * abs(float(number)) + 2 * float(Decimal((0, (1,), Decimal(number).as_tuple().exponent)))


def main(
    folder: Annotated[Path, typer.Argument(help="Where the pages and their figures are written.")] = DOCS,
) -> None:
    """Run the tutorials and write their pages; fail where one differs from the page kept in docs.

    A page written over the kept one may differ: that is why it is written again.
    """
    changed = []
    for script in sorted(DOCS.glob("*.py")):
        page = script.with_suffix(".md")
        kept = page.read_text() if page.exists() else ""
        changed += differences(kept, write_page(script, folder).read_text())
    for before, after in changed:
        typer.echo(f"< {before}\n> {after}")
    if changed and folder.resolve() != DOCS:
        raise typer.Exit(1)


if __name__ == "__main__":
    typer.run(main)
