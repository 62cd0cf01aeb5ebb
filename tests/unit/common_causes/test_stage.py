"""What is read of a well, who shares what, and the tables."""

import shutil
from dataclasses import fields, replace
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from drillid.common_causes.stage import (
    COMMON_CAUSES,
    LEFT_OUT,
    STANDINGS,
    WellEvidence,
    common_table,
    groups,
    judge_fleet,
    read_well,
    standing_table,
    write_common_causes,
)
from drillid.common_causes.verdicts import SHARES, CommonVerdict, OwnVerdict, Standing
from drillid.config.settings import CommonCausesSettings, Settings
from drillid.datasets.store import WellFolders
from drillid.datasets.tables import write_table
from drillid.discrepancy.inference.shared_likelihood import HELD, RIG, candidate_labels
from drillid.report.rig_page import common_text, heading, write_rig_pages
from tests.simulated import Processed
from tests.truth.common_causes.wells import LAG, fleet


def wells(lag: float, count: int = 5, **shares: str) -> list[WellEvidence]:
    """Wells of rig R with a lag, or none."""
    sets = fleet(41, count, {LAG: np.full(count, lag)}, error=0.003)
    return [WellEvidence(each.well, {"rig": "R", **shares}, (each,), (), ()) for each in sets]


def test_only_wells_that_share_something_are_judged_together() -> None:
    fleet_of_two = wells(0.0, 2, section="8½ in, oil-based", tool="")
    other = WellEvidence("X", {"rig": "S", "section": "8½ in, oil-based"}, fleet_of_two[0].sets, (), ())
    found = [
        (shared, name, [well.name for well in members]) for shared, name, members in groups([*fleet_of_two, other])
    ]
    assert found == [("rig", "R", ["W0", "W1"]), ("section", "8½ in, oil-based", ["W0", "W1", "X"])]


def test_a_well_without_evidence_is_in_no_group() -> None:
    first, second = wells(0.0, 2)
    assert list(groups([first, replace(second, sets=())])) == []


def test_a_lag_of_all_wells_is_their_rigs() -> None:
    (judged,) = judge_fleet(wells(0.012), CommonCausesSettings())
    assert judged.verdict.cause == "drive_lag"
    assert "5 wells of this rig have in common" in common_text(vars(judged.verdict))
    assert {each.standing for each in judged.standings} == {SHARES}


def test_a_cause_that_several_sets_of_a_well_name_is_compared_once(healthy: Processed, tmp_path: Path) -> None:
    folders = WellFolders(tmp_path, "T")
    folders.write("discrepancy", "examination", healthy.dataset("discrepancy", "examination"), rig="R")
    row = healthy.folders.read_table("discrepancy", "verdicts").iloc[0].to_dict() | {"cause": "drive_lag"}
    rows = [row | {"class": "drive_lag", "size": size} for size in (0.01, 0.03, 0.02)]
    folders.write_table("discrepancy", "verdicts", pd.DataFrame(rows))
    assert read_well(folders, {}).verdicts == (OwnVerdict(("drive_lag",), "drive_lag", 0.03),)


@pytest.fixture(scope="module")
def for_sisters(healthy: Processed, tmp_path_factory: pytest.TempPathFactory) -> Processed:
    """A healthy well, examined where common causes are judged."""
    well = healthy.copied(tmp_path_factory.mktemp("common") / "results")
    well.run("discrepancy", settings=Settings(common_causes=CommonCausesSettings(enabled=True)))
    return well


def test_what_a_well_stores_is_read_back(healthy: Processed, for_sisters: Processed) -> None:
    found = read_well(for_sisters.folders, {"section": "", "tool": ""})
    (of_set,) = found.sets
    assert found.shares["rig"] == of_set.rig != ""
    assert of_set.score.shape == (2, len(candidate_labels()), HELD, RIG.size)
    assert of_set.windows == 4
    assert 0 < of_set.temper <= 1
    # nothing of it is stored where it is not judged
    stored = healthy.dataset("discrepancy", "examination")
    assert stored.sizes["candidate"] == stored["shared_value"].size == 0
    # about the fit, the likelihood of no cause is that of the set's model
    assert of_set.value[:, of_set.sizes == 0] == pytest.approx(0.0)


def test_tables_and_pages_of_a_fleet(for_sisters: Processed, tmp_path: Path) -> None:
    results = tmp_path / "results"
    for name in ("A", "B"):
        folder = results / "discrepancy" / name
        folder.parent.mkdir(parents=True, exist_ok=True)
        folder.symlink_to(for_sisters.folders.stage("discrepancy"))
    named = write_common_causes(results, {"A": {}, "B": {}}, CommonCausesSettings(enabled=True))
    table = pd.read_csv(results / "common_causes.csv")
    assert named == 0
    # both folders say the name of the well that they were made for, so that there is one well and no group
    assert table.empty or table["verdict"].tolist() == ["none"]
    pages = tmp_path / "pages"
    pages.mkdir()
    assert len(write_rig_pages(results, pages, {})) == len(table) == len(list(pages.iterdir()))


def test_a_damaged_well_is_left_to_where_the_fleet_is_gathered(for_sisters: Processed, tmp_path: Path) -> None:
    results = tmp_path / "results"
    shutil.copytree(for_sisters.folders.stage("discrepancy"), results / "discrepancy/A")
    damaged = next((results / "discrepancy/A").rglob("zarr.json"))
    damaged.write_text(damaged.read_text() + " ")
    assert write_common_causes(results, {"A": {}}, CommonCausesSettings()) == 0
    assert (results / COMMON_CAUSES).exists()


def test_a_refused_size_is_told_for_all_wells(tmp_path: Path) -> None:
    (judged,) = judge_fleet(wells(0.05), CommonCausesSettings())
    write_table(common_table([judged.verdict]), tmp_path / COMMON_CAUSES)
    write_table(standing_table(judged.standings), tmp_path / STANDINGS)
    (link,) = write_rig_pages(tmp_path, tmp_path, {})
    page = (tmp_path / link["file"]).read_text()
    assert "nothing that they all have in common" in link["text"]
    assert "<td>All wells</td><td>drive lag</td><td>at bound</td>" in page


@pytest.mark.parametrize("names", [("101", "102"), ("007", "1e3"), ("nan", "34/10-A-12 H")])
def test_wells_and_groups_of_any_name_are_named_and_linked_as_the_sheet_does(
    names: tuple[str, str], tmp_path: Path
) -> None:
    verdict = dict.fromkeys((each.name for each in fields(CommonVerdict)), float("nan"))
    standing = dict.fromkeys((each.name for each in fields(Standing)), float("nan"))
    group = {"shared": "section", "name": "8.50", "cause": "drive_lag"}
    sized = {"verdict": "drive_lag", "unit": "s", "wells": 2, "sharing": 2, "probability": 0.9, "size": 0.05}
    common = pd.DataFrame([verdict | group | sized | {"size_low": 0.048, "size_high": 0.052}])
    rows = [standing | group | {"well": name, "standing": "shares it", "reason": ""} for name in names]
    write_table(common, tmp_path / COMMON_CAUSES)
    write_table(pd.DataFrame(rows), tmp_path / STANDINGS)
    # the second well has no page of its own any more
    (link,) = write_rig_pages(tmp_path, tmp_path, {names[0]: "its-own-folder"})
    assert (link["heading"], link["file"]) == ("Section 8.50", "section-8.50.html")
    page = (tmp_path / link["file"]).read_text()
    assert f'<td><a href="its-own-folder.html">{names[0]}</a></td>' in page
    assert f"<td>{names[1]}</td>" in page


@pytest.mark.parametrize(
    ("kind", "name", "said"),
    [
        ("rig", "Rigel", "Rig Rigel"),
        ("rig", "Rig 7", "Rig 7"),
        ("rig", "RIG-7", "RIG-7"),
        ("rig", "rig_7", "rig_7"),
        ("rig", "Rig7", "Rig7"),
        ("tool", "Toolbox", "Tool Toolbox"),
        ("tool", "motor 5", "Tool motor 5"),
    ],
)
def test_the_kind_of_a_group_is_in_its_heading_once(kind: str, name: str, said: str) -> None:
    assert heading({"shared": kind, "name": name}) == said


def test_groups_and_wells_whose_names_give_one_folder_have_pages_of_their_own(tmp_path: Path) -> None:
    blank = dict.fromkeys((each.name for each in fields(CommonVerdict)), float("nan"))
    names = ("12 1/4 in", "12-1-4 in", "12-1-4 IN", "8.50")
    rows = [blank | {"shared": "section", "name": name, "verdict": "none", "wells": 2, "sharing": 0} for name in names]
    write_table(pd.DataFrame(rows), tmp_path / COMMON_CAUSES)
    write_table(standing_table([]), tmp_path / STANDINGS)
    links = write_rig_pages(tmp_path, tmp_path, {"a well": "section-8.50"})
    files = [link["file"] for link in links]
    assert files[0] == "section-12-1-4-in.html"
    assert len({file.lower() for file in [*files, "section-8.50.html"]}) == len(names) + 1
    for name, file in zip(names, files, strict=True):
        assert f"<h1>Section {name}</h1>" in (tmp_path / file).read_text()


def test_what_wells_share_is_told_as_a_driller_would() -> None:
    group = {
        "shared": "rig",
        "wells": 5,
        "sharing": 5,
        "cause": "drive_lag",
        "verdict": "drive_lag|clock_offset",
        "unit": "s",
    }
    said = common_text({**group, "size": 0.05, "size_low": 0.048, "size_high": 0.052, "probability": 0.93})
    assert said.startswith("5 wells of this rig have in common that the drive responds 50 ms late: have its torque")
    assert "Time constant: 50 ms (95 % interval 48 ms to 52 ms); the probability is 93 %." in said
    assert "cannot tell it from clock offset" in said
    size = {"size": 0.05, "size_low": 0.048, "size_high": 0.052, "probability": 0.93}
    assert common_text({**group, **size, "sharing": 3}).startswith("3 of 5 wells of this rig have in common")
    assert (heading({**group, "name": "Rig 7"}), heading({**group, "name": "Alfa"})) == ("Rig 7", "Rig Alfa")


def test_a_set_that_nothing_explains_is_left_out_with_its_reason(healthy: Processed, tmp_path: Path) -> None:
    examination = healthy.folders.read("discrepancy", "examination").load()
    examination["verdict"][:] = "unknown"
    examination["unknown_evidence"][:] = 100.0
    folders = WellFolders(tmp_path, "U")
    folders.write("discrepancy", "examination", examination, rig="R")
    folders.write_table("discrepancy", "verdicts", healthy.folders.read_table("discrepancy", "verdicts"))
    found = read_well(folders, {})
    assert found.sets == ()
    write_common_causes(tmp_path, {"U": {}}, CommonCausesSettings())
    standings = pd.read_csv(tmp_path / "well_standings.csv")
    assert standings["standing"].tolist() == [LEFT_OUT]
    assert "no cause of the catalogue explains" in standings["reason"][0]
