"""The same log in every shape is the same record, end to end, by the description that a user would write."""

from pathlib import Path

import numpy as np
import pytest

from drillid.config.rig import Rig
from drillid.config.settings import Settings
from drillid.config.sheets import Well
from drillid.datasets.memory import WellInMemory
from drillid.records.stage import process
from drillid.units import to_si_factor
from tests.unit.formats.numbers import LOG, UNITS
from tests.unit.formats.shapes import CHANNELS, SHAPES


@pytest.mark.parametrize("name", SHAPES)
def test_the_record_is_the_same_in_every_shape(name: str, tmp_path: Path) -> None:
    shape = SHAPES[name]
    log = LOG.assign(Time=LOG["Time"] + (shape.start - LOG["Time"].iloc[0]))
    rig = Rig.checked({"name": "R", "channels": CHANNELS, **shape.description}, "rig.yaml")
    folders = WellInMemory(name="W")
    problems = process(Well("W", rig, tuple(shape.write(log, tmp_path))), folders, Settings())
    told = [problem.what for problem in problems]
    assert folders.has("records", "records"), told
    records = folders.read("records", "records")
    off = np.abs((records["time"].values - log["Time"].to_numpy()) / np.timedelta64(1, "ns"))
    assert off.max() < 2000, "within the resolution of serial dates"
    for channel, column in CHANNELS.items():
        si = {"torque": "N m", "speed": "rad/s", "flow": "m^3/s"}.get(channel.split("_")[0], "m")
        expected = log[column["column"]].to_numpy() * to_si_factor(UNITS[column["column"]], si)
        apart = 0.006 if name == "slow depth apart" else 0.0
        found = records[channel].values
        np.testing.assert_allclose(found, expected, rtol=2e-6, atol=apart + 1e-5 * np.ptp(expected), err_msg=channel)
    for words in shape.told:
        assert any(words in what for what in told), told
