"""The proof's own arithmetic: limits, sizes, registration, baselines at equal false alarms."""

import json
from collections import Counter
from dataclasses import asdict, replace
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
import typer
from scipy.special import ndtr
from scipy.stats import beta

from benchmarks.blind import __main__ as proof
from benchmarks.blind import blocks, limits
from benchmarks.blind.answer import Claim
from benchmarks.blind.at_best import at_best
from benchmarks.blind.baselines import _coordinates
from benchmarks.blind.blocks import Block, judged, markdown, register, registered
from benchmarks.blind.document import write_page
from benchmarks.blind.draw import NULLS, PAIRS, REMOVED, ZONES, in_turn, planned
from benchmarks.blind.ideal.ideal import threshold
from benchmarks.blind.limits import cases_needed, lower_limit, upper_limit
from benchmarks.blind.run import ENGINES
from benchmarks.blind.scores import TARGETS, at_equal_alarms, holds, power_ratio, scores
from benchmarks.blind.vocabulary import CAUSES
from benchmarks.blind.world import WORLDS, World
from drillid.discrepancy.catalogue import CATALOGUE
from drillid.errors import SettingsError

ROOT = Path(__file__).resolve().parents[3]


@pytest.fixture
def listed(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> Path:
    path = tmp_path / "blocks.json"
    path.write_text(json.dumps([asdict(block) for block in blocks.blocks()]))
    monkeypatch.setattr(blocks, "PATH", path)
    monkeypatch.setattr(blocks, "_git", lambda *words: "" if words[0] == "status" else "c" * 40)
    return path


@pytest.mark.parametrize(("rate", "limit"), [(0.04, 0.06), (0.975, 0.95), (0.92, 0.8)])
def test_so_many_cases_hold_a_limit_nine_times_in_ten(rate: float, limit: float) -> None:
    cases = cases_needed(rate, limit)
    counts = np.random.default_rng(0).binomial(cases, rate, 2000)
    held = [
        upper_limit(int(k), cases) <= limit if rate < limit else lower_limit(int(k), cases) >= limit for k in counts
    ]
    assert np.mean(held) > 0.87
    few = np.random.default_rng(0).binomial(cases // 2, rate, 500)
    half = cases // 2
    held = [upper_limit(int(k), half) <= limit if rate < limit else lower_limit(int(k), half) >= limit for k in few]
    assert np.mean(held) < 0.87


def test_a_block_is_registered_once_and_only_under_its_code(listed: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    block = register("other", 300_000, 500)
    assert registered("other", 300_000, 500) == block
    assert registered("own", 300_000, 500) is None
    with pytest.raises(SettingsError, match="are used"):
        register("other", 300_400, 500)
    with pytest.raises(SettingsError, match="are used"):
        register("own", 150_000, 500)
    judged(block, dict.fromkeys(TARGETS, float("nan")) | {"false_alarm_high": 0.01}, 200)
    *_, last = [each for each in blocks.blocks() if each.registered]
    assert last.failed is not None
    assert "false_alarm_high" not in last.failed
    assert "power_ratio_low" in last.failed
    assert last.note == "the first 200 of 500 registered"
    monkeypatch.setattr(blocks, "judge_hash", lambda: "another")
    assert registered("other", 300_000, 500) is None


@pytest.mark.parametrize("world", WORLDS.values(), ids=list(WORLDS))
def test_a_block_of_the_registered_size_holds_ten_large_cases_of_each_cause(world: World) -> None:
    seeds = range(230_011, 230_011 + blocks.size()[0])
    large = Counter(in_turn(seed, world) for seed in seeds if planned(seed, world) == "large")
    assert set(large) == set(world.named)
    assert min(large.values()) >= blocks.LEAST_PER_CAUSE
    kinds = Counter(planned(seed, world) for seed in seeds)
    for kind, share in {"none": NULLS, "pair": PAIRS / 2, "removed": REMOVED / 2, "zone": ZONES / 2}.items():
        assert kinds[kind] / len(seeds) == pytest.approx(share, abs=0.005)


def test_a_checkout_with_changes_registers_nothing(listed: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(blocks, "_git", lambda *words: " M benchmarks/blind/judge.py")
    with pytest.raises(SettingsError, match="uncommitted"):
        register("own", 300_000, 500)


def test_the_page_lists_all_blocks(tmp_path: Path) -> None:
    (tmp_path / "discovery").mkdir()
    for part in (ROOT / "docs" / "discovery").glob("*.txt"):
        (tmp_path / "discovery" / part.name).write_text(part.read_text())
    write_page(tmp_path)
    assert markdown() in (ROOT / "docs" / "discovery.md").read_text()
    assert (tmp_path / "discovery.md").read_text() == (ROOT / "docs" / "discovery.md").read_text()


def test_the_vocabulary_is_that_of_the_engine() -> None:
    for name, cause in CATALOGUE.items():
        known = CAUSES[name]
        assert (known.family, known.low, known.high) == (cause.family, cause.size.low, cause.size.high)


def _table(cases: int = 400) -> pd.DataFrame:
    """Judgements of an engine that detects what lies 3 deviations off and is always right."""
    generator = np.random.default_rng(0)
    hidden = np.where(np.arange(cases) % 2, "mud_drag", "none")
    off = np.where(hidden == "none", 0.0, generator.uniform(0, 12, cases))
    score = off + generator.standard_normal(cases)
    detected = score > 3.0
    claim = [(("named", "string", 0.99, True),) if hit else (("none", "", 0.9, True),) for hit in detected]
    constant = dict.fromkeys(["contains", "covered", "gain_positive", "second_none", "in_turn", "linear"], True)
    flags = dict.fromkeys(["removed", "still_there", "sure_of_wrong_family"], False)
    return pd.DataFrame(
        {
            "hidden": hidden,
            "detected": detected,
            "detectability": off,
            "candidates": 1.0,
            "claims": claim,
            "named": np.where(detected, "mud_drag", "none"),
            "right": detected,
            "score": score,
            "seconds": 1.0,
            "power": 0.9,
            "family_power": 0.9,
            "large": off > 6,
            "shows": off > 6,
            "failure": "",
            "location_error": np.nan,
            **constant,
            **flags,
        }
    )


def test_scores_have_limits_on_either_side() -> None:
    found = scores(_table())
    assert found["accuracy_at_2x_low"] < found["accuracy_at_2x"] <= found["accuracy_at_2x_high"]
    assert found["false_alarm_low"] <= found["false_alarm"] < found["false_alarm_high"] == found["false_alarm_upper"]
    assert found["power_ratio_low"] < found["power_ratio"] < found["power_ratio_high"]
    assert found["power_ratio"] == pytest.approx(1.0, abs=0.1)
    assert found["causes_right"] == 1
    assert holds("causes_right", found["causes_right"]) is False
    assert holds("unknown_share_low", found["unknown_share_low"]) is False
    assert set(TARGETS) <= set(found)


def test_a_faultless_engine_reaches_what_is_possible_at_best_and_another_does_not(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(limits, "_DRAWS", 50)
    # right more often than it states, but right whenever the cause is large
    table = _table()
    best, reached = at_best(table), scores(table)
    large = int(table["large"].sum())
    assert best["accuracy_at_2x_low"] == reached["accuracy_at_2x_low"] == lower_limit(large, large)
    assert best["coverage95_low"] < best["coverage95_high"] < 1.0
    assert reached["calibration_error_high"] > 1.5 * best["calibration_error_high"]
    generator = np.random.default_rng(1)
    honest = [tuple((*each[:3], generator.random() < each[2]) for each in row) for row in table["claims"]]
    calibrated = scores(table.assign(claims=honest))
    assert calibrated["calibration_error_high"] == pytest.approx(best["calibration_error_high"], rel=0.4)
    wrong = scores(table.assign(right=False))
    assert wrong["accuracy_at_2x_low"] == 0.0


def test_times_of_examinations_are_kept_for_either_world(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(proof, "RESULT", tmp_path / "blind.json")
    # the limits of other scores by resampling take all the time
    monkeypatch.setattr(limits, "_DRAWS", 2)
    table = _table()
    for world, factor in (("own", 1.0), ("other", 2.0)):
        seconds = factor * np.where(table["hidden"] == "none", 0.5, 3.0)
        proof._keep(world, scores(table.assign(seconds=seconds)), {})
    kept = json.loads((tmp_path / "blind.json").read_text())
    assert [kept[f"{prefix}examine_s_median_wrong"] for prefix in ("", "other_")] == [3.0, 6.0]
    assert [kept[f"{prefix}examine_s_median_null"] for prefix in ("", "other_")] == [0.5, 1.0]


def test_a_run_in_which_no_case_was_judged_says_so(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(proof, "run", lambda *_: {name: pd.DataFrame() for name in ENGINES})
    with pytest.raises(typer.Exit) as ended:
        proof.main("own", 60_000, 40, 0.0)
    assert ended.value.exit_code == 1
    assert "the next run goes on" in capsys.readouterr().out


def test_engines_are_compared_at_equal_false_alarms() -> None:
    """Whatever threshold an engine came with, the comparison sets its own."""
    table = _table()
    strict, bold = (at_equal_alarms(table.assign(detected=table["score"] > least), 0.05) for least in (9.0, -9.0))
    assert strict == bold
    assert strict["false_alarm"] <= 0.05
    guessing = table.assign(score=np.random.default_rng(1).random(len(table)))
    assert at_equal_alarms(guessing, 0.05)["power_ratio"] < 0.15 < strict["power_ratio"]


@pytest.mark.parametrize(("alarms", "rate"), [(0, 0.5 / 201), (3, 3.5 / 201)])
def test_few_false_alarms_are_compared_with_the_ideal_test_at_the_rate_that_they_tell(alarms: int, rate: float) -> None:
    table = _table().assign(detectability=6.0, candidates=8.0)
    is_null = table["hidden"] == "none"
    table["detected"] = ~is_null | (is_null & (is_null.cumsum() <= alarms))
    assert power_ratio(table) == pytest.approx(1 / float(ndtr(6.0 - threshold(8.0, rate))))
    found, rates = scores(table), np.maximum(beta.ppf([0.95, 0.05], alarms + 0.5, 200.5 - alarms), 1e-4)
    drawn = [1 / float(ndtr(6.0 - threshold(8.0, r))) for r in rates]
    assert (found["power_ratio_low"], found["power_ratio_high"]) == pytest.approx(drawn, rel=0.02)


def test_a_lasso_keeps_what_is_there() -> None:
    """Coordinate descent meets the conditions of the optimum: the rest is within the penalty, and at it where kept."""
    generator = np.random.default_rng(0)
    design = generator.standard_normal((50, 6))
    design /= np.linalg.norm(design, axis=0)
    unit, gain = design.T @ design, design.T @ (design @ np.array([5.0, 0, 0, -3.0, 0, 0]))
    size = _coordinates(unit, gain, 0.5, np.zeros(6))
    rest = gain - unit @ size
    assert np.abs(rest).max() < 0.5 + 1e-4
    np.testing.assert_allclose(rest[size != 0], 0.5 * np.sign(size[size != 0]), atol=1e-4)
    assert {0, 3} <= set(np.flatnonzero(size))


def test_a_claim_knows_family_and_kind() -> None:
    both = Claim("speed_filter|torque_filter", 0.9, cause="torque_filter")
    assert (both.family, both.kind, both.members) == ("control", "named", ("speed_filter", "torque_filter"))
    assert (Claim("unknown", 0.5).family, Claim("unknown", 0.5).kind) == ("", "unknown")
    assert isinstance(replace(blocks.blocks()[0], note="x"), Block)
