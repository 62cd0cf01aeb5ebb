"""Waveforms of TDMS: channels that start together or apart, and recordings that were appended."""

from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest
from nptdms import ChannelObject, TdmsWriter
from nptdms.reader import TdmsReader

from drillid.errors import LogError
from drillid.formats import Dialect, headers, read_log

STAMPS = pd.date_range("2025-03-03T06:00", periods=50, freq="20ms").as_unit("ns")
SPEED = np.linspace(119, 121, 50)
TORQUE = np.linspace(-1, 13, 50)


def tdms(path: Path, *segments: dict[str, tuple[str, np.ndarray]], interval: float = 0.02) -> Path:
    """A file of waveforms; each segment holds the start and the values of channels."""
    with TdmsWriter(path) as writer:
        for segment in segments:
            channels = [
                ChannelObject(
                    "Fast", name, values, {"wf_start_time": np.datetime64(start, "us"), "wf_increment": interval}
                )
                for name, (start, values) in segment.items()
            ]
            writer.write_segment(channels)
    return path


def test_waveforms_that_start_within_a_small_part_of_a_sample_are_one_table(tmp_path: Path) -> None:
    starts = ("2025-03-03T06:00:00", "2025-03-03T06:00:00.000150")
    path = tdms(tmp_path / "log.tdms", {"RPM": (starts[0], SPEED), "TQ": (starts[1], TORQUE)})
    found = read_log(path, None, ["RPM", "TQ"])
    assert (found.stamps == STAMPS.to_numpy()).all()
    assert [what for what, _ in found.notes] == [
        "its channels start up to 150 us apart, and are read as if sampled together"
    ]


def test_waveforms_that_start_apart_are_tables_of_names_of_their_own(tmp_path: Path) -> None:
    starts = ("2025-03-03T06:00:00", "2025-03-03T06:00:00.005")
    path = tdms(tmp_path / "log.tdms", {"RPM": (starts[0], SPEED), "TQ": (starts[1], TORQUE)})
    assert [header.table for header in headers(path)] == ["Fast, 50 Hz", "Fast, 50 Hz:2"]
    found = read_log(path, None, ["TQ"], dialect=Dialect(table="Fast, 50 Hz:2"))
    assert found.stamps[0] == np.datetime64(starts[1])


def test_the_metadata_of_all_segments_are_read_once(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tdms(tmp_path / "log.tdms", *[{"RPM": ("2025-03-03T06:00:00", SPEED)}] * 3)
    read, reading = list[int](), TdmsReader._read_segment_metadata

    def counted(reader: TdmsReader, *words: Any) -> Any:
        read.append(words[1])
        return reading(reader, *words)

    monkeypatch.setattr(TdmsReader, "_read_segment_metadata", counted)
    headers(path)
    assert len(set(read)) == 4, "three segments and the end of the file"
    assert len(read) == len(set(read))


def test_recordings_that_were_appended_to_tdms_start_at_their_own_times(tmp_path: Path) -> None:
    first, second = "2025-03-03T06:00:00", "2025-03-03T06:05:00"
    path = tdms(
        tmp_path / "log.tdms",
        {"RPM": (first, SPEED[:20]), "TQ": (first, TORQUE[:20])},
        {"RPM": (first, SPEED[20:30]), "TQ": (first, TORQUE[20:30])},
        {"RPM": (second, SPEED[30:]), "TQ": (second, TORQUE[30:])},
    )
    found = read_log(path, None, ["RPM", "TQ"])
    np.testing.assert_array_equal(found.pop("RPM"), SPEED)
    expected = np.append(STAMPS[:30], STAMPS[:20] + pd.Timedelta("5min"))
    assert (found.stamps == expected.astype("datetime64[ns]")).all()
    assert any("placed at their own starts: 2025-03-03T06:05:00.000" in what for what, _ in found.notes)


def test_appended_recordings_that_overlap_are_refused(tmp_path: Path) -> None:
    path = tdms(
        tmp_path / "log.tdms",
        {"RPM": ("2025-03-03T06:00:00", SPEED)},
        {"RPM": ("2025-03-03T06:00:00.500", SPEED)},
    )
    with pytest.raises(LogError, match=r"'RPM' in parts that were appended starts at .*00\.500 and at .*00\.000"):
        read_log(path, None, ["RPM"])
