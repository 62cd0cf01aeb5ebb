"""What the report reads of a well: counts, levels, comparisons, texts."""

from collections import Counter
from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
import xarray as xr

from drillid.datasets.registry import PROBLEM_COLUMNS
from drillid.datasets.store import WellFolders
from drillid.discrepancy.sets import verdict_table
from drillid.figures.captions import share
from drillid.report.attention import interval_explanation, interval_lead, items, rise_text
from drillid.report.charts.style import clear_ticks
from drillid.report.content import (
    EXPLANATIONS,
    Comparison,
    Estimate,
    FlaggedInterval,
    Identified,
    ParameterSpread,
    Rise,
    comparison,
    comparisons,
    covered_hours,
    drilled,
    joined,
    kinds,
    read_segments,
    weighted_mean,
    without_windows,
)
from drillid.report.quantities import QUANTITIES, number, size_text
from drillid.report.rendering import bar_length
from drillid.report.sentences import data_sheet_verdict, deviations_text, error_text, estimate_text
from drillid.report.verdicts import verdict_text
from drillid.report.well_report import StickSlip, WellReport, stick_slip
from drillid.units import RPM
from tests.verdicts import LAG

NOTHING = pd.DataFrame(columns=list(PROBLEM_COLUMNS))
WELL = WellReport("A", "A", "", "", drilled(read_segments(WellFolders(Path(), "A"))), None, NOTHING, NOTHING)
"""Without results."""


def test_what_was_identified_is_counted(found: Identified) -> None:
    assert (found.windows, found.accepted, found.judged) == (10, 10, True)
    assert found.hours == pytest.approx(10 * 600 / 3600)
    (run,) = found.runs
    assert (run.windows, run.used) == (10, 8)
    assert "60 m" in run.collars
    assert "OD" in run.collars
    assert "6.50 in" in run.collars
    assert run.spreads["inertia_td"].usual == pytest.approx(1105, rel=5e-3)
    assert run.spreads["length"].usual == pytest.approx(0, abs=15)


@pytest.mark.parametrize(
    ("start", "end", "width"),
    [(0.0, 108.0, 74), (91.0, 112.0, 74), (-1800.0, 23000.0, 98), (0.096, 0.122, 98), (2400.0, 3100.0, 74)],
)
def test_numbers_of_an_axis_neither_touch_nor_leave_it(start: float, end: float, width: int) -> None:
    ticks = clear_ticks(start, end, width)
    assert 1 <= len(ticks) <= 3
    ends = [
        ((tick - start) / (end - start) * width + side * 3 * len(f"{tick:.6g}")) for tick in ticks for side in (-1, 1)
    ]
    assert ends == sorted(ends)
    assert ends[0] > -5
    assert ends[-1] < width


def test_bars_of_evidence_differ_beyond_thirty() -> None:
    lengths = [bar_length(value) for value in (0.0, 5.0, 10.0, 30.0, 87.0, 1545.0)]
    assert lengths == sorted(set(lengths))
    assert lengths[-1] < 8


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


def test_a_parameter_without_data_sheet_in_the_windows_that_are_compared_is_left_out() -> None:
    fits, compared = fits_of([1000.0] * 4, 20.0, 1000.0, 30.0), np.array([True, True, False, False])
    assert [each.parameter for each in comparisons(fits, compared)] == ["inertia_td"]
    fits["prior"][compared], fits["prior_error"][compared] = np.nan, np.nan
    assert comparisons(fits, compared) == ()
    assert comparisons(fits, np.ones(4, dtype=bool))[0].data_sheet == Estimate(1000.0, 30.0)
    # without any accepted window the data sheets are told alone
    assert comparisons(fits, np.zeros(4, dtype=bool))[0].verdict == "not determined by the data"


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


def test_the_usual_level_is_one_number(found: Identified) -> None:
    (interval,), (run,) = found.intervals, found.runs
    for rise in interval.rises:
        assert rise.usual.value == pytest.approx(run.spreads[rise.parameter].usual)


def test_a_run_without_accepted_fits_leaves_the_error_of_one_window_known(found: Identified) -> None:
    (run,) = found.runs
    unused = {name: ParameterSpread(*[np.nan] * 4, at_bound=0) for name in run.spreads}
    runs = (run, replace(run, used=0, spreads=unused))
    assert replace(found, runs=runs).window_error("delay") == found.window_error("delay") == run.spreads["delay"].error
    assert np.isnan(replace(found, runs=runs[1:]).window_error("delay"))


def test_agreement_with_the_data_sheets_is_said() -> None:
    compared = (
        Comparison("delay", Estimate(0.030, 0.001), Estimate(0.0405, 0.0001)),
        Comparison("inertia_td", Estimate(1100.0, 55.0), Estimate(1105.0, 2.0)),
        Comparison("polar_moment", Estimate(1.6e-5, 8e-7), None),
    )
    words = deviations_text(compared)
    assert "rive delay (40.50 ± 0.10 ms against 30.0 ± 1.0 ms) disagrees with the data sheets" in words
    assert words.endswith("pipe polar moment is not determined by these data.")
    assert data_sheet_verdict(compared) == "drive delay disagrees"
    assert data_sheet_verdict(compared[1:]) == "agrees"
    assert data_sheet_verdict(()) == "not given"


def test_a_rise_has_the_least_ratio_within_the_errors() -> None:
    rise = Rise("damping_bha", Estimate(340.0, 20.0), Estimate(15.0, 5.0), 9.0)
    assert rise.least_ratio == pytest.approx((340 - 39.2) / (15 + 9.8))
    words = rise_text(rise).striptags()
    assert words.startswith("BHA damping 340 N m s/rad")
    assert "where 15 N m s/rad" in words
    assert "at least 12 times as much" in words
    hardly = Rise("inertia_bha", Estimate(80.0, 10.0), Estimate(75.0, 5.0), 2.1)
    assert "times" not in rise_text(hardly)
    assert interval_explanation(FlaggedInterval(1.0, 2.0, 1, (hardly,))) == EXPLANATIONS[frozenset({"inertia_bha"})]


def test_an_interval_in_which_nothing_rose_clearly_names_no_rise() -> None:
    lead = interval_lead(FlaggedInterval(1000.0, 1010.0, 3, ()))
    assert lead.startswith("Damping or inertia of the assembly is higher here")
    assert "and more mass" not in lead
    assert "washed-out" not in lead
    both = tuple(Rise(name, Estimate(9.0, 1.0), Estimate(1.0, 1.0), 5.0) for name in ("damping_bha", "inertia_bha"))
    assert "and more mass rotates with it, as in a washed" in interval_lead(FlaggedInterval(1.0, 2.0, 3, both))


@pytest.mark.parametrize(
    ("rose", "kind"),
    [
        ((), "Bit and assembly"),
        (("inertia_bha",), "Bit and assembly"),
        (("damping_bha",), "Wash-out"),
        (("damping_bha", "inertia_bha"), "Wash-out"),
    ],
)
def test_only_a_rise_of_damping_is_listed_as_a_wash_out(rose: tuple[str, ...], kind: str) -> None:
    rises = tuple(Rise(name, Estimate(9.0, 1.0), Estimate(1.0, 1.0), 5.0) for name in rose)
    interval = FlaggedInterval(1000.0, 1010.0, 3, rises)
    change = replace(LAG, verdict="regime_change", cause="regime_change", from_m=1000.0, to_m=1010.0)
    verdict = verdict_text(verdict_table("A", [change]).to_dict("records")[0])
    found = Identified(10, 1.7, 10, Counter(), (1.0, 1.0, 1.0), True, (interval,), (), ())
    for verdicts in ((), (verdict,)):
        (item,) = items(replace(WELL, identified=found, verdicts=verdicts))
        assert item.kind == kind
        assert ("washed-out" in item.lead) == (kind == "Wash-out")


@pytest.mark.parametrize(("there", "said"), [(4.96, "4"), (2.98, "2.9"), (1.99, "1.9"), (1.1, "1.1"), (1.09, "")])
def test_a_least_ratio_is_not_rounded_up(there: float, said: str) -> None:
    words = rise_text(Rise("damping_bha", Estimate(there, 0.0), Estimate(1.0, 0.0), 9.0)).striptags()
    assert (f"at least {said} times" in words) if said else ("times" not in words)


def test_a_speed_below_its_limit_does_not_read_the_same() -> None:
    for lowest, said in (
        (119.3, "118.9 rpm where a bit with the stated torque needs 119.3 rpm"),
        (140.0, "119 rpm where"),
    ):
        risk = StickSlip(1, 2, 118.9 * RPM, lowest * RPM, 1000.0, 1010.0)
        (item,) = (each for each in items(replace(WELL, stick_slip=risk)) if each.kind == "Stick-slip")
        assert item.more.startswith(said)


@pytest.mark.parametrize(
    ("lowest", "slope", "lead", "why"),
    [
        (
            [np.nan, np.inf, np.inf],
            20.0,
            "Risk of stick-slip at every speed: reduce the weight on bit or have the speed control tuned.",
            "With a bit of the stated torque no speed is stable there; 2 of 2 windows are below their limit.",
        ),
        (
            [130.0, np.inf, 100.0],
            20.0,
            "Risk of stick-slip, in 1 of 2 windows at every speed: reduce the weight on bit or have the speed control "
            "tuned.",
            "With a bit of the stated torque no speed is stable there; 2 of 3 windows are below their limit.",
        ),
        (
            [np.nan, np.inf, 100.0],
            -60.0,
            "Risk of stick-slip at every speed: have the speed control tuned.",
            "The bit feeds vibration by itself, whatever the weight on it; 1 of 2 windows is below its limit.",
        ),
        (
            [np.nan, np.inf, 100.0],
            np.nan,
            "Risk of stick-slip at every speed: have the speed control tuned.",
            "The speed control feeds vibration by itself, whatever the weight on the bit; 1 of 2 windows is below its "
            "limit.",
        ),
    ],
)
def test_windows_that_no_speed_makes_stable_are_told(lowest: list[float], slope: float, lead: str, why: str) -> None:
    limits = {"lowest_stable_speed": np.array(lowest) * RPM, "critical_slope": np.full(3, slope)}
    depth = xr.Dataset({name: ("depth", value) for name, value in limits.items()}, {"depth": [1000.0, 1010.0, 1020.0]})
    risk = stick_slip(depth, np.full(3, 119 * RPM))
    assert risk is not None
    (item,) = (each for each in items(replace(WELL, stick_slip=risk)) if each.kind == "Stick-slip")
    assert (item.lead, item.more) == (lead, why)


def test_windows_that_overlap_count_their_time_once() -> None:
    start = np.array(["2025-01-01T00:00", "2025-01-01T00:30", "2025-01-01T04:00"], dtype="datetime64[ns]")
    assert covered_hours(start, start + np.timedelta64(1, "h")) == pytest.approx(2.5)


def test_reasons_of_one_kind_count_together() -> None:
    same = kinds(pd.Series(["gap of 37.0 s", "gap of 37.0 s", "connection"]))
    assert same.tolist() == ["gap of 37.0 s", "gap of 37.0 s", "connection"]
    rows = [
        ("drilling", "too short: 20.0 s of the 360.0 s needed", 20, 0),
        ("drilling", "too short: 7.5 s of the 360.0 s needed", 7.5, 0),
    ]
    rows += [("drilling", "", 1200, 2), ("unknown", "gap of 600.0 s", 600, 0)]
    table = without_windows(pd.DataFrame(rows, columns=["state", "reason", "duration_s", "windows"]))
    assert table.values.tolist() == [
        ["unknown", "gap of 600.0 s", 1, 10.0],
        ["drilling", "too short: … s of the … s needed", 2, pytest.approx(27.5 / 60)],
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


def test_metres_between_two_segments_are_not_drilled() -> None:
    columns = ["state", "end", "from_m", "to_m", "duration_s"]
    rows = [("drilling", 1000.0, 1010.0), ("reaming", 1010.0, 1500.0), ("drilling", 1500.0, 1520.0)]
    found = drilled(pd.DataFrame([(state, "2025-05-01", *ends, 1800) for state, *ends in rows], columns=columns))
    assert (found.from_m, found.to_m, found.hours, found.metres) == (1000.0, 1520.0, 1.0, 30.0)
    assert drilled(pd.DataFrame(columns=columns)).metres == 0


def test_numbers_are_written_for_readers() -> None:
    assert [number(value) for value in (1234.4, 12345, -3.2, -0.2, np.nan)] == [
        "1234",
        "12\u202f345",
        "−3",
        "0",
        "–",
    ]
    assert [share(*parts) for parts in ((1, 1), (999, 1000), (1, 1000), (1, 200), (1, 100), (0, 9), (1, 0))] == [
        "100 %",
        "> 99 %",
        "< 1 %",
        "< 1 %",
        "1 %",
        "0 %",
        "–",
    ]
    assert estimate_text(Estimate(0.040523, 0.000018), "delay") == "40.523 ± 0.018 ms"
    inertia = estimate_text(Estimate(1100.0, 55.0), "inertia_td")
    assert all(text in inertia for text in ("1100 ± 55 kg m²", "26\u202f103 ± 1305 lb·ft²"))


def test_an_error_is_told_to_two_digits() -> None:
    assert error_text(1.8e-8, "delay") == "0.000018"
    assert error_text(0.0, "delay") == "0.00"
    assert error_text(np.nan, "delay") == "–"
    inertia = error_text(55.0, "inertia_td")
    assert all(text in inertia for text in (">55<", ">1305<"))


def test_quantities_are_in_both_units() -> None:
    depths = QUANTITIES["depth"].text(2990.4, 3050.0)
    assert str(depths) == '<span class="metric">2990–3050 m</span><span class="oilfield">9811–10\u202f007 ft</span>'
    assert QUANTITIES["depth"].text(np.nan, 1.0) == "–"
    assert QUANTITIES["rotation"].text(np.pi) == "30 rpm"
    assert QUANTITIES["pressure"].per_metric == pytest.approx(14.5038, rel=1e-5)
    assert QUANTITIES["flow"].per_metric == pytest.approx(0.264172, rel=1e-5)


def test_sizes_are_in_units_that_one_feels() -> None:
    assert size_text(0.0494, "s") == "49.4 ms"
    assert size_text(4e-4, "s²") == "20 ms"
    assert size_text(-0.05, "1") == "5 %"
    assert size_text(1e-4, "s/s") == "6 ms in a minute"
    assert size_text(150.0, "N s^(3/2)/m⁴") == "150 N s^(3/2)/m⁴"


def test_a_weighted_mean_follows_the_surer_value() -> None:
    mean = weighted_mean(np.array([1.0, 5.0]), np.array([1.0, 2.0]))
    assert (mean.value, mean.error) == (pytest.approx(1.8), pytest.approx(np.sqrt(0.8)))
    assert np.isnan(weighted_mean(np.array([]), np.array([])).value)
