"""Times as recorders and offices write them into text: which column they are in, what they count, their zone."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from drillid.errors import LogError
from drillid.formats import first_stamp, read_log
from drillid.formats.description import Dialect, TimeColumn
from drillid.formats.log import Log

STAMPS = pd.date_range("2025-03-03T06:00", periods=50, freq="50ms").as_unit("ns")
NS = STAMPS.asi8
SPEED = np.linspace(119, 121, 50).round(3)
DATES, CLOCK = STAMPS.strftime("%Y-%m-%d"), STAMPS.strftime("%H:%M:%S.%f").str[:-3]
WHOLE = DATES + " " + CLOCK


def saved(path: Path, head: str = "", **columns: Sequence[object]) -> Path:
    """A log of such columns and a speed, as comma-separated text below some lines."""
    text = pd.DataFrame(columns).assign(RPM=SPEED).to_csv(index=False)
    path.write_text(head + text)
    return path


def read(path: Path, zone: str = "UTC") -> tuple[Log, list[str]]:
    """The log, read without a word about its times but a zone, and what is told of it."""
    found = read_log(path, None, ["RPM"], zone=zone)
    np.testing.assert_allclose(found.pop("RPM"), SPEED)
    return found, [what for what, _ in found.notes]


def check(path: Path, *told: str, zone: str = "UTC", stamps: pd.DatetimeIndex = STAMPS, within_ns: int = 0) -> None:
    """The log has these stamps, UTC, and so much is told of it."""
    found, notes = read(path, zone)
    assert np.abs(found.stamps.view(np.int64) - stamps.asi8).max() <= within_ns
    assert first_stamp(path, None, zone) == found.stamps.min()
    for words in told:
        assert any(words in what for what in notes), notes


@pytest.mark.parametrize("names", ["Datum Uhrzeit", "Datum Tijd", "Date Ora", "Date Clock", "Dato Klokkeslett"])
def test_date_and_time_of_day_are_known_by_their_names(names: str, tmp_path: Path) -> None:
    date, time = names.split()
    path = saved(tmp_path / "log.csv", **{date: DATES, time: CLOCK})
    check(path, f"the times are taken from column '{time}'", f"the dates are taken from column '{date}'")


def test_dates_alone_are_no_times(tmp_path: Path) -> None:
    for dates in (DATES, STAMPS.strftime("%d.%m.%Y")):
        path = saved(tmp_path / "log.csv", Datum=dates, Stunden=CLOCK)
        with pytest.raises(LogError, match=r"'Datum': holds dates without times of day.*time\.column.*time\.date"):
            read_log(path, None, ["RPM"])
    path = tmp_path / "log.parquet"
    pd.DataFrame({"Date": STAMPS.date, "RPM": SPEED}).to_parquet(path)
    with pytest.raises(LogError, match="holds dates without times of day"):
        read_log(path, None, ["RPM"])


@pytest.mark.parametrize("sign", [".", ":"])
@pytest.mark.parametrize("suffix", ["", "Z"])
@pytest.mark.parametrize("step", [1, -1])
def test_milliseconds_may_lack_their_leading_zeros(sign: str, suffix: str, step: int, tmp_path: Path) -> None:
    fractions = pd.Index([str(milli) for milli in STAMPS.microsecond // 1000])
    times = STAMPS.strftime("%Y-%m-%dT%H:%M:%S") + sign + fractions + suffix
    path = saved(tmp_path / "log.csv", Time=times[::step])
    check(path, "are read as whole milliseconds", stamps=STAMPS[::step])


def test_decimals_of_seconds_may_lack_their_last_zeros(tmp_path: Path) -> None:
    fractions = [f"{milli / 1000:.3f}"[1:].rstrip("0").rstrip(".") for milli in STAMPS.microsecond // 1000]
    path = saved(tmp_path / "log.csv", Time=STAMPS.strftime("%Y-%m-%d %H:%M:%S") + pd.Index(fractions))
    check(path)
    assert read(path)[1] == []


def test_counts_of_net_and_windows_are_known_by_their_size(tmp_path: Path) -> None:
    ticks = 621_355_968_000_000_000 + NS // 100
    check(saved(tmp_path / "ticks.csv", Time=ticks), "read as ticks of .NET, 100 ns since the year 1, in the zone UTC")
    path = saved(tmp_path / "oslo.csv", Time=ticks + 36_000_000_000)
    check(path, "in the zone Europe/Oslo", zone="Europe/Oslo")
    file_times = 116_444_736_000_000_000 + NS // 100
    path = saved(tmp_path / "file_times.csv", Time=file_times)
    check(path, "file times of Windows, 100 ns since 1601, UTC", zone="Europe/Oslo")
    found = read_log(path, TimeColumn("Time", unit="filetime"), ["RPM"])
    assert (found.stamps == STAMPS.to_numpy()).all()


@pytest.mark.parametrize(
    ("name", "hours"),
    [
        ("Time [UTC+3]", 3),
        ("Time (UTC+03:00)", 3),
        ("Timestamp [Europe/Oslo]", 1),
        ("Time (GMT-05:30)", -5.5),
        ("Time (UTC)", 0),
        ("Time_UTC", 0),
        ("Time UTC+2", 2),
        ("UTC+2", 2),
    ],
)
def test_the_zone_in_a_columns_name_is_that_of_its_times(name: str, hours: float, tmp_path: Path) -> None:
    local = STAMPS + pd.Timedelta(hours=hours)
    path = saved(tmp_path / "log.csv", **{name: local.strftime("%Y-%m-%d %H:%M:%S.%f")})
    check(path, f"the times in column '{name}' are in the zone", zone="America/Chicago")


@pytest.mark.parametrize("name", ["Time [CST]", "Time (CET)"])
def test_an_abbreviation_of_a_zone_is_told_not_to_be_used(name: str, tmp_path: Path) -> None:
    path = saved(tmp_path / "log.csv", **{name: WHOLE})
    check(path, f"{name[-4:-1]} at column '{name}' stands for several zones; UTC is assumed")


def test_the_zone_in_the_row_of_units_is_that_of_the_times(tmp_path: Path) -> None:
    rows = saved(tmp_path / "log.csv", Time=WHOLE).read_text().partition("\n")[2]
    (tmp_path / "log.csv").write_text(f"Time,RPM\nUTC+3,rpm\n{rows}")
    check(tmp_path / "log.csv", "in the zone UTC+03:00", stamps=STAMPS - pd.Timedelta(hours=3))


def test_a_zone_elsewhere_in_the_file_is_told_not_to_be_used(tmp_path: Path) -> None:
    path = saved(tmp_path / "log.csv", "# Timezone: UTC+03:00\n", Time=WHOLE)
    check(path, "line 1 states a time zone, which is not used: '# Timezone: UTC+03:00'")
    path = saved(tmp_path / "log.csv", **{"Time": WHOLE, "UTC Offset": ["+01:00"] * 50})
    check(path, "the zone in column 'UTC Offset' is not used; those in column 'Time' are assumed to be in UTC")
    assert read(saved(tmp_path / "log.csv", **{"Time": WHOLE + "Z", "UTC Offset": ["+01:00"] * 50}))[1] == []


def test_times_of_day_with_a_zone_beside_dates_are_in_it(tmp_path: Path) -> None:
    check(saved(tmp_path / "log.csv", Date=DATES, Time=CLOCK + "Z"), zone="Europe/Oslo")
    early = pd.date_range("2025-03-03T23:59:59", periods=50, freq="50ms").as_unit("ns")
    local = early + pd.Timedelta(hours=2)
    clock = local.strftime("%H:%M:%S.%f").str[:-3] + "+02:00"
    check(saved(tmp_path / "log.csv", Date=local.strftime("%Y-%m-%d"), Time=clock), zone="Europe/Oslo", stamps=early)


def test_fractions_of_a_day_and_its_seconds_beside_dates(tmp_path: Path) -> None:
    seconds = (STAMPS - STAMPS.normalize()).total_seconds()
    fractions = pd.Index([f"{second / 86400:.9f}" for second in seconds])
    check(saved(tmp_path / "log.csv", Date=["45719"] * 50, Time=fractions), within_ns=60_000)
    check(saved(tmp_path / "log.csv", **{"Date": DATES, "Time (s)": [f"{second:.2f}" for second in seconds]}))
    late = STAMPS + pd.Timedelta(seconds=61)
    path = saved(tmp_path / "log.csv", Date=DATES, Time=[f"{second + 61:.2f}" for second in seconds])
    check(path, "the times in column 'Time' are read as seconds of the day", stamps=late)
    path = saved(tmp_path / "log.csv", Date=DATES, Time=STAMPS.strftime("%H%M%S.%f"))
    check(path)


@pytest.mark.parametrize(
    ("name", "start", "step", "clock"),
    [
        ("Time", 10_200.0, 0.05, "02:50:00"),
        ("Time", 10_200.0, 1.0, "02:50:00"),
        ("Time", 10_259.0, 1e-4, "01:02:59"),
        ("Time (s)", 10_200.0, 0.05, "02:50:00"),
        ("Time (s)", 0.2, 5e-4, "00:00:00.200"),
    ],
)
def test_the_first_stamp_is_read_as_the_whole_log_where_its_first_rows_may_be_seconds_of_the_day_or_digits(
    name: str, start: float, step: float, clock: str, tmp_path: Path
) -> None:
    rows = start + step * np.arange(3000)
    path = tmp_path / "log.csv"
    pd.DataFrame({"Date": "2025-03-03", name: rows.round(4), "RPM": 120.0}).to_csv(path, index=False)
    assert read_log(path, None, ["RPM"]).stamps.min() == np.datetime64(f"2025-03-03T{clock}")
    assert first_stamp(path, None) == np.datetime64(f"2025-03-03T{clock}")


@pytest.mark.parametrize("name", ["", "recorded at", "When"])
def test_the_only_column_of_stamps_holds_the_times_whatever_its_name(name: str, tmp_path: Path) -> None:
    check(saved(tmp_path / "log.csv", **{name: WHOLE}), f"the times are taken from column '{name or 'column 1'}'")
    path = tmp_path / "log.parquet"
    pd.DataFrame({"RPM": SPEED}, index=pd.Index(STAMPS)).to_parquet(path)
    check(path, "the times are taken from column '__index_level_0__'")
    with pytest.raises(LogError, match="no column that is named like a time"):
        read_log(saved(tmp_path / "two.csv", Sent=WHOLE, Received=WHOLE), None, ["RPM"])


def test_of_two_times_those_with_dates_are_taken(tmp_path: Path) -> None:
    since_start = [f"{second:.2f}" for second in (NS - NS[0]) * 1e-9]
    path = saved(tmp_path / "log.csv", **{"Time (s)": since_start, "DateTime": WHOLE})
    check(path, "the times are taken from column 'DateTime'")
    check(saved(tmp_path / "log.csv", Time=CLOCK, Timestamp=WHOLE), "the times are taken from column 'Timestamp'")
    path = saved(tmp_path / "log.csv", Time=NS // 10**6, DateTime=WHOLE)
    check(path, "the times in column 'Time' are read as ms since 1970", zone="Europe/Oslo")


def test_milliseconds_in_a_column_of_their_own_are_added(tmp_path: Path) -> None:
    milli = STAMPS.microsecond // 1000
    seconds, clock = STAMPS.strftime("%Y-%m-%d %H:%M:%S"), STAMPS.strftime("%H:%M:%S")
    check(saved(tmp_path / "log.csv", Time=seconds, ms=milli), "the milliseconds in column 'ms' are added to the times")
    check(saved(tmp_path / "log.csv", Date=DATES, Time=clock, Millisecond=[f"{each:03d}" for each in milli]))
    check(saved(tmp_path / "log.csv", Time=WHOLE, ms=milli))
    found, told = read(saved(tmp_path / "log.csv", Time=seconds, ms=np.arange(50) * 50))
    assert (found.stamps == STAMPS.floor("s").to_numpy()).all()
    assert any("its row 21 is '1000'" in what for what in told)


def test_points_of_decimals_or_of_thousands_are_a_question(tmp_path: Path) -> None:
    torque = [950 + 10 * at for at in range(50)]
    path = tmp_path / "log.csv"
    written = [f"{each:,d}".replace(",", ".") for each in torque]
    pd.DataFrame({"Time": WHOLE, "TQ": written}).to_csv(path, sep=";", index=False)
    with pytest.raises(LogError, match=r"'1\.000' and '950' in column 'TQ': is the point for decimals or thousands"):
        read_log(path, None, ["TQ"])
    np.testing.assert_allclose(read_log(path, None, ["TQ"], dialect=Dialect(decimal=",")).pop("TQ"), torque)
    np.testing.assert_allclose(read_log(path, None, ["TQ"], dialect=Dialect(thousands=".")).pop("TQ"), torque)
    assert read_log(path, None, ["TQ"], dialect=Dialect(decimal=".")).pop("TQ")[5] == 1.0
    path.write_text(path.read_text().replace(";950", ";950.5"))
    assert read_log(path, None, ["TQ"]).pop("TQ")[:2].tolist() == [950.5, 960]


def test_names_may_be_wrapped_in_their_cells(tmp_path: Path) -> None:
    rows = saved(tmp_path / "log.csv", Time=WHOLE).read_text().partition("\n")[2]
    path = tmp_path / "log.csv"
    path.write_text(f'Rig 7,"12 1/4"" section"\n"Time","Rotary\nspeed\n(rpm)"\n{rows}')
    found = read_log(path, None, ["Rotary speed (rpm)"])
    np.testing.assert_allclose(found.pop("Rotary speed (rpm)"), SPEED)
    assert found.units == {"Rotary speed (rpm)": "rpm"}
    path.write_text(f'Rig 7, 12 1/4" section\nTime,RPM\n{rows}')
    check(path)
    path.write_text(f'Rig 7,"12 1/4 section\nTime,RPM\n{rows}')
    check(path)


def test_words_of_historians_among_numbers_are_missing_values(tmp_path: Path) -> None:
    torque = ["No Data", "12.5", "No Data", "Bad Input", *map(str, range(45)), "Bad Input"]
    found = read_log(saved(tmp_path / "log.csv", Time=WHOLE, TQ=torque), None, ["TQ"])
    assert np.flatnonzero(np.isnan(found.pop("TQ"))).tolist() == [0, 2, 3, 49]
    [(told, _)] = found.notes
    assert "'No Data' (2), 'Bad Input' (2) of column 'TQ' are taken as missing values" in told
    for wrong in ("No Data", "12a"):
        torque[:4] = [wrong, wrong if wrong == "12a" else "1", "2", "3"]
        path = saved(tmp_path / "log.csv", Time=WHOLE, TQ=[*torque[:49], "4"])
        with pytest.raises(LogError, match=f"'{wrong}' is not a number"):
            read_log(path, None, ["TQ"]).pop("TQ")


def test_the_null_values_of_recorders_are_missing(tmp_path: Path) -> None:
    path = saved(tmp_path / "log.csv", Time=WHOLE, TQ=[-9999.25, -999.25, -9999, *range(47)])
    assert np.isnan(read_log(path, None, ["TQ"]).pop("TQ")).sum() == 3


@pytest.mark.parametrize("between", [" ", "T"])
def test_offsets_may_be_whole_hours_and_change(between: str, tmp_path: Path) -> None:
    stamps = pd.date_range("2025-10-26T00:59:59", periods=50, freq="50ms").as_unit("ns")
    local = stamps.tz_localize("UTC").tz_convert("Europe/Oslo")
    offsets = local.strftime("%z").str[:3]
    path = saved(tmp_path / "log.csv", Time=local.strftime(f"%Y-%m-%d{between}%H:%M:%S.%f") + offsets)
    check(path, zone="America/Chicago", stamps=stamps)
    assert set(offsets) == {"+01", "+02"}
    check(saved(tmp_path / "log.csv", Time=STAMPS.strftime("%Y-%m-%d %H:%M:%S.%f")), zone="UTC")


@pytest.mark.parametrize("offset", ["Z", "+00:00", "+00", "+0000"])
def test_the_row_that_alone_lacks_or_has_an_offset_is_named(offset: str, tmp_path: Path) -> None:
    plain = list(STAMPS.strftime("%Y-%m-%d %H:%M:%S.%f"))
    whole = [cell + offset for cell in plain]
    for cells, what in (
        ([*whole[:30], plain[30], *whole[31:]], "has no offset from UTC, unlike"),
        ([*plain[:30], whole[30], *plain[31:]], "has an offset from UTC, unlike"),
    ):
        path = saved(tmp_path / "log.csv", Time=cells)
        with pytest.raises(LogError, match=rf"column 'Time', row 31: '{plain[30]}.* {what} most others") as raised:
            read_log(path, None, ["RPM"])
        assert "in line 32 of the file" in raised.value.remedy
    damaged = [*whole[:20], "yesterday", *whole[21:30], plain[30], *whole[31:]]
    with pytest.raises(LogError, match="row 21: 'yesterday' is not a time"):
        read_log(saved(tmp_path / "log.csv", Time=damaged), None, ["RPM"])


@pytest.mark.parametrize("form", ["parquet", "feather"])
def test_stated_null_values_are_missing_in_single_precision_too(tmp_path: Path, form: str) -> None:
    speed = SPEED.astype(np.float32)
    speed[10:20] = -999.9
    table = pd.DataFrame({"Time": STAMPS, "RPM": speed})
    path = tmp_path / f"log.{form}"
    table.to_parquet(path) if form == "parquet" else table.to_feather(path)
    found = read_log(path, None, ["RPM"], dialect=Dialect(null_values=(-999.9,))).pop("RPM")
    assert np.flatnonzero(np.isnan(found)).tolist() == list(range(10, 20))


@pytest.mark.parametrize("cells", [",,,", ",nan,nan,nan", ",No Data,No Data,No Data"])
@pytest.mark.parametrize("between", ["T", " "])
def test_rows_of_stamps_alone_are_no_header(tmp_path: Path, cells: str, between: str) -> None:
    """As a historian begins, and in the form of stamps that messages recommend."""
    stamps = pd.date_range("2025-03-03T06:00", periods=200, freq="20ms").strftime(f"%Y-%m-%d{between}%H:%M:%S.%f")
    rows = [f"{stamp}Z{cells if row < 60 else f',{row},120.5,2500'}" for row, stamp in enumerate(stamps)]
    (tmp_path / "log.csv").write_text("\n".join(["Time,SWEEP,RPM,DMEA", *rows]))
    log = read_log(tmp_path / "log.csv", None, ["SWEEP", "RPM"])
    assert log.stamps.size == 200
    assert np.count_nonzero(np.isnan(log.pop("SWEEP"))) == 60


@pytest.mark.parametrize(
    "head",
    [["Date,2025-03-04,,"], ["Rig,7,,"], ["Well,A-1,,", "Rig,7,,"], ["Start,2025-03-03,,", "End,2025-03-04,,", ",,,"]],
)
def test_what_a_workbook_has_above_its_table_is_no_data(tmp_path: Path, head: list[str]) -> None:
    stamps = pd.date_range("2025-03-03T06:00", periods=100, freq="20ms").strftime("%Y-%m-%d %H:%M:%S.%f")
    rows = [f"{stamp},{row},120.5,2500" for row, stamp in enumerate(stamps)]
    (tmp_path / "log.csv").write_text("\n".join([*head, "Time,SWEEP,RPM,DMEA", *rows]))
    log = read_log(tmp_path / "log.csv", None, ["SWEEP"])
    np.testing.assert_array_equal(log.pop("SWEEP"), np.arange(100))


def test_milliseconds_without_zeros_are_told_though_rows_are_out_of_order(tmp_path: Path) -> None:
    stamps = pd.date_range("2025-03-03T06:00", periods=6000, freq="10ms")
    written = [f"{at:%Y-%m-%d %H:%M:%S}.{at.microsecond // 1000}" for at in stamps]
    written[1333], written[1334] = written[1334], written[1333]
    pd.DataFrame({"Time": written, "RPM": 120.0}).to_csv(tmp_path / "log.csv", index=False)
    found = read_log(tmp_path / "log.csv", None, ["RPM"]).stamps.astype(np.int64)
    np.testing.assert_array_equal(np.sort(found), stamps.as_unit("ns").asi8)


def test_a_row_that_is_commented_out_is_left_out(tmp_path: Path) -> None:
    rows = [f"2025-03-03T06:00:{row // 10:02d}.{row % 10}00Z,{row}" for row in range(500)]
    rows[300] = "#" + rows[300]
    (tmp_path / "log.csv").write_text("\n".join(["Time,RPM", *rows]))
    assert np.setdiff1d(np.arange(500), read_log(tmp_path / "log.csv", None, ["RPM"]).pop("RPM")).tolist() == [300]
