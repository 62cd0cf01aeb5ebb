"""Intervals of the control that are tried where nothing states or shows one."""

import numpy as np
import pytest
from scipy.special import erf

from drillid.discrepancy.inference.control_intervals import Usual, usual_intervals
from drillid.fits.datasheet import DataSheet, with_held_control
from drillid.physics.equipment import Controller

SILENT = DataSheet(Controller(600.0, 300.0))


def likely(usual: tuple[Usual, ...]) -> set[float]:
    """Intervals that are at most a factor of ten less likely than continuous control."""
    return {round(each.interval, 6) for each in usual if each.cost < np.log(10)}


def test_without_logs_any_usual_interval_is_likely() -> None:
    usual = usual_intervals(SILENT)
    assert len(likely(usual)) == len(usual) > 10
    # the half-normal prior below half the square of the shortest interval
    least = erf(0.01 / np.sqrt(2) / (0.025 * np.sqrt(2)))
    assert sum(np.exp(-each.cost) for each in usual) == pytest.approx(1 / least)


def test_even_rows_make_whole_parts_of_theirs_likely() -> None:
    sheet = with_held_control(SILENT, [np.nan, np.nan], rate=50.0, highest=5.0)
    assert likely(usual_intervals(sheet)) == {0.0, 0.005, 0.006667, 0.01, 0.02}
    in_step = [each for each in usual_intervals(sheet) if each.relative < 0.01]
    others = [each for each in usual_intervals(sheet) if each.relative >= 0.01]
    share = sum(np.exp(-each.cost) for each in others)
    # continuous control counts with both
    assert 0.03 < share / (share + sum(np.exp(-each.cost) for each in in_step)) < 0.05


@pytest.mark.parametrize(("held", "rate"), [([0.03, np.nan], 50.0), ([np.nan], 25.0), ([], 50.0)])
def test_uneven_or_few_rows_say_nothing_of_even_ones(held: list[float], rate: float) -> None:
    sheet = with_held_control(SILENT, held, rate, highest=5.0)
    assert np.isnan(sheet.even_rows)
    assert sheet.control_interval == pytest.approx(0.03 if 0.03 in held else np.nan, nan_ok=True)


def test_a_stated_interval_stays() -> None:
    stated = DataSheet(Controller(600.0, 300.0), control_interval=0.01)
    assert with_held_control(stated, [0.03], 50.0, 5.0) is stated
