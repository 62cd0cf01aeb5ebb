"""Stored images of every figure of a small synthetic well and of the speed control, without letters."""

from collections.abc import Callable
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
from matplotlib.text import Text

from drillid.control.stick_slip import stick_slip_map
from drillid.control.tuning import controlled_by
from drillid.datasets.store import WellFolders
from drillid.figures.captions import FIGURES
from drillid.figures.control import draw_bit_mobility, draw_stick_slip_map
from drillid.figures.data import WellResults
from drillid.figures.layout import save
from drillid.figures.stage import draw
from drillid.physics.equipment import Controller
from drillid.physics.nonlinear import Cutting, Weakening
from tests.simulated import DEEP
from tests.synthetic_well import SETTINGS, make_well

FOLDER = Path(__file__).parent / "figures"
_DPI = 36
_CONTROLLERS = {"stiff": Controller(20000.0, 20000.0), "soft": Controller(1500.0, 800.0)}


def write_image(figure: Any, path: Path) -> None:
    """Write a figure small and without letters."""
    for text in figure.findobj(Text):
        text.set_alpha(0.0)
    save(figure, path, _DPI)


def write_images() -> int:
    """Draw all stored images again, and return how many there are."""
    FOLDER.mkdir(exist_ok=True)
    with TemporaryDirectory() as folder:
        well = make_well(Path(folder), "many", 10)
        results = WellResults.load(well, WellFolders(Path(folder), "many"), SETTINGS.discrepancy.error_rate)
        for name in FIGURES:
            write_image(draw(results, name), FOLDER / f"{name}.png")
    for name, drawn in CONTROL.items():
        write_image(drawn(), FOLDER / f"{name}.png")
    return len(FIGURES) + len(CONTROL)


def _stick_slip() -> Any:
    cutting = Cutting(0.06, 0.03, Weakening(6.0))
    return draw_stick_slip_map(stick_slip_map(DEEP.system, cutting, np.linspace(2e4, 2e5, 10), _CONTROLLERS))


def _bit_mobility() -> Any:
    return draw_bit_mobility(
        {name: controlled_by(DEEP.system, each) for name, each in _CONTROLLERS.items()}, (0.1, 4.0)
    )


CONTROL: dict[str, Callable[[], Any]] = {"stick_slip_map": _stick_slip, "controlled_bit_mobility": _bit_mobility}
"""Figures of the speed control, by the names of their images."""
