"""The log in LAS and WITSML as different programs write them."""

from __future__ import annotations

import gzip
from pathlib import Path

import pandas as pd

from tests.unit.formats.numbers import NUMBERS, UNITS, iso, since_1970


def _las(rows: str, curves: str, well: str = "", version: str = "2.0", wrap: str = "NO", data: str = "~A") -> str:
    return (
        f"~VERSION INFORMATION\n VERS.   {version} : CWLS LOG ASCII STANDARD - VERSION {version}\n"
        f" WRAP.   {wrap} : see the standard\n~WELL INFORMATION BLOCK\n#MNEM.UNIT  DATA : DESCRIPTION\n"
        " STRT.S  0.0 : START TIME\n STOP.S  29.98 : STOP TIME\n STEP.S  0.02 : STEP\n NULL.  -999.25 : NULL VALUE\n"
        f" COMP.  A: B & CO : COMPANY\n WELL.  34/10-A-12 H : WELL\n{well}~CURVE INFORMATION\n{curves}"
        "~PARAMETER INFORMATION\n RIG .  Rig 7 : RIG: the seventh\n~OTHER\n Remarks: 12:00 nothing. ~ A line\n"
        f"{data}\n{rows}"
    )


def _curves(first: str) -> str:
    return first + "".join(f" {name:<6}.{unit:<8} 00 000 00 00 : {name}: of the rig\n" for name, unit in UNITS.items())


def las_iso(log: pd.DataFrame, folder: Path) -> list[Path]:
    """Columns with spaces, stamps in ISO, lines with carriage returns."""
    stamped = log.assign(Time=log["Time"].dt.strftime("%Y-%m-%dT%H:%M:%S.%f"))
    rows = stamped.to_csv(index=False, header=False, sep=" ", lineterminator="\r\n")
    (folder / "log.LAS").write_text(_las(rows, _curves(" TIME  .          : time, UTC\n")), newline="")
    return [folder / "log.LAS"]


def las_wrapped(log: pd.DataFrame, folder: Path) -> list[Path]:
    """Rows over several lines, elapsed seconds."""
    seconds = since_1970(log) - since_1970(log)[0]
    rows = "".join(
        f"{at:12.3f}\n"
        + "".join(f"{value:14.5f}" for value in row[:4])
        + "\n"
        + "".join(f"{v:14.5f}" for v in row[4:])
        + "\n"
        for at, row in zip(seconds, log[NUMBERS].to_numpy(), strict=True)
    )
    (folder / "log.las").write_text(_las(rows, _curves(" ETIM  .S         : elapsed time\n"), wrap="YES"))
    return [folder / "log.las"]


def las_date_and_time(log: pd.DataFrame, folder: Path) -> list[Path]:
    """Tabs, date and time apart."""
    apart = log.assign(Time=log["Time"].dt.strftime("%d-%b-%Y"))
    apart.insert(1, "clock", log["Time"].dt.strftime("%H:%M:%S.%f").str[:-3])
    rows = apart.to_csv(index=False, header=False, sep="\t")
    curves = _curves(" DATE.DD-MMM-YYYY : date\n TIME.HH:MM:SS : time\n")
    (folder / "log.las").write_text(_las(rows, curves, data="~ASCII LOG DATA"))
    return [folder / "log.las"]


def las_3(log: pd.DataFrame, folder: Path) -> list[Path]:
    """LAS 3.0 with commas."""
    rows = log.assign(Time=iso(log)).to_csv(index=False, header=False)
    text = _las(
        rows,
        _curves(" TIME  .          : time {YYYY-MM-DDThh:mm:ss}\n"),
        version="3.0",
        data="~LOG_DATA | LOG_DEFINITION",
    )
    text = text.replace("~CURVE INFORMATION", "~LOG_DEFINITION").replace("~PARAMETER", "~LOG_PARAMETER")
    (folder / "log.las").write_text(text.replace(" WRAP.", " DLM.  COMMA : DELIMITER\n WRAP."))
    return [folder / "log.las"]


def witsml_1311(log: pd.DataFrame, folder: Path) -> list[Path]:
    """Prefixed names, an index curve by its column, units of WITSML, a depth log beside, null values in it."""
    units = UNITS | {"RPM": "c/s", "SET": "c/s", "FLOW": "m3/s"}
    log = log.assign(RPM=log["RPM"] / 60, SET=log["SET"] / 60, FLOW=log["FLOW"] / 6e4, Time=iso(log)).round(9)
    curves = "".join(
        f'<w:logCurveInfo uid="{name}"><w:mnemonic>{name}</w:mnemonic><w:unit>{units.get(name, "s")}</w:unit>'
        f"<w:nullValue>-9999</w:nullValue><w:columnIndex>{at}</w:columnIndex>"
        f"<w:typeLogData>{'date time' if at == 1 else 'double'}</w:typeLogData></w:logCurveInfo>\n"
        for at, name in enumerate(log, 1)
    )
    data = "".join(f"<w:data>{row}</w:data>\n" for row in log.to_csv(index=False, header=False).splitlines())
    depth = (
        '<w:log uidWell="w" uidWellbore="b" uid="d"><w:nameWell>W</w:nameWell><w:name>depth</w:name>'
        '<w:indexType>measured depth</w:indexType><w:startIndex uom="m">1</w:startIndex>'
        '<w:indexCurve columnIndex="1">Mdepth</w:indexCurve><w:logCurveInfo uid="1"><w:mnemonic>Mdepth</w:mnemonic>'
        "<w:unit>m</w:unit><w:columnIndex>1</w:columnIndex></w:logCurveInfo><w:logData><w:data>1</w:data></w:logData></w:log>"
    )
    (folder / "log.xml").write_text(
        '<?xml version="1.0" encoding="UTF-8" standalone="no"?>\n<?xml-stylesheet type="text/xsl" href="log.xsl"?>\n'
        '<w:logs xmlns:w="http://www.witsml.org/schemas/131" xmlns:xsi="http://www.w3.org/2001/XMLSchema-instance" '
        'xsi:schemaLocation="http://www.witsml.org/schemas/131 obj_log.xsd" version="1.3.1.1"><w:documentInfo>'
        f"<w:documentName>Log &amp; more</w:documentName></w:documentInfo>{depth}"
        '<w:log uidWell="w" uidWellbore="b" uid="t"><w:nameWell>W</w:nameWell><w:nameWellbore>B</w:nameWellbore>'
        "<w:name>Time log</w:name><w:serviceCompany>Nobody</w:serviceCompany><w:indexType>date time</w:indexType>"
        "<w:startDateTimeIndex>2025-03-03T06:00:00Z</w:startDateTimeIndex>"
        '<w:indexCurve columnIndex="1">Time</w:indexCurve>'
        f"{curves}<w:logData>{data}</w:logData></w:log></w:logs>"
    )
    return [folder / "log.xml"]


def witsml_1411(log: pd.DataFrame, folder: Path) -> list[Path]:
    """Two log objects in the default namespace, the lists in another order than the curves, empty cells, gzipped."""
    names = ["Time", *reversed(NUMBERS)]
    units = ["unitless", *(UNITS[name] for name in reversed(NUMBERS))]
    curves = "".join(
        f"<logCurveInfo uid='{name}'><mnemonic namingSystem='x'>{name}</mnemonic>"
        f"<unit>{UNITS.get(name, 'unitless')}</unit>"
        "<minDateTimeIndex>2025-03-03T06:00:00.000Z</minDateTimeIndex><curveDescription>of, the rig</curveDescription>"
        f"<typeLogData>{'date time' if name == 'Time' else 'double'}</typeLogData></logCurveInfo>"
        for name in log
    )
    stamped = log.assign(Time=iso(log), EMPTY="")[[*names, "EMPTY"]]
    logs = ""
    for number, part in enumerate((stamped.iloc[:700], stamped.iloc[700:])):
        data = "".join(f"<data>{row}</data>" for row in part.to_csv(index=False, header=False).splitlines())
        logs += (
            f'<log uidWell="w" uidWellbore="b" uid="{number}"><nameWell>W</nameWell><nameWellbore>B</nameWellbore>'
            f"<name>part {number}</name><indexType>date time</indexType><direction>increasing</direction>"
            f"<indexCurve>Time</indexCurve><nullValue>-999.25</nullValue>{curves}"
            "<logCurveInfo uid='EMPTY'><mnemonic>EMPTY</mnemonic><unit>m</unit></logCurveInfo>"
            f"<logData>\n<mnemonicList>{','.join([*names, 'EMPTY'])}</mnemonicList>\n"
            f"<unitList>{','.join([*units, 'm'])}</unitList>\n{data}</logData></log>"
        )
    text = f'<logs xmlns="http://www.witsml.org/schemas/1series" version="1.4.1.1">{logs}</logs>'
    (folder / "log.xml.gz").write_bytes(gzip.compress(text.encode("utf-8-sig")))
    return [folder / "log.xml.gz"]


def witsml_lists_only(log: pd.DataFrame, folder: Path) -> list[Path]:
    """As gateways write it: no index, no curves, the lists alone."""
    names, units = ",".join(["TIME", *NUMBERS]), ",".join(["s", *UNITS.values()])
    data = "\n".join(
        f"  <data>{row}</data>" for row in log.assign(Time=iso(log)).to_csv(index=False, header=False).split()
    )
    lists = f"<mnemonicList>{names}</mnemonicList><unitList>{units}</unitList>"
    (folder / "log.witsml").write_text(
        '<?xml version="1.0"?>\n<!-- gateway -->\n<logs xmlns="http://www.witsml.org/schemas/1series">\n<log>'
        f"<nameWell>W</nameWell><logData>{lists}{data}</logData></log></logs>"
    )
    return [folder / "log.witsml"]
