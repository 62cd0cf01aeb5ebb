"""One suite over every file format of rig logs, plain and packed."""

import io
import re
import tarfile
import zipfile
from pathlib import Path

import numpy as np
import openpyxl
import pandas as pd
import pytest

from drillid.errors import LogError
from drillid.formats import first_stamp, format_of, formats, headers, read_log
from tests.unit.formats.writers import PACKERS, TRUE_TIMES, WITHOUT_SPACES, WRITERS, stamped, text_of, write

STAMPS = pd.date_range("2025-03-03T06:00", periods=50, freq="20ms", tz="UTC")
PACKED = [f".csv{packing}" for packing in PACKERS] + [".las.gz", ".xml.zip", ".parquet.gz"]

every_format = pytest.mark.parametrize("suffix", [*WRITERS, *PACKED])


@pytest.fixture
def log() -> pd.DataFrame:
    return pd.DataFrame({"Time": STAMPS, "RPM": np.linspace(119, 121, 50), "Hole depth": np.arange(50), "other": "x"})


def depth(suffix: str) -> str:
    """How the column 'Hole depth' is called where names hold no spaces."""
    return "Hole_depth" if suffix.startswith(WITHOUT_SPACES) else "Hole depth"


def test_every_format_is_in_this_suite() -> None:
    first = {reader.SUFFIXES[0] for reader in formats().values()}
    # WITS and LabVIEW Measurement state no zones: their suites are test_wits.py and test_lvm.py
    assert first - {".wits", ".lvm"} == set(WRITERS), (
        "give the new format a writer, so that the whole suite runs over it"
    )


@every_format
def test_reads_values_and_utc_stamps(suffix: str, log: pd.DataFrame, tmp_path: Path) -> None:
    found = read_log(write(log, tmp_path / f"log{suffix}"), "Time", ["RPM", depth(suffix)])
    np.testing.assert_allclose(found.pop("RPM"), log["RPM"], rtol=1e-12)
    assert found.pop(depth(suffix)).dtype == np.float64
    assert (found.stamps == STAMPS.tz_localize(None).to_numpy()).all()
    assert found.notes == []


@every_format
def test_finds_the_times_by_itself(suffix: str, log: pd.DataFrame, tmp_path: Path) -> None:
    path = write(log, tmp_path / f"log{suffix}")
    assert read_log(path, None, ["RPM"]).notes == []
    assert set(headers(path)[0].columns) == {"Time", "RPM", depth(suffix), "other"}


@every_format
def test_stamps_without_zone_take_the_stated_one(suffix: str, log: pd.DataFrame, tmp_path: Path) -> None:
    path = write(log.assign(Time=STAMPS.tz_localize(None)), tmp_path / f"log{suffix}")
    found = read_log(path, "Time", ["RPM"], zone="Europe/Oslo")
    assert found.stamps[0] == np.datetime64("2025-03-03T05:00")


@every_format
def test_stamps_with_an_offset_become_utc(suffix: str, log: pd.DataFrame, tmp_path: Path) -> None:
    path = write(log.assign(Time=STAMPS.tz_convert("America/Chicago")), tmp_path / f"log{suffix}")
    assert read_log(path, "Time", ["RPM"], zone="Europe/Oslo").stamps[0] == np.datetime64("2025-03-03T06:00")


@every_format
@pytest.mark.parametrize(
    ("start", "fault"),
    [
        ("2025-10-26T02:59:59.9", "2025-10-26 02:59:59 occurs twice there, as clocks are set back"),
        ("2025-03-30T01:59:59.9", "2025-03-30 02:00:00 does not exist there, as clocks are set forward"),
    ],
)
def test_stamps_in_the_hour_of_a_changed_clock_are_refused(
    suffix: str, start: str, fault: str, log: pd.DataFrame, tmp_path: Path
) -> None:
    times = pd.date_range(start, periods=50, freq="20ms")
    path = write(log.assign(Time=times), tmp_path / f"log{suffix}")
    with pytest.raises(LogError) as error:
        read_log(path, "Time", ["RPM"], zone="Europe/Oslo")
    assert error.value.what.startswith(f"the stamps cannot be placed in the time zone 'Europe/Oslo': {fault}")
    assert re.fullmatch(rf"{re.escape(str(path))}.*, column 'Time', row \d+", error.value.where)
    assert "UTC" in error.value.remedy


def test_a_zone_that_is_none_is_told(log: pd.DataFrame, tmp_path: Path) -> None:
    path = write(log.assign(Time=STAMPS.tz_localize(None)), tmp_path / "log.csv")
    with pytest.raises(LogError, match="'Europe/Olso' is not a time zone"):
        read_log(path, "Time", ["RPM"], zone="Europe/Olso")


@every_format
def test_empty_cells_and_null_values_are_missing(suffix: str, log: pd.DataFrame, tmp_path: Path) -> None:
    log.loc[3, "RPM"], log.loc[4, "RPM"] = np.nan, -999.25
    path = write(log, tmp_path / f"log{suffix}")
    assert np.flatnonzero(np.isnan(read_log(path, "Time", ["RPM"]).pop("RPM"))).tolist() == [3, 4]


@every_format
def test_missing_column_is_named_with_the_likely_one(suffix: str, log: pd.DataFrame, tmp_path: Path) -> None:
    path = write(log, tmp_path / f"log{suffix}")
    likely = depth(suffix)
    with pytest.raises(LogError, match=rf"no column 'Hole dept'; its columns are .*'RPM'.*mean '{likely}'\?"):
        read_log(path, "Time", ["RPM", "Hole dept"])
    with pytest.raises(LogError, match="no column 'Stamp'"):
        read_log(path, "Stamp", ["RPM"])


@every_format
def test_text_among_numbers_is_named_by_row_and_column(suffix: str, log: pd.DataFrame, tmp_path: Path) -> None:
    log["RPM"] = log["RPM"].astype(str)
    log.loc[6, "RPM"] = "n/a!"
    path = write(log, tmp_path / f"log{suffix}")
    place = "'Sheet1', column 'RPM', row 8" if suffix == ".xlsx" else "column 'RPM', row 7"
    line = {".csv": " in line 8 of the file", ".las": r" in line \d\d of the file"}.get("." + suffix.split(".")[1], "")
    with pytest.raises(LogError, match=rf"{place}: 'n/a!' is not a number\. Correct the cell{line}, or leave it empty"):
        read_log(path, "Time", [depth(suffix), "RPM"]).pop("RPM")


@every_format
@pytest.mark.parametrize("wrong", ["noon", "", "2025-13-03T06:00:00Z"])
def test_a_stamp_that_is_no_time_is_named_by_row(suffix: str, wrong: str, log: pd.DataFrame, tmp_path: Path) -> None:
    log["Time"] = [stamp.isoformat() for stamp in STAMPS]
    log.loc[9, "Time"] = wrong
    path = write(log, tmp_path / f"log{suffix}")
    row = 11 if suffix == ".xlsx" else 10
    with pytest.raises(LogError, match=rf"column 'Time', row {row}: '{wrong}' is not a time"):
        read_log(path, "Time", ["RPM"])


@every_format
def test_numbers_are_no_time(suffix: str, log: pd.DataFrame, tmp_path: Path) -> None:
    path = write(log, tmp_path / f"log{suffix}")
    with pytest.raises(LogError, match=r"column 'RPM', row \d: .* is not a time.*time\.start"):
        read_log(path, "RPM", [depth(suffix)])


@every_format
def test_no_rows(suffix: str, log: pd.DataFrame, tmp_path: Path) -> None:
    path = write(log.iloc[:0], tmp_path / f"log{suffix}")
    with pytest.raises(LogError, match="holds no "):
        read_log(path, "Time", ["RPM"])


@every_format
def test_missing_file(suffix: str, tmp_path: Path) -> None:
    with pytest.raises(LogError, match=rf"{suffix}: is longer than the name of a file may be\. Correct its path"):
        read_log(tmp_path / f"{'a' * 300}{suffix}", "Time", ["RPM"])
    with pytest.raises(LogError, match=f"nowhere{suffix}: does not exist"):
        read_log(tmp_path / f"nowhere{suffix}", "Time", ["RPM"])


def test_a_pattern_without_a_file_is_told_as_such(tmp_path: Path) -> None:
    with pytest.raises(LogError, match=r"W1/\*\.csv: matches no file\. Correct the pattern"):
        read_log(tmp_path / "W1/*.csv", "Time", ["RPM"])


@every_format
def test_an_empty_file_is_told_to_be_empty(suffix: str, tmp_path: Path) -> None:
    path = tmp_path / f"log{suffix}"
    if suffix == ".zarr":
        path.mkdir()
        with pytest.raises(LogError, match="is not a zarr store"):
            read_log(path, "Time", ["RPM"])
        return
    path.touch()
    for read in (lambda: read_log(path, "Time", ["RPM"]), lambda: first_stamp(path, "Time")):
        with pytest.raises(LogError, match=r"is empty\. Export the log again"):
            read()


@every_format
def test_the_first_stamp_is_the_earliest_of_the_first_rows(suffix: str, log: pd.DataFrame, tmp_path: Path) -> None:
    path = tmp_path / f"log{suffix}"
    late_first = pd.concat([log.assign(Time=STAMPS[::-1])] + [log.assign(Time=STAMPS - pd.Timedelta(hours=1))] * 20)
    write(late_first, path)
    assert first_stamp(path, "Time") == np.datetime64("2025-03-03T05:00")
    write(log.assign(Time=pd.date_range("2025-10-26T02:30", periods=50, freq="20ms")), path)
    assert first_stamp(path, "Time", "Europe/Oslo") == np.datetime64("2025-10-26T00:30")


@every_format
def test_damaged_file(suffix: str, log: pd.DataFrame, tmp_path: Path) -> None:
    path = write(log, tmp_path / f"log{suffix}")
    if path.is_dir():
        (path / "RPM" / "0").unlink()
    else:
        path.write_bytes(path.read_bytes()[:40])
    with pytest.raises(LogError, match=str(path)):
        read_log(path, "Time", ["RPM"])


@every_format
def test_a_folder_and_binary_rubbish_are_refused(suffix: str, tmp_path: Path) -> None:
    (tmp_path / f"folder{suffix}").mkdir()
    rubbish = tmp_path / f"rubbish{suffix}"
    rubbish.write_bytes(bytes(range(256)) * 40)
    for path in (tmp_path / f"folder{suffix}", rubbish):
        with pytest.raises(LogError, match=str(path)):
            read_log(path, "Time", ["RPM"])


def test_unknown_ending_lists_the_known_ones() -> None:
    with pytest.raises(LogError, match=r"not in a known format.*\.csv, .*\.parquet.*packed as \.gz"):
        format_of(Path("log.las2"))
    assert format_of(Path("LOG.CSV")).SUFFIXES == format_of(Path("log.csv.gz")).SUFFIXES


def test_a_file_is_read_by_its_content_where_its_name_is_wrong(log: pd.DataFrame, tmp_path: Path) -> None:
    for written, called in (
        (".csv", ".xls"),
        (".parquet", ".csv"),
        (".las", ".txt"),
        (".xml", ".log"),
        (".csv.gz", ".csv"),
    ):
        path = write(log, tmp_path / f"log{written}").rename(tmp_path / f"other{called}")
        found = read_log(path, "Time", ["RPM"])
        assert found.stamps[0] == np.datetime64("2025-03-03T06:00")
        assert len(found.notes) == (written != ".csv.gz")


@pytest.mark.parametrize("names", [("Tag", "Value"), ("Sensor name", "Messwert"), ("_field", "_value")])
def test_long_form_is_told_with_how_to_make_a_log_of_it(
    names: tuple[str, str], log: pd.DataFrame, tmp_path: Path
) -> None:
    long = stamped(log)[["Time", "RPM"]].melt(id_vars="Time", var_name=names[0], value_name=names[1])
    long.to_csv(tmp_path / "log.csv", index=False)
    pivot = rf"log\.pivot_table\(index='Time', columns='{names[0]}', values='{names[1]}'"
    with pytest.raises(LogError, match=rf"has no column 'RPM' and looks like long form: .*'{names[0]}'.*{pivot}"):
        read_log(tmp_path / "log.csv", "Time", ["RPM"])
    (note,) = headers(tmp_path / "log.csv")[0].notes
    assert note[0].startswith("looks like long form")
    assert headers(write(log, tmp_path / "wide.csv"))[0].notes == ()


def test_a_readme_beside_the_log_in_an_archive_is_left_out_and_told(log: pd.DataFrame, tmp_path: Path) -> None:
    path = tmp_path / "log.zip"
    with zipfile.ZipFile(path, "w") as archive:
        archive.writestr("export/stand.csv", text_of(log))
        archive.writestr("export/ReadMe.txt", "exported by nobody, at all")
    found = read_log(path, "Time", ["RPM"])
    np.testing.assert_allclose(found.pop("RPM"), log["RPM"])
    assert [what for what, _ in found.notes] == [
        "files in the archive are not logs, judging by their names, and are not read: 'export/ReadMe.txt'"
    ]


def test_archives_of_several_logs_are_refused_with_what_to_do(log: pd.DataFrame, tmp_path: Path) -> None:
    text = text_of(log).encode()
    with zipfile.ZipFile(tmp_path / "logs.zip", "w") as archive:
        archive.writestr("one.csv", text)
        archive.writestr("two.csv", text)
    with pytest.raises(LogError, match=r"is a zip file with 2 files \(one\.csv, two\.csv\).*zip each log separately"):
        read_log(tmp_path / "logs.zip", "Time", ["RPM"])
    for name, mode in (("logs.tar.gz", "w:gz"), ("logs.tar", "w")):
        with tarfile.open(tmp_path / name, mode) as archive:  # type: ignore[call-overload]
            member = tarfile.TarInfo("one.csv")
            member.size = len(text)
            archive.addfile(member, io.BytesIO(text))
        with pytest.raises(LogError, match="is a tar archive, which may hold several files"):
            read_log(tmp_path / name, "Time", ["RPM"])


@pytest.mark.parametrize("since", [1900, 1904])
def test_days_of_a_workbook_count_from_where_it_says(since: int, log: pd.DataFrame, tmp_path: Path) -> None:
    path = tmp_path / "log.xlsx"
    days = 45719.25 + np.arange(50) * 0.02 / 86400 - (1462 if since == 1904 else 0)
    book = openpyxl.Workbook()
    book.epoch = openpyxl.utils.datetime.CALENDAR_MAC_1904 if since == 1904 else book.epoch
    for row in [("Time", "RPM"), *zip(days, log["RPM"], strict=True)]:
        book.active.append(row)
    book.save(path)
    found = read_log(path, "Time", ["RPM"])
    assert np.max(np.abs((found.stamps - STAMPS.tz_localize(None).to_numpy()) / np.timedelta64(1, "us"))) < 5
    assert any("count from 1904" in what for what, _ in found.notes) == (since == 1904)


def test_true_times_are_written_where_the_suite_says_so(log: pd.DataFrame, tmp_path: Path) -> None:
    import pyarrow as pa

    for suffix in WRITERS:
        path = write(log, tmp_path / f"log{suffix}")
        header = headers(path)[0]
        kind = formats()[suffix].read_columns(path, header, ["Time"], ["Time"]).column("Time").type
        assert pa.types.is_timestamp(kind) == (suffix in TRUE_TIMES)


def test_a_library_without_memory_holds_nothing_against_the_log(
    log: pd.DataFrame, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def fail(path: Path, dialect: object) -> None:
        raise OSError("Unknown error: Failed to launch worker thread: Resource temporarily unavailable")

    path = write(log, tmp_path / "log.parquet")
    monkeypatch.setattr(formats()[".parquet"], "headers", fail)
    with pytest.raises(MemoryError, match="worker thread"):
        read_log(path, "Time", ["RPM"])


def test_a_small_file_that_asks_for_all_memory_is_damaged(
    log: pd.DataFrame, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    from nptdms import TdmsFile

    def fail(*_: object) -> None:
        raise MemoryError

    path = write(log, tmp_path / "log.tdms")
    monkeypatch.setattr(TdmsFile, "_read_file", fail)
    with pytest.raises(LogError, match=r"damaged: it states lengths beyond the memory"):
        read_log(path, "Time", ["RPM"])
