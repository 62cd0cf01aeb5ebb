"""Every figure looks as it was last looked at; `python -m tests.baselines.make figures` draws the stored ones again.

The stored images have no letters, whose shapes depend on the fonts at hand: what they say is tested by their words.
"""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from matplotlib.testing.compare import compare_images

from drillid.control.stick_slip import StickSlipMap
from drillid.figures.captions import FIGURES
from drillid.figures.control import draw_bit_mobility, draw_stick_slip_map
from drillid.figures.data import WellResults
from drillid.figures.stage import draw
from tests.baselines.images import CONTROL, FOLDER, write_image
from tests.simulated import DEEP

TOLERANCE = 0.6
"""Root mean square of the pixels' differences, of 255; a line of 200 pixels that moves by two makes more."""


def difference(figure: object, name: str, folder: Path) -> str | None:
    """What matplotlib says of the differences from a stored image; None where there are none."""
    drawn = folder / f"{name}.png"
    write_image(figure, drawn)
    return compare_images(str(FOLDER / f"{name}.png"), str(drawn), TOLERANCE)


@pytest.mark.parametrize("name", list(FIGURES))
def test_a_figure_looks_as_it_was_last_looked_at(many: WellResults, name: str, tmp_path: Path) -> None:
    assert difference(draw(many, name), name, tmp_path) is None


@pytest.mark.parametrize("name", list(CONTROL))
def test_a_figure_of_control_looks_as_it_was_last_looked_at(name: str, tmp_path: Path) -> None:
    assert difference(CONTROL[name](), name, tmp_path) is None


def test_every_controller_has_its_line() -> None:
    names = [f"controller {number}" for number in range(7)]
    weight, speed = np.array([2e4, 2e5]), np.array([5.0, 9.0])
    stability = StickSlipMap(weight, dict.fromkeys(names, speed), dict.fromkeys(names, 0.2))
    mobilities = draw_bit_mobility(dict.fromkeys(names, DEEP.system))
    for figure in (draw_stick_slip_map(stability), mobilities):
        assert len(figure.axes[0].lines) == len(names)


def test_a_single_point_that_moves_is_a_difference(many: WellResults, tmp_path: Path) -> None:
    fits = many.fits.copy(deep=True)
    fits["value"].loc[{"parameter": "inertia_td"}] *= np.where(np.arange(fits.sizes["window"]) == 4, 1.02, 1.0)
    found = difference(draw(replace(many, fits=fits), "parameters"), "parameters", tmp_path)
    assert found is not None
    assert "RMS" in found


def test_every_stored_image_is_compared() -> None:
    assert {path.stem for path in FOLDER.glob("*.png")} == {*FIGURES, *CONTROL}
