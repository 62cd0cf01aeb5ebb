"""LabVIEW Measurement files, as the express function of LabVIEW writes them."""

from pathlib import Path

import numpy as np
import pytest

from drillid.errors import LogError
from drillid.formats import Dialect, TimeColumn, format_of, headers, read_log

HEAD = (
    "LabVIEW Measurement\t\nWriter_Version\t2\nReader_Version\t2\nSeparator\tTab\nDecimal_Separator\t.\n"
    "Multi_Headings\t{headings}\nX_Columns\t{x}\nTime_Pref\tRelative\nOperator\tRig 7\nDate\t2025/03/04\n"
    "Time\t05:59:59.5\n***End_of_Header***\t\n\t\n"
)
SEGMENT = (
    "Channels\t2\t\t\nSamples\t{rows}\t{rows}\t\nDate\t2025/03/04\t2025/03/04\t\n"
    "Time\t{start}\t{start}\t\nY_Unit_Label\tkN.m\trpm\t\nX_Dimension\tTime\tTime\t\n"
    "X0\t0.0000000000000000E+0\t0.0000000000000000E+0\t\nDelta_X\t0.020000\t0.020000\t\n"
    "***End_of_Header***\t\t\t\nX_Value\tTorque\tSpeed\tComment\n"
)
OF_SEVERAL = (
    "Channels\t2\t\t\t\nSamples\t30\t\t30\t\nDate\t2025/03/04\t\t2025/03/04\t\nTime\t06:00:00\t\t06:00:00\t\n"
    "Y_Unit_Label\tkN.m\t\trpm\t\nX0\t0.0\t\t0.0\t\nDelta_X\t0.02\t\t0.02\t\n***End_of_Header***\t\t\t\t\n"
    "X_Value\tTorque\tX_Value\tSpeed\tComment\n"
)


def rows(form: str, count: int = 30) -> str:
    """Rows of data; {t} is the time of each, s, {tq} and {n} its values."""
    cells = ((0.02 * at, 12 + at / 8, 120 + at / 4) for at in range(count))
    return "".join(form.format(t=f"{t:.6f}", tq=f"{torque:.6f}", n=f"{speed:.6f}") + "\n" for t, torque, speed in cells)


ONE, NONE = "{t}\t{tq}\t{n}", "\t{tq}\t{n}"
START = "06:00:00.0000000000000000000"
FILES = {
    "one column of times": HEAD.format(headings="No", x="One") + SEGMENT.format(rows=30, start=START) + rows(ONE),
    "no column of times": HEAD.format(headings="Yes", x="No") + SEGMENT.format(rows=30, start=START) + rows(NONE),
    "a column for each": HEAD.format(headings="No", x="Multi") + OF_SEVERAL + rows("{t}\t{tq}\t{t}\t{n}"),
    "comments": HEAD.format(headings="No", x="One") + SEGMENT.format(rows=30, start=START) + rows(ONE + "\tslips, 2"),
    "since 1904": HEAD.format(headings="No", x="One").replace("Relative", "Absolute")
    + SEGMENT.format(rows=30, start="11:11:11")
    + ("\n" + rows(ONE)).replace("\n0.", "\n3823912800.").lstrip(),
}
FILES["decimal commas"] = FILES["one column of times"].replace(".", ",").replace("kN,m", "kN.m")
FILES["commas between cells"] = (
    FILES["one column of times"].replace("Separator\tTab", "Separator\tComma").replace("\t", ",")
)
FILES["a block of its own"] = FILES["one column of times"].replace(
    "Channels\t2", "***Start_Special***\nSetup\tA\nX_Value\t1\n***End_Special***\n\nChannels\t2"
)


def saved(tmp_path: Path, text: str, name: str = "log.lvm") -> Path:
    """A file with the text."""
    path = tmp_path / name
    path.write_bytes(text.replace("\n", "\r\n").encode("cp1252"))
    return path


@pytest.mark.parametrize("text", FILES.values(), ids=FILES)
def test_every_layout_is_read_alike(tmp_path: Path, text: str) -> None:
    log = read_log(saved(tmp_path, text), None, ["Torque", "Speed"])
    expected = np.datetime64("2025-03-04T06:00:00", "ns") + np.arange(30) * np.timedelta64(20, "ms")
    assert np.array_equal(log.stamps, expected)
    assert log.units == {"Torque": "kN.m", "Speed": "rpm"}
    assert np.allclose(log.pop("Torque"), 12 + np.arange(30) / 8)
    assert np.allclose(log.pop("Speed"), 120 + np.arange(30) / 4)


def test_starts_are_of_the_rigs_clock(tmp_path: Path) -> None:
    path = saved(tmp_path, FILES["no column of times"])
    log = read_log(path, TimeColumn(zone="Europe/Oslo"), ["Torque"])
    assert log.stamps[0] == np.datetime64("2025-03-04T05:00:00", "ns")


def test_segments_are_placed_at_their_own_starts(tmp_path: Path) -> None:
    first = HEAD.format(headings="Yes", x="No") + SEGMENT.format(rows=30, start="06:00:00") + rows(NONE) + "\n"
    path = saved(tmp_path, first + SEGMENT.format(rows=30, start="06:10:00.25") + rows(NONE))
    log = read_log(path, None, ["Torque"])
    assert log.stamps.size == 60
    assert log.stamps[30] == np.datetime64("2025-03-04T06:10:00.250", "ns")


def test_a_recording_that_was_appended_with_its_header_is_a_segment(tmp_path: Path) -> None:
    first = FILES["one column of times"]
    path = saved(tmp_path, first + first.replace(START, "07:00:00"))
    assert read_log(path, None, ["Torque"]).stamps[30] == np.datetime64("2025-03-04T07:00:00", "ns")


def test_segments_with_other_channels_are_tables(tmp_path: Path) -> None:
    first = HEAD.format(headings="Yes", x="No") + SEGMENT.format(rows=30, start="06:00:00") + rows(NONE)
    path = saved(tmp_path, first + SEGMENT.format(rows=30, start="06:10:00").replace("Torque", "Load") + rows(NONE))
    assert [header.table for header in headers(path)] == ["segment 1", "segment 2"]
    assert read_log(path, None, ["Load"], dialect=Dialect(table="segment 2")).pop("Load")[0] == 12


def test_a_start_that_is_not_set_is_asked_for(tmp_path: Path) -> None:
    text = FILES["one column of times"].replace("2025/03/04", "1904/01/01")
    path = saved(tmp_path, text)
    with pytest.raises(LogError, match=r"time\.start"):
        read_log(path, None, ["Torque"])
    log = read_log(path, TimeColumn(start="2025-03-04T06:00:00"), ["Torque"])
    assert log.stamps[1] == np.datetime64("2025-03-04T06:00:00.020", "ns")


REFUSED = {
    "a recording appended without a header": (FILES["one column of times"] + rows(ONE), "do not advance in line 54"),
    "a segment before the end of the one above": (
        FILES["one column of times"] + SEGMENT.format(rows=30, start="06:00:00.3") + rows(ONE),
        "line 63, that starts before",
    ),
    "starts apart": (
        FILES["no column of times"].replace(f"Time\t{START}\t{START}", "Time\t06:00:00\t06:00:01"),
        "start 1 s apart",
    ),
    "intervals apart": (FILES["no column of times"].replace("0.020000\t\n", "0.010000\t\n"), "different intervals"),
    "no interval": (FILES["no column of times"].replace("Delta_X", "Delta"), "no interval between samples"),
    "times apart": (
        FILES["a column for each"].replace("0.020000\t120.25", "0.030000\t120.25"),
        "differ from those of the first channel",
    ),
    "a time is missing": (FILES["a column for each"].replace("\t0.020000\t120.25", "\t\t"), "rows without a time"),
    "cut in its header": (FILES["one column of times"].partition("X_Value")[0], "ends within a header"),
}


@pytest.mark.parametrize(("text", "what"), REFUSED.values(), ids=REFUSED)
def test_what_cannot_be_placed_in_time_is_refused(tmp_path: Path, text: str, what: str) -> None:
    with pytest.raises(LogError, match=what):
        read_log(saved(tmp_path, text), None, ["Torque", "Speed"])


def test_rows_under_one_header_without_times_are_noted(tmp_path: Path) -> None:
    text = FILES["no column of times"].replace("Multi_Headings\tYes", "Multi_Headings\tNo")
    assert any("without gaps" in what for what, _ in read_log(saved(tmp_path, text), None, ["Torque"]).notes)


def test_the_content_shows_the_format(tmp_path: Path) -> None:
    path = saved(tmp_path, FILES["no column of times"], "log.txt")
    assert format_of(path).SUFFIXES == (".lvm",)


def test_a_cell_that_is_no_number_is_named(tmp_path: Path) -> None:
    log = read_log(saved(tmp_path, FILES["no column of times"].replace("12.125000", "bad")), None, ["Torque"])
    with pytest.raises(LogError, match="row 2"):
        log.pop("Torque")
