"""Verdicts in words: every cause has an action, and numbers and doubts are given as they are."""

import re
from dataclasses import replace
from typing import Any

import pytest

from drillid.discrepancy import CATALOGUE, Verdict
from drillid.discrepancy.sets import verdict_table
from drillid.discrepancy.verdicts.verdict import UNPROVED
from drillid.report.verdicts import verdict_text
from tests.verdicts import LAG


def row(verdict: Verdict) -> dict[Any, Any]:
    """As verdicts.csv holds it."""
    return verdict_table("W1", [verdict]).to_dict("records")[0]


@pytest.mark.parametrize("name", list(CATALOGUE))
def test_every_cause_has_a_text(name: str) -> None:
    cause = CATALOGUE[name]
    words = verdict_text(row(replace(LAG, verdict=name, cause=name, family=cause.family, unit=cause.size.unit)))
    assert words.named
    assert words.heading == f"1800–1950 m: {name.replace('_', ' ')}"
    text = " ".join(words.sentences)
    assert cause.meaning[1:] in text
    assert cause.size.name[1:] in text
    assert "nan" not in text
    assert all(sentence[0].isupper() and sentence.endswith(".") for sentence in words.sentences)


def test_none_that_is_likelier_wrong_does_not_say_that_all_is_well() -> None:
    none = replace(LAG, verdict="none", cause="", family="")
    sure, doubtful = (verdict_text(row(replace(none, probability=probability))) for probability in (0.8, 0.2))
    assert sure.heading.endswith("nothing wrong")
    assert doubtful.heading.endswith("nothing proved")
    assert "20 %" in doubtful.sentences[0]


def test_numbers_have_their_intervals() -> None:
    text = " ".join(verdict_text(row(LAG)).sentences)
    assert "Time constant: 0.0494 s (95 % interval 0.0489 to 0.0499 s)." in text
    assert "Clear: the probability is above 99 %." in text
    assert "Predictive gain on 12 windows that it was not fitted to: 339 (90 % interval 310 to 368) units" in text


def test_doubt_is_stated() -> None:
    doubtful = verdict_text(row(replace(LAG, probability=0.62)))
    assert "Doubtful: the probability is 62 %." in doubtful.sentences
    assert doubtful.doubt == "What would decide it: a sweep to higher frequency."


def test_a_class_lists_all_members() -> None:
    words = verdict_text(row(replace(LAG, verdict="speed_filter|torque_filter", cause="torque_filter")))
    assert words.heading.endswith("speed filter or torque filter")
    text = " ".join(words.sentences)
    assert all(CATALOGUE[name].meaning in text for name in ("speed_filter", "torque_filter"))
    assert "if it is torque filter" in text


def test_a_place_is_stated() -> None:
    words = verdict_text(row(replace(LAG, verdict="local_damping_zone", cause="local_damping_zone", location_m=1988.9)))
    assert "It is located 1989 m along the string." in words.sentences


def test_an_undetermined_place_is_stated() -> None:
    nowhere = "The data do not determine its location along the string."
    zone = replace(LAG, verdict="local_damping_zone", cause="local_damping_zone")
    everywhere = replace(zone, verdict="local_damping_zone|mud_drag")
    assert nowhere in verdict_text(row(zone)).sentences
    assert not any(nowhere in verdict_text(row(verdict)).sentences for verdict in (everywhere, LAG))


def test_nothing_and_something_unknown() -> None:
    nothing = verdict_text(row(Verdict("none", "", 0.93, 1000.0, 1100.0)))
    assert (nothing.named, nothing.action) == (False, "")
    assert "(probability 93 %)" in nothing.sentences[0]
    unknown = Verdict("unknown", "bit", 0.99, 1000.0, 1100.0, what_would_separate="it acts at the bit")
    words = verdict_text(row(unknown))
    assert words.named
    assert not re.search("None|nan", " ".join([*words.sentences, words.action, words.doubt]))
    assert "it acts at the bit" in words.sentences[0]


def test_an_unknown_has_what_would_fit_and_its_probability() -> None:
    evidence = f"linear responses, p-value 1e-05; drive_lag {UNPROVED}"
    words = verdict_text(row(Verdict("unknown", "drive", 0.12, 1000.0, 1100.0, evidence=evidence)))
    assert "of which no cause is proved yet: in the part called drive" in words.sentences[0]
    assert "Linear responses, p-value 1e-05; drive lag would fit" in words.sentences[1]
    assert words.sentences[1].endswith("That no known cause is behind it has a probability of 12 %.")
