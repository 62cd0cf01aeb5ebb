"""Each fault of a column's unit, sign or choice is a row with a remedy; impossible channels are not used."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from hypothesis import given
from hypothesis import strategies as st

from drillid.config.rig import CHANNEL_UNITS, Channel, Rig
from drillid.config.settings import Settings
from drillid.errors import LogError
from drillid.records.mapping import MappedColumn
from drillid.records.plausibility import CHECKS, RANGES, possible_values, unit_remedy
from drillid.records.stage import Record, regular_record
from drillid.units import to_si_factor
from tests.raw_logs import RATE, RIG, START, drilling, save, standstill

LOG = pd.concat(
    [drilling(400), standstill(30, START + pd.Timedelta(seconds=400), 2004.8), drilling(60, 2, 2004.8)],
    ignore_index=True,
).assign(Time=START + pd.to_timedelta(np.arange(490 * 50) * 20, unit="ms"))
MISSING = np.nan


def rig(**units: str) -> Rig:
    """The rig of the log with other units."""
    channels = {
        name: column.model_copy(update={"unit": units.get(name, column.unit)}) for name, column in RIG.channels.items()
    }
    return RIG.model_copy(update={"channels": channels})


def record(tmp_path: Path, log: pd.DataFrame = LOG, described: Rig = RIG) -> Record:
    return regular_record(save(log, tmp_path / "log.parquet"), described, Settings().records)


def test_a_log_in_good_order_is_not_questioned(tmp_path: Path) -> None:
    assert record(tmp_path).notes == ()


QUESTIONED = {
    "speed in rad/s as rpm": (
        LOG.assign(RPM=LOG["RPM"] * np.pi / 30),
        RIG,
        ["speed is 1.317 rad/s while the string turns", "0.105 times its set point"],
        "If the column 'RPM' holds rad/s it is 12.58 rad/s: write unit: rad/s",
    ),
    "flow in L/min as gal/min": (LOG, rig(flow="gal/min"), ["flow is 0.1703"], "If the column 'FLOW' holds L/min"),
    "sweep in kN m as thousands of ft-lbf": (
        LOG.assign(SWEEP=LOG["SWEEP"] * 1e3),
        rig(torque_sweep="ft-lbf"),
        ["changes exactly 0.738 times as much as the sweep"],
        "1 ft-lbf is 1.356 N m",
    ),
    "sign of the sweep": (LOG.assign(SWEEP=-LOG["SWEEP"]), RIG, ["the speed moves against the sweep"], "signs"),
    "sign of the speed": (
        LOG.assign(RPM=-LOG["RPM"], SET=-LOG["SET"]),
        RIG,
        ["the drive takes power out of the string", "the speed moves against the sweep"],
        "sign of torque command or speed",
    ),
    "a speed that is another column": (
        LOG.assign(RPM=np.where(LOG["RPM"] > 9, np.random.default_rng(1).normal(120, 2, len(LOG)), 0.0)),
        RIG,
        ["the speed does not move with the sweep"],
        "columns",
    ),
    "a log of 1 Hz": (LOG.iloc[::50], RIG, ["usable only up to 0.4 Hz"], "at the rate of its recorder"),
    "bit a little too deep": (LOG.assign(BIT=LOG["BIT"] + 40), RIG, ["the bit is 12.2 m below"], "1 m is 3.28 ft"),
    "bit a little too shallow": (
        LOG.assign(BIT=LOG["BIT"] - 40),
        RIG,
        ["deepens while the bit is 12.2 m above"],
        "1 m is 3.28 ft",
    ),
    "hole decreasing": (
        LOG.assign(HOLE=LOG["HOLE"] - np.where(LOG.index > 20_000, 30.0, 0.0)),
        RIG,
        ["the depth of the hole decreases by 9.1 m at 2025-03-03T06:06:4"],
        "may hold the bit depth",
    ),
    "hole jumping": (
        LOG.assign(HOLE=LOG["HOLE"] + np.where(LOG.index > 21_000, 30.0, 0.0)),
        RIG,
        ["increases by 9.1 m within a second at 2025-03-03T06:07:0"],
        "its unit may change within the log",
    ),
    "9000 ft given as m": (
        LOG.assign(HOLE=LOG["HOLE"] + 2500, BIT=LOG["BIT"] + 2500),
        rig(hole_depth="m", bit_depth="m"),
        ["hole_depth is 9071 m", "bit_depth is 9071 m"],
        "If the column 'HOLE' holds ft it is 2765 m: write unit: ft",
    ),
    "a fast hole": (
        LOG.assign(HOLE=6562 + (LOG["HOLE"] - 6562) * 5, BIT=6562 + (LOG["BIT"] - 6562) * 5),
        RIG,
        ["the hole deepens at 216 m/h"],
        "it may be ft",
    ),
}


@pytest.mark.parametrize("fault", QUESTIONED)
def test_an_unusual_log_is_used_and_questioned(fault: str, tmp_path: Path) -> None:
    log, described, sentences, remedy = QUESTIONED[fault]
    found = record(tmp_path, log, described)
    for sentence in sentences:
        assert sum(sentence in what for what, _ in found.notes) == 1, found.notes
    assert any(remedy in advice for _, advice in found.notes), found.notes
    assert len(found.notes) == len(sentences), found.notes
    assert found.samples.sizes["time"] == len(log)


REFUSED = {
    "speed in rpm as rad/s": (LOG, rig(speed="rad/s"), "119.9 rad/s.*write unit: rpm"),
    "bit depth in ft as m": (LOG, rig(bit_depth="m"), r"the bit is 456\d.\d m below the bottom of the hole.*3.28"),
    "hole depth in ft as m": (LOG, rig(hole_depth="m"), r"deepens while the bit is 456\d.\d m above its bottom.*3.28"),
    "sweep in kN m as N m": (LOG, rig(torque_sweep="N m"), r"1e\+03 times as much as the sweep.*write unit: kN m"),
    "command in kN m as N m": (LOG, rig(torque_command="N m"), "0.001 times as much as the sweep.*'TQ' holds kN m"),
    "both in kN m as N m": (
        LOG,
        rig(torque_command="N m", torque_sweep="N m"),
        r"an inertia of 0.7\d+ kg m².*'SWEEP' holds kN m",
    ),
    "sweep in N m as kN m": (LOG.assign(SWEEP=LOG["SWEEP"] * 1e3), RIG, "torque_sweep, column 'SWEEP' in kN m, is"),
    "a negative depth": (
        LOG.assign(HOLE=-LOG["HOLE"]),
        RIG,
        "hole_depth, column 'HOLE' in ft, is 200.* outside -50",
    ),
    "a hole as fast as a fall": (
        LOG.assign(HOLE=LOG["HOLE"] + LOG.index * 0.05, BIT=LOG["BIT"] + LOG.index * 0.05),
        RIG,
        "the hole deepens at 2786 m/h",
    ),
}


@pytest.mark.parametrize("fault", REFUSED)
def test_a_log_whose_channels_cannot_be_is_refused(fault: str, tmp_path: Path) -> None:
    log, described, message = REFUSED[fault]
    with pytest.raises(LogError, match=message):
        record(tmp_path, log, described)


def test_an_impossible_optional_channel_is_dropped_and_said(tmp_path: Path) -> None:
    found = record(tmp_path, described=rig(flow="m^3/s"))
    assert [(what[:48], remedy[:56]) for what, remedy in found.notes] == [
        ("flow, column 'FLOW' in m^3/s, is 2700 m^3/s in t", "If the column 'FLOW' holds L/min it is 0.045 m^3/s: writ")
    ]
    assert "the channel is not used" in found.notes[0][0]
    assert np.isnan(found.samples["flow"]).all()


def test_codes_of_a_recorder_are_missing_values_and_the_rest_is_used(tmp_path: Path) -> None:
    log = LOG.assign(
        FLOW=LOG["FLOW"].where(LOG.index % 2 == 0, -32768.0), RPM=LOG["RPM"].where(LOG.index != 777, 65535.0)
    )
    found = record(tmp_path, log)
    assert [what.split(" are outside")[0] for what, _ in found.notes] == [
        "1 values of speed",
        "12250 values of flow",
        "1 rows hold no speed",
    ]
    np.testing.assert_allclose(found.samples["flow"][:19_900], 0.045, rtol=1e-6)
    assert found.samples["speed"].values[777] == pytest.approx(float(LOG["RPM"].iloc[777]) * np.pi / 30, abs=0.15)


@pytest.mark.parametrize(
    ("share", "kept"), [(0.0, True), (0.19, True), (0.21, False), (1.0, False)], ids=["none", "few", "many", "all"]
)
def test_the_share_of_impossible_values_decides(share: float, kept: bool) -> None:
    values = np.full(1000, 12.0)
    values[: round(1000 * share)] = np.linspace(100, 200, round(1000 * share))
    column = MappedColumn("FLOW", "m^3/s")
    found, notes = possible_values("flow", values / 100, column, "log")
    assert (found is not None) == kept
    assert bool(notes) == (share > 0)
    if found is not None:
        assert np.isnan(found).sum() == round(1000 * share)


@given(
    st.sampled_from(sorted(RANGES)), st.sampled_from(["N m", "kN m", "ft-lbf", "rpm", "psi", "bar", "t", "klbf", "ft"])
)
def test_the_unit_that_was_meant_is_named(name: Channel, meant: str) -> None:
    """A typical level in another unit, taken for SI, is either usual or leads back to a usual level."""
    si = CHANNEL_UNITS[name]
    try:
        factor = to_si_factor(meant, si)
    except ValueError:
        return
    read = RANGES[name].typical / factor
    low, high = RANGES[name].usual
    if not low <= read <= high:
        remedy = unit_remedy(name, read, MappedColumn("C", si))
        assert remedy.startswith("If the column 'C' holds ")
        unit = remedy.split(" holds ")[1].split(" it is ")[0]
        assert low <= read * to_si_factor(unit, si) <= high


def test_every_channel_has_a_range_and_every_bound_a_reason() -> None:
    assert set(RANGES) == set(CHANNEL_UNITS)
    for bounds in RANGES.values():
        assert bounds.possible[0] < 0 < bounds.usual[0] < bounds.typical < bounds.usual[1] < bounds.possible[1]
        assert bounds.reason
    for check in CHECKS:
        assert check.possible[0] <= check.usual[0] < check.usual[1] <= check.possible[1], check.name
        assert check.reason
        assert check.remedy
    assert len({check.name for check in CHECKS}) == len(CHECKS)


@pytest.mark.parametrize(
    "change",
    [
        lambda log: log.iloc[:10],
        lambda log: log.assign(SWEEP=0.0),
        lambda log: log.assign(RPM=0.0, TQ=0.0),
        lambda log: log.assign(HOLE=0.0, BIT=0.0),
        lambda log: log.assign(TQ=np.nan, SET=np.nan, BIT=np.nan, FLOW=np.nan),
        lambda log: log.assign(RPM=log["RPM"].where(log.index % 700 == 0)),
        lambda log: log.assign(HOLE=log["HOLE"].where(log.index % 2000 == 0)),
    ],
    ids=["ten rows", "no sweep", "standstill", "no depth", "no optional value", "hardly a speed", "hardly a depth"],
)
def test_what_a_log_does_not_show_is_not_judged(change: Callable[[pd.DataFrame], pd.DataFrame], tmp_path: Path) -> None:
    log = change(LOG)
    notes = record(tmp_path, log).notes
    assert not [what for what, _ in notes if "usual" in what or "speed moves" in what], notes
    assert RATE == 50
