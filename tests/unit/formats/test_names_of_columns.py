"""Names of columns as public sets of drilling data and recorders write them."""

from pathlib import Path

import pytest

from drillid.config.rig import Clock, LogFile
from drillid.formats import read_log
from drillid.formats.mnemonics import channel_column, is_unit, units_at_ends
from drillid.inspection.contents import contents
from drillid.units import to_si_factor

WITH_UNITS = "Time s,Averaged RPM rpm,Average Surface Torque kN.m,Total Depth m,Gas (avg) %,Rig Mode unitless,well"
RECORDER = "YYYY/MM/DD,HH:MM:SS,Hole Depth (meters),Top Drive Torque (kN_m),Top Drive Rotary (RPM)"


def saved(tmp_path: Path, names: str, cells: str) -> Path:
    """Thirty rows; `cells` of each with its second as {s:02d}."""
    path = tmp_path / "log.csv"
    path.write_text(names + "\n" + "".join(cells.format(s=second) + "\n" for second in range(30)))
    return path


def test_units_behind_names_are_read(tmp_path: Path) -> None:
    path = saved(tmp_path, WITH_UNITS, "2025-03-04T06:00:{s:02d}.000Z,12{s:02d},12.5,2000.{s:02d},0.02,1,A-12")
    log = read_log(path, None, ["Average Surface Torque kN.m", "Total Depth m", "Rig Mode unitless"])
    assert log.units == {"Average Surface Torque kN.m": "kN.m", "Total Depth m": "m"}
    assert any("'Gas (avg) %' are read as units, '%'" in what for what, _ in log.notes)
    found = contents(path, Clock(), LogFile())[0].channels
    assert {name: (guess.column, guess.unit, guess.guessed) for name, guess in found.items()} == {
        "torque_command": ("Average Surface Torque kN.m", "kN.m", False),
        "speed": ("Averaged RPM rpm", "rpm", False),
        "hole_depth": ("Total Depth m", "m", False),
    }


def test_a_word_that_is_a_unit_is_none_where_other_names_have_none() -> None:
    assert units_at_ends(["Time", "Top Drive RPM", "Torque Limit", "Bit Depth", "Hook Load"]) == {}
    assert units_at_ends(["Time", "Bit Depth m", "Torque kNm"]) == {}
    assert units_at_ends(["Time", "Mud Flow In", "Mud Density In", "mud temp in", "Drive A", "Drive T"]) == {}
    assert units_at_ends(["Time s", "Flow In", "Gas %", "Rate 1/min", "Bit Depth m"]) == {
        "Time s": "s",
        "Gas %": "%",
        "Rate 1/min": "1/min",
        "Bit Depth m": "m",
    }


def test_units_of_products_and_quotients_in_brackets_are_read(tmp_path: Path) -> None:
    path = saved(tmp_path, RECORDER, "2025/03/04,06:00:{s:02d},184.{s:02d},3.{s:02d},110")
    found = contents(path, Clock(), LogFile())[0].channels
    assert found["torque_command"].unit == "kN_m"
    assert found["speed"].column == "Top Drive Rotary (RPM)"


def test_a_unit_at_a_names_end_that_is_stated_beside_it_leaves_the_name_whole(tmp_path: Path) -> None:
    path = saved(tmp_path, "Time,Surf_RPM,TQA\nUTC,rpm,kN.m", "2025-03-04T06:00:{s:02d}Z,12{s:02d},12.5")
    assert contents(path, Clock(), LogFile())[0].channels["speed"].column == "Surf_RPM"


def test_rates_with_per_in_their_unit_are_known() -> None:
    assert is_unit("m_per_hr")
    assert to_si_factor("m_per_hr", "m/s") == pytest.approx(1 / 3600)


def test_the_position_of_the_block_is_no_depth_of_the_bit() -> None:
    assert channel_column("bit_depth", ["TIME", "BPOS", "TQA"]) is None
