"""The table of rules: derived values follow, what pins a rule is there, and the page is current."""

import ast
from pathlib import Path

import numpy as np
import pytest
from scipy.stats import norm

from benchmarks.blind.scores import SHARES
from drillid.discrepancy import rules

ROOT = Path(__file__).resolve().parents[3]


def test_derived_rules_follow_from_what_they_are_derived_from() -> None:
    assert norm.cdf(rules.DISTINCT / 2) == pytest.approx(rules.DISTINGUISHED_SHARE)
    assert 2 * norm.sf(rules.TORQUE_STEP) * 600 * 50 == pytest.approx(1e-3, rel=0.2)
    assert np.exp(-rules.LINE_KEPT) == pytest.approx(1 / 7, rel=0.06)
    assert rules.RESPONSES_SHARE + rules.DETECTIONS_SHARE < 1


def test_rules_count_as_plain_numbers() -> None:
    assert isinstance(rules.DISTINCT * 2, float)
    assert np.float64(2) * rules.CLOSURE_RATE == 0.02
    assert f"{rules.CLASS_MASS:.1f}" == "0.9"


@pytest.mark.parametrize("name", list(rules.RULES))
def test_a_rule_says_what_it_decides_and_why(name: str) -> None:
    rule = rules.RULES[name]
    assert len(rule.meaning) > 20
    assert len(rule.source) > 5
    for pin in rule.pinned_by.split("; "):
        if pin.startswith("make blind: "):
            assert set(pin.removeprefix("make blind: ").split(", ")) <= {*SHARES, "power_ratio", "calibration_error"}
        else:
            file, test = pin.split("::")
            functions = [node.name for node in ast.walk(ast.parse((ROOT / file).read_text())) if hasattr(node, "name")]
            assert test in functions, f"{name} is pinned by a test that is not there: {pin}"


def test_the_page_of_rules_is_current() -> None:
    assert (ROOT / "docs/rules.md").read_text() == rules.page(), "run `make docs`"
