"""Sheets: what is read, and that every mistake names sheet, row and remedy."""

from pathlib import Path

import pytest

from drillid.config.settings import Settings
from drillid.config.sheets import read_sheets
from drillid.errors import SettingsError
from tests.workflow.toys import RIG

WELLS = "well\trig\tdescription\nW1\ttoy\tthe first, on rig #4\n# W9\ttoy\tleft out\n\nW2\ttoy\t\n"
LOGS = "well\tlog\nW1\ta.csv\nW2\tb.csv\nW1\tc.csv\n"


def settings_for(folder: Path, wells: str = WELLS, logs: str = LOGS) -> Settings:
    (folder / "wells.tsv").write_text(wells)
    (folder / "logs.tsv").write_text(logs)
    (folder / "toy.yaml").write_text(RIG)
    return Settings(wells=str(folder / "wells.tsv"), logs=str(folder / "logs.tsv"), rigs=str(folder))


def test_wells_keep_the_order_of_the_sheet_and_their_logs(tmp_path: Path) -> None:
    found = read_sheets(settings_for(tmp_path))
    assert list(found) == ["W1", "W2"]
    assert found["W1"].logs == (Path("a.csv"), Path("c.csv"))
    assert found["W1"].description == "the first, on rig #4"
    assert found["W2"].load().rig.name == "toy"


@pytest.mark.parametrize(
    ("wells", "logs", "message"),
    [
        (WELLS + "W1\ttoy\tagain\n", LOGS, "wells.tsv, row 6: well 'W1' is listed twice"),
        (WELLS + "W 3\ttoy\t\n", LOGS, "wells.tsv, row 6: 'well': "),
        (WELLS + "../W3\ttoy\t\n", LOGS, "wells.tsv, row 6: 'well': "),
        (WELLS, LOGS + "Well7\td.csv\n", "logs.tsv, row 5: log of the unknown well 'Well7'. Add the well"),
        (WELLS, LOGS + "W2\ta.csv\n", "logs.tsv, row 5: log 'a.csv' is listed already at "),
        (WELLS, LOGS + "W2\t\n", "logs.tsv, row 5: 'log': "),
        (WELLS.replace("rig\t", "rigg\t"), LOGS, "unknown key 'rigg'"),
        (WELLS + "W3\ttoy\tx\ty\n", LOGS, "wells.tsv: is not a table"),
        ("", LOGS, "wells.tsv: has no header. Begin the sheet with the line 'well\trig\tdescription'"),
    ],
)
def test_a_mistake_names_its_sheet_row_and_remedy(tmp_path: Path, wells: str, logs: str, message: str) -> None:
    with pytest.raises(SettingsError) as error:
        read_sheets(settings_for(tmp_path, wells, logs))
    assert message in str(error.value)


def test_a_sheet_that_is_not_there_is_named(tmp_path: Path) -> None:
    settings = settings_for(tmp_path)
    (tmp_path / "logs.tsv").unlink()
    with pytest.raises(SettingsError, match=r"logs\.tsv: cannot be read"):
        read_sheets(settings)


def test_a_rig_that_does_not_validate_is_found_only_when_its_well_is_worked_on(tmp_path: Path) -> None:
    settings = settings_for(tmp_path)
    (tmp_path / "toy.yaml").write_text(RIG.replace("SWEEP, unit: kN m", "SWEEP, unit: psi"))
    listing = read_sheets(settings)["W1"]
    with pytest.raises(SettingsError, match="psi"):
        listing.load()


@pytest.mark.parametrize(
    ("row", "message"),
    [
        ("W3\ttoys\t\n", "toys.yaml: rig 'toys' has no description. Write this file, or correct the rig of well 'W3'"),
        ("W3\ttoy\t\n", "logs sheet: well 'W3' has no logs. List its log files there"),
    ],
)
def test_a_well_without_rig_or_logs_is_found_only_when_it_is_worked_on(tmp_path: Path, row: str, message: str) -> None:
    logs = LOGS + ("W3\td.csv\n" if "toys" in row else "")
    found = read_sheets(settings_for(tmp_path, WELLS + row, logs))
    assert found["W1"].load().name == "W1"
    with pytest.raises(SettingsError) as error:
        found["W3"].load()
    assert message in str(error.value)
