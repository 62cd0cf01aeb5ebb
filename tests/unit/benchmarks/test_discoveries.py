"""Rows, gains in time and absent data of `make discoveries`."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from matplotlib.patches import Rectangle

from benchmarks.discoveries import __main__ as discoveries
from benchmarks.discoveries import field_rows as discoveries_field_rows
from benchmarks.discoveries import motor_rows as discoveries_motor_rows
from benchmarks.discoveries import wells as discoveries_wells
from benchmarks.discoveries.field import CYCLE_S, Misses, gain, log_odds
from benchmarks.discoveries.rows import COLUMNS, Discovery, printed, table
from drillid.discrepancy import Verdict
from drillid.discrepancy.sets import verdict_table
from drillid.simulation.start_up import RATE, WellFriction
from tests.drawn import kept_figures
from tests.verdicts import LAG


def misses(torque: float, bit: float, figures: int, seed: int = 0) -> Misses:
    """A minute of cycles with so large rms misses, that vary a little."""
    time = np.arange(round(60 * RATE)) / RATE
    generator = np.random.default_rng(seed)
    size = 1 + 0.1 * generator.standard_normal(20)[(time / CYCLE_S).astype(int)]
    wave = np.sqrt(2) * size * np.sin(2 * np.pi * time / CYCLE_S)
    names = tuple("abcdefghij"[:figures])
    return Misses(
        WellFriction(0.1), names, {"torque": np.tile(torque * wave, (3, 1)), "bit speed": np.tile(bit * wave, (3, 1))}
    )


def test_the_gain_in_time_is_the_fall_of_the_rms_with_the_spread_of_the_cycles() -> None:
    value, low, high = gain(misses(4.0, 40.0, 1), misses(2.0, 41.0, 2, seed=1), "torque")
    assert value == pytest.approx(2.0, abs=0.4)
    assert 0 < low < value < high
    value, low, high = gain(misses(4.0, 40.0, 1), misses(2.0, 41.0, 2, seed=1), "bit speed")
    assert value < 0
    same = misses(4.0, 40.0, 1)
    assert gain(same, same, "torque") == (0.0, 0.0, 0.0)


def test_further_figures_must_pay_their_price() -> None:
    base = misses(4.0, 40.0, 1)
    assert log_odds(base, misses(3.9, 39.0, 4)) < 0
    assert log_odds(base, misses(1.0, 10.0, 4)) > 5


def test_rows_of_a_wells_verdicts_keep_all_that_they_say(tmp_path: Path) -> None:
    said = [
        Verdict("none", "", 0.7, 1000.0, 1100.0, evidence="chance 0.5"),
        replace(LAG, verdict="clock_offset|drive_lag", evidence="linear"),
    ]
    verdict_table("W1", said).to_csv(tmp_path / "verdicts.csv", index=False)
    with kept_figures() as figures:
        part = discoveries_wells.discover(tmp_path, tmp_path)
    assert [one.verdict for one in part.rows] == ["none", "clock_offset|drive_lag"]
    rows = table(part.rows)
    assert tuple(rows.columns) == COLUMNS
    assert rows["class"].tolist() == ["", "clock_offset|drive_lag"]
    assert rows.loc[1, ["size", "size_low", "gain_high", "gain_unit", "held_out"]].tolist() == [
        *(LAG.size, LAG.size_low, LAG.predictive_gain_high),
        *("log score a window", "12 windows in turn"),
    ]
    assert rows.loc[0, "gain_unit"] == ""
    (axis,) = figures[0].axes
    assert part.figures == (tmp_path / "wells.png",)
    assert part.figures[0].read_bytes().startswith(b"\x89PNG")
    assert (axis.get_xlabel(), axis.get_ylabel()) == ("hole depth, m", "W1")
    bars = [(bar.get_x(), bar.get_width()) for bar in axis.patches if isinstance(bar, Rectangle)]
    assert bars == [(1000.0, 100.0), (LAG.from_m, LAG.to_m - LAG.from_m)]
    words = [each.get_text().strip() for each in axis.texts]
    assert words == ["none (0.7)", f"clock_offset|drive_lag (1), {LAG.size:.3g} s"]
    text = printed(part.rows)
    assert "0.0494 (0.0489 to 0.0499) s" in text
    assert "To separate: a sweep to higher frequency." in text


def test_absent_data_are_said_and_the_table_is_written_all_the_same(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    nowhere = tmp_path / "nowhere"
    for module in (discoveries_motor_rows, discoveries_field_rows):
        monkeypatch.setattr(module, "DATA", nowhere)
    monkeypatch.setattr(discoveries_wells, "LOGS", nowhere)
    discoveries.main(wells=nowhere, results=tmp_path)
    said = capsys.readouterr().out
    for absent in ("the wells' logs are not at", "the motor's record is not at", "the field log is not at"):
        assert f"absent: {absent}" in said
    written = pd.read_csv(tmp_path / "discoveries.csv")
    assert tuple(written.columns) == COLUMNS
    assert written.empty


def test_wells_that_were_not_run_are_asked_for(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(discoveries_wells, "LOGS", tmp_path)
    assert "make rigs" in discoveries_wells.discover(tmp_path, tmp_path / "none").absent


def test_a_row_without_size_and_gain_shows_none() -> None:
    text = printed([Discovery("here", "none", 0.5, "quiet")])
    assert "nan" not in text
