"""What stands above every figure."""

from types import SimpleNamespace
from typing import Any

import pytest

from drillid.figures.captions import FIGURES
from drillid.figures.layout import new_figure


@pytest.mark.parametrize("name", ["34/10-A-12 H", "US$ and $\\frac{", "$$", "<script>"])
def test_the_name_of_a_well_is_no_formula(name: str) -> None:
    well: Any = SimpleNamespace(name=name)
    figure = new_figure(well, next(iter(FIGURES)), 4.0, 3.0)
    figure.canvas.draw()
    assert figure.texts[0].get_text().replace(r"\$", "$").startswith(f"{name} · ")
