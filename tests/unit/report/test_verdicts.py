"""Verdicts in words: every cause has a headline and an action, and numbers and doubts are given as they are."""

import re
from dataclasses import replace
from typing import Any

import pandas as pd
import pytest
from markupsafe import Markup

from drillid.discrepancy import CATALOGUE, Verdict
from drillid.discrepancy.catalogue import SYMPTOMS
from drillid.discrepancy.catalogue.time import rise
from drillid.discrepancy.sets import verdict_table
from drillid.discrepancy.verdicts.verdict import UNKNOWN, UNPROVED
from drillid.report.content import Drilled
from drillid.report.verdicts import Prediction, SetText, Visible, percent, verdict_text, verdict_texts
from drillid.report.well_report import WellReport
from tests.verdicts import LAG

LAG_SEEN = Visible("drive_lag", 0.012, Markup("12 ms"), Markup("30 ms"), True)
SET = SetText(1700.0, 2000.0, "", "", Prediction(0.21, 0.12, 0.1, 0.15), (LAG_SEEN,))


def row(verdict: Verdict) -> dict[Any, Any]:
    """As verdicts.csv holds it."""
    return verdict_table("W1", [verdict]).to_dict("records")[0]


@pytest.mark.parametrize("name", list(CATALOGUE))
def test_every_cause_has_what_a_driller_says_and_what_to_do(name: str) -> None:
    cause = CATALOGUE[name]
    words = verdict_text(row(replace(LAG, verdict=name, cause=name, family=cause.family, unit=cause.size.unit)))
    assert words.kind == "named"
    assert words.title.lower() == name.replace("_", " ")
    lead = words.lead.striptags()
    assert lead[0].isupper() or lead[0].isdigit()
    assert ": " in lead
    assert lead.endswith(".")
    assert words.action
    assert not re.search(r"nan|[{}]", " ".join([lead, words.size, words.gain, words.doubt]))
    # the root of a square is told
    assert cause.size.fixed or cause.size.name.removesuffix(", squared")[1:] in words.size.unescape()


@pytest.mark.parametrize("name", list(CATALOGUE))
def test_what_the_headline_says_is_not_said_again(name: str) -> None:
    first, second = (
        set(re.findall(r"[a-z]{4,}", text.lower())) for text in (CATALOGUE[name].headline, CATALOGUE[name].action)
    )
    assert len(second - first) > len(second & first)


def test_the_lead_has_the_size_in_units_that_one_feels_and_its_sign_in_words() -> None:
    assert verdict_text(row(LAG)).lead == "The drive responds 49.4 ms late: have its torque loop checked."
    weak = replace(LAG, verdict="actuator_gain", cause="actuator_gain", size=-0.2, unit="1")
    assert "delivers 20 % less torque than commanded" in verdict_text(row(weak)).lead


@pytest.mark.parametrize("size", [12.0, -12.0])
def test_an_interval_in_which_the_inertia_alone_rose_has_no_size_of_damping(size: float) -> None:
    sized = replace(LAG, family="disturbance", unit="N m s/rad", size=size, size_low=size - 30, size_high=size + 30)
    change = replace(sized, verdict="regime_change", cause="regime_change", evidence=rise("BHA inertia", 5.0))
    words = verdict_text(row(change))
    assert words.title == "rise of BHA inertia"
    assert "damping" not in words.lead
    assert "BHA inertia up by 5.0 standard deviations" in words.lead
    assert words.size == ""
    both = replace(change, size=12.0, evidence=f"{rise('BHA damping', 4.0)}; {rise('BHA inertia', 5.0)}")
    assert verdict_text(row(both)).lead.startswith("The damping at the assembly jumps up")
    assert "12 N m s/rad" in verdict_text(row(both)).size.striptags()


def test_none_that_is_likelier_wrong_does_not_say_that_all_is_well() -> None:
    none = replace(LAG, verdict="none", cause="", family="")
    sure, doubtful = (verdict_text(row(replace(none, probability=probability))) for probability in (0.8, 0.2))
    assert (sure.kind, doubtful.kind) == ("none", "unproved")
    assert doubtful.lead.startswith("Nothing is proved")
    assert "20 %" in doubtful.doubt


def test_nothing_wrong_says_how_small_a_cause_would_have_been_seen() -> None:
    words = verdict_text(row(replace(LAG, verdict="none", cause="", family="")), [SET])
    assert words.lead == "Nothing is wrong with the simulation here. A drive lag of 12 ms would have been detected."


def test_sets_one_after_another_in_which_nothing_is_wrong_are_told_once() -> None:
    clear = replace(LAG, verdict="none", cause="", family="", from_m=1700.0, to_m=2000.0, probability=0.8)
    deeper = replace(clear, from_m=2000.0, to_m=2200.0, probability=0.9)
    worse = replace(LAG_SEEN, size=0.02, smallest=Markup("20 ms"))
    sets = [SET, replace(SET, from_m=2000.0, to_m=2200.0, visible=(worse,))]
    both, lag, alone = verdict_texts([row(each) for each in (clear, deeper, LAG, clear)], sets)
    assert (both.from_m, both.to_m) == (1700.0, 2200.0)
    assert both.lead.endswith("A drive lag of 12 ms to 20 ms would have been detected.")
    assert both.doubt == "The probability that nothing is wrong is 80 to 90 % in each of 2 sets of windows."
    assert (lag.kind, alone.kind, alone.to_m) == ("named", "none", 2000.0)


def test_numbers_have_their_intervals_and_the_gain_is_in_rpm_first() -> None:
    words = verdict_text(row(LAG), [SET])
    assert words.size == "Time constant: 49.4 ms (95 % interval 48.9 ms to 49.9 ms)."
    assert words.doubt.startswith("Clear: the probability is above 99 %.")
    assert "changes the predicted speed of the top drive by 0.15 rpm." in words.gain
    assert "the error of the predicted speed falls from 0.21 to 0.12 rpm; the noise is 0.10 rpm." in words.gain
    assert "12 windows it was not fitted to: 339 (90 % interval 310 to 368) per window" in words.gain
    assert "gained on 1 window it was not fitted to" in verdict_text(row(replace(LAG, held_out_windows=1)), [SET]).gain


def test_an_error_that_noise_hides_is_not_told_as_a_gain() -> None:
    noisy = replace(SET, prediction=Prediction(0.605, 0.611, 0.61, 0.1))
    assert (
        "speed rises from 0.60 to 0.61 rpm; the noise is 0.61 rpm, which hides the cause there."
        in verdict_text(row(LAG), [noisy]).gain
    )


def test_an_error_that_rises_is_not_told_to_stay() -> None:
    worse = replace(SET, prediction=Prediction(0.20, 0.35, 0.1, 0.3))
    said = verdict_text(row(LAG), [worse]).gain
    assert "speed rises from 0.20 to 0.35 rpm; the noise is 0.10 rpm." in said
    told = replace(SET, prediction=Prediction(0.5609, 0.5502, 0.6416, 0.078))
    assert (
        "speed falls from 0.561 to 0.550 rpm; the noise is 0.642 rpm, which hides"
        in verdict_text(row(LAG), [told]).gain
    )


def test_doubt_is_stated() -> None:
    doubtful = verdict_text(row(replace(LAG, probability=0.62)))
    assert doubtful.doubt == "Doubtful: the probability is 62 %."
    assert doubtful.decisive.startswith("a sweep to higher")


@pytest.mark.parametrize(("probability", "said"), [(0.9951, "above 99 %"), (0.0049, "below 1 %"), (0.012, "1 %")])
def test_a_probability_is_not_rounded_to_zero_or_one(probability: float, said: str) -> None:
    assert percent(probability) == said


def test_the_evidence_is_apart_from_base_rates() -> None:
    words = verdict_text({**row(LAG), "evidence_nats": 12.3})
    assert "Log Bayes factor 12.3 in favour of this verdict" in words.evidence


def test_a_class_has_what_all_its_members_would_be() -> None:
    both = replace(LAG, verdict="drive_lag|clock_offset")
    words = verdict_text(row(both))
    assert words.lead.startswith("One of these, which the data cannot tell apart: the drive responds 49.4 ms late")
    assert CATALOGUE["clock_offset"].meaning in words.lead
    assert "Time constant, if it is drive lag: 49.4 ms" in words.size


def test_a_root_is_not_called_a_square() -> None:
    jitter = replace(
        LAG, verdict="delay_jitter", cause="delay_jitter", unit="s²", size=4e-4, size_low=1e-4, size_high=9e-4
    )
    assert verdict_text(row(jitter)).size == "Root mean square: 20 ms (95 % interval 10 ms to 30 ms)."


def test_a_member_of_a_class_without_a_size_has_no_direction() -> None:
    drift = replace(
        LAG, verdict="parameter_drift|regime_change", cause="parameter_drift", unit="N m s/rad", size=-150.0
    )
    lead = verdict_text(row(drift)).lead
    assert "the damping at the bit drifts" in lead
    assert CATALOGUE["regime_change"].meaning in lead
    assert "jumps up" not in lead
    fallen = replace(drift, verdict="regime_change", cause="regime_change")
    assert "jumps down" in verdict_text(row(fallen)).lead


def test_a_place_is_stated_where_the_data_determine_it() -> None:
    zone = replace(LAG, verdict="local_damping_zone", cause="local_damping_zone", unit="N m s/rad")
    nowhere = "The data do not determine its location along the string."
    assert nowhere in verdict_text(row(zone)).size
    assert nowhere not in verdict_text(row(LAG)).size
    placed = verdict_text(row(replace(zone, location_m=1988.9)))
    assert "drags on the string at 1989 m" in placed.lead.striptags()
    assert "It is located 1989 m" in placed.size.striptags()


def test_something_unknown_has_its_place_and_its_probability() -> None:
    unknown = Verdict("unknown", "bit", 0.99, 1000.0, 1100.0, what_would_separate="it acts at the bit")
    words = verdict_text(row(unknown))
    assert words.wrong
    assert words.lead == "Something is wrong that no known cause explains: it acts at the bit."
    evidence = f"linear responses, p-value 1e-05; drive_lag {UNPROVED}"
    doubtful = verdict_text(row(Verdict("unknown", "drive", 0.12, 1000.0, 1100.0, evidence=evidence)))
    assert doubtful.lead == "Something may be wrong whose cause is not proved yet: in the part called drive."
    assert "Linear responses, p-value 1e-05; drive lag would fit" in doubtful.evidence
    assert "behind it is 12 %" in doubtful.doubt


def test_of_sets_that_name_the_same_the_last_is_told() -> None:
    ends = [(2000.0, 2100.0), (2100.0, 2200.0), (2200.0, 2300.0)]
    lagging, clear = (replace(LAG, verdict=name) for name in ("drive_lag", "none"))
    named = [lagging, clear, lagging]
    verdicts = tuple(
        verdict_text({**row(each), "from_m": top, "to_m": bottom})
        for each, (top, bottom) in zip(named, ends, strict=True)
    )
    sets = tuple(replace(SET, from_m=top, to_m=bottom) for top, bottom in ends)
    nothing = pd.DataFrame()
    well = WellReport("A", "A", "", "", Drilled(2000.0, 2300.0, 9.0, 9.0, None), None, nothing, nothing, verdicts, sets)
    assert (well.told, well.alike) == ([1, 2], [0])
    assert well.titles(0) == well.titles(2) == "drive lag"


def test_sets_that_one_clear_verdict_tells_of_have_its_title() -> None:
    ends = [(2000.0, 2100.0), (2100.0, 2200.0), (2200.0, 2300.0)]
    clear = replace(LAG, verdict="none", cause="", family="")
    rows = [
        {**row(replace(clear, probability=probability)), "from_m": top, "to_m": bottom}
        for (top, bottom), probability in zip(ends, (0.9, 0.6, 0.8), strict=True)
    ]
    sets = tuple(replace(SET, from_m=top, to_m=bottom) for top, bottom in ends)
    verdicts, nothing = verdict_texts(rows, sets), pd.DataFrame()
    well = WellReport("A", "A", "", "", Drilled(2000.0, 2300.0, 9.0, 9.0, None), None, nothing, nothing, verdicts, sets)
    assert [well.titles(number) for number in range(3)] == ["nothing wrong"] * 3
    assert (well.told, well.alike) == ([2], [0, 1])
    assert [verdict.probability for verdict in verdicts] == [0.6]


def test_what_was_learnt_is_told_apart_from_the_evidence() -> None:
    words = "a p-value of 1e-9; learnt: an inertia hangs on the string by a spring"
    told = verdict_text(row(replace(LAG, verdict="unknown", cause="", family="bit", evidence=words)))
    assert told.learnt == "An inertia hangs on the string by a spring."
    assert told.evidence.startswith("A p-value of 1e-9.")
    assert not verdict_text(row(LAG)).learnt


@pytest.mark.parametrize("name", list(SYMPTOMS))
def test_a_symptom_is_what_is_wrong_and_its_measurement_what_would_decide_it(name: str) -> None:
    symptom = SYMPTOMS[name]
    words = verdict_text(
        row(
            Verdict(
                UNKNOWN,
                symptom.family,
                0.9,
                1000.0,
                1010.0,
                evidence=f"{symptom.meaning}, p-value 0.001 where nothing is wrong",
                what_would_separate=symptom.separated_by,
            )
        )
    )
    assert symptom.meaning in words.lead.unescape()
    assert symptom.separated_by not in words.lead.unescape()
    assert words.decisive == symptom.separated_by


@pytest.mark.parametrize("extended", [0.31, 0.52])
def test_a_noise_that_is_not_known_is_left_out(extended: float) -> None:
    text = Prediction(0.52, extended, float("nan"), 0.4).text
    assert "–" not in text
    assert text.endswith("rpm.")
