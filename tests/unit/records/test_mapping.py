"""Columns become channels by the description, by mnemonics of WITS and by the file's own units; decisions are told."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from drillid.config.rig import Rig
from drillid.errors import LogError
from drillid.records.channels import RawChannels, read_channels

DEPTH = [2000 + row / 100 for row in range(60)]
CHANNELS = {
    "torque_sweep": {"column": "SWEEP", "unit": "kN m"},
    "speed": {"column": "RPM", "unit": "rpm"},
    "hole_depth": {"column": "DMEA", "unit": "m"},
}


def rig(**keys: Any) -> Rig:
    return Rig.checked({"name": "R", "channels": CHANNELS, **keys}, "rig")


def channels(path: Path, description: Rig) -> tuple[RawChannels, list[str]]:
    raw = read_channels(path, description)
    return raw, [what for what, _ in raw.notes]


def written(folder: Path, names: str, cells: str = "1.5,120,{depth}", head: str = "", stamp: str = "") -> Path:
    """A log of 60 rows, one a second."""
    times = [stamp.format(row=row, seconds=f"{row:02d}") or f"2025-03-03T06:00:{row:02d}Z" for row in range(60)]
    rows = "".join(f"{time},{cells.format(depth=depth)}\n" for time, depth in zip(times, DEPTH, strict=True))
    path = folder / "log.csv"
    path.write_text(f"{head}{names}\n{rows}")
    return path


def test_channels_that_are_not_named_are_taken_by_their_mnemonics_in_wits(tmp_path: Path) -> None:
    own = {name: CHANNELS[name] for name in ("torque_sweep",)}
    names = "Time,SWEEP,RPMA,DMEA (ft),DBTM (ft),WOBA (klbf),MFIA (gpm),SPPA (psi),HKLA (klbf),TQA (kft-lb)"
    path = written(tmp_path, names, "1.5,120,{depth},{depth},20,600,3000,250,10")
    raw, notes = channels(path, rig(channels=own))
    held = {name: float(values[0]) for name, values in raw.channels.items()}
    expected = {
        "torque_command": 13558.18,
        "torque_sweep": 1500.0,
        "speed": 4 * np.pi,
        "hole_depth": 609.6,
        "bit_depth": 609.6,
        "weight_on_bit": 88964.4,
        "flow": 600 * 6.30902e-5,
        "standpipe_pressure": 2.0684e7,
        "hook_load": 1112055.0,
    }
    assert held == pytest.approx(expected, rel=1e-4)
    assert "speed is taken from column 'RPMA' in rpm, named by its mnemonic in WITS" in notes
    assert len(notes) == len(expected) - 1


def test_a_mnemonic_yields_to_the_description_and_can_be_left_out(tmp_path: Path) -> None:
    path = written(tmp_path, "Time,SWEEP,RPM,DMEA,RPMA,HKLA (t)", "1.5,120,{depth},7,80")
    raw, notes = channels(path, rig(channels=CHANNELS | {"hook_load": None}))
    assert raw.channels.keys() == CHANNELS.keys()
    assert raw.channels["speed"][0] == pytest.approx(4 * np.pi)
    assert notes == []


def test_a_mnemonic_without_unit_or_without_numbers_is_told_and_not_used(tmp_path: Path) -> None:
    path = written(tmp_path, "Time,SWEEP,RPM,DMEA,HKLA,SPPA (kN),WOBA (t)", "1.5,120,{depth},80,3,n/a!")
    raw, notes = channels(path, rig())
    assert raw.channels.keys() == CHANNELS.keys()
    told = [
        "but has no unit; it is not used",
        "but is in 'kN', which is not a unit of standpipe_pressure",
        "'n/a!' is not",
    ]
    for what in told:
        assert sum(what in note for note in notes) == 1, notes


def test_a_needed_channel_that_only_its_mnemonic_shows_must_have_a_unit(tmp_path: Path) -> None:
    own = {name: CHANNELS[name] for name in ("torque_sweep", "speed")}
    with pytest.raises(LogError, match=r"column 'DMEA': is hole_depth by its mnemonic in WITS, and has no unit"):
        channels(written(tmp_path, "Time,SWEEP,RPM,DMEA"), rig(channels=own))
    with pytest.raises(LogError, match=r"no column known to hold hole_depth; its columns are 'Time', 'SWEEP'"):
        channels(written(tmp_path, "Time,SWEEP,RPM,D"), rig(channels=own))


def test_units_are_the_files_own_where_the_description_is_silent(tmp_path: Path) -> None:
    own = {name: {"column": column["column"]} for name, column in CHANNELS.items()}
    path = written(tmp_path, "Time,SWEEP,RPM,DMEA\ns,kft.lbf,c/min,ft")
    raw, notes = channels(path, rig(channels=own))
    assert raw.channels["hole_depth"][0] == pytest.approx(609.6)
    assert raw.channels["torque_sweep"][0] == pytest.approx(2033.7, rel=1e-4)
    assert notes == ["the units are taken from line 2"]
    with pytest.raises(LogError, match="has no unit, neither in the file nor in the rig description's channel torque"):
        channels(written(tmp_path, "Time,SWEEP,RPM,DMEA"), rig(channels=own))
    with pytest.raises(
        LogError, match="column 'SWEEP': has the unit 'bar' in the file, which is not a unit of torque_sweep"
    ):
        channels(written(tmp_path, "Time,SWEEP (bar),RPM (rpm),DMEA (m)"), rig(channels=own))


def test_a_unit_of_another_kind_in_the_file_is_told_and_the_described_one_taken(tmp_path: Path) -> None:
    raw, notes = channels(written(tmp_path, "Time,SWEEP (bar),RPM,DMEA"), rig())
    assert raw.channels["torque_sweep"][0] == pytest.approx(1500.0)
    assert notes == [
        "column 'SWEEP' has the unit 'bar' in the file, which is not a unit of torque_sweep; 'kN m' is used"
    ]


def test_whatever_a_reader_decides_is_told(tmp_path: Path) -> None:
    path = written(tmp_path, "Date;Time;SWEEP;RPM;DMEA", head="Well: A\nexported by nobody\n\n")
    path.write_text(
        path.read_text()
        .replace(",", ";")
        .replace("2025-03-03T", "24/03/2025;")
        .replace("Z;", ";")
        .replace("1.5", "1,5")
    )
    raw, notes = channels(path, rig(time={"zone": "Europe/Oslo"}))
    assert raw.stamps[0] == np.datetime64("2025-03-24T05:00", "ns").astype(np.int64)
    assert raw.channels["torque_sweep"][0] == 1500.0
    assert notes == [
        "the names of the columns are taken from line 4",
        "numbers such as '1,5' are read with a decimal comma",
        "the dates are taken from column 'Date'",
        "the dates in column 'Date' are read as day first, as one of them is '24/03/2025'",
    ]


@pytest.mark.parametrize(
    ("stamp", "time"),
    [
        ("{row}", {"start": "2025-03-03T07:00:00", "zone": "Europe/Oslo"}),
        ("{row}", {"start": "2025-03-03T06:00:00Z", "unit": "s"}),
        ("17409816{seconds}000", {"unit": "ms"}),
        ("06:00:{seconds}", {"start": "2025-03-03"}),
        ("03/03/25 06:00:{seconds}", {"format": "%d/%m/%y %H:%M:%S"}),
        ("3.3.2025 06h00 {seconds}", {"format": "%d.%m.%Y %Hh%M %S", "column": "Stamp"}),
    ],
)
def test_times_are_as_the_description_states_them(stamp: str, time: dict[str, str], tmp_path: Path) -> None:
    path = written(tmp_path, f"{time.get('column', 'Time')},SWEEP,RPM,DMEA", stamp=stamp)
    raw, _ = channels(path, rig(time=time))
    start = np.datetime64("2025-03-03T06:00", "ns").astype(np.int64)
    assert (raw.stamps == start + np.arange(60) * 1_000_000_000).all()


def test_the_layout_is_as_the_description_states_it(tmp_path: Path) -> None:
    path = tmp_path / "log.csv"
    rows = "".join(f"2025-03-03T06:00:{row:02d}Z|1.500,5|120|{depth}|-1\n" for row, depth in enumerate(DEPTH))
    path.write_text("! 1\n" + rows.replace(".", "").replace("1500,5", "1.500,5"))
    layout = {"delimiter": "|", "decimal": ",", "thousands": ".", "comment": "!", "null_values": [-1]}
    layout["columns"] = ["Time", "SWEEP", "RPM", "DMEA", "TQA (kN m)"]
    wide = CHANNELS | {
        "torque_sweep": {"column": "SWEEP", "unit": "N m"},
        "hole_depth": {"column": "DMEA", "unit": "mm"},
    }
    raw, _ = channels(path, rig(channels=wide, file=layout))
    assert raw.channels["torque_sweep"][0] == pytest.approx(1500.5)
    assert "torque_command" not in raw.channels, "-1 stands for a missing value"
