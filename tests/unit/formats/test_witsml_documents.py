"""WITSML documents that declare another encoding than they are written in, and those without a log."""

from pathlib import Path

import numpy as np
import pytest

from drillid.errors import LogError
from drillid.formats import read_log

ROWS = "".join(f"<data>2025-03-04T06:{at // 60:02d}:{at % 60:02d}Z,{1 + at / 1000}</data>\n" for at in range(3000))
LOG = (
    '<logs xmlns="http://www.witsml.org/schemas/1series" version="1.4.1.1"><log uid="1"><name>Bøla, 40 °C</name>'
    "<indexType>{index}</indexType><logData><mnemonicList>{time},TQA</mnemonicList><unitList>s,kN.m</unitList>\n"
    f"{ROWS}</logData></log></logs>"
)
DECLARED = {
    "UTF-16 in memory, UTF-8 in the file": ('<?xml version="1.0" encoding="utf-16"?>', "utf-8"),
    "the same with a mark": ("<?xml version='1.0' encoding='UTF-16' standalone='yes'?>", "utf-8-sig"),
    "UTF-8, that of Windows in the file": ('<?xml version="1.0" encoding="UTF-8"?>\n', "cp1252"),
    "nothing, that of Windows in the file": ("", "cp1252"),
    "what it is in, UTF-16": ('<?xml version="1.0" encoding="utf-16"?>', "utf-16"),
    "what it is in, Latin-1": ('<?xml version="1.0" encoding="ISO-8859-1"?>', "latin-1"),
    "what it is in, UTF-8": ('<?xml version="1.0" encoding="utf-8"?>', "utf-8"),
}


@pytest.mark.parametrize(("declaration", "encoding"), DECLARED.values(), ids=DECLARED)
def test_the_encoding_is_that_of_the_content(tmp_path: Path, declaration: str, encoding: str) -> None:
    path = tmp_path / "log.xml"
    path.write_bytes((declaration + LOG.format(index="date time", time="TIME")).encode(encoding))
    log = read_log(path, None, ["TQA"])
    assert log.units == {"TQA": "kN.m"}
    assert log.stamps[0] == np.datetime64("2025-03-04T06:00:00", "ns")
    assert log.pop("TQA").size == 3000


def test_a_log_over_depth_without_curves_is_named_by_its_index(tmp_path: Path) -> None:
    path = tmp_path / "log.xml"
    path.write_text(LOG.format(index="measured depth", time="DEPT"), encoding="utf-8")
    with pytest.raises(LogError, match="over depth only, with the index 'DEPT'"):
        read_log(path, None, ["TQA"])


WITHOUT_LOGS = {
    "another object": ("<trajectorys><trajectory uid='1'/></trajectorys>", "holds no log object.*'trajectorys'"),
    "a query": (
        "<logs><log uid='%uid%'><name/><indexType/><logCurveInfo uid=''><mnemonic/></logCurveInfo>"
        "<logData><data/></logData></log></logs>",
        "such as a query.*Save the server's response",
    ),
    "an answer without an object": ("<Envelope><Result>1</Result><XMLout></XMLout></Envelope>", "'Envelope'"),
}


@pytest.mark.parametrize(("text", "what"), WITHOUT_LOGS.values(), ids=WITHOUT_LOGS)
def test_documents_without_logs_tell_what_they_hold(tmp_path: Path, text: str, what: str) -> None:
    path = tmp_path / "log.xml"
    path.write_text(text)
    with pytest.raises(LogError, match=what):
        read_log(path, None, ["TQA"])
