"""What is wrong with a rig description is told with its key and what to do."""

from dataclasses import fields
from pathlib import Path
from typing import Any, get_args

import pytest
import yaml

from drillid.config import examples
from drillid.config.rig import CHANNEL_UNITS, Clock, LogFile, Rig
from drillid.errors import SettingsError
from drillid.formats import Dialect, TimeColumn
from drillid.formats.counted_times import COUNTED
from drillid.formats.mnemonics import MNEMONICS, SURE
from tests.workflow.toys import RIG

TOY = yaml.safe_load(RIG)
CHANNELS = TOY["channels"]
SWAPPED = {"outer_diameter": "100 mm", "inner_diameter": "110 mm"}


def changed(**keys: Any) -> dict[str, Any]:
    """The toy rig with other values; a key with None is left out."""
    return {key: value for key, value in {**TOY, **keys}.items() if value is not None}


COLLARS = {"outer_diameter": "8 in", "inner_diameter": "2.8125 in", "length": "60 m"}


@pytest.mark.parametrize(
    ("content", "what", "remedy"),
    [
        (
            changed(channels={"speed": CHANNELS["speed"]}),
            "'channels': torque_sweep is missing",
            "Map it to the log's column of the injected torque, with its unit",
        ),
        (
            changed(channels=CHANNELS | {"speed": None}),
            "'channels.speed': is needed and cannot be left out",
            "Map it to a column",
        ),
        (
            changed(other_logs=[{"files": "*_depth.csv", "channels": {"hole_depth": {"column": "D", "unit": "kN"}}}]),
            "'other_logs.0.channels.hole_depth.unit': column 'D': the unit 'kN' cannot be",
            "one of the kind of m",
        ),
        (
            changed(time={"format": "dd.mm.yyyy"}),
            "'time.format': 'dd.mm.yyyy' is neither 'day first' nor 'month first' nor a format of strptime",
            "'%d.%m.%Y %H:%M:%S'",
        ),
        (changed(time={"start": "3/3/2025"}), "'time.start': '3/3/2025' is not an ISO time", "2025-03-03T06:00:00"),
        (changed(time={"unit": "seconds"}), "'time.unit': Input should be 'ns', 'us', 'ms', 's'", "Correct the value"),
        (changed(file={"delimiter": "tabs"}), "'file.delimiter': 'tabs' is not one character", "Write one, or tab, "),
        (
            changed(file={"decimal": ",", "thousands": ","}),
            "'file.thousands': ',' is already the decimal separator",
            "Correct one of the two",
        ),
        (changed(file={"header_line": 0}), "'file.header_line': 0 should be greater than", "counted from 1"),
        (
            changed(channels=CHANNELS | {"speed": {"column": "RPM", "unit": "psi"}}),
            "'channels.speed.unit': column 'RPM': the unit 'psi' cannot be",
            "one of the kind of rad/s",
        ),
        (
            changed(pipe={"outer_diameter": "108.6 mm", "inner_diameter": "5 in"}),
            "'pipe': outer 108.6 mm is smaller than inner 127 mm: they are probably swapped",
            "Swap the values of 'outer_diameter' and 'inner_diameter'",
        ),
        (changed(collars=[SWAPPED | {"length": "1 m"}]), "'collars.0': outer 100 mm is smaller", "Swap the values"),
        (
            changed(collars=[COLLARS, COLLARS | {"outer_diameter": "6.5 in"}]),
            "'collars.1.from_depth': another run begins at 0 m as well",
            "collars of several sizes in one run are one entry",
        ),
        (changed(other_logs=[{"files": "."}]), "'other_logs.0.files': '.' is a folder", "depth/*.csv"),
        (changed(other_logs=[{"files": "depth/"}]), "'other_logs.0.files': 'depth/' is a folder", "depth/*.csv"),
        (changed(file={"null_values": [-999, float("nan")]}), "'file.null_values.1'", "Correct the value"),
        (
            changed(pipe={"outer_diameter": "5 in", "inner_diameter": "127 mm"}),
            "'pipe': outer and inner diameter are the same, 127 mm",
            "Correct one of the diameters",
        ),
        (changed(name=None), "the key 'name' is missing", "Add 'name'"),
        (changed(name=7), "'name': 7 is not text", "Put it in quotation marks"),
        (
            changed(drive_delay={"value": "-1 ms"}),
            "'drive_delay.value': -0.001 s is outside the range of rigs, 0 to 1 s",
            "Write a value within these bounds, with its unit",
        ),
        (
            changed(drive_delay={"value": 40}),
            "'drive_delay.value': 40 s is outside the range of rigs",
            "If another unit is meant, write it after the number: '40 ms'",
        ),
        (
            changed(pipe={"outer_diameter": 10, "inner_diameter": "4 in"}),
            "'pipe.outer_diameter': 10 m is outside the range of rigs, 0.02 to 0.8 m",
            "'10 in' or '10 cm'",
        ),
        (
            changed(controller={"proportional": "1.5e9 N m s/rad"}),
            "'controller.proportional': 1.5e+09 N m s/rad is outside the range of rigs, 0, or 10 to 1e+06 N m s/rad",
            "a million times too large for most rigs: check the prefix of its unit",
        ),
        (
            changed(controller={"proportional": 1.5}),
            "'controller.proportional': 1.5 N m s/rad is outside the range of rigs",
            "write it after the number: '1.5 kN m s/rad' or '1.5 kN m/rpm'",
        ),
        (
            changed(top_drive_inertia={"value": "1100 kg m^2", "relative": 5}),
            "'top_drive_inertia.relative': 5 is outside",
            "'5 %'",
        ),
        (changed(top_drive_inertia={"value": float("nan")}), "'top_drive_inertia.value': ", "Correct the value"),
        (changed(top_drive_inertia={"value": "inf kg m^2"}), "'top_drive_inertia.value': ", "Correct the value"),
        (["a", "list"], "top level: Input should be a valid dictionary", "known keys are channels, "),
    ],
)
def test_a_fault_names_its_key_and_a_remedy(content: Any, what: str, remedy: str) -> None:
    with pytest.raises(SettingsError) as error:
        Rig.checked(content, "toy.yaml")
    assert what in error.value.what
    assert remedy in error.value.remedy


def test_every_fault_is_told_with_its_remedy() -> None:
    with pytest.raises(SettingsError) as error:
        Rig.checked(changed(name=None, controler={}), "toy.yaml")
    assert error.value.what == "the key 'name' is missing; unknown key 'controler'"
    assert error.value.remedy == "Add 'name'. Did you mean 'controller'?"


@pytest.mark.parametrize(("depth", "length"), [(0.0, 90.0), (2999.9, 90.0), (3000.0, 100.0), (9000.0, 100.0)])
def test_collars_are_those_of_the_run_that_drills_at_a_depth(depth: float, length: float) -> None:
    size = {"outer_diameter": "165.1 mm", "inner_diameter": "71.4 mm"}
    collars = [size | {"length": "100 m", "from_depth": "3000 m"}, size | {"length": "90 m"}]
    found = Rig.checked(changed(collars=collars), "toy.yaml").collars_at(depth)
    assert found is not None
    assert found.length == length


def test_above_all_runs_there_are_no_collars() -> None:
    later = {"outer_diameter": "165.1 mm", "inner_diameter": "71.4 mm", "length": "90 m", "from_depth": "1000 m"}
    rig = Rig.checked(changed(collars=[later]), "toy.yaml")
    assert rig.collars_at(999.9) is None


def test_a_log_of_another_shape_has_its_own_description_and_the_rest_is_as_for_all() -> None:
    own = {"hole_depth": {"column": "Depth", "unit": "ft"}}
    others = [
        {"files": "*_Depth.csv", "channels": own, "time": {"zone": "Europe/Oslo"}},
        {"files": "slow/*.xlsx", "file": {"table": "data"}},
    ]
    rig = Rig.checked(changed(other_logs=others), "toy.yaml")
    depth, slow, usual = (rig.for_log(Path(name)) for name in ("a/W1_depth.CSV", "/b/slow/W1.xlsx", "slow.xlsx"))
    assert depth.channels.keys() == own.keys()
    assert depth.time.zone == "Europe/Oslo"
    assert depth.file == usual.file == rig.file
    assert (slow.file.table, slow.channels, slow.time) == ("data", rig.channels, rig.time)
    assert usual == rig.model_copy(update={"other_logs": ()})
    assert depth.for_log(Path("W1_depth.csv")) == depth


def test_users_can_state_whatever_readers_can_do() -> None:
    assert set(get_args(get_args(Clock.model_fields["unit"].annotation)[0])) == set(COUNTED)
    assert set(Clock.model_fields) - {"sample_rate"} == {field.name for field in fields(TimeColumn)}
    assert set(LogFile.model_fields) - {"ignore_units"} == {field.name for field in fields(Dialect)}
    assert LogFile(delimiter="tab").delimiter == "\t"
    assert set(SURE) <= set(MNEMONICS) <= set(CHANNEL_UNITS)
    assert {channel: SURE[channel][0] in MNEMONICS[channel] for channel in SURE} == dict.fromkeys(SURE, True)


@pytest.mark.parametrize("keys", examples.SHAPES.values())
def test_examples_in_the_documentation_are_valid(keys: str) -> None:
    Rig.checked(changed(**yaml.safe_load(keys)), "example")
