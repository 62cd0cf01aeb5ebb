"""The chart of a learnt law: its band on the well's page, and none where nothing is offered."""

from types import SimpleNamespace
from typing import Any

import numpy as np
import xarray as xr

from drillid.report.charts.discovery import law_chart

SPEED = np.linspace(8.0, 12.0, 41)


def results(torque: np.ndarray, twist: np.ndarray | None = None) -> Any:
    """A well whose one set has a law of the bit, or of a coupling."""
    values = {"law_speed": SPEED, "law_torque": torque, "law_error": np.full(41, 5.0)}
    missing = np.full(41, np.nan)
    values |= {"coupling_torque": 1e3 * SPEED, "coupling_twist": missing if twist is None else twist}
    values |= {"coupling_error": np.full(41, 1e-3)}
    return SimpleNamespace(
        examination=xr.Dataset({name: (("set", "law_point"), value[None]) for name, value in values.items()})
    )


def test_the_law_is_drawn_with_its_band() -> None:
    chart = law_chart(results(100.0 * (SPEED - 10.0)), 0)
    assert chart is not None
    band, line = (renderer.data_source.data for renderer in chart.renderers)
    np.testing.assert_allclose(line["value"], 0.1 * (SPEED - 10.0), atol=1e-6)
    np.testing.assert_allclose(band["high"] - band["low"], 2 * 1.96 * 5e-3, rtol=1e-3)


def test_nothing_is_drawn_without_a_law() -> None:
    assert law_chart(results(np.full(41, np.nan)), 0) is None


def test_the_law_of_a_coupling_is_drawn_in_its_own_units() -> None:
    chart = law_chart(results(np.full(41, np.nan), 1e-3 * (SPEED - 10.0) ** 2), 0)
    assert chart is not None
    band, line = (renderer.data_source.data for renderer in chart.renderers)
    np.testing.assert_allclose(line["place"], SPEED, rtol=1e-6)
    np.testing.assert_allclose(line["value"], (SPEED - 10.0) ** 2, atol=1e-5)
    np.testing.assert_allclose(band["high"] - band["low"], 2 * 1.96, rtol=1e-3)
    assert "coupling" in chart.title.text
