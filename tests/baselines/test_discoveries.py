"""The status quo of verdicts on the motor bench and the field start: what their gains do and do not show.

Nobody documents what is wrong with these simulations, so nothing here is a truth; `make discoveries` prints the rows,
and their numbers are stored in motor_discoveries.json and field_discoveries.json (`python -m tests.baselines.make`).
"""

from pathlib import Path

import numpy as np
import pytest
from matplotlib.patches import Rectangle

from benchmarks.discoveries import motor_fit as motor
from benchmarks.discoveries.field import Misses, log_odds
from benchmarks.discoveries.field_rows import CONTACT, REST, SOLID, STIFFER, field_rows, parts
from benchmarks.discoveries.figures import draw_field, draw_motor
from benchmarks.discoveries.motor import MotorExamined
from benchmarks.discoveries.motor_rows import motor_rows
from benchmarks.discoveries.rows import Discovery
from benchmarks.field import start_up as field
from benchmarks.field.log import FieldLog
from drillid.units import RPM
from tests.baselines.values import examined_motor, simulated_field
from tests.drawn import check_visible, kept_figures, line


@pytest.fixture(scope="module")
def examined() -> MotorExamined:
    if not motor.DATA.is_file():
        pytest.skip(f"the motor's record is not at {motor.DATA}")
    return examined_motor()


@pytest.fixture(scope="module")
def log() -> FieldLog:
    if not field.DATA.is_file():
        pytest.skip(f"the field log is not at {field.DATA}")
    return simulated_field()[0]


@pytest.fixture(scope="module")
def found(log: FieldLog) -> dict[str, Misses]:
    return simulated_field()[1]


@pytest.fixture(scope="module")
def rows(log: FieldLog, found: dict[str, Misses]) -> tuple[Discovery, ...]:
    return field_rows(found, log)


def test_speed_leaves_a_class_that_the_angle_separates(examined: MotorExamined) -> None:
    speed, angle, rest = motor_rows(examined)
    assert speed.verdict == "drive_lag|recorder_filter"
    assert speed.gain[1] > 0
    assert angle.verdict == "recorder_filter"
    assert angle.gain[1] > 0.99
    assert examined.by_angle.evidence["drive_lag"] < 0
    assert rest.verdict == "unknown"


def test_the_coupling_softens_alike_in_both_balances(examined: MotorExamined) -> None:
    load, shaft = (examined.balances[f"softening, {side}"] for side in ("load", "motor"))
    assert load.relative < -3 * load.error
    assert shaft.relative == pytest.approx(load.relative, abs=3 * load.error)
    assert load.after < load.before


def test_friction_gains_on_held_out_time_only_beside_a_lighter_assembly(
    rows: tuple[Discovery, ...], found: dict[str, Misses]
) -> None:
    named = [one for one in rows if one.verdict == "coulomb_contact"]
    lighter = [one for one in rows if "inertia" in one.data]
    assert len(named) == len(lighter) == 2
    assert all(one.gain[1] > 0 for one in (*named, *lighter))
    for series in ("torque", "bit speed"):
        assert found[SOLID].rms(series, 45, 60) > 0.95 * next(iter(found.values())).rms(series, 45, 60)


def test_a_stiffer_pipe_does_not_stand_in_for_the_lighter_assembly(found: dict[str, Misses]) -> None:
    assert log_odds(found[STIFFER], found[CONTACT]) > 5
    assert log_odds(found[SOLID], found[STIFFER]) < log_odds(found[SOLID], found[CONTACT])


def test_friction_of_rest_is_not_said_to_gain_where_held_out_time_does_not_show_it(
    rows: tuple[Discovery, ...], found: dict[str, Misses]
) -> None:
    rest = [one for one in rows if "friction of rest" in one.data]
    assert all(one.verdict == "unknown" and one.gain[1] < 0 for one in rest)
    assert all("not sure to be one" in one.evidence for one in rest)
    table = parts(found)
    assert (table.loc[REST] < table.loc[CONTACT]).sum() >= 5


def test_intervals_hold_their_value_and_the_inertia_is_told(rows: tuple[Discovery, ...]) -> None:
    assert all(one.size[1] < one.size[0] < one.size[2] for one in rows)
    assert all(one.size[2] < 1 for one in rows if "inertia" in one.data)


def test_the_figures_are_drawn(
    examined: MotorExamined, log: FieldLog, found: dict[str, Misses], tmp_path: Path
) -> None:
    with kept_figures() as figures:
        draw_motor(examined, tmp_path / "motor.png")
        draw_field(log, found, tmp_path / "field.png")
    size, evidence, misfit, record = figures[0].axes
    assert [axis.get_ylabel() for axis in (size, misfit, record)] == [
        "mobility, rad/s per A",
        "misfit per response, even periods",
        "amplitude",
    ]
    assert misfit.get_xlabel() == record.get_xlabel() == "frequency, Hz"
    np.testing.assert_allclose(line(size, "by the angle")[1], np.abs(examined.angle[1].value))
    ratio = np.abs(examined.ratio[1].value)
    np.testing.assert_allclose(line(record, "recorded speed per derivative of the angle")[1], ratio)
    assert [label.get_text() for label in evidence.get_yticklabels()] == [*examined.by_speed.evidence, "unknown"]
    torque, bit, bars = figures[1].axes
    np.testing.assert_allclose(line(torque, "measured")[1], log.torque / 1e3)
    np.testing.assert_allclose(line(bit, "measured")[1], (log.bit_slowest + log.bit_fastest) / 2 / RPM)
    assert [torque.get_ylabel(), bit.get_ylabel()] == ["torque, kN m", "bit speed, rpm"]
    heights = [bar.get_height() for bar in bars.patches if isinstance(bar, Rectangle)]
    assert len(heights) == 4 * len(found)
    assert heights[:: len(found)] == pytest.approx([1.0] * 4)  # viscous drag by itself
    for figure in figures:
        check_visible(figure)
