"""The pages of a small synthetic fleet: complete, escaped, the same for the same results, with the right numbers."""

import errno
import html
import json
import re
from html.parser import HTMLParser
from pathlib import Path

import pandas as pd
import pytest

from drillid.config.settings import Settings
from drillid.config.sheets import read_sheets
from drillid.datasets.registry import CHANGE_COLUMNS, PROBLEM_COLUMNS
from drillid.datasets.tables import write_table
from drillid.fleet.stages import STAGES
from drillid.report import page as report
from drillid.report.charts.embedding import bokeh_script
from drillid.report.content import EXPLANATIONS
from tests.unit.report.conftest import ATTACK, PROBLEMS, WELLS, Fleet

LARGEST_PAGE = 2e6


def text(fragment: str) -> str:
    """What a reader sees in metric units, white space shortened."""
    metric = re.sub(r'<span class="oilfield">[^<]*</span>', "", fragment)
    bare = re.sub(r"<(script|style)\b.*?</\1>", " ", metric, flags=re.S)
    return re.sub(r"\s+", " ", html.unescape(re.sub(r"<[^>]+>", " ", bare)))


class Structure(HTMLParser):
    """Checks that tags are balanced and collects headings, anchors and references."""

    VOID = frozenset({"meta", "img", "br", "link", "input", "hr", "rect", "polyline"})

    def __init__(self) -> None:
        super().__init__()
        self.open: list[str] = []
        self.headings: list[int] = []
        self.ids: list[str] = []
        self.references: list[str] = []
        self.tags: list[str] = []

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        """Collect what the tests ask for."""
        self.tags.append(tag)
        self.ids += [value for name, value in attrs if name == "id" and value]
        self.references += [value for name, value in attrs if name in ("src", "href") and value]
        if re.fullmatch(r"h\d", tag):
            self.headings.append(int(tag[1]))
        if tag not in self.VOID:
            self.open.append(tag)

    def handle_endtag(self, tag: str) -> None:
        """The tag that closes must be the last that opened."""
        if tag not in self.VOID:
            assert self.open.pop() == tag


def structure(page: str) -> Structure:
    parsed = Structure()
    parsed.feed(page)
    return parsed


@pytest.mark.parametrize("well", ["", *WELLS])
def test_pages_are_well_formed_and_refer_to_nothing_that_is_elsewhere(fleet: Fleet, well: str) -> None:
    page = fleet.page(well)
    found = structure(page)
    assert found.open == []
    assert found.headings.count(1) == 1
    assert all(after <= before + 1 for before, after in zip(found.headings, found.headings[1:], strict=False))
    assert len(found.ids) == len(set(found.ids))
    assert {each[1:] for each in found.references if each.startswith("#")} <= set(found.ids)
    folder = fleet.results / "report" if well else fleet.results
    files = [each.partition("#")[0] for each in found.references if not each.startswith("#")]
    made_by_others = ("verdicts.csv", "depth/", "figures/")
    assert all((folder / each).exists() for each in files if not any(part in each for part in made_by_others))
    assert not re.search(r"https?://|url\(|@import", re.sub(r'<script type="application/json".*?</script>', "", page))
    assert len(page) < LARGEST_PAGE


@pytest.mark.parametrize("well", ["", *WELLS])
def test_texts_of_users_are_escaped(fleet: Fleet, well: str) -> None:
    page = fleet.page(well)
    assert ATTACK not in page
    assert "<b>bold</b>" not in page
    assert "<of the test>" not in page
    if not well:
        assert "Fleet of &lt;two&gt; &amp; more" in page
    if well in ("", "W4"):
        assert ATTACK in text(page)


def test_what_is_urgent_is_first_in_the_fleet_and_told_once_in_its_well(fleet: Fleet) -> None:
    items = [text(item) for item in fleet.page().split('<li class="item')[1:]]
    assert [item.count("No result") > 0 for item in items[:3]] == [True, True, False]
    (first,) = [item for item in items if "W1 Wash-out, 1015–1021 m" in item]
    assert items.index(first) < min(row for row, item in enumerate(items) if item.startswith(" note"))
    assert re.search(r"BHA damping \d+ N m s/rad where \d+ N m s/rad is usual, at least \d+ times as much", first)
    page = text(fleet.page("W1"))
    assert page.count(EXPLANATIONS[frozenset({"damping_bha", "inertia_bha"})]) == 1
    assert page.count("is usual") == 2
    assert page.count("caliper") == 1
    assert "The rise of BHA damping and BHA inertia at 1015–1021 m appears as a difference between windows" in page


def test_a_mark_of_a_depth_has_one_colour_in_list_and_table(fleet: Fleet) -> None:
    item = next(each for each in fleet.page().split('<li class="item')[1:] if "1015–1021" in text(each))
    row = next(each for each in fleet.page().split("<tr data-text")[1:] if 'W1.html"' in each)
    marks = [set(re.findall(r'class="mark (\w+)"', each)) for each in (item.partition("</li>")[0], row)]
    assert marks[0]
    assert marks[0] <= marks[1]


def test_colours_of_the_rig_states_are_told(fleet: Fleet) -> None:
    assert re.search(r"Rig state:( \w+)* drilling", text(fleet.page("W1")))


def test_what_nothing_tested_is_not_shown_as_zero(fleet: Fleet) -> None:
    assert "not tested" in text(fleet.page("W1"))


def test_every_problem_is_in_its_well(fleet: Fleet) -> None:
    for well, stage, where, what, remedy in [*PROBLEMS[:1], *PROBLEMS[15:]]:
        assert " ".join([stage, where, what, remedy]) in text(fleet.page(well))
    assert "mobility stack 0 and 4 more places windows … disagree 5 times See them" in text(fleet.page("W2"))
    assert "problems.csv lists them all" in text(fleet.page("W2"))
    assert "problems.csv lists" not in text(fleet.page("W1"))


def test_wells_without_result_say_why(fleet: Fleet) -> None:
    summary = text(fleet.page())
    assert f"No result. Records: bad.csv, row 7: {ATTACK} is not a number. Correct the row." in summary
    assert "No result. Windows: well W3: no window was found." in summary
    assert "No result" in text(fleet.page("W4"))


def test_a_single_window_makes_no_level_and_no_anomaly(fleet: Fleet) -> None:
    assert "No run has enough windows for a usual level" in text(fleet.page("W2"))


def test_the_fleet_has_drilled_what_its_segments_have(fleet: Fleet) -> None:
    # 30 m of ten windows and 3 m of one; both wells and that without windows have a segment of 1 m, 1090 m deep
    assert re.search(r"Drilled in the logs 36 m in \d", text(fleet.page()))


def test_time_without_windows_is_listed_by_reason(fleet: Fleet) -> None:
    page = text(fleet.page("W1"))
    assert "drilling too short: 300.0 s of the 360.0 s needed 1 5.0" in page
    assert "connection – 1 3.0" in page


def test_wells_are_linked_with_their_neighbours(fleet: Fleet) -> None:
    references = structure(fleet.page("W2")).references
    assert {"W1.html", "W3.html", "../report.html"} <= set(references)


def test_the_same_results_give_the_same_pages(fleet: Fleet) -> None:
    before = {well: fleet.page(well) for well in ["", *WELLS]}
    elsewhere = fleet.settings.model_copy(update={"fleet": fleet.settings.fleet.model_copy(update={"processes": 3})})
    report.write_report(elsewhere, fleet.results, WELLS)
    assert {well: fleet.page(well) for well in ["", *WELLS]} == before


def small_fleet(root: Path, names: list[str], description: str = "", title: str = "Fleet") -> Fleet:
    """Wells that failed, with keys as the stages leave them."""
    settings = Settings.checked(
        {
            **{key: str(root / f"{key}.tsv") for key in ("wells", "logs")},
            **{key: str(root / key) for key in ("rigs", "results")},
            "report": {"title": title},
        },
        "test",
    )
    (root / "wells.tsv").write_text("\n".join(["well\trig\tdescription", *(f"{n}\trig\t{description}" for n in names)]))
    (root / "logs.tsv").write_text(
        "\n".join(["well\tlog", *(f"{name}\t{root}/{number}.csv" for number, name in enumerate(names))])
    )
    results = root / "results"
    wells = list(read_sheets(settings))
    for stage in STAGES:
        for well in wells:
            (results / stage / well).mkdir(parents=True)
            (results / stage / well / "key.json").write_text(json.dumps({"key": "one"}))
    rows = [(name, "records", f"a.csv {description}", f"=1+1 {description}", description or "See it") for name in names]
    write_table(pd.DataFrame(rows, columns=list(PROBLEM_COLUMNS)), results / "problems.csv")
    return Fleet(settings, results, wells)


def test_pages_of_wells_that_have_not_changed_are_not_written_again(tmp_path: Path) -> None:
    fleet = small_fleet(tmp_path, ["A", "B"])
    fleet.write()
    marks = {well: fleet.page(well) + "<!-- as it was -->" for well in fleet.wells}
    for well, page in marks.items():
        (fleet.results / f"report/{well}.html").write_text(page)
    (fleet.results / "records/B/key.json").write_text(json.dumps({"key": "another"}))
    fleet.write()
    assert fleet.page("A") == marks["A"]
    assert fleet.page("B") != marks["B"]


def test_a_script_that_was_cut_off_is_written_again(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    fleet = small_fleet(tmp_path, ["A"])
    name, content = bokeh_script()
    script = fleet.results / "report" / name

    def full(path: Path, data: bytes) -> int:
        with path.open("wb") as file:
            file.write(data[:1000])
        raise OSError(errno.ENOSPC, "No space left on device", str(path))

    with monkeypatch.context() as patched:
        patched.setattr(Path, "write_bytes", full)
        with pytest.raises(OSError, match="No space left"):
            fleet.write()
    assert not script.exists()
    fleet.write()
    assert script.read_bytes() == content
    # as an earlier version may have left it
    script.write_bytes(content[:1000])
    fleet.write()
    assert script.read_bytes() == content


def test_the_page_of_a_well_that_is_listed_no_more_goes(tmp_path: Path) -> None:
    fleet = small_fleet(tmp_path, ["A", "B"])
    fleet.write()
    report.write_report(fleet.settings, fleet.results, ["A"])
    assert {path.suffix for path in (fleet.results / "report").glob("B.*")} == set()


def test_a_well_whose_name_is_the_folder_of_another_keeps_its_problems(tmp_path: Path) -> None:
    (tmp_path / "wells.tsv").write_text("well\trig\tfolder\nW2\tr\tW1\nW1\tr\tW3\n")
    (tmp_path / "logs.tsv").write_text("well\tlog\nW1\ta.csv\nW2\tb.csv\n")
    names = {name: str(tmp_path / f"{name}.tsv") for name in ("wells", "logs")}
    settings = Settings.checked({**names, "results": str(tmp_path), "rigs": str(tmp_path)}, "test")
    rows = [("W1", "records", "a.csv", "is empty", "Copy it again"), ("W2", "records", "b.csv", "is locked", "Open it")]
    write_table(pd.DataFrame(rows, columns=list(PROBLEM_COLUMNS)), tmp_path / "problems.csv")
    report.write_report(settings, tmp_path, ["W1", "W3"])
    summaries = [json.loads((tmp_path / f"report/{folder}.json").read_text()) for folder in ("W1", "W3")]
    assert [(each["name"], each["problems"]) for each in summaries] == [("W2", 1), ("W1", 1)]
    pages = [text((tmp_path / f"report/{folder}.html").read_text()) for folder in ("W1", "W3")]
    assert ["is empty" in page for page in pages] == [False, True]


def test_what_is_new_since_the_last_report_is_first(tmp_path: Path) -> None:
    fleet = small_fleet(tmp_path, ["A"])
    row = {
        "well": "A",
        "change": "new_windows",
        "from_m": 1000.0,
        "to_m": 1030.0,
        "count": 3,
        "reason": "new log c.csv",
    }
    one = {"well": "A", "change": "removed_windows", "count": 1, "from_m": 990.0, "to_m": 993.0, "reason": ""}
    kinds = [{"well": "A", "change": "new_problem", "count": count, "now": f"kind {count}"} for count in (1, 2)]
    failed = {"well": "A", "change": "failed", "now": "records: stand_04|b.csv: column HOOK_LOAD is missing"}
    changes = pd.DataFrame([row, one, *kinds, failed], columns=list(CHANGE_COLUMNS))
    write_table(changes, fleet.results / "changes.csv")
    fleet.write()
    said = text(fleet.page())
    assert "New since the last report A : 3 new windows at 1000–1030 m reason: new log c.csv" in said
    assert "A : 1 removed window at 990–993 m" in said
    assert "A : 1 new problem: kind 1 A : 2 new problems: kind 2" in said
    assert "stand_04|b.csv: column HOOK_LOAD is missing" in said


def test_a_page_without_scripts_shows_the_figure_only_if_there_is_one(fleet: Fleet) -> None:
    page, figure = fleet.page("W1"), fleet.results / "figures/W1/parameters.png"
    assert ("parameters.png" in page) == figure.exists()


def test_a_first_report_says_so_and_a_later_one_that_nothing_has_changed(tmp_path: Path) -> None:
    fleet = small_fleet(tmp_path, ["A"])
    fleet.write()
    assert "This is the first report" in text(fleet.page())
    (fleet.results / "reported.json").write_text(json.dumps({"reported": True, "before": {"A": {}}, "now": {"A": {}}}))
    fleet.write()
    assert "Nothing has changed since the last report" in text(fleet.page())


def test_advice_for_the_control_comes_before_the_log_plot(fleet: Fleet) -> None:
    page = fleet.page("W1")
    assert page.index('id="verdicts"') < page.index('id="control"') < page.index('id="log-part"')


def test_a_well_named_and_described_as_a_script_is_shown_and_not_run(tmp_path: Path) -> None:
    name, attack = "34/10-A <script>alert(1)</script>", "<img src=x onerror=alert(2)>"
    fleet = small_fleet(tmp_path, [name], attack, f"Fleet {attack}")
    assert fleet.wells == ["34-10-A-script-alert-1-script"]
    fleet.write()
    for page in (fleet.page(), fleet.page(fleet.wells[0])):
        parsed = structure(page)
        assert "img" not in parsed.tags
        assert ATTACK not in page
        assert not any("onerror" in reference or " " in reference for reference in parsed.references)
        for written in (name, attack, f"=1+1 {attack}"):
            assert written in text(page)


def test_a_page_of_starts_of_rotation_alone_speaks_of_no_wells(tmp_path: Path) -> None:
    start = {"name": "B", "depth": "9 m", "verdict": "kept", "torque": "2 kN m", "bit": "9 rpm"}
    start |= {"problems": 0, "figure": ""}
    page = report.fleet_page(Settings(), tmp_path, [], starts=[start])
    assert "1 start of rotation" in text(page)
    assert "Nothing stands out in any well" not in page
    found = structure(page)
    assert {each[1:] for each in found.references if each.startswith("#")} <= set(found.ids)
    assert "starts" in found.ids
    assert "attention" not in found.ids
