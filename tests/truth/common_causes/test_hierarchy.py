"""Wells whose scores are drawn from the model of the hierarchy itself: its rates, intervals and comparisons hold."""

from dataclasses import replace

import numpy as np
import pytest

from drillid.arrays import Floats
from drillid.common_causes.pooling import DEVIATION, SetStatistics, Wells, together
from drillid.common_causes.verdicts import ABSENT, AT_BOUND, LONE, SHARES, UNSEEN, WITHDRAWN, Judged, OwnVerdict, judge
from drillid.discrepancy.base_rates import BaseRates
from drillid.discrepancy.inference.shared_likelihood import RIG, held_sizes
from drillid.discrepancy.verdicts.verdict import NONE
from tests.truth.common_causes.wells import CANDIDATES, LAG, SCALE, TOLERANCE, fleet, rows_of


def judged(sets: list[SetStatistics], own: dict[str, list[OwnVerdict]] | None = None) -> Judged:
    """The verdict on the wells of a rig."""
    return judge("rig", "R", sets, own or {}, 0.05, BaseRates())


def test_fleets_without_a_cause_get_one_no_more_often_than_stated() -> None:
    alarms = sum(judged(fleet(seed, 2 + seed % 4)).verdict.cause != "" for seed in range(40))
    # P(more than 5 of 40) is 1.4 % at the stated 5 %
    assert alarms <= 5


def test_intervals_hold_the_common_size() -> None:
    true, held, named = 0.012, 0, 0
    for seed in range(1000, 1024):
        verdict = judged(fleet(seed, 6, {LAG: np.full(6, true)}, error=0.006)).verdict
        if verdict.cause == "drive_lag":
            named, held = named + 1, held + (verdict.size_low <= true <= verdict.size_high)
    assert named >= 18
    assert held >= 0.85 * named


@pytest.mark.parametrize("wells", [6, 12])
def test_intervals_hold_the_common_size_where_the_wells_have_sizes_about_it(wells: int) -> None:
    true, held, named = 0.012, 0, 0
    for seed in range(40):
        sizes = true * np.abs(1 + 0.3 * np.random.default_rng(90000 + seed).standard_normal(wells))
        verdict = judged(fleet(seed, wells, {LAG: sizes}, error=0.002)).verdict
        if verdict.cause == "drive_lag":
            named, held = named + 1, held + (verdict.size_low <= true <= verdict.size_high)
    assert named >= 30
    # fewer than 85 % of 40 are held with a probability of 0.3 % where 95 % are expected
    assert held >= 0.85 * named


def test_the_error_falls_with_the_root_of_the_number_of_wells() -> None:
    widths = []
    for wells in (4, 36):
        verdict = judged(fleet(7, wells, {LAG: np.full(wells, 0.012)}, error=0.002)).verdict
        assert verdict.cause == "drive_lag"
        widths.append(verdict.size_high - verdict.size_low)
    assert widths[0] / widths[1] == pytest.approx(3.0, rel=0.3)


def test_an_error_of_the_data_sheet_is_the_same_in_all_wells() -> None:
    """Counted once a well, an error of one tolerance would become a cause as wells are added."""
    alarms = sum(judged(fleet(seed, 30, error=0.002)).verdict.cause != "" for seed in range(2000, 2004))
    assert alarms <= 1


def test_deviations_of_wells_are_integrated_out_as_exactly_where_the_information_falls_with_the_size() -> None:
    wells, tolerance = 6, np.diag(np.full(RIG.size, TOLERANCE**2.0))
    sets = []
    for each in fleet(4, wells, error=0.004):
        falling = (1 - 0.3 * each.sizes / each.sizes.max(axis=1, keepdims=True)) ** 2
        sets.append(replace(each, information=each.information * falling[None, ..., None, None]))
    pooled = Wells(sets)
    found = together(pooled, pooled.at(LAG, np.array([0.0, sets[0].sizes[LAG].max()])))
    exact = []
    for node in (0, -1):
        # each well's likelihood is a Gaussian of its own coordinates; these are those of the rig plus a deviation
        total, matrix, vector = 0.0, np.linalg.inv(tolerance), np.zeros(RIG.size)
        for each in sets:
            information, place = each.information[0, LAG, node], each.coordinates[LAG, node]
            score, value = each.score[0, LAG, node], each.value[0, LAG, node]
            covariance = np.linalg.inv(information) + DEVIATION**2 * tolerance
            mean, peak = place + np.linalg.solve(information, score), 0.5 * score @ np.linalg.solve(information, score)
            total += value + peak - 0.5 * np.linalg.slogdet(information)[1] - 0.5 * np.linalg.slogdet(covariance)[1]
            total -= 0.5 * mean @ np.linalg.solve(covariance, mean)
            matrix = matrix + np.linalg.inv(covariance)
            vector = vector + np.linalg.solve(covariance, mean)
        exact.append(total + 0.5 * vector @ np.linalg.solve(matrix, vector) - 0.5 * np.linalg.slogdet(matrix)[1])
    assert found[1] - found[0] == pytest.approx(exact[1] - exact[0], abs=1e-6)


def test_sizes_that_differ_between_wells_are_told_from_a_common_one() -> None:
    generator = np.random.default_rng(3)
    alike = judged(fleet(11, 20, {LAG: np.full(20, 0.012)}, error=0.002)).verdict
    apart = judged(fleet(11, 20, {LAG: np.abs(0.012 + 0.005 * generator.standard_normal(20))}, error=0.002)).verdict
    assert alike.cause == apart.cause == "drive_lag"
    assert alike.heterogeneity_p_value > 0.01 > apart.heterogeneity_p_value
    assert alike.spread_nats < 0 < apart.spread_nats


def test_one_bad_sensor_is_not_given_to_the_rig() -> None:
    sizes, alarms = np.zeros(8), 0
    sizes[5] = 0.02
    own = {"W5": [OwnVerdict(("speed_scale",), "speed_scale", 0.02)]}
    for seed in (21, 22, 23):
        result = judged(fleet(seed, 8, {SCALE: sizes}, error=0.001), own)
        assert ("W5", "speed_scale", LONE) in [(each.well, each.cause, each.standing) for each in result.standings]
        alarms += result.verdict.cause != ""
    # the others have no cause, and get one in 5 % of fleets
    assert alarms <= 1


@pytest.mark.parametrize("seed", [21, 22, 23])
def test_of_two_wells_the_bad_one_is_told(seed: int) -> None:
    result = judged(fleet(seed, 2, {SCALE: np.array([0.0, 0.02])}, error=0.001))
    assert (result.verdict.verdict, result.verdict.cause) == (NONE, "")
    assert result.verdict.probability > 0.5
    assert [(each.well, each.cause, each.standing) for each in result.standings] == [("W1", "speed_scale", LONE)]


def test_wells_without_what_half_of_them_have_do_not_share_it() -> None:
    result = judged(fleet(21, 4, {SCALE: np.array([0.0, 0.02, 0.0, 0.02])}, error=0.001))
    standings = {each.well: each.standing for each in result.standings}
    assert (standings["W0"], standings["W2"]) == (ABSENT, ABSENT)
    assert ABSENT not in (standings["W1"], standings["W3"])
    assert (result.verdict.wells, result.verdict.sharing) == (4, 2)


def test_wells_that_all_have_a_name_are_not_told_to_deny_it(monkeypatch: pytest.MonkeyPatch) -> None:
    """A cause that looks almost like an error of the rig's data sheet is hardly seen in few wells."""

    def alike(generator: np.random.Generator, error: float) -> tuple[Floats, Floats, Floats]:
        rig, straight, bent = rows_of(generator, error)
        straight[:, LAG], bent[:, LAG] = rig[:, 2] + 0.02 * straight[:, LAG], 0.02 * bent[:, LAG]
        return rig, straight, bent

    monkeypatch.setattr("tests.truth.common_causes.wells.rows_of", alike)
    own, standings = {"W1": [OwnVerdict(("drive_lag",), "drive_lag", 0.02)]}, []
    for seed in range(20):
        result = judged(fleet(seed, 4, {LAG: np.full(4, 0.02)}, error=0.004), own)
        standings += [each.standing for each in result.standings if each.well == "W1"]
    assert len(standings) == 20
    # three standard errors off by chance: one in 370
    assert standings.count(WITHDRAWN) <= 1


def test_a_name_that_the_sisters_contradict_is_withdrawn() -> None:
    own, standings = {"W3": [OwnVerdict(("drive_lag",), "drive_lag", 0.04)]}, []
    for seed in range(31, 37):
        result = judged(fleet(seed, 10, error=0.005), own)
        assert result.verdict.cause == ""
        standings += [(each.well, each.standing) for each in result.standings]
    # the noise of one well alone favours a lag in half of all wells
    assert standings.count(("W3", WITHDRAWN)) > 3
    assert set(standings) <= {("W3", WITHDRAWN), ("W3", LONE)}


def test_sisters_that_cannot_see_a_cause_contradict_nothing() -> None:
    result = judged(fleet(31, 3, error=0.2), {"W1": [OwnVerdict(("drive_lag",), "drive_lag", 0.04)]})
    assert [(each.well, each.standing) for each in result.standings] == [("W1", UNSEEN)]


def test_a_size_that_is_not_known_is_compared_with_nothing() -> None:
    own = {"W1": [OwnVerdict(("drive_lag",), "drive_lag", float("nan"))]}
    (found,) = judged(fleet(31, 3, error=0.2), own).standings
    assert found.standing == UNSEEN
    assert "nan" not in found.reason


def test_wells_share_what_is_named_for_their_rig() -> None:
    result = judged(fleet(41, 5, {LAG: np.full(5, 0.012)}, error=0.003))
    assert result.verdict.cause == "drive_lag"
    assert [each.standing for each in result.standings] == [SHARES] * 5


def test_a_size_beyond_what_is_held_is_not_named() -> None:
    result = judged(fleet(41, 5, {LAG: np.full(5, 3 * held_sizes(CANDIDATES[LAG].cause.size)[-1])}, error=0.003))
    assert result.verdict.p_value < 0.05
    assert (result.verdict.verdict, result.verdict.cause) == (NONE, "")
    assert [(each.well, each.cause, each.standing) for each in result.standings] == [("", "drive_lag", AT_BOUND)]
