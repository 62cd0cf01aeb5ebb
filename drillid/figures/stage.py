"""The paper's figures 6 to 13 for a well, its parameters against depth, anomalies and verdicts, as files."""

from __future__ import annotations

import shutil
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

from drillid.datasets.reuse import Memo, checksum
from drillid.datasets.store import Problem, WellFolders
from drillid.errors import SettingsError
from drillid.figures.content import drawn_content
from drillid.figures.data import WellResults

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from drillid.config.listing import Well
    from drillid.config.settings import Settings


def drawings() -> dict[str, Callable[[WellResults], Figure]]:
    """Every figure of `drillid.figures.captions.FIGURES` with the function of its name that draws it."""
    from drillid.figures import depth, prediction, tracks, verdicts, windows

    functions = (
        *(tracks.parameters, tracks.anomaly),
        *(verdicts.verdicts, verdicts.evidence, verdicts.distinguishability),
        *(prediction.model_residuals, prediction.held_out, prediction.reflectogram),
        *(windows.spectrograms, windows.command_mobility_measured, windows.command_mobility_fitted),
        *(depth.command_mobility_depth, depth.bit_step_stiff, depth.bit_step_controlled),
        *(depth.bit_mobility_stiff, depth.bit_mobility_controlled, depth.residuals),
    )
    return {draw.__name__: draw for draw in functions}


def draw(results: WellResults, name: str) -> Figure:
    """One figure in the figures' own style.

    Parameters
    ----------
    name : of `drillid.figures.captions.FIGURES`

    Raises
    ------
    SettingsError
        If there is no such figure.
    """
    import matplotlib

    from drillid.figures.style import STYLE

    functions = drawings()
    if name not in functions:
        raise SettingsError(name, "is not a figure", f"Choose one of {', '.join(functions)}")
    with matplotlib.rc_context(STYLE):
        return functions[name](results)


def process(well: Well, folders: WellFolders, settings: Settings) -> list[Problem]:
    """Draw all figures of a well into its figures folder, except those that an earlier run drew from the same content.

    A well without windows has none.
    """
    if not folders.has("windows", "windows") or not folders.read("windows", "windows").sizes["window"]:
        return []
    from drillid.figures.layout import save

    results = WellResults.load(well, folders, settings.discrepancy.error_rate)
    folder, earlier = folders.stage("figures"), folders.aside("figures")
    folder.mkdir(parents=True, exist_ok=True)
    memo = Memo(folders, "figures")
    for name in drawings():
        content = drawn_content(results, name)
        key = memo.key(name, content)
        files = [f"{name}.{suffix}" for suffix in settings.figures.formats]
        known = {} if content is None else memo.earlier.get(key, {})
        if all(known.get(file) == _checksum(earlier / file) for file in files):
            for file in files:
                shutil.copyfile(earlier / file, folder / file)
        else:
            figure = draw(results, name)
            for file in files:
                save(figure, folder / file, settings.figures.dpi)
        if content is not None:
            memo.found[key] = {file: checksum(folder / file) for file in files}
    memo.save()
    return []


def _checksum(path: Path) -> str:
    """Checksum of a file's bytes; empty, unlike that of any file, where there is none."""
    return checksum(path) if path.exists() else ""
