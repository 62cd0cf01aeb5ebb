"""One suite over every file format of rig logs."""

import gzip
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from drillid.errors import LogError
from drillid.formats import format_of, formats, read_log

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
    np.testing.assert_allclose(found["RPM"], log["RPM"], rtol=1e-12)
    assert found["Hole depth"].dtype == np.float64
    assert pd.DatetimeIndex(found.index).tz is None
    assert (found.index == STAMPS.tz_localize(None)).all()


@every_format
def test_stamps_without_zone_take_the_stated_one(suffix: str, log: pd.DataFrame, tmp_path: Path) -> None:
    path = tmp_path / f"log{suffix}"
    WRITERS[suffix](log.assign(Time=STAMPS.tz_localize(None)), path)
    found = read_log(path, "Time", ["RPM"], zone="Europe/Oslo")
    assert found.index[0] == pd.Timestamp("2025-03-03T05:00")


@every_format
def test_stamps_with_an_offset_become_utc(suffix: str, log: pd.DataFrame, tmp_path: Path) -> None:
    path = tmp_path / f"log{suffix}"
    WRITERS[suffix](log.assign(Time=STAMPS.tz_convert("America/Chicago")), path)
    assert read_log(path, "Time", ["RPM"], zone="Europe/Oslo").index[0] == pd.Timestamp("2025-03-03T06:00")


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
    assert np.flatnonzero(read_log(path, "Time", ["RPM"])["RPM"].isna()).tolist() == [3, 4]


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
    with pytest.raises(LogError, match=r"column 'RPM', row 7: 'n/a!' is no number"):
        read_log(path, "Time", ["Hole depth", "RPM"])


@every_format
@pytest.mark.parametrize("wrong", ["noon", "", "2025-13-03T06:00:00Z"])
def test_a_stamp_that_is_no_time_is_named_by_row(suffix: str, wrong: str, log: pd.DataFrame, tmp_path: Path) -> None:
    log["Time"] = [stamp.isoformat() for stamp in STAMPS]
    log.loc[9, "Time"] = wrong
    path = tmp_path / f"log{suffix}"
    WRITERS[suffix](log, path)
    with pytest.raises(LogError, match=r"column 'Time', row 10: .* is no time"):
        read_log(path, "Time", ["RPM"])


@every_format
def test_numbers_are_no_time(suffix: str, log: pd.DataFrame, tmp_path: Path) -> None:
    path = tmp_path / f"log{suffix}"
    WRITERS[suffix](log, path)
    with pytest.raises(LogError, match=r"column 'RPM', row 1: .* is no time"):
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
@pytest.mark.parametrize("kept", [0, 40], ids=["empty", "cut short"])
def test_damaged_file(suffix: str, kept: int, log: pd.DataFrame, tmp_path: Path) -> None:
    path = tmp_path / f"log{suffix}"
    WRITERS[suffix](log, path)
    path.write_bytes(path.read_bytes()[:kept])
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
