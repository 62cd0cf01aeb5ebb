"""The field well's log is as documented, and the model's misfit is below that of the authors' own simulation."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import typer

from benchmarks.field import start_up as field
from benchmarks.field.log import FieldLog, read_field_log
from benchmarks.field.start_up import DATA, JITTER, LADDER, jittered_misfits, run, simulated_misfit, table, write
from drillid.simulation.start_up import RATE, TIME_STEP
from drillid.simulation.start_up_fit import misfit
from tests.drawn import check_visible, kept_figures, line


@pytest.fixture(scope="module")
def log() -> FieldLog:
    if not DATA.is_file():
        pytest.skip(f"the field log is not at {DATA}")
    return read_field_log(DATA)


@pytest.mark.parametrize(
    ("series", "mean", "peak_to_peak", "frequency"),
    [("torque", 13.1, 24.5, 0.261), ("authors_torque", 15.2, 25.9, 0.270)],
)
def test_torques_from_12_to_48_s_are_as_documented(
    log: FieldLog, series: str, mean: float, peak_to_peak: float, frequency: float
) -> None:
    """Mean and peak to peak in kN m, and the frequency of the main line in Hz."""
    torque = getattr(log, series)[1200:4800] / 1e3
    assert torque.mean() == pytest.approx(mean, abs=0.05)
    assert np.ptp(torque) == pytest.approx(peak_to_peak, abs=0.05)
    length = 16 * torque.size
    lines = np.abs(np.fft.rfft((torque - torque.mean()) * np.hanning(torque.size), length))
    assert np.fft.rfftfreq(length, 1 / RATE)[lines.argmax()] == pytest.approx(frequency, abs=0.001)


def test_the_misfit_of_the_last_model_is_less_than_half_of_the_authors(log: FieldLog) -> None:
    """Also with slightly different friction."""
    torque, bit, _ = np.sqrt(np.mean(jittered_misfits(list(LADDER.values())[-1][0], log) ** 2, axis=0))
    authors = misfit(log, log.authors_torque, log.authors_bit_speed)
    assert torque < 0.5 * authors.torque_rms
    assert bit < 0.5 * authors.bit_rms


def test_each_part_of_the_model_reduces_the_misfit_also_with_slightly_different_friction(log: FieldLog) -> None:
    misses = [np.mean((jittered_misfits(friction, log)[:, :2] / (1.9, 21.0)) ** 2) for friction, _ in LADDER.values()]
    assert np.all(np.diff(misses) < 0)
    assert misses[-1] < 0.5 * misses[-2]


def test_the_misfit_does_not_depend_on_the_time_step(log: FieldLog) -> None:
    friction = list(LADDER.values())[-1][0]
    coarse, fine = (simulated_misfit(log, run(friction, log, step)) for step in (TIME_STEP, TIME_STEP / 2))
    assert coarse.torque_rms == pytest.approx(fine.torque_rms, abs=0.1)
    assert coarse.bit_rms == pytest.approx(fine.bit_rms, abs=1.0)


def test_the_misfit_beyond_the_fitted_interval_is_small_too(log: FieldLog) -> None:
    """Until the string begins to move axially at 50 s."""
    simulated = run(list(LADDER.values())[-1][0], log)
    result = misfit(log, simulated.torque, simulated.recorded_bit_speed(), 45.0, 50.0)
    authors = misfit(log, log.authors_torque, log.authors_bit_speed, 45.0, 50.0)
    assert result.torque_rms < 0.6 * authors.torque_rms
    assert result.bit_rms < 0.5 * authors.bit_rms


def test_table_and_files_agree(log: FieldLog, tmp_path: Path) -> None:
    friction = list(LADDER.values())[-1][0]
    with kept_figures() as figures:
        write(log, friction, tmp_path)
    content = json.loads((tmp_path / "field.json").read_text())
    torque, bit, _ = jittered_misfits(friction, log)[JITTER.index(1.0)]
    assert content["torque_rms_knm"] == pytest.approx(torque)
    assert content["bit_rms_rpm"] == pytest.approx(bit)
    assert replace(friction, **content["parameters"]) == friction
    drawn_torque, drawn_speed = figures[0].axes
    simulated = run(friction, log)
    np.testing.assert_allclose(line(drawn_torque, "measured")[1], log.torque / 1e3)
    np.testing.assert_allclose(line(drawn_torque, "simulated")[1], simulated.torque / 1e3)
    assert drawn_torque.get_ylabel() == "drive torque, kN m"
    assert drawn_speed.get_ylabel().startswith("bit speed, rpm")
    assert drawn_speed.get_xlabel() == "time, s"
    check_visible(figures[0])
    assert f"{torque:7.2f}" in table(log)


def test_a_missing_log_is_named_and_ends_with_a_failure(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    missing = tmp_path / "none.csv"
    monkeypatch.setattr(field, "DATA", missing)
    with pytest.raises(typer.Exit) as ended:
        field.main()
    assert ended.value.exit_code == 1
    assert str(missing) in capsys.readouterr().err
