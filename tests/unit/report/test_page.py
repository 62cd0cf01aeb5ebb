"""The report of a small synthetic fleet: complete, self-contained, escaped, and with the right numbers."""

import base64
import html
import re
from dataclasses import replace
from html.parser import HTMLParser
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
import xarray as xr
import yaml

from drillid.config.settings import Settings
from drillid.datasets.registry import PROBLEM_COLUMNS
from drillid.datasets.store import WellFolders
from drillid.datasets.tables import write_table
from drillid.figures import stage as figures
from drillid.figures.captions import FIGURES
from drillid.report import page as report
from drillid.report.content import (
    EXPLANATIONS,
    Comparison,
    Estimate,
    FlaggedInterval,
    Identified,
    Rise,
    comparison,
    covered_hours,
    drilled,
    identified,
    joined,
    kinds,
    read_segments,
    weighted_mean,
    without_windows,
)
from tests.synthetic_well import RIG, make_well

COUNTS = {"W1": 10, "W2": 1, "W3": 0}
WELLS = [*COUNTS, "W4"]
PROBLEMS = [
    ("W1", "records", "log_1.csv", "3 spikes replaced", "Look at the recorder"),
    *(("W2", "fits", f"window {name} <1500 m", f"reason & name {name}", "See it") for name in "abcdefghi"),
    *(("W2", "mobility", f"stack {number}", f"windows {number} disagree", "See them") for number in range(5)),
    ("W3", "windows", "well W3", "no window was found", "See its segments.csv for the reasons"),
    ("W4", "records", "bad.csv, row 7", "<script>alert(1)</script> is not a number", "Correct the row"),
]


@pytest.fixture(scope="module")
def fleet(tmp_path_factory: pytest.TempPathFactory) -> tuple[Settings, Path]:
    """A flagged well with figures, one of a single window, one without windows, and one that failed at its logs."""
    root = tmp_path_factory.mktemp("fleet")
    settings = Settings.checked(
        {
            **{name: str(root / f"{name}.tsv") for name in ("wells", "logs")},
            **{name: str(root / name) for name in ("rigs", "results")},
            "report": {"title": "Fleet of <two> & more"},
            "figures": {"dpi": 50},
        },
        "test",
    )
    (root / "rigs").mkdir()
    (root / "rigs/rig.yaml").write_text(yaml.safe_dump(RIG, allow_unicode=True))
    rows = [f"{well}\trig\tWell {number} <b>bold</b>" for number, well in enumerate(WELLS)]
    (root / "wells.tsv").write_text("\n".join(["well\trig\tdescription", *rows]))
    (root / "logs.tsv").write_text("\n".join(["well\tlog", *(f"{well}\t{well}.csv" for well in WELLS)]))
    results = root / "results"
    made = {name: make_well(results, name, count) for name, count in COUNTS.items()}
    figures.process(made["W1"], WellFolders(results, "W1"), settings)
    pd.DataFrame(PROBLEMS, columns=list(PROBLEM_COLUMNS)).to_csv(results / "problems.csv", index=False)
    return settings, results


@pytest.fixture(scope="module")
def page(fleet: tuple[Settings, Path]) -> str:
    settings, results = fleet
    report.write_report(settings, results, WELLS)
    return (results / "report.html").read_text(encoding="utf-8")


@pytest.fixture(scope="module")
def found(fleet: tuple[Settings, Path]) -> Identified:
    return identified(WellFolders(fleet[1], "W1"), report.read_sheets(fleet[0])["W1"].load().rig)


def section(page: str, well: str) -> str:
    """The part of the page that is about one well."""
    return page.split(f'id="well-{well}"')[1].split("<h2")[0]


def text(fragment: str) -> str:
    """What a reader sees, white space shortened."""
    return re.sub(r"\s+", " ", html.unescape(re.sub(r"<[^>]+>", " ", fragment)))


class Structure(HTMLParser):
    """Checks that tags are balanced and collects headings, images, anchors and references."""

    VOID = frozenset({"meta", "img", "br", "link", "input", "hr"})

    def __init__(self) -> None:
        super().__init__()
        self.open: list[str] = []
        self.headings: list[int] = []
        self.images: list[dict[str, str | None]] = []
        self.ids: list[str] = []
        self.references: list[str] = []
        self.tags: set[str] = set()

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        """Collect what the tests ask for."""
        known = dict(attrs)
        self.tags.add(tag)
        self.ids += [value for name, value in attrs if name == "id" and value]
        self.references += [value for name, value in attrs if name in ("src", "href") and value]
        if re.fullmatch(r"h\d", tag):
            self.headings.append(int(tag[1]))
        if tag == "img":
            self.images.append(known)
        if tag not in self.VOID:
            self.open.append(tag)

    def handle_endtag(self, tag: str) -> None:
        """The tag that closes must be the last that opened."""
        assert self.open.pop() == tag


@pytest.fixture(scope="module")
def structure(page: str) -> Structure:
    parsed = Structure()
    parsed.feed(page)
    return parsed


def test_the_page_is_well_formed_and_its_headings_skip_no_level(structure: Structure) -> None:
    assert structure.open == []
    assert structure.headings.count(1) == 1
    assert structure.headings[0] == 1
    assert all(after <= before + 1 for before, after in zip(structure.headings, structure.headings[1:], strict=False))
    assert len(structure.ids) == len(set(structure.ids))


def test_the_page_needs_nothing_from_outside(page: str, structure: Structure) -> None:
    assert not {"script", "link", "iframe"} & structure.tags
    outside = [each for each in structure.references if not each.startswith(("data:image/png;base64,", "#"))]
    assert outside == []
    assert {each[1:] for each in structure.references if each.startswith("#")} <= set(structure.ids)
    assert "url(" not in page
    assert "@import" not in page


def test_every_figure_is_in_the_page_as_it_was_drawn_with_words_for_it(
    fleet: tuple[Settings, Path], page: str, structure: Structure
) -> None:
    folder = fleet[1] / "figures/W1"
    inside = [base64.b64decode(str(image["src"]).partition(",")[2]) for image in structure.images]
    assert inside == [(folder / f"{name}.png").read_bytes() for name in FIGURES]
    for image, figure in zip(structure.images, FIGURES.values(), strict=True):
        assert image["alt"] == f"W1: {figure.title}"
        assert figure.caption in text(page)
        assert int(str(image["width"])) > int(str(image["height"])) / 2 > 100


def test_texts_of_users_are_escaped(page: str) -> None:
    assert "<script>" not in page
    assert "&lt;script&gt;alert(1)&lt;/script&gt;" in page
    assert "Fleet of &lt;two&gt; &amp; more" in page
    assert "<b>bold</b>" not in page


def test_the_flagged_interval_is_first_and_in_its_well(page: str) -> None:
    for part in (page.split("<h3>Wells</h3>")[0], section(page, "W1")):
        assert "1015–1021 m" in text(part)
        assert re.search(r"BHA damping \d+ N m s/rad where \d+ is usual, at least \d+ times as much", text(part))
        assert "BHA inertia" in text(part)
        assert EXPLANATIONS[frozenset({"damping_bha", "inertia_bha"})] in text(part)


def test_every_problem_is_in_its_well(page: str) -> None:
    for well, stage, where, what, remedy in [*PROBLEMS[:10], *PROBLEMS[15:]]:
        cells = " ".join([stage, where, what, remedy])
        assert cells in text(section(page, well))
    assert "14 rows: 9 in fits, 5 in mobility" in text(section(page, "W2"))
    assert "mobility stack 0 and 4 more places windows … disagree 5 times See them" in text(section(page, "W2"))
    assert "problems.csv beside this report lists each of them" in text(section(page, "W2"))
    assert "problems.csv beside this report lists" not in text(section(page, "W1"))


def test_wells_without_result_say_why_at_the_top(page: str) -> None:
    summary = text(page.split("<h3>Wells</h3>")[0])
    assert "W4 has no result. Records: bad.csv, row 7: <script>alert(1)</script> is not a number." in summary
    assert "W3 has no result. Windows: well W3: no window was found." in summary
    assert "No result." in text(section(page, "W4"))


def test_a_single_window_makes_no_level_and_no_anomaly(page: str) -> None:
    assert "No run has enough windows for a usual level" in text(section(page, "W2"))
    assert "too few windows" in text(page.split("<h3>Wells</h3>")[1])


def test_time_without_windows_is_listed_by_reason(page: str) -> None:
    assert "drilling too short: 300 s of 600 s 1 5.0" in text(section(page, "W1"))
    assert "connection connection 1 3.0" in text(section(page, "W1"))


def test_the_same_results_give_the_same_page(fleet: tuple[Settings, Path], page: str) -> None:
    settings, results = fleet
    elsewhere = settings.model_copy(update={"fleet": settings.fleet.model_copy(update={"processes": 3})})
    report.write_report(elsewhere, results, WELLS)
    assert (results / "report.html").read_text(encoding="utf-8") == page


def test_a_large_fleet_shows_the_parameters_of_flagged_wells_alone(
    fleet: tuple[Settings, Path], page: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(report, "_ILLUSTRATED_WELLS", 3)
    settings, results = fleet
    problems = pd.read_csv(results / "problems.csv")
    listings = report.read_sheets(settings)
    few = [
        report.well_report(WellFolders(results, well), listings[well], problems, illustrated=False) for well in WELLS
    ]
    assert [[picture.name for picture in each.pictures] for each in few] == [["parameters", "verdicts"], [], [], []]
    assert "in the folder figures/W1 beside this report" in text(report.render(settings, few))


def test_what_was_identified_is_counted(found: Identified) -> None:
    assert (found.windows, found.accepted, found.judged) == (10, 10, True)
    assert found.hours == pytest.approx(10 * 600 / 3600)
    (run,) = found.runs
    assert (run.windows, run.used, run.collars) == (10, 8, "60 m collars, OD 165 mm")
    assert run.spreads["inertia_td"].median == pytest.approx(1105, rel=5e-3)
    assert run.spreads["length"].median == pytest.approx(0, abs=15)


def test_an_interval_has_its_level_and_the_usual_one(found: Identified) -> None:
    (interval,) = found.intervals
    damping, inertia = interval.rises
    assert abs(damping.there.value - 400) < 4 * damping.there.error
    assert abs(damping.usual.value - 20) < 4 * damping.usual.error
    assert abs(inertia.there.value - 120) < 4 * inertia.there.error
    assert 10 < damping.least_ratio < 20
    assert 1.7 < inertia.least_ratio < 2.0


def test_the_prior_is_subtracted_from_the_estimate() -> None:
    alone, deviation, data_sheet, tolerance = 1105.0, 20.0, 1000.0, 30.0
    weights = 1 / deviation**2, 1 / tolerance**2
    joint = (alone * weights[0] + data_sheet * weights[1]) / sum(weights)
    fits = fits_of([joint] * 4, sum(weights) ** -0.5, data_sheet, tolerance)
    result = comparison(fits, "inertia_td", np.ones(4, dtype=bool))
    assert result.measured is not None
    assert result.measured.value == pytest.approx(alone)
    assert result.measured.error == pytest.approx(deviation / 2)
    assert result.pull == pytest.approx(105 / np.hypot(10, 30))
    assert result.verdict == "disagrees"


def test_data_that_add_nothing_to_the_data_sheet_determine_nothing() -> None:
    fits = fits_of([1000.0] * 4, 30.0 * (1 - 1e-4), 1000.0, 30.0)
    assert comparison(fits, "inertia_td", np.ones(4, dtype=bool)).verdict == "not determined by the data"
    assert comparison(fits, "inertia_td", np.zeros(4, dtype=bool)).data_sheet == Estimate(1000.0, 30.0)


def fits_of(values: list[float], error: float, data_sheet: float, tolerance: float) -> xr.Dataset:
    """Fits of one parameter."""
    columns = {
        "value": values,
        "standard_error": [error] * 4,
        "prior": [data_sheet] * 4,
        "prior_error": [tolerance] * 4,
    }
    rows = {name: (("window", "parameter"), np.array(column)[:, None]) for name, column in columns.items()}
    return xr.Dataset(rows, {"parameter": ["inertia_td"]})


def test_disagreement_with_the_data_sheet_is_at_the_top(fleet: tuple[Settings, Path]) -> None:
    settings, results = fleet
    problems = pd.DataFrame(columns=list(PROBLEM_COLUMNS))
    listing = report.read_sheets(settings)["W2"]
    well = report.well_report(WellFolders(results, "W2"), listing, problems, illustrated=True)
    assert well.identified is not None
    data_sheet = (
        Comparison("delay", Estimate(0.030, 0.001), Estimate(0.0405, 0.0001)),
        Comparison("inertia_td", Estimate(1100.0, 55.0), Estimate(1105.0, 2.0)),
        Comparison("polar_moment", Estimate(1.6e-5, 8e-7), None),
    )
    summary = report.render(settings, [replace(well, identified=replace(well.identified, comparisons=data_sheet))])
    summary_text = text(summary.split("<h3>Wells</h3>")[0])
    assert "rive delay (40.50 ± 0.10 ms against 30.0 ± 1.0 ms) disagrees with the data sheets" in summary_text
    assert report.data_sheet_text(data_sheet).endswith("pipe polar moment is not determined by these data.")
    assert report.data_sheet_verdict(data_sheet) == "drive delay disagrees"
    assert report.data_sheet_verdict(data_sheet[1:]) == "agrees"
    assert report.data_sheet_verdict(()) == "not given"


def test_rejected_fits_are_listed_with_their_reasons(fleet: tuple[Settings, Path]) -> None:
    settings, results = fleet
    problems = pd.DataFrame(columns=list(PROBLEM_COLUMNS))
    listing = report.read_sheets(settings)["W2"]
    well = report.well_report(WellFolders(results, "W2"), listing, problems, illustrated=True)
    assert well.identified is not None
    rejected = replace(well.identified, accepted=0)
    rejected.rejections["the residuals are too large"] = 1
    summary_text = text(report.render(settings, [replace(well, identified=rejected)]).split("<h3>Wells</h3>")[0])
    assert "1 of 1 fits are not accepted: 1 because the residuals are too large." in summary_text


def test_a_rise_has_the_least_ratio_within_the_errors() -> None:
    rise = Rise("damping_bha", Estimate(340.0, 20.0), Estimate(15.0, 5.0), 9.0)
    assert rise.least_ratio == pytest.approx((340 - 39.2) / (15 + 9.8))
    assert (
        report.rise_text(rise, brief=True) == "BHA damping 340 N m s/rad where 15 is usual, at least 12 times as much"
    )
    assert report.rise_text(rise).endswith("(9.0 standard deviations in the clearest window)")
    hardly = Rise("inertia_bha", Estimate(80.0, 10.0), Estimate(75.0, 5.0), 2.1)
    assert "times" not in report.rise_text(hardly)
    assert report.explanation(FlaggedInterval(1.0, 2.0, 1, (hardly,))) == EXPLANATIONS[frozenset({"inertia_bha"})]


def test_windows_that_overlap_count_their_time_once() -> None:
    start = np.array(["2025-01-01T00:00", "2025-01-01T00:30", "2025-01-01T04:00"], dtype="datetime64[ns]")
    assert covered_hours(start, start + np.timedelta64(1, "h")) == pytest.approx(2.5)


def test_reasons_of_one_kind_count_together() -> None:
    same = kinds(pd.Series(["gap of 37.0 s", "gap of 37.0 s", "connection"]))
    assert same.tolist() == ["gap of 37.0 s", "gap of 37.0 s", "connection"]
    rows = [("drilling", "too short: 20.0 s of 600.0 s", 20, 0), ("drilling", "too short: 7.5 s of 600.0 s", 7.5, 0)]
    rows += [("drilling", "", 1200, 2), ("unknown", "gap of 600 s", 600, 0)]
    table = without_windows(pd.DataFrame(rows, columns=["state", "reason", "duration_s", "windows"]))
    assert table.values.tolist() == [
        ["unknown", "gap of 600 s", 1, 10.0],
        ["drilling", "too short: … s of … s", 2, pytest.approx(27.5 / 60)],
    ]


def test_equal_problems_are_joined_at_the_first_place_once_they_are_many() -> None:
    spikes = [("W1", "records", f"log {n}", f"{n} spikes in speed", f"See log {n}") for n in range(5)]
    gaps = [("W1", "records", f"log {n}", f"a gap of {n} s", "None") for n in range(3)]
    other = [("W1", "windows", "log 9", "7 spikes in speed", "None")]
    table = joined(pd.DataFrame([gaps[0], *spikes, *gaps[1:], *other], columns=list(PROBLEM_COLUMNS)))
    assert table[["stage", "where", "what", "remedy", "rows"]].to_numpy().tolist() == [
        ["records", "log 0", "a gap of 0 s", "None", 1],
        ["records", "log 0", "… spikes in speed", "See log 0", 5],
        ["records", "log 1", "a gap of 1 s", "None", 1],
        ["records", "log 2", "a gap of 2 s", "None", 1],
        ["windows", "log 9", "7 spikes in speed", "None", 1],
    ]
    same = joined(
        pd.DataFrame([("W1", "fits", f"window {n}", "is 3 off", "None") for n in range(4)], columns=table.columns[:5])
    )
    assert same[["what", "rows"]].to_numpy().tolist() == [["is 3 off", 4]]
    assert joined(pd.DataFrame(columns=list(PROBLEM_COLUMNS))).empty


def test_a_well_without_segments_has_drilled_nothing(tmp_path: Path) -> None:
    segments = read_segments(WellFolders(tmp_path, "lost"))
    nothing = drilled(segments)
    assert (nothing.hours, nothing.newest) == (0.0, None)
    assert np.isnan(nothing.from_m)
    assert without_windows(segments).empty


def test_numbers_are_written_for_readers() -> None:
    assert [report.number(value) for value in (1234.4, 12345, -3.2, -0.2, np.nan)] == [
        "1234",
        "12\u202f345",
        "−3",
        "0",
        "–",
    ]
    assert [report.share(*parts) for parts in ((1, 1), (999, 1000), (1, 1000), (0, 9), (1, 0))] == [
        "100 %",
        "> 99 %",
        "< 1 %",
        "0 %",
        "–",
    ]
    assert report.estimate_text(Estimate(0.040523, 0.000018), "delay") == "40.523 ± 0.018 ms"
    assert report.estimate_text(Estimate(1100.0, 55.0), "inertia_td") == "1100 ± 55 kg m²"


def test_depths_of_a_well_without_any_are_a_dash() -> None:
    assert report.depths(FlaggedInterval(2745.2, 3389.4, 1, ())) == "2745–3389 m"
    assert report.depths(FlaggedInterval(np.nan, np.nan, 0, ())) == "–"


def test_a_weighted_mean_follows_the_surer_value() -> None:
    mean = weighted_mean(np.array([1.0, 5.0]), np.array([1.0, 2.0]))
    assert (mean.value, mean.error) == (pytest.approx(1.8), pytest.approx(np.sqrt(0.8)))
    assert np.isnan(weighted_mean(np.array([]), np.array([])).value)


def test_a_well_named_and_described_as_a_script_is_shown_and_not_run(tmp_path: Path) -> None:
    name, attack = "34/10-A <script>alert(1)</script>", "<img src=x onerror=alert(2)>"
    settings = Settings.checked(
        {
            **{key: str(tmp_path / f"{key}.tsv") for key in ("wells", "logs")},
            **{key: str(tmp_path / key) for key in ("rigs", "results")},
            "report": {"title": f"Fleet {attack}"},
        },
        "test",
    )
    (tmp_path / "wells.tsv").write_text(f"well\trig\tdescription\n{name}\trig\t{attack}\n")
    (tmp_path / "logs.tsv").write_text(f"well\tlog\n{name}\t{tmp_path}/a.csv\n")
    (tmp_path / "results").mkdir()
    rows = [(name, "records", f"a.csv {attack}", f"=1+1 {attack}", attack)]
    write_table(pd.DataFrame(rows, columns=list(PROBLEM_COLUMNS)), tmp_path / "results/problems.csv")
    wells = list(report.read_sheets(settings))
    assert wells == ["34-10-A-script-alert-1-script"]
    report.write_report(settings, tmp_path / "results", wells)
    page = (tmp_path / "results/report.html").read_text(encoding="utf-8")
    parsed = Structure()
    parsed.feed(page)
    assert {"script", "img"}.isdisjoint(parsed.tags)
    assert not any("onerror" in reference or " " in reference for reference in parsed.references)
    assert f"well-{wells[0]}" in parsed.ids
    shown = text(page)
    for written in (name, attack, f"=1+1 {attack}"):
        assert written in shown
