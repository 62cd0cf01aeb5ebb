"""The paper's figures 6 to 13 for a well, its parameters against depth, and what stands out, as PNG files."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

from drillid.datasets.store import Problem, WellFolders
from drillid.figures.data import WellResults

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from drillid.config.settings import Settings
    from drillid.config.sheets import Well


def drawings() -> dict[str, Callable[[WellResults], Figure]]:
    """Every figure of `drillid.figures.captions.FIGURES` with the function that draws it."""
    from drillid.figures import depth as figures_depth
    from drillid.figures import prediction as figures_prediction
    from drillid.figures import tracks as figures_tracks
    from drillid.figures import verdicts as figures_verdicts
    from drillid.figures import windows as figures_windows
    from drillid.figures.captions import FIGURES

    modules = (figures_tracks, figures_verdicts, figures_windows, figures_depth, figures_prediction)
    return {name: next(getattr(module, name) for module in modules if hasattr(module, name)) for name in FIGURES}


def process(well: Well, folders: WellFolders, settings: Settings) -> list[Problem]:
    """Draw all figures of a well into its figures folder; a well without windows has none."""
    if not folders.has("windows", "windows") or not folders.read("windows", "windows").sizes["window"]:
        return []
    import matplotlib

    from drillid.figures.style import STYLE, save

    results = WellResults.load(well, folders, settings.discrepancy.error_rate)
    folder = folders.stage("figures")
    folder.mkdir(parents=True, exist_ok=True)
    with matplotlib.rc_context(STYLE):
        for name, draw in drawings().items():
            save(draw(results), folder / f"{name}.png", settings.figures.dpi)
    return []
