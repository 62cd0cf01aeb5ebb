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


def las(times: str, cells: str, head: str = VERSION + WELL, curves: str = CURVES, data: str = "~A") -> str:
    """A LAS file; `cells` of a row's times with its second as {s:02d}."""
    rows = "".join(f"{cells.format(s=second)} 1.5 120\n" for second in SECONDS)
    return f"{head}~Curve\n{times}\n{curves}{data}\n{rows}"


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
    assert f"the log 'B' is no part of the table of 'A', from which it differs {difference}" in log.notes[0][0]


def test_units_beside_the_data_are_those_of_their_block(tmp_path: Path) -> None:
    path = tmp_path / "log.xml"
    unit = "<mnemonicList>TIME,TQA</mnemonicList><unitList>s,{}</unitList>"
    first, second = (unit.format(name) + data("{t}Z,1", range(9)) for name in ("kN.m", "kft.lbf"))
    path.write_text(witsml(first + "</logData><logData>" + second, "", INDEX))
    assert [header.units["TQA"] for header in headers(path)] == ["kN.m", "kft.lbf"]


def test_elapsed_times_count_from_a_start_in_its_own_zone_or_the_rig_s(tmp_path: Path) -> None:
    path = tmp_path / "log.xml"
    for zone, start, told in (("", 5, "Europe/Oslo"), ("Z", 6, "UTC"), ("+01:00", 5, "UTC")):
        path.write_text(ELAPSED.replace("T06:00:00<", f"T06:00:00{zone}<"))
        log = read_log(path, TimeColumn(zone="Europe/Oslo"), ["TQA"])
        assert log.stamps[0] == np.datetime64(f"2025-03-04T0{start}:00", "ns")
        assert log.notes[0][0].endswith(f"the first is 2025-03-04T0{start if zone else 6}:00:00.000 {told}")


def test_version_2_of_witsml_is_refused_with_what_to_do(tmp_path: Path) -> None:
    path = tmp_path / "log.xml"
    path.write_text('<Log xmlns="http://www.energistics.org/energyml/data/witsmlv2"><ChannelSet/></Log>')
    with pytest.raises(LogError, match=r"is of version 2 of WITSML\. Export it as WITSML 1\.4\.1\.1"):
        headers(path)
