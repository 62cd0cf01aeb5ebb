"""The same log in every shape is the same record, end to end, by the description that a user would write."""

from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from drillid.config.files import parse_yaml
from drillid.config.listing import Well
from drillid.config.rig import Clock, LogFile, Rig
from drillid.config.settings import Settings
from drillid.datasets.memory import WellInMemory
from drillid.inspection.inspect import inspect
from drillid.records.stage import process
from drillid.units import to_si_factor
from tests.unit.formats.numbers import LOG, UNITS
from tests.unit.formats.shapes import CHANNELS, SHAPES, Shape

DRAFTED = (
    *("LAS with date and time apart", "WITSML 1.4.1.1", "TDMS waveforms", "workbook", "German office"),
    *("MAT 5, datenum", "seconds from a start"),
)


@pytest.mark.parametrize("name", SHAPES)
def test_the_record_is_the_same_in_every_shape(name: str, tmp_path: Path) -> None:
    shape = SHAPES[name]
    rig = Rig.checked({"name": "R", "channels": CHANNELS, **shape.description}, "rig.yaml")
    told = compared(
        shape.write(moved(shape), tmp_path), rig, moved(shape), 0.006 if name == "slow depth apart" else 0.0
    )
    for words in shape.told:
        assert any(words in what for what in told), told


@pytest.mark.parametrize("name", DRAFTED)
def test_the_drafted_description_reads_it_as_well(name: str, tmp_path: Path) -> None:
    shape = SHAPES[name]
    files = shape.write(moved(shape), tmp_path)
    clock = Clock.checked(shape.description.get("time", {}), "what the user knows")
    text = inspect(files, "R", clock, LogFile(), Settings()).draft
    compared(files, Rig.checked(parse_yaml(text, "draft"), "draft"), moved(shape))


def moved(shape: Shape) -> pd.DataFrame:
    """The log at the shape's time."""
    return LOG.assign(Time=LOG["Time"] + (shape.start - LOG["Time"].iloc[0]))


def compared(files: list[Path], rig: Rig, log: pd.DataFrame, apart: float = 0.0) -> list[str]:
    """What the records' stage tells, having made the log's record of the files; `apart`: error of depths, m."""
    folders = WellInMemory(name="W")
    told = [problem.what for problem in process(Well("W", rig, tuple(files)), folders, Settings())]
    assert folders.has("records", "records"), told
    records = folders.read("records", "records")
    off = np.abs((records["time"].values - log["Time"].to_numpy()) / np.timedelta64(1, "ns"))
    assert off.max() < 2000, "within the resolution of serial dates"
    for channel, column in CHANNELS.items():
        si = {"torque": "N m", "speed": "rad/s", "flow": "m^3/s"}.get(channel.split("_")[0], "m")
        expected = log[column["column"]].to_numpy() * to_si_factor(UNITS[column["column"]], si)
        found = records[channel].values
        np.testing.assert_allclose(found, expected, rtol=2e-6, atol=apart + 1e-5 * np.ptp(expected), err_msg=channel)
    return told
