"""The chart of a learnt law: its band on the well's page, and none where nothing is offered."""

from types import SimpleNamespace
from typing import Any

import numpy as np
import xarray as xr

from drillid.report.charts.discovery import law_chart

SPEED = np.linspace(8.0, 12.0, 41)


MISSING = np.full(41, np.nan)


def results(torque: np.ndarray, twist: np.ndarray = MISSING, control: np.ndarray = MISSING) -> Any:
    """A well whose one set has a law of the bit, of a coupling, or of the control."""
    values = {"law_speed": SPEED, "law_torque": torque, "law_error": np.full(41, 5.0)}
    values |= {"coupling_torque": 1e3 * SPEED, "coupling_twist": twist, "coupling_error": np.full(41, 1e-3)}
    values |= {"control_speed_error": SPEED - 10.0, "control_torque": control}
    values |= {"control_torque_error": np.full(41, 10.0)}
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
    assert law_chart(results(MISSING), 0) is None


def test_the_law_of_a_coupling_is_drawn_in_its_own_units() -> None:
    chart = law_chart(results(MISSING, 1e-3 * (SPEED - 10.0) ** 2), 0)
    assert chart is not None
    band, line = (renderer.data_source.data for renderer in chart.renderers)
    np.testing.assert_allclose(line["place"], SPEED, rtol=1e-6)
    np.testing.assert_allclose(line["value"], (SPEED - 10.0) ** 2, atol=1e-5)
    np.testing.assert_allclose(band["high"] - band["low"], 2 * 1.96, rtol=1e-3)
    assert "coupling" in chart.title.text


def test_the_law_of_the_control_is_drawn_over_its_error() -> None:
    chart = law_chart(results(MISSING, control=200.0 * (SPEED - 10.0) ** 3), 0)
    assert chart is not None
    band, line = (renderer.data_source.data for renderer in chart.renderers)
    np.testing.assert_allclose(line["value"], 0.2 * (SPEED - 10.0) ** 3, atol=1e-5)
    np.testing.assert_allclose(band["high"] - band["low"], 2 * 1.96 * 1e-2, rtol=1e-3)
    assert "speed control" in chart.title.text
