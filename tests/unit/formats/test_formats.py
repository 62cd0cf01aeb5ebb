"""One suite over every file format of rig logs."""

import gzip
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from drillid.errors import LogError
from drillid.formats import first_stamp, format_of, formats, read_log

STAMPS = pd.date_range("2025-03-03T06:00", periods=50, freq="20ms", tz="UTC")


def _text(log: pd.DataFrame) -> str:
    return log.assign(Time=[stamp if isinstance(stamp, str) else stamp.isoformat() for stamp in log["Time"]]).to_csv(
        index=False
    )


def _write_csv(log: pd.DataFrame, path: Path) -> None:
    path.write_text(_text(log))


def _write_gzip(log: pd.DataFrame, path: Path) -> None:
    path.write_bytes(gzip.compress(_text(log).encode()))


def _write_parquet(log: pd.DataFrame, path: Path) -> None:
    log.to_parquet(path, index=False)


WRITERS = {".csv": _write_csv, ".csv.gz": _write_gzip, ".parquet": _write_parquet}

every_format = pytest.mark.parametrize("suffix", sorted(formats()))


@pytest.fixture
def log() -> pd.DataFrame:
    return pd.DataFrame({"Time": STAMPS, "RPM": np.linspace(119, 121, 50), "Hole depth": np.arange(50), "other": "x"})


def test_every_format_is_in_this_suite() -> None:
    assert set(formats()) == set(WRITERS), "give the new format a writer here, so that the whole suite runs over it"


@every_format
def test_reads_values_and_utc_stamps(suffix: str, log: pd.DataFrame, tmp_path: Path) -> None:
    path = tmp_path / f"log{suffix}"
    WRITERS[suffix](log, path)
    found = read_log(path, "Time", ["RPM", "Hole depth"])
    np.testing.assert_allclose(found.pop("RPM"), log["RPM"], rtol=1e-12)
    assert found.pop("Hole depth").dtype == np.float64
    assert (found.stamps == STAMPS.tz_localize(None).to_numpy()).all()


@every_format
def test_stamps_without_zone_take_the_stated_one(suffix: str, log: pd.DataFrame, tmp_path: Path) -> None:
    path = tmp_path / f"log{suffix}"
    WRITERS[suffix](log.assign(Time=STAMPS.tz_localize(None)), path)
    found = read_log(path, "Time", ["RPM"], zone="Europe/Oslo")
    assert found.stamps[0] == np.datetime64("2025-03-03T05:00")


@every_format
def test_stamps_with_an_offset_become_utc(suffix: str, log: pd.DataFrame, tmp_path: Path) -> None:
    path = tmp_path / f"log{suffix}"
    WRITERS[suffix](log.assign(Time=STAMPS.tz_convert("America/Chicago")), path)
    assert read_log(path, "Time", ["RPM"], zone="Europe/Oslo").stamps[0] == np.datetime64("2025-03-03T06:00")


@every_format
def test_stamps_in_an_hour_that_comes_twice_are_refused(suffix: str, log: pd.DataFrame, tmp_path: Path) -> None:
    path = tmp_path / f"log{suffix}"
    WRITERS[suffix](log.assign(Time=pd.date_range("2025-10-26T02:30", periods=50, freq="20ms")), path)
    with pytest.raises(LogError, match=r"cannot be placed in the time zone 'Europe/Oslo'.*UTC"):
        read_log(path, "Time", ["RPM"], zone="Europe/Oslo")


@every_format
def test_empty_cells_and_null_values_are_missing(suffix: str, log: pd.DataFrame, tmp_path: Path) -> None:
    log.loc[3, "RPM"], log.loc[4, "RPM"] = np.nan, -999.25
    path = tmp_path / f"log{suffix}"
    WRITERS[suffix](log, path)
    assert np.flatnonzero(np.isnan(read_log(path, "Time", ["RPM"]).pop("RPM"))).tolist() == [3, 4]


@every_format
def test_missing_column_is_named_with_the_likely_one(suffix: str, log: pd.DataFrame, tmp_path: Path) -> None:
    path = tmp_path / f"log{suffix}"
    WRITERS[suffix](log, path)
    with pytest.raises(LogError, match=r"no column 'Hole dept'; its columns are 'Time', 'RPM'.*mean 'Hole depth'\?"):
        read_log(path, "Time", ["RPM", "Hole dept"])
    with pytest.raises(LogError, match="no column 'Stamp'"):
        read_log(path, "Stamp", ["RPM"])


@every_format
def test_text_among_numbers_is_named_by_row_and_column(suffix: str, log: pd.DataFrame, tmp_path: Path) -> None:
    log["RPM"] = log["RPM"].astype(str)
    log.loc[6, "RPM"] = "n/a!"
    path = tmp_path / f"log{suffix}"
    WRITERS[suffix](log, path)
    with pytest.raises(LogError, match=r"column 'RPM', row 7: 'n/a!' is not a number"):
        read_log(path, "Time", ["Hole depth", "RPM"]).pop("RPM")


@every_format
@pytest.mark.parametrize("wrong", ["noon", "", "2025-13-03T06:00:00Z"])
def test_a_stamp_that_is_no_time_is_named_by_row(suffix: str, wrong: str, log: pd.DataFrame, tmp_path: Path) -> None:
    log["Time"] = [stamp.isoformat() for stamp in STAMPS]
    log.loc[9, "Time"] = wrong
    path = tmp_path / f"log{suffix}"
    WRITERS[suffix](log, path)
    with pytest.raises(LogError, match=r"column 'Time', row 10: .* is not a time"):
        read_log(path, "Time", ["RPM"])


@every_format
def test_numbers_are_no_time(suffix: str, log: pd.DataFrame, tmp_path: Path) -> None:
    path = tmp_path / f"log{suffix}"
    WRITERS[suffix](log, path)
    with pytest.raises(LogError, match=r"column 'RPM', row 1: .* is not a time"):
        read_log(path, "RPM", ["Hole depth"])


@every_format
def test_no_rows(suffix: str, log: pd.DataFrame, tmp_path: Path) -> None:
    path = tmp_path / f"log{suffix}"
    WRITERS[suffix](log.iloc[:0], path)
    with pytest.raises(LogError, match="holds no rows"):
        read_log(path, "Time", ["RPM"])


@every_format
def test_missing_file(suffix: str, tmp_path: Path) -> None:
    with pytest.raises(LogError, match=f"nowhere{suffix}: does not exist"):
        read_log(tmp_path / f"nowhere{suffix}", "Time", ["RPM"])


@every_format
def test_an_empty_file_is_told_to_be_empty(suffix: str, tmp_path: Path) -> None:
    path = tmp_path / f"log{suffix}"
    path.touch()
    for read in (lambda: read_log(path, "Time", ["RPM"]), lambda: first_stamp(path, "Time")):
        with pytest.raises(LogError, match=r"is empty\. Export the log again"):
            read()


@every_format
def test_the_first_stamp_is_the_earliest_of_the_first_rows(suffix: str, log: pd.DataFrame, tmp_path: Path) -> None:
    path = tmp_path / f"log{suffix}"
    late_first = pd.concat([log.assign(Time=STAMPS[::-1])] + [log.assign(Time=STAMPS - pd.Timedelta(hours=1))] * 20)
    WRITERS[suffix](late_first, path)
    assert first_stamp(path, "Time") == np.datetime64("2025-03-03T05:00")
    WRITERS[suffix](log.assign(Time=pd.date_range("2025-10-26T02:30", periods=50, freq="20ms")), path)
    assert first_stamp(path, "Time", "Europe/Oslo") == np.datetime64("2025-10-26T00:30")


@pytest.mark.parametrize("packed", [False, True], ids=["plain", "gzip"])
@pytest.mark.parametrize("encoding", ["latin-1", "utf-8", "utf-8-sig"])
def test_a_header_in_any_usual_encoding(encoding: str, packed: bool, log: pd.DataFrame, tmp_path: Path) -> None:
    path = tmp_path / ("log.csv.gz" if packed else "log.csv")
    content = _text(log.rename(columns={"Hole depth": "Tiefe für 8½"})).encode(encoding)
    path.write_bytes(gzip.compress(content) if packed else content)
    np.testing.assert_allclose(read_log(path, "Time", ["Tiefe für 8½"]).pop("Tiefe für 8½"), log["Hole depth"])


@every_format
def test_damaged_file(suffix: str, log: pd.DataFrame, tmp_path: Path) -> None:
    path = tmp_path / f"log{suffix}"
    WRITERS[suffix](log, path)
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


def test_a_line_cut_short_is_refused(log: pd.DataFrame, tmp_path: Path) -> None:
    path = tmp_path / "log.csv"
    path.write_text(_text(log).rstrip()[:-12])
    with pytest.raises(LogError, match=r"log\.csv"):
        read_log(path, "Time", ["RPM"])


def test_unknown_ending_lists_the_known_ones() -> None:
    with pytest.raises(LogError, match=r"no known format.*\.csv, \.csv\.gz, \.parquet"):
        format_of(Path("log.las2"))
    assert format_of(Path("LOG.CSV")).SUFFIXES == format_of(Path("log.csv.gz")).SUFFIXES
