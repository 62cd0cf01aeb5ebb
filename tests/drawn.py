"""Figures that a function saves, kept to look at what is drawn in them."""

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import numpy as np
import pytest
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from drillid.arrays import Floats


@contextmanager
def kept_figures() -> Iterator[list[Figure]]:
    """Every figure that is saved meanwhile, in the order of saving."""
    kept: list[Figure] = []
    save = Figure.savefig

    def keep(figure: Figure, *arguments: Any, **options: Any) -> None:
        save(figure, *arguments, **options)
        kept.append(figure)

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(Figure, "savefig", keep)
        yield kept


def line(axis: Axes, label: str) -> tuple[Floats, Floats]:
    """Abscissae and ordinates of the line with this label."""
    (found,) = [each for each in axis.lines if each.get_label() == label]
    return np.asarray(found.get_xdata(), dtype=float), np.asarray(found.get_ydata(), dtype=float)


def check_visible(figure: Figure) -> None:
    """Every axis has finite extents, and of every line with values something lies within them."""
    for axis in figure.axes:
        extents = (axis.get_xlim(), axis.get_ylim())
        assert np.isfinite(extents).all()
        for each in axis.lines:
            if each.get_transform() != axis.transData:
                continue  # a line across the whole axis
            points = np.array([each.get_xdata(), each.get_ydata()], dtype=float)
            low, high = np.sort(extents).T[:, :, None]
            assert np.any(np.all((low <= points) & (points <= high), axis=0)), each.get_label()
