"""Sheets: what is read, and that every mistake names sheet, row and remedy."""

import os
import re
import unicodedata
from pathlib import Path

import pytest

from drillid.config.folders import SAFE, folder_of
from drillid.config.settings import Settings
from drillid.config.sheets import WellRow, read_sheets
from drillid.errors import SettingsError
from tests.workflow.toys import RIG

WELLS = "well\trig\tdescription\nW1\ttoy\tthe first, on rig #4\n# W9\ttoy\tleft out\n\nW2\ttoy\t\n"
LOGS = "well\tlog\nW1\ta.csv\nW2\tb.csv\nW1\tc.csv\n"


def settings_for(folder: Path, wells: str = WELLS, logs: str = LOGS) -> Settings:
    (folder / "wells.tsv").write_text(wells)
    (folder / "logs.tsv").write_text(logs)
    (folder / "toy.yaml").write_text(RIG)
    return Settings(wells=str(folder / "wells.tsv"), logs=str(folder / "logs.tsv"), rigs=str(folder))


def faults_in(settings: Settings) -> dict[str, list[str]]:
    """Faults of rows by the names of the wells that fail for them."""
    found = {listing.name: list(map(str, listing.faults)) for listing in read_sheets(settings).values()}
    return {name: faults for name, faults in found.items() if faults}


def test_wells_keep_the_order_of_the_sheet_and_their_logs(tmp_path: Path) -> None:
    found = read_sheets(settings_for(tmp_path))
    assert list(found) == ["W1", "W2"]
    assert found["W1"].logs == (Path("a.csv"), Path("c.csv"))
    assert found["W1"].description == "the first, on rig #4"
    assert found["W2"].load().rig.name == "toy"


def test_a_sheet_may_be_as_long_as_a_fleet_has_logs(tmp_path: Path) -> None:
    logs = [f"W1\traw/a-log-with-a-name-that-is-rather-long-{number:05d}.parquet" for number in range(20_000)]
    settings = settings_for(tmp_path, logs="\n".join(["well\tlog", *logs]))
    assert len(read_sheets(settings)["W1"].logs) == len(logs)


@pytest.mark.parametrize(
    ("well", "wells", "logs", "message"),
    [
        ("W1", "W1\ttoy\tagain\n", "", "wells.tsv, row 6: well 'W1' is listed twice"),
        ("wells.tsv, row 6", "../W3\ttoy\t\n", "", "wells.tsv, row 6: 'well': '../W3' is a path, not a name"),
        ("wells.tsv, row 6", "W\u200b3\ttoy\t\n", "", "wells.tsv, row 6: 'well': "),
        ("wells.tsv, row 6", "\ttoy\t\n", "", "wells.tsv, row 6: 'well': "),
        ("w1", "w1\ttoy\t\n", "", "wells.tsv, row 6: wells 'W1' and 'w1' would share the folder 'w1'"),
        ("W3", "W3\t../toy\t\n", "", "wells.tsv, row 6: 'rig': "),
        ("W3", "W3\ttoy\tx\ty\n", "", "wells.tsv, row 6: has 4 cells below 3 columns. Remove superfluous tabs"),
        ("W2", "", "W2\t./a.csv\n", "logs.tsv, row 5: log './a.csv' is already listed at "),
        ("W2", "", "W2\t../../a.csv\n", "logs.tsv, row 5: log '../../a.csv' lies in "),
        ("W2", "", "W2\t/etc/hostname\n", "logs.tsv, row 5: log '/etc/hostname' lies in /etc, outside the folders"),
        ("W2", "", "W2\tfile:///etc/hostname\n", "logs.tsv, row 5: log 'file:///etc/hostname' lies "),
        ("W2", "", "W2\tsimplecache::file:///a.csv\n", "logs.tsv, row 5: log 'simplecache::file:///a.csv' lies "),
        ("Well7", "", "Well7\td.csv\n", "logs.tsv, row 5: log of the unknown well 'Well7'. Add the well"),
        ("w1", "", "w1\td.csv\n", "logs.tsv, row 5: log of the unknown well 'w1'. Add the well"),
        ("W2", "", "W2\ta.csv\n", "logs.tsv, row 5: log 'a.csv' is already listed at "),
        ("W2", "", "W2\t\n", "logs.tsv, row 5: 'log': "),
        ("logs.tsv, row 5", "", "\td.csv\n", "logs.tsv, row 5: 'well': "),
    ],
)
def test_a_mistake_in_a_row_names_row_and_remedy_and_is_of_its_well_alone(
    well: str, wells: str, logs: str, message: str, tmp_path: Path
) -> None:
    settings = settings_for(tmp_path, WELLS + wells, LOGS + logs)
    [(name, [fault])] = faults_in(settings).items()
    assert (name, message in fault) == (well, True), (name, fault)
    found = read_sheets(settings)
    assert list(found)[:2] == ["W1", "W2"]
    assert found["W1"].logs == (Path("a.csv"), Path("c.csv"))
    assert found["W2"].logs == (Path("b.csv"),)
    assert len({folder.casefold() for folder in found}) == len(found)
    assert all(re.fullmatch(SAFE, folder) for folder in found)


def test_a_name_is_the_same_however_its_accents_are_written(tmp_path: Path) -> None:
    wells, logs = (
        f"well\t{column}\n" + unicodedata.normalize(form, f"\u00c5sgard A-1\t{cell}\n")
        for column, cell, form in (("rig", "toy", "NFC"), ("log", "a.csv", "NFD"))
    )
    settings = settings_for(tmp_path, wells, logs)
    assert faults_in(settings) == {}
    assert [listing.name for listing in read_sheets(settings).values()] == ["\u00c5sgard A-1"]


def test_sections_and_tools_are_the_same_however_their_accents_are_written() -> None:
    text = "17\u00bd in, forage \u00e0 l'huile"
    first, second = (
        WellRow(well=form, rig="toy", section=unicodedata.normalize(form, text), tool=unicodedata.normalize(form, text))
        for form in ("NFC", "NFD")
    )
    assert (first.section, first.tool) == (second.section, second.tool) == (text, text)


def test_unknown_wells_that_would_share_a_folder_are_all_told(tmp_path: Path) -> None:
    settings = settings_for(tmp_path, logs=LOGS + "X 1\td.csv\nX/1\te.csv\nx-1\tf.csv\n")
    assert list(faults_in(settings)) == ["X 1", "X/1", "x-1"]
    assert len({folder.casefold() for folder in read_sheets(settings)}) == 5


@pytest.mark.parametrize("separator", ["\u2028", "\x85", "\v", "\f"])
def test_a_cell_keeps_what_a_text_processor_puts_between_its_lines(tmp_path: Path, separator: str) -> None:
    wells = f"well\trig\tdescription\ttool\nW1\ttoy\tfirst{separator}second\tmotor 5\nW2\ttoy\t\t\n"
    found = read_sheets(settings_for(tmp_path, wells))
    assert list(found) == ["W1", "W2"]
    assert (found["W1"].tool, found["W1"].faults) == ("motor 5", ())


def test_a_cell_of_several_lines_is_a_fault_of_its_row(tmp_path: Path) -> None:
    faults = faults_in(settings_for(tmp_path, WELLS + 'W3\ttoy\t"first\nsecond"\n', LOGS + "W3\td.csv\n"))
    assert "row 6: holds a cell with a line break" in faults["W3"][0]


def test_a_log_whose_name_is_not_utf_8_is_named(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    Path(os.fsdecode(b"br\xf8nn.csv")).touch()
    faults = faults_in(settings_for(tmp_path, logs="well\tlog\nW1\ta.csv\nW2\tb*.csv\n"))
    assert faults["W2"] == [
        f"{tmp_path}/logs.tsv, row 3: the name of the log 'br\\udcf8nn.csv' is not in UTF-8. Rename the file"
    ]


def test_of_a_well_whose_row_is_refused_nothing_else_is_said(tmp_path: Path) -> None:
    settings = settings_for(tmp_path, WELLS + "W3\t../toy\t\n", LOGS + "W3\td.csv\nW3\te.csv\n")
    assert [len(faults) for faults in faults_in(settings).values()] == [1]
    assert read_sheets(settings)["W3"].logs == (Path("d.csv"), Path("e.csv"))


def test_a_mended_row_is_another_input_of_its_well(tmp_path: Path) -> None:
    assert read_sheets(settings_for(tmp_path))["W2"].stated == {}
    assert "already listed" in str(read_sheets(settings_for(tmp_path, logs=LOGS + "W2\ta.csv\n"))["W2"].stated)


@pytest.mark.parametrize(
    ("wells", "logs", "message"),
    [
        (
            WELLS.replace("\t", ","),
            LOGS,
            "wells.tsv: has commas between its columns 'well,rig,description'. Save the sheet",
        ),
        (WELLS, LOGS.replace("\t", ";"), "logs.tsv: has semicolons between its columns"),
        (WELLS.replace("rig\t", "rigg\t"), LOGS, "wells.tsv: has an unknown column 'rigg'. Did you mean 'rig'?"),
        (WELLS, LOGS.replace("\tlog", "\tlog\tlog"), "logs.tsv: has the column 'log' twice"),
        (WELLS, LOGS.replace("\tlog", ""), "logs.tsv: has no column 'log'. Add it"),
        (WELLS.splitlines()[0], LOGS, "wells.tsv: lists no wells. Add a row for each well"),
        (WELLS, "well\tlog\n", "logs.tsv: lists no logs. Add a row for each log file"),
        ("", LOGS, "wells.tsv: has no header. Begin the sheet with the line 'well\trig\tdescription'"),
    ],
)
def test_a_mistake_in_a_sheet_as_a_whole_is_raised(tmp_path: Path, wells: str, logs: str, message: str) -> None:
    with pytest.raises(SettingsError) as error:
        read_sheets(settings_for(tmp_path, wells, logs))
    assert message in str(error.value)


def test_empty_cells_at_the_ends_of_lines_are_none(tmp_path: Path) -> None:
    wells = "".join(f"{line}\t\t\n" for line in WELLS.splitlines())
    assert [listing.description for listing in read_sheets(settings_for(tmp_path, wells)).values()] == [
        "the first, on rig #4",
        "",
    ]


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
        ("W3\ttoys\t\n", "toys.yaml: rig 'toys' has no description. Did you mean 'toy'? Else write this file, or "),
        ("W3\tR7\t\n", "R7.yaml: rig 'R7' has no description. Write this file, or correct the rig of well 'W3'"),
        ("W3\ttoy\t\n", "logs sheet: well 'W3' has no logs. List its log files there"),
    ],
)
def test_a_well_without_rig_or_logs_is_found_only_when_it_is_worked_on(tmp_path: Path, row: str, message: str) -> None:
    logs = LOGS + ("W3\td.csv\n" if "rig" in message else "")
    found = read_sheets(settings_for(tmp_path, WELLS + row, logs))
    assert found["W1"].load().name == "W1"
    with pytest.raises(SettingsError) as error:
        found["W3"].load()
    assert message in str(error.value)


NAMED = """well\trig\tdescription\tfolder
34/10-A-12 H\ttoy\t\t
Øst 7\ttoy\t\t
<script>\ttoy\t\t
A\ttoy\t\t
a\ttoy\t\tsmall-a
"""
NAMED_LOGS = "well\tlog\n34/10-A-12 H\ta.csv\na\tb.csv\n"


def test_a_well_is_called_what_people_call_it_and_has_a_folder_of_its_own(tmp_path: Path) -> None:
    found = read_sheets(settings_for(tmp_path, NAMED, NAMED_LOGS))
    assert {folder: listing.name for folder, listing in found.items()} == {
        "34-10-A-12-H": "34/10-A-12 H",
        "Ost-7": "Øst 7",
        "script": "<script>",
        "A": "A",
        "small-a": "a",
    }
    assert found["34-10-A-12-H"].logs == (Path("a.csv"),)
    assert found["small-a"].logs == (Path("b.csv"),)
    assert found["34-10-A-12-H"].load().name == "34/10-A-12 H"


@pytest.mark.parametrize("other", ["34-10-A-12-H", "34/10 A/12 H", "34-10-a-12-h"])
def test_wells_whose_names_make_one_folder_are_refused_with_both(tmp_path: Path, other: str) -> None:
    wells = f"well\trig\tdescription\n34/10-A-12 H\ttoy\t\n{other}\ttoy\t\n"
    found = read_sheets(settings_for(tmp_path, wells, "well\tlog\n34/10-A-12 H\ta.csv\n"))
    assert [(listing.name, len(listing.faults)) for listing in found.values()] == [("34/10-A-12 H", 0), (other, 1)]
    (fault,) = list(found.values())[1].faults
    assert f"wells '34/10-A-12 H' and '{other}' would share the folder" in fault.what
    assert "a column 'folder'" in fault.remedy


@pytest.mark.parametrize(
    "name",
    ["34/10-A-12 H", "../x", "Скважина 7", "油井7", "a" * 200, "...", "CON?", "Åsgård Ø", "W1", "W1.json", "W1.PART"],
)
def test_every_folder_is_safe_and_that_of_a_safe_name_is_the_name(name: str) -> None:
    folder = folder_of(name)
    assert re.fullmatch(SAFE, folder)
    assert len(folder) < 100
    assert folder_of(name) == folder
    assert folder_of(folder) == folder


def test_names_that_lose_letters_keep_folders_apart() -> None:
    assert len({folder_of(name) for name in ("Скважина 7", "Площадь 7", "油井7", "7")}) == 4
    assert folder_of("W1") == "W1"


@pytest.mark.parametrize("end", [".json", ".JSON", ".part", ".lock"])
def test_no_folder_looks_like_a_file_beside_it(end: str) -> None:
    assert folder_of(f"W1{end}") != f"W1{end}"
    assert not folder_of(f"W 1{end}").endswith(end)


def test_logs_may_lie_in_the_working_folder_beside_the_sheet_in_the_results_and_where_it_is_allowed(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    work, share, sheets = tmp_path / "work", tmp_path / "share", tmp_path / "sheets"
    for folder in (work, share, sheets):
        folder.mkdir()
    monkeypatch.chdir(work)
    logs = [f"{work}/a.csv", "b/c.csv", f"{sheets}/d.csv", f"{share}/results/e.csv", "s3://bucket/f.csv"]
    text = "".join(f"W1\t{log}\n" for log in logs)
    settings = settings_for(sheets, logs="well\tlog\n" + text).model_copy(update={"results": f"{share}/results"})
    assert read_sheets(settings)["W1"].logs == tuple(map(Path, logs))
    (sheets / "logs.tsv").write_text(f"well\tlog\nW1\t{share}/g.csv\n")
    [[fault]] = faults_in(settings).values()
    assert re.search(r"log_roots: \[.*/share\]", fault)
    allowed = settings.model_copy(update={"log_roots": (str(share),)})
    assert read_sheets(allowed)["W1"].logs == (share / "g.csv",)


def test_a_link_does_not_lead_out_of_the_folders(tmp_path: Path) -> None:
    sheets, secret = tmp_path / "sheets", tmp_path / "secret"
    sheets.mkdir()
    secret.mkdir()
    (secret / "a.csv").touch()
    (sheets / "log.csv").symlink_to(secret / "a.csv")
    (sheets / "logs").symlink_to(secret)
    for log in ("log.csv", "logs/a.csv", "logs/../a.csv"):
        settings = settings_for(sheets, logs=f"well\tlog\nW1\t{sheets}/{log}\n")
        [[fault]] = faults_in(settings).values()
        assert "outside the folders for logs" in fault


def test_a_pattern_stands_for_the_files_that_it_matches(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    for name in ("W1/b.csv", "W1/a.csv", "W1/.c.csv", "W1/a.csv.part", "W2/log[1].csv", "W2/log1.csv"):
        (tmp_path / name).parent.mkdir(exist_ok=True)
        (tmp_path / name).touch()
    logs = "well\tlog\nW1\tW1/*.csv\nW1\tlate/*.csv\nW2\tW2/log[1].csv\n"
    found = read_sheets(settings_for(tmp_path, logs=logs))
    assert found["W1"].logs == tuple(map(Path, ("W1/a.csv", "W1/b.csv", "late/*.csv")))
    assert found["W2"].logs == (Path("W2/log[1].csv"),)


@pytest.mark.parametrize(
    ("log", "fault"),
    [
        ("W1/?.csv", "log 'W1/a.csv' is already listed at"),
        ("linked/*.csv", "log 'linked/*.csv' lies in "),
        ("W3/*.csv", "log 'W3/s.csv' lies in "),
        ("/etc/host*", "log '/etc/host*' lies in /etc, outside"),
        ("s3://bucket/*.csv", "log 's3://bucket/*.csv' is a pattern, and patterns of addresses are not resolved"),
    ],
)
def test_a_pattern_gives_no_more_than_its_files_listed_one_by_one(
    log: str, fault: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    for name in ("here/W1/a.csv", "here/W1/b.csv", "secret/s.csv"):
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).touch()
    (tmp_path / "here/linked").symlink_to(tmp_path / "secret")
    (tmp_path / "here/W3").mkdir()
    (tmp_path / "here/W3/s.csv").symlink_to(tmp_path / "secret/s.csv")
    monkeypatch.chdir(tmp_path / "here")
    settings = settings_for(tmp_path / "here", logs=f"well\tlog\nW1\tW1/*.csv\nW2\t{log}\n")
    [found] = faults_in(settings)["W2"]
    assert fault in found
    assert len(read_sheets(settings)["W1"].logs) == 2


@pytest.mark.parametrize("link", ["logs/linked.csv", "linked/a.csv"])
def test_a_file_that_is_listed_again_through_a_link_is_found(link: str, tmp_path: Path) -> None:
    log = tmp_path / "logs/a.csv"
    log.parent.mkdir()
    log.touch()
    (tmp_path / "logs/linked.csv").symlink_to("a.csv")
    (tmp_path / "linked").symlink_to("logs")
    settings = settings_for(tmp_path, logs=f"well\tlog\nW1\t{log}\nW2\t{tmp_path / link}\n")
    [fault] = faults_in(settings)["W2"]
    assert re.search(rf"{link}' is already listed at .*, row 2 as '{log}', which is the same file", fault)


def test_a_cell_is_read_without_the_quotes_in_which_excel_saves_it(tmp_path: Path) -> None:
    wells = WELLS.replace("the first, on rig #4", '"the first, ""8½"" section"')
    found = read_sheets(settings_for(tmp_path, wells, LOGS + 'W2\t"tag 1, b.csv"\n'))
    assert found["W1"].description == 'the first, "8½" section'
    assert Path("tag 1, b.csv") in found["W2"].logs
