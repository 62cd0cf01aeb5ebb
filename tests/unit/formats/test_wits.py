"""WITS streams of level 0: the same values as any other format gives, and what goes wrong on the line."""

import gzip
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from typer.testing import CliRunner

from drillid.commands import app
from drillid.errors import LogError
from drillid.formats import first_stamp, headers, read_log
from drillid.formats.description import Dialect, TimeColumn
from drillid.formats.detection import format_of

STAMPS = pd.date_range("2025-03-03T05:59:59.5", periods=50, freq="20ms")
RPM = np.linspace(119, 121, 50)
TORQUE = np.linspace(11.5, 12.25, 50)
COLUMNS = {"0120": RPM, "0118": TORQUE, "0110": np.arange(50) / 8}


def record(*items: str) -> str:
    return "\r\n".join(["&&", *items, "!!", ""])


def frame(stamp: pd.Timestamp, **items: object) -> str:
    clock = stamp.strftime("%H%M%S.%f")[:-3]
    return record(
        f"0105{stamp:%y%m%d}", f"0106{clock}", *(f"{code.lstrip('_')}{value}" for code, value in items.items())
    )


def frames(stamps: pd.DatetimeIndex = STAMPS, **changed: str) -> list[str]:
    """A record for each time; of changed items the given text in the tenth."""
    cells = {code: [repr(float(value)) for value in values] for code, values in COLUMNS.items()}
    for code, text in changed.items():
        cells[code.lstrip("_")][9] = text
    rows = zip(*cells.values(), strict=True)
    return [
        frame(stamp, **{f"_{code}": cell for code, cell in zip(cells, row, strict=True)})
        for stamp, row in zip(stamps, rows, strict=True)
    ]


def stream(path: Path, text: str) -> Path:
    path.write_bytes(text.encode())
    return path


def test_a_round_trip_gives_the_same_record(tmp_path: Path) -> None:
    plain = stream(tmp_path / "log.wits", "".join(frames()))
    packed = tmp_path / "log.wits.gz"
    packed.write_bytes(gzip.compress(plain.read_bytes()))
    for path in (plain, packed):
        found = read_log(path, None, ["RPMA", "TQA", "DMEA"])
        assert found.notes == []
        assert (found.stamps == STAMPS.to_numpy()).all()
        for name, values in zip(["RPMA", "TQA", "DMEA"], COLUMNS.values(), strict=True):
            np.testing.assert_array_equal(found.pop(name), values)
    (header,) = headers(plain)
    assert header.columns == ("DATE", "TIME", "DMEA", "TQA", "RPMA")
    assert (header.time, header.date, header.table) == ("TIME", "DATE", "")


def test_items_may_be_named_by_their_codes_and_clocks_have_zones(tmp_path: Path) -> None:
    path = stream(tmp_path / "log.wits", "".join(frames()))
    found = read_log(path, TimeColumn("0106", date="0105", zone="Europe/Oslo"), ["0120"])
    np.testing.assert_array_equal(found.pop("0120"), RPM)
    assert found.stamps[0] == STAMPS[0].to_datetime64() - np.timedelta64(1, "h")
    assert first_stamp(path, None) == STAMPS[0].to_datetime64()


def test_a_stream_is_known_by_its_content(tmp_path: Path) -> None:
    for name in ("log.txt", "log.csv", "log.las"):
        path = stream(tmp_path / name, "0108100.0\r\n!!\r\n" + "".join(frames()))
        assert format_of(path).SUFFIXES[0] == ".wits"
        np.testing.assert_array_equal(read_log(path, None, ["RPMA"]).pop("RPMA"), RPM)


def test_records_of_several_types_are_tables(tmp_path: Path) -> None:
    slow = [record("0805250303", "0806060000", f"0812{value}") for value in (1.5, 2.5)]
    path = stream(tmp_path / "log.wits", slow[0] + "".join(frames()) + slow[1])
    assert [header.table for header in headers(path)] == ["record 1", "record 8"]
    np.testing.assert_array_equal(read_log(path, None, ["RPMA"]).pop("RPMA"), RPM)
    other = read_log(path, None, ["0812"], dialect=Dialect(table="record 8"))
    assert other.pop("0812").tolist() == [1.5, 2.5]
    assert other.stamps[0] == np.datetime64("2025-03-03T06:00")


def test_records_cut_short_and_noise_are_left_out_and_told(tmp_path: Path) -> None:
    whole = frames()
    cut = "&&\r\n0105250303\r\n0106055959.9\r\n012077"
    noise = "\x00\x7fconnected 9600 baud\r\n0120 5\r\n"
    path = stream(tmp_path / "log.wits", whole[0] + cut + "\r\n" + noise + "".join(whole[1:]) + cut)
    found = read_log(path, None, ["RPMA"])
    np.testing.assert_array_equal(found.pop("RPMA"), RPM)
    assert [what for what, _ in found.notes] == ["2 of 52 records have no end and are left out"]


def test_missing_items_and_null_values_are_missing(tmp_path: Path) -> None:
    rows = frames(_0120="-9999")
    rows[3] = rows[3].replace(f"0120{float(RPM[3])!r}\r\n", "")
    rows[5] = rows[5].replace(f"0120{float(RPM[5])!r}", "0120   ")
    values = read_log(stream(tmp_path / "log.wits", "".join(rows)), None, ["RPMA"]).pop("RPMA")
    assert np.flatnonzero(np.isnan(values)).tolist() == [3, 5, 9]


def test_text_among_numbers_is_named_by_item_and_line(tmp_path: Path) -> None:
    path = stream(tmp_path / "log.wits", "".join(frames(_0120="off")))
    place = rf"column 'RPMA', row 10: 'off' is not a number\. Correct the cell in line {9 * 7 + 1} of the file"
    with pytest.raises(LogError, match=place):
        read_log(path, None, ["RPMA"]).pop("RPMA")


def test_times_of_day_without_a_date_ask_for_one(tmp_path: Path) -> None:
    text = "".join(frames()).replace("0105250303\r\n", "")
    with pytest.raises(LogError, match=r"holds times of day without a date.*time\.start"):
        read_log(stream(tmp_path / "log.wits", text), None, ["RPMA"])
    started = TimeColumn(start="2025-03-03")
    assert read_log(tmp_path / "log.wits", started, ["RPMA"]).stamps[-1] == STAMPS[-1].to_datetime64()


@pytest.mark.parametrize("text", ["&&\r\n0105250303\r\n", "&&\n" * 200_000, "!!\n" * 200_000, "0105250303\n" * 9])
def test_streams_without_a_whole_record_are_refused_at_once(text: str, tmp_path: Path) -> None:
    with pytest.raises(LogError, match="holds no whole record between && and !!"):
        read_log(stream(tmp_path / "log.wits", text), None, ["RPMA"])


def test_an_unknown_item_is_told_with_the_likely_one(tmp_path: Path) -> None:
    with pytest.raises(LogError, match=r"no column 'RPMB'.*mean 'RPMA'\?"):
        read_log(stream(tmp_path / "log.wits", "".join(frames())), None, ["RPMB"])


def test_inspect_maps_the_items_and_asks_for_their_units(tmp_path: Path) -> None:
    stamps = pd.date_range("2025-03-03T06:00", periods=50, freq="1s")
    path = stream(tmp_path / "log.wits", "".join(frames(stamps)))
    told = CliRunner().invoke(app, ["inspect", str(path)])
    assert told.exit_code == 0, told.output
    for words in ("speed: {column: RPMA", "hole_depth: {column: DMEA", "torque_command: {column: TQA"):
        assert words in told.output


def test_records_without_times_are_left_out_and_told(tmp_path: Path) -> None:
    path = tmp_path / "log.wits"
    timed = "&&\n0105250303\n01060600{:02d}\n0118{}\n!!\n"
    path.write_text("".join(timed.format(at, at) + "&&\n01109545.0\n!!\n&&\n0824109.5\n!!\n" for at in range(12)))
    log = read_log(path, None, ["TQA"])
    assert log.pop("TQA").tolist() == list(range(12))
    assert [what for what, _ in log.notes if "left out" in what] == [
        "12 of 24 records of type 1 hold no date and time and are left out"
    ]


def test_a_stream_without_times_tells_what_it_lacks(tmp_path: Path) -> None:
    path = tmp_path / "log.wits"
    path.write_text("&&\n01083650.40\n01133.5\n01142850.7\n!!\n" * 12)
    with pytest.raises(LogError, match=r"items 05 and 06\. Configure the sender to send these"):
        read_log(path, None, ["HKLA"])
