"""A quote that does not close takes no rows into its cell."""

from pathlib import Path

import numpy as np
import pytest

from drillid.formats import TimeColumn, read_log

ROWS = 3000
WITSML = (
    '<logs xmlns="http://www.witsml.org/schemas/1series" version="1.4.1.1"><log><indexType>date time</indexType>'
    "<indexCurve>TIME</indexCurve>{curves}<logData><mnemonicList>TIME,RPM,NOTE</mnemonicList>"
    "<unitList>,rpm,</unitList>{rows}</logData></log></logs>"
)


def cells(row: int) -> list[str]:
    """A row with a remark, some of which begin with the size of a bit in inches."""
    remark = '"8 1/2 bit' if row in (500, 2000) else '"a ""b"" c"' if row == 700 else "plain"
    return [f"2025-03-03T06:{row // 60:02d}:{row % 60:02d}Z", f"{100 + row % 7}", remark]


def text(folder: Path, delimiter: str) -> Path:
    """Text with a delimiter."""
    lines = [delimiter.join(["TIME", "RPM", "NOTE"]), *(delimiter.join(cells(row)) for row in range(ROWS))]
    (folder / "log.csv").write_text("\n".join(lines))
    return folder / "log.csv"


def las(folder: Path) -> Path:
    """LAS with commas."""
    rows = "\n".join(",".join(cells(row)) for row in range(ROWS))
    head = "~V\nVERS. 2.0:\nWRAP. NO:\n~W\nNULL. -999.25:\n~C\nTIME. : t\nRPM.rpm : r\nNOTE. : n\n~A\n"
    (folder / "log.las").write_text(head + rows)
    return folder / "log.las"


def witsml(folder: Path) -> Path:
    """A WITSML document."""
    curves = "".join(f"<logCurveInfo><mnemonic>{name}</mnemonic></logCurveInfo>" for name in ("TIME", "RPM", "NOTE"))
    rows = "".join("<data>" + ",".join(cells(row)) + "</data>" for row in range(ROWS))
    (folder / "log.xml").write_text(WITSML.format(curves=curves, rows=rows))
    return folder / "log.xml"


@pytest.mark.parametrize("form", [",", ";", "\t", "las", "xml"])
def test_every_row_is_read(tmp_path: Path, form: str) -> None:
    path = las(tmp_path) if form == "las" else witsml(tmp_path) if form == "xml" else text(tmp_path, form)
    log = read_log(path, TimeColumn("TIME"), ["RPM"])
    assert log.stamps.size == ROWS
    np.testing.assert_array_equal(log.pop("RPM"), [100 + row % 7 for row in range(ROWS)])
