"""TODO."""

import contextlib
import io
import re
import warnings
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import zip_longest
from pathlib import Path
from typing import Any

from drillid.errors import SettingsError

_MARK = re.compile(r"^# %%(?: \[(\w+)\])?$")
_DPI = 110


@dataclass(frozen=True)
class Cell:
    """One cell of a script."""

    text: bool
    first_line: int
    """Number of its first line in the script, from 0."""
    lines: tuple[str, ...]

    @property
    def content(self) -> str:
        """Text without its comment signs, or code."""
        lines = [re.sub(r"^# ?", "", line) for line in self.lines] if self.text else self.lines
        return "\n".join(lines).strip("\n")


def cells(script: str) -> list[Cell]:
    """Cells of a script's text; what is above the first mark is left to editors.

    Raises
    ------
    SettingsError
        If a mark is of an unknown kind or a cell of text holds code.
    """
    lines = script.splitlines()
    starts = [number for number, line in enumerate(lines) if line.startswith("# %%")]
    found = []
    for start, end in zip(starts, [*starts[1:], len(lines)], strict=True):
        mark = _MARK.match(lines[start])
        cell = Cell(mark is not None and mark[1] == "markdown", start + 1, tuple(lines[start + 1 : end]))
        bare = cell.text and any(line and not line.startswith("#") for line in cell.lines)
        if mark is None or mark[1] not in (None, "markdown") or bare:
            raise SettingsError(
                f"script, line {start + 1}", "is no cell of text or code", "Begin it with '# %% [markdown]' or '# %%'"
            )
        found.append(cell)
    return found


def write_page(script: Path, folder: Path) -> Path:
    """Run a script and write `<folder>/<script's name>.md`, with its figures in a folder of that name beside it.

    Figures are those of pyplot that are open after a cell; their labels, `plt.figure("label")`, name them.

    Raises
    ------
    Exception
        Whatever a cell raises, with the script's line.
    """
    figures = folder / script.stem
    figures.mkdir(parents=True, exist_ok=True)
    for old in figures.glob("*.png"):
        old.unlink()
    page = folder / f"{script.stem}.md"
    namespace: dict[str, Any] = {"__name__": "__main__", "__file__": str(script)}
    with _drawing_without_a_screen(), warnings.catch_warnings():
        warnings.simplefilter("error")
        parts = [_shown(cell, script, namespace, figures) for cell in cells(script.read_text())]
    note = f"<!-- Written by `make tutorial` from {script.name}; edit that instead. -->"
    page.write_text("\n\n".join([note, *filter(None, parts)]) + "\n")
    return page


def _shown(cell: Cell, script: Path, namespace: dict[str, Any], figures: Path) -> str:
    """A cell as the page shows it; code is run."""
    if cell.text or not cell.content:
        return cell.content
    # blank lines above keep the script's line numbers in a traceback
    source = "\n" * cell.first_line + "\n".join(cell.lines)
    printed = io.StringIO()
    with contextlib.redirect_stdout(printed):
        exec(compile(source, str(script), "exec"), namespace)
    blocks = [f"```python\n{cell.content}\n```"]
    if printed.getvalue():
        blocks.append(f"```text\n{printed.getvalue().rstrip()}\n```")
    return "\n\n".join([*blocks, *_saved(figures)])


def _saved(figures: Path) -> Iterator[str]:
    """Write all open figures and give the lines that show them."""
    from matplotlib import pyplot

    for number in pyplot.get_fignums():
        figure = pyplot.figure(number)
        label = str(figure.get_label()) or f"Figure {number}"
        name = re.sub(r"\W+", "_", label.lower()).strip("_") + ".png"
        figure.savefig(figures / name, dpi=_DPI, metadata={"Software": None}, pil_kwargs={"optimize": True})
        pyplot.close(figure)
        yield f"![{label}]({figures.name}/{name})"


@contextlib.contextmanager
def _drawing_without_a_screen() -> Iterator[None]:
    """Figures in memory, with pyplot's settings as they were afterwards."""
    import matplotlib
    from matplotlib import pyplot

    pyplot.switch_backend("agg")
    with matplotlib.rc_context():
        try:
            yield
        finally:
            pyplot.close("all")


_NUMBER = re.compile(r"-?\d+(?:\.\d+)?(?:e[+-]?\d+)?")
_WITHIN = 0.02
"""Relative difference that another processor's rounding may make at the end of a fit."""


def differences(page: str, other: str) -> list[tuple[str, str]]:
    """Lines of two pages that differ by more than the last printed digits of a number.

    Parameters
    ----------
    page, other : whole texts
    """
    pairs = zip_longest(page.splitlines(), other.splitlines(), fillvalue="")
    return [pair for pair in pairs if not _same(*pair)]


def _same(line: str, other: str) -> bool:
    if _NUMBER.sub("", line).split() != _NUMBER.sub("", other).split():
        return False
    pairs = list(zip_longest(_NUMBER.findall(line), _NUMBER.findall(other), fillvalue="nan"))
    return all(abs(float(one) - float(two)) <= _WITHIN * abs(float(one)) + 2 * _last_digit(one) for one, two in pairs)


def _last_digit(number: str) -> float:
    """What one step of a number's last digit amounts to."""
    plain, _, exponent = number.partition("e")
    return float(10.0 ** (int(exponent or 0) - len(plain.partition(".")[2])))
