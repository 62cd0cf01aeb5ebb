"""LAS and WITSML as programs of different makers write them: thirty rows from 06:00:00 UTC, one a second."""

from pathlib import Path

import numpy as np
import pytest

from drillid.errors import LogError
from drillid.formats import Dialect, TimeColumn, headers, read_log

VERSION = "~Version\nVERS. 2.0:\nWRAP. NO:\n"
WELL = "~Well\nSTRT.S 0 :\nSTOP.S 29:\nSTEP.S 1:\nNULL. -999.25:\n"
CURVES = "TQA .kft.lbf : torque\nRPMA.rev/min: rpm\n"
SECONDS = range(30)


def las(
    times: str,
    cells: str,
    head: str = VERSION + WELL,
    curves: str = CURVES,
    data: str = "~A",
    rows: range = SECONDS,
) -> str:
    """A LAS file; `cells` of a row's times with its second as {s:02d}."""
    lines = "".join(f"{cells.format(s=second)} 1.5 120\n" for second in rows)
    return f"{head}~Curve\n{times}\n{curves}{data}\n{lines}"


THIRD = (
    "~Version\nVERS. 3.0 :\nWRAP. NO :\nDLM. COMMA :\n~Well\nSTRT. 2025-03-04T06:00:00 :\n"
    "NULL. -999.25 :\n~{0}_Definition{1}\nTIME. {{YYYY-MM-DDThh:mm:ss}} : t\n" + CURVES
)


def third(kind: str, number: str, seconds: range) -> str:
    """A section of data of LAS 3.0, of the definition of its kind with the number 1, if any."""
    rows = "".join(f"2025-03-04T06:00:{second:02d}Z,1.5,120\n" for second in seconds)
    return f"~{kind}_Data{number} | {kind}_Definition{'[1]' if number else ''}\n{rows}"


LAS = {
    "date and time by their units": las("DATE.YYYY/MM/DD : d\nTIME.HH:MM:SS : t", "2025/03/04 06:00:{s:02d}"),
    "day, month, short year": las("DATE.DDMMYY : d\nTIME.HHMMSS : t", "040325 0600{s:02d}"),
    "leading zeros lost": las("DATE.DDMMYY : d\nTIME.HHMMSS : t", "40325 600{s:02d}"),
    "month first by its unit": las("DATE.MM/DD/YYYY : d\nTIME.HH:MM:SS : t", "03/04/2025 06:00:{s:02d}"),
    "day first by its unit": las("DATE.DD/MM/YYYY : d\nTIME.HH:MM:SS : t", "04/03/2025 06:00:{s:02d}"),
    "named month": las("DATE.DD-MMM-YY : d\nTIME.HH:MM:SS : t", "04-MAR-25 06:00:{s:02d}"),
    "LAS 1.2": las(
        "DATE.YYYYMMDD : d\nTIME.HHMMSS : t",
        "20250304 0600{s:02d}",
        "~Version\nVERS. 1.2:\nWRAP. NO:\n" + WELL + "WELL. WELL: 34/10-A-12\n",
        data="~A  DATE TIME TQA RPMA",
    ),
    "start in STRT": las(
        "ETIM.S : t", "{s}", VERSION + WELL.replace("STRT.S 0 :", "STRT.  2025-03-04T06:00:00 : start")
    ),
    "start among the parameters": las(
        "ETIM.S : t", "{s}", VERSION + WELL + "~Parameter\nSTIME. 2025-03-04 06:00:00 : start time\n"
    ),
    "epoch": las("TIME.S : unix", "17410680{s:02d}"),
    "rules and comments": las(
        "TIME. : t", "   2025-03-04T06:00:{s:02d}Z ", "#====\n# LAS\n" + VERSION + "#--\n" + WELL
    ),
    "seconds of the day": las(
        "TIME.S : t",
        "216{s:02d}",
        VERSION + WELL.replace("STRT.S 0", "STRT.S 21600") + "DATE. 2025-03-04 : d\nSTIM. 06:00:00 : t\n",
    ),
    "seconds of the day from a date": las(
        "TIME.S : second of the day", "216{s:02d}", VERSION + WELL + "DATE. 2025-03-04 : d\n"
    ),
    "continued": las(
        "ETIM.S : t",
        "36{s:02d}",
        VERSION + WELL.replace("STRT.S 0", "STRT.S 3600") + "STIME. 2025-03-04 06:00:00 : t\n",
    ),
    "decimals of a second that its unit leaves out": las("TIME.DD/MM/YY_HH:MM:SS : t", "04/03/25_06:00:{s:02d}.000"),
    "start behind its description, as in LAS 1.2": las(
        "ETIM.S : t",
        "{s}",
        VERSION.replace("2.0", "1.2") + WELL + "DATE. LOG DATE : 04-MAR-2025\nSTIM. START TIME : 06:00:00\n",
    ),
    "end of the file marked": las("TIME : t", "2025-03-04T06:00:{s:02d}Z") + "\x1a",
    "two files in one": las("TIME : t", "2025-03-04T06:00:{s:02d}Z", rows=range(12))
    + "\x1a"
    + las("TIME : t", "2025-03-04T06:00:{s:02d}Z", VERSION + WELL.replace("STRT.S 0", "STRT.S 12"), rows=range(12, 30)),
    "two sections with one definition": THIRD.format("Log", "[1]")
    + third("Log", "[1]", range(12))
    + third("Log", "[2]", range(12, 30)),
    "drilling data of LAS 3.0": THIRD.format("Drilling", "") + third("Drilling", "", SECONDS),
    "log data beside other data": THIRD.format("Log", "")
    + "~Tops_Parameter\nTOPS. x :\n~Tops_Definition\nNAME. : n\nDEPT.M : d\n~Tops_Data | Tops_Definition\nBase,3100\n"
    + third("Log", "", SECONDS),
    "space in the stamp": las("TIME.YYYY-MM-DD hh:mm:ss : t", "2025-03-04 06:00:{s:02d}"),
}


@pytest.mark.parametrize("name", LAS)
def test_las_of_many_makers(name: str, tmp_path: Path) -> None:
    path = tmp_path / "log.las"
    path.write_text(LAS[name])
    log = read_log(path, TimeColumn(), ["TQA", "RPMA"])
    start = np.datetime64("2025-03-04T06:00", "ns")
    assert (log.stamps == start + np.arange(30) * np.timedelta64(1, "s")).all()
    assert log.pop("TQA").tolist() == [1.5] * 30
    assert log.units == {"TQA": "kft.lbf", "RPMA": "rev/min"}


def test_starts_in_las_are_in_their_own_zone_or_the_rig_s(tmp_path: Path) -> None:
    path = tmp_path / "log.las"
    for zone, start in (("", "03-03T23:30"), ("Z", "03-04T00:30"), ("+02:00", "03-03T22:30")):
        head = VERSION + WELL.replace("STRT.S 0 :", f"STRT. 2025-03-04T00:30:00{zone} : start")
        for column, cells in (("ETIM.S : t", "{s}"), ("TIME.HH:MM:SS : t", "00:30:{s:02d}")):
            path.write_text(las(column, cells, head))
            log = read_log(path, TimeColumn(zone="Europe/Oslo"), ["TQA"])
            expected = np.datetime64(f"2025-{start}", "ns") + np.arange(30) * np.timedelta64(1, "s")
            assert (log.stamps == expected).all()


def test_a_stated_start_with_a_zone_dates_times_of_day_in_that_zone(tmp_path: Path) -> None:
    path = tmp_path / "log.las"
    path.write_text(las("TIME.HH:MM:SS : t", "00:30:{s:02d}"))
    log = read_log(path, TimeColumn(start="2025-03-04T00:30:00+02:00"), ["TQA"])
    assert log.stamps[0] == np.datetime64("2025-03-03T22:30", "ns")


@pytest.mark.parametrize(
    ("column", "cells", "well"),
    [
        ("ETIM.S : t", "36{s:02d}", WELL + "DATE. 2025-03-04 : d\nSTIM. 06:00:00 : t\n"),
        ("ETIM.S : t", "36{s:02d}", WELL.replace("STRT.S 0", "STRT.S 3600") + "DATE. 2025-03-04 : d\n"),
        ("TIME.HHMMSS : t", "0600{s:02d}", WELL + "DATE. 2025-03-04 : d\nSTIM. 06:00:00 : t\n"),
    ],
)
def test_times_of_las_whose_start_is_open_are_refused(column: str, cells: str, well: str, tmp_path: Path) -> None:
    path = tmp_path / "log.las"
    path.write_text(las(column, cells, VERSION + well))
    with pytest.raises(LogError, match=r"row 1: '.*' is not a time.*time\.start"):
        read_log(path, None, ["TQA"])


def test_what_is_counted_tells_its_start_and_the_first_time(tmp_path: Path) -> None:
    path = tmp_path / "log.las"
    path.write_text(LAS["continued"])
    assert [what for what, _ in read_log(path, TimeColumn(), ["TQA"]).notes][-1] == (
        "the times in column 'ETIM' count from 2025-03-04T05:00:00.000, as the file's header says: "
        "the first is 2025-03-04T06:00:00.000 UTC"
    )


@pytest.mark.parametrize(
    ("what", "second"),
    [
        ("the curves", las("TIME : t", "2025-03-04T07:00:{s:02d}Z", curves=CURVES.replace("RPMA", "RPM"))),
        ("the units", las("TIME : t", "2025-03-04T07:00:{s:02d}Z", curves=CURVES.replace("kft.lbf", "kN.m"))),
        ("the null values", las("TIME : t", "2025-03-04T07:00:{s:02d}Z", VERSION + WELL.replace("-999.25", "0"))),
    ],
)
def test_las_files_in_one_that_contradict_each_other_are_refused(what: str, second: str, tmp_path: Path) -> None:
    path = tmp_path / "log.las"
    path.write_text(las("TIME : t", "2025-03-04T06:00:{s:02d}Z") + second)
    with pytest.raises(LogError, match=rf"several sections of data, and {what} of '~A' are not those of the first"):
        read_log(path, None, ["TQA"])


def test_what_is_left_out_of_las_is_told(tmp_path: Path) -> None:
    path = tmp_path / "log.las"
    whole = LAS["two files in one"]
    path.write_text(
        whole.replace("06:00:14Z", "06:00:14Z 1.5 120\nstopped\n2025-03-04T06:00:14Z") + "2025-03-04T06:00:30Z 1."
    )
    log = read_log(path, None, ["TQA"])
    assert log.pop("TQA").size == 31
    lines = path.read_text().splitlines()
    places = [f"line {lines.index(line) + 1} is" for line in ("stopped", "2025-03-04T06:00:30Z 1.")]
    assert [note[: len(place)] for (note, _), place in zip(log.notes, places, strict=True)] == places
    path.write_text(path.read_text().replace("2025-03-04T06:00:20Z", "then,20"))
    line = path.read_text().splitlines().index("then,20 1.5 120") + 1
    with pytest.raises(LogError, match=rf"row 22: 'then,20' is not a time.* in line {line} of the file"):
        read_log(path, None, ["TQA"])
    path.write_text(LAS["rules and comments"].replace("06:00:14Z  1.5 120", "06:00:14Z  1.5 120\n#a b c\nstopped"))
    assert read_log(path, None, ["TQA"]).pop("TQA").tolist() == [1.5] * 30
    path.write_text(LAS["log data beside other data"])
    assert "and not '~Tops_Data | Tops_Definition'" in read_log(path, None, ["TQA"]).notes[0][0]


def test_a_format_by_a_unit_is_not_said_to_be_the_user_s(tmp_path: Path) -> None:
    path = tmp_path / "log.las"
    path.write_text(las("TIME.DD/MM/YY_HH:MM:SS : t", "04/03/25T06:00:{s:02d}"))
    with pytest.raises(
        LogError, match=r"from the unit of column 'TIME' in the file\. State another format as time\.format"
    ):
        read_log(path, None, ["TQA"])


def test_curves_with_a_colon_in_their_mnemonics_are_kept_apart(tmp_path: Path) -> None:
    path = tmp_path / "log.las"
    path.write_text(
        las("TIME : t", "2025-03-04T06:00:{s:02d}Z", curves="TQ:1.kN.m : torque: a\nTQ:2.kN.m 1 : (b: c)\n")
    )
    assert headers(path)[0].columns == ("TIME", "TQ:1", "TQ:2")
    log = read_log(path, None, ["TQ:1", "TQ:2"])
    assert (log.units, log.pop("TQ:2")[0]) == ({"TQ:1": "kN.m", "TQ:2": "kN.m"}, 120.0)


def test_the_date_of_an_export_is_no_start(tmp_path: Path) -> None:
    path = tmp_path / "log.las"
    path.write_text(las("ETIM.S : t", "{s}", VERSION + WELL + "DATE.  2024-03-27 12:24:54 : Log Export Date\n"))
    with pytest.raises(LogError, match=r"'0' is not a time.*time\.start"):
        read_log(path, None, ["TQA"])


INFO = "".join(
    f"<logCurveInfo uid='{name}'><mnemonic>{name}</mnemonic><unit>{unit}</unit></logCurveInfo>"
    for name, unit in (("TIME", "s"), ("TQA", "kft.lbf"), ("RPMA", "rpm"))
)
INDEX = "<indexType>date time</indexType><indexCurve>TIME</indexCurve>"


def data(row: str, seconds: range = SECONDS) -> str:
    return "".join(f"<data>{row.format(t=f'2025-03-04T06:00:{second:02d}', s=second)}</data>" for second in seconds)


def witsml(rows: str, names: str = "TIME,TQA,RPMA", head: str = INDEX + INFO) -> str:
    lists = f"<mnemonicList>{names}</mnemonicList>" if names else ""
    return (
        f'<logs xmlns="http://www.witsml.org/schemas/1series" version="1.4.1.1"><log>{head}'
        f"<logData>{lists}{rows}</logData></log></logs>"
    )


TWO = data("{t}Z,1.5,120", range(12)) + "</logData><logData><mnemonicList>TIME,RPMA,TQA</mnemonicList>"
ESCAPED = witsml(data("{t}Z,1.5,120")).replace("<", "&lt;").replace(">", "&gt;")
WITSML = {
    "two blocks of data with other orders": witsml(TWO + data("{t}Z,120,1.5", range(12, 30))),
    "spaces": witsml(data(" {t}Z, 1.5, 120 "), "TIME, TQA, RPMA"),
    "index last": witsml(data("1.5,120,{t}Z"), "TQA,RPMA,TIME"),
    "another zone": witsml(data("{t}.000+00:00,1.5,120")),
    "Latin-1": '<?xml version="1.0" encoding="windows-1252"?>'
    + witsml(data("{t}Z,1.5,120"), head=f"<name>Å</name>{INDEX}{INFO}"),
    "text with commas": witsml(data('{t}Z,1.5,120,"drilling, rotary"'), "TIME,TQA,RPMA,ACT"),
    "more empty cells at the end than curves": witsml(data("{t}Z,1.5,120,,")),
    "latest row first": witsml(
        data("{t}Z,1.5,120", SECONDS[::-1]), head=f"<direction>decreasing</direction>{INDEX}{INFO}"
    ),
    "elapsed seconds": witsml(
        data("{s},1.5,120"),
        head="<startDateTimeIndex>2025-03-04T06:00:00Z</startDateTimeIndex>"
        + (INDEX + INFO).replace("date time", "elapsed time"),
    ),
    "known by their aliases": witsml(
        data("{t}Z,1.5,120"),
        "TIME,STQ,SRPM",
        INDEX
        + INFO.replace(
            "<mnemonic>TQA", "<mnemonic>STQ</mnemonic><mnemAlias namingSystem='WITS'>TQA</mnemAlias><mnemonic>STQ"
        ).replace("<mnemonic>RPMA</mnemonic>", "<mnemonic>SRPM</mnemonic><mnemAlias>RPMA</mnemAlias>"),
    ),
    "empty cells left out at the end": witsml(data("{t}Z,1.5,120"), "TIME,TQA,RPMA,ACT,GAS"),
    "1.3.1.1, columns by their numbers": witsml(
        data("{t}Z,1.5,120"),
        "",
        "<indexType>date time</indexType><indexCurve columnIndex='1'>1</indexCurve>"
        + INFO.replace("<unit>s</unit>", "<columnIndex>1</columnIndex>")
        .replace("<unit>kft.lbf", "<columnIndex>2</columnIndex><unit>kft.lbf")
        .replace("<unit>rpm", "<columnIndex>3</columnIndex><unit>rpm"),
    ),
    "an answer of a server": f'<s:Envelope xmlns:s="x"><s:Body><r><XMLout>{ESCAPED}</XMLout></r></s:Body></s:Envelope>',
    "one element for all rows": witsml(
        "<data>" + data("{t}Z,1.5,120").replace("<data>", "").replace("</data>", "\n") + "</data>"
    ),
}


@pytest.mark.parametrize("name", WITSML)
def test_witsml_of_many_makers(name: str, tmp_path: Path) -> None:
    path = tmp_path / "log.xml"
    path.write_text(WITSML[name], encoding="cp1252")
    log = read_log(path, TimeColumn(), ["TQA", "RPMA"])
    start = np.datetime64("2025-03-04T06:00", "ns")
    assert (np.sort(log.stamps) == start + np.arange(30) * np.timedelta64(1, "s")).all()
    assert (log.pop("TQA").tolist(), log.pop("RPMA").tolist()) == ([1.5] * 30, [120.0] * 30)
    assert log.units == {"TQA": "kft.lbf", "RPMA": "rpm"}


def test_logs_of_one_name_with_other_curves_can_be_told_apart(tmp_path: Path) -> None:
    path = tmp_path / "log.xml"
    first, second = (witsml(data("{t}Z,1"), f"TIME,{name}", f"<name>log</name>{INDEX}") for name in ("TQA", "RPMA"))
    path.write_text(first.replace("</logs>", "") + second[second.index("<log>") :])
    assert [header.table for header in headers(path)] == ["log", "log:2"]


def test_a_null_value_of_one_curve_is_that_of_no_other(tmp_path: Path) -> None:
    path = tmp_path / "log.xml"
    nulls = INFO.replace("<unit>rpm</unit>", "<unit>rpm</unit><nullValue>0</nullValue>")
    path.write_text(
        witsml(
            data("{t}Z,0,0", range(5)) + data("{t}Z,-7,120", range(5, 9)),
            head=INDEX + "<nullValue>-7</nullValue>" + nulls,
        )
    )
    log = read_log(path, None, ["TQA", "RPMA"])
    np.testing.assert_array_equal(log.pop("TQA"), [0.0] * 5 + [np.nan] * 4)
    np.testing.assert_array_equal(log.pop("RPMA"), [np.nan] * 5 + [120.0] * 4)


def test_blocks_of_a_log_with_different_curves_are_one_table(tmp_path: Path) -> None:
    path = tmp_path / "log.xml"
    blocks = (
        data("{t}Z,1.5", range(9))
        + "</logData><logData><mnemonicList>TIME,RPMA,TQA</mnemonicList>"
        + data("{t}Z,120,2.5", range(9, 20))
        + "</logData><logData><mnemonicList>TIME,RPMA</mnemonicList>"
        + data("{t}Z,130", range(20, 30))
    )
    path.write_text(witsml(blocks, "TIME,TQA", f"<name>L</name>{INDEX}{INFO}"))
    log = read_log(path, None, ["TQA", "RPMA"])
    assert (log.stamps == np.datetime64("2025-03-04T06:00", "ns") + np.arange(30) * np.timedelta64(1, "s")).all()
    np.testing.assert_array_equal(log.pop("TQA"), [1.5] * 9 + [2.5] * 11 + [np.nan] * 10)
    np.testing.assert_array_equal(log.pop("RPMA"), [np.nan] * 9 + [120.0] * 11 + [130.0] * 10)
    assert "some have no values of 'RPMA', 'TQA'" in log.notes[0][0]


def joined(*documents: str) -> str:
    """One document of the logs of several."""
    logs = [document[document.index("<log>") : document.index("</logs>")] for document in documents]
    return documents[0][: documents[0].index("<log>")] + "".join(logs) + "</logs>"


FIRST = witsml(data("{t}Z,1.5,120", range(15)), head=f"<name>A</name>{INDEX}{INFO}")
SECOND = witsml(data("{t}Z,1.5,120", range(15, 30)), head=f"<name>B</name>{INDEX}{INFO}")
ELAPSED = witsml(
    data("{s},1.5,120", range(15)),
    head="<name>A</name><startDateTimeIndex>2025-03-04T06:00:00</startDateTimeIndex>"
    + (INDEX + INFO).replace("date time", "elapsed time"),
)
CONTRADICTIONS = {
    "in the unit of 'TQA', 'kN.m' and 'kft.lbf'": joined(FIRST, SECOND.replace("kft.lbf", "kN.m")),
    "in the value of 'RPMA' for missing values": joined(
        FIRST, SECOND.replace("<unit>rpm</unit>", "<unit>rpm</unit><nullValue>0</nullValue>")
    ),
    "in the start of their elapsed times": joined(
        ELAPSED, ELAPSED.replace("<name>A", "<name>B").replace("T06:00:00", "T07:00:00")
    ),
}


@pytest.mark.parametrize("difference", CONTRADICTIONS)
def test_logs_that_contradict_each_other_are_tables_apart(difference: str, tmp_path: Path) -> None:
    path = tmp_path / "log.xml"
    path.write_text(CONTRADICTIONS[difference])
    with pytest.raises(LogError, match=r"its tables 'A', 'B' all hold.*file\.table"):
        read_log(path, None, ["TQA", "RPMA"])
    log = read_log(path, None, ["TQA", "RPMA"], dialect=Dialect(table="B"))
    assert log.pop("RPMA").tolist() == [120.0] * 15
    assert f"the log 'B' is not part of the table of 'A', from which it differs {difference}" in log.notes[0][0]


def test_null_values_of_all_recorders_keep_no_logs_apart(tmp_path: Path) -> None:
    path = tmp_path / "log.xml"
    stated = SECOND.replace("<unit>rpm</unit>", "<unit>rpm</unit><nullValue>-999.25</nullValue>")
    path.write_text(joined(FIRST, stated.replace(",120<", ",-999.25<")))
    values = read_log(path, None, ["RPMA"]).pop("RPMA")
    np.testing.assert_array_equal(values, [120.0] * 15 + [np.nan] * 15)


def test_units_beside_the_data_are_those_of_their_block(tmp_path: Path) -> None:
    path = tmp_path / "log.xml"
    unit = "<mnemonicList>TIME,TQA</mnemonicList><unitList>s,{}</unitList>"
    first, second = (unit.format(name) + data("{t}Z,1", range(9)) for name in ("kN.m", "kft.lbf"))
    path.write_text(witsml(first + "</logData><logData>" + second, "", INDEX))
    assert [header.units["TQA"] for header in headers(path)] == ["kN.m", "kft.lbf"]


def test_elapsed_times_count_from_a_start_in_its_own_zone_or_the_rig_s(tmp_path: Path) -> None:
    path = tmp_path / "log.xml"
    for zone, start in (("", 5), ("Z", 6), ("+01:00", 5)):
        path.write_text(ELAPSED.replace("T06:00:00<", f"T06:00:00{zone}<"))
        log = read_log(path, TimeColumn(zone="Europe/Oslo"), ["TQA"])
        assert log.stamps[0] == np.datetime64(f"2025-03-04T0{start}:00", "ns")
        assert log.notes[0][0].endswith(f"the first is 2025-03-04T0{start}:00:00.000 UTC")


def test_version_2_of_witsml_is_refused_with_what_to_do(tmp_path: Path) -> None:
    path = tmp_path / "log.xml"
    path.write_text('<Log xmlns="http://www.energistics.org/energyml/data/witsmlv2"><ChannelSet/></Log>')
    with pytest.raises(LogError, match=r"is in version 2 of WITSML\. Export it as WITSML 1\.4\.1\.1"):
        headers(path)


@pytest.mark.parametrize(
    "row", ["0,{0:03d} 12,50 120,1 2500,0", "{0} 12,50 120,1 2500,0", "{0}.5,  12.5, 120.1,2500.0"]
)
def test_a_comma_between_spaces_is_that_of_a_decimal_number(tmp_path: Path, row: str) -> None:
    head = "~V\nVERS. 2.0:\nWRAP. NO:\n~W\nSTRT.S 0 :\nNULL. -999.25:\n~C\nTIME.S : t\n"
    curves = "TQA.kN.m : q\nRPMA.rpm : r\nDMEA.m : d\n~A\n"
    (tmp_path / "log.las").write_text(head + curves + "\n".join(row.format(at) for at in range(1, 200)))
    time = TimeColumn("TIME", unit="s", start="2025-03-03T06:00:00")
    log = read_log(tmp_path / "log.las", time, ["TQA", "RPMA"])
    assert log.pop("TQA") == pytest.approx(np.full(199, 12.5))
    assert log.pop("RPMA") == pytest.approx(np.full(199, 120.1))
