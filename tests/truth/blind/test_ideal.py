"""The ideal test of the sealed proof: its theory is what the simulator does, and it knows exact equivalences."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy.stats import binom

from benchmarks.blind.draw import draw, sized
from benchmarks.blind.engines import evidence_of
from benchmarks.blind.generator import cases
from benchmarks.blind.generator.cases import EFFECTS, Case, plain_case
from benchmarks.blind.hidden import Hidden
from benchmarks.blind.ideal.alike import imitated, same, stands_in
from benchmarks.blind.ideal.ideal import Ideal
from benchmarks.blind.ideal.of_case import ideal_of
from benchmarks.blind.ideal.own import OwnResponses
from benchmarks.blind.ideal.theory import Theory
from benchmarks.blind.judge import ideals
from benchmarks.blind.limits import lower_limit, upper_limit
from benchmarks.blind.vocabulary import DISTINCT, wrong_factor
from drillid.discrepancy import CATALOGUE
from drillid.physics.responses import command_mobility, laplace


@pytest.fixture(scope="module")
def case() -> Case:
    return replace(plain_case(7, 2)[0], command_logged=True)


@pytest.fixture(scope="module")
def ideal(case: Case) -> Ideal:
    return ideal_of(case)


def test_every_cause_of_the_catalogue_is_hidden() -> None:
    assert set(EFFECTS) == set(CATALOGUE)


@pytest.mark.parametrize("name", ["hysteretic_damping", "local_damping_zone", "recorder_filter"])
def test_response_and_noise_are_those_of_the_simulator(
    case: Case, name: str, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.setattr(cases, "FOLDER", tmp_path)
    low, high = EFFECTS[name].range(case.world(0), case.context(Hidden(name, 0.0, 0.5)))
    loaded = replace(case, hidden=(Hidden(name, float(np.sqrt(low * high)), 0.5),), segments=case.segments[:1])
    evidence = evidence_of(loaded)
    world, used, s = loaded.world(0), evidence.used[0], laplace(evidence.frequency)
    expected = command_mobility(world.linear(0.5), s) * world.recording(0.5, 600.0).transfer(s)
    square = np.abs(evidence.mobility[0] - expected)[used] ** 2 / evidence.variance[0, used]
    assert 0.85 < square.mean() < 1.25
    theory = Theory(loaded, OwnResponses(loaded))
    frequency = np.abs(theory.s) / (2 * np.pi)
    variance = 4 / theory.weights[0][0] ** 2
    ratio = np.interp(frequency, evidence.frequency, evidence.variance[0]) / variance
    assert 0.85 < np.median(ratio) < 1.15


def test_a_twin_is_the_same_and_a_stranger_is_not(case: Case, ideal: Ideal) -> None:
    generator = np.random.default_rng(0)
    drifting = sized(case, "parameter_drift", generator, (4.0, 4.0))
    assert same(ideal, drifting) == {"parameter_drift", "regime_change"}
    filtered = sized(case, "torque_filter", generator, (25.0, 25.0))
    assert same(ideal, filtered) == {"torque_filter", "speed_filter"}
    assert same(ideal, sized(case, "drive_lag", generator, (25.0, 25.0))) == {"drive_lag"}


def test_a_section_above_the_collars_is_a_string_of_two_sizes(case: Case, ideal: Ideal) -> None:
    """Where the change lies is no shape that is tried, and the size is larger than any that is hidden."""
    heaviest = Hidden("extra_section", 0.3 * case.segments[0].pipe_length, 0.9)
    assert "tapered_string" in same(ideal, heaviest)
    assert "extra_section" not in same(ideal, Hidden("tapered_string", 1.0, 0.1))


def test_what_two_causes_do_together_is_imitated(ideal: Ideal, case: Case) -> None:
    generator = np.random.default_rng(0)
    # a record times g is the control's gains over g with the torque times g
    assert imitated(ideal, sized(case, "speed_scale", generator, (25.0, 25.0)))
    assert not imitated(ideal, sized(case, "clock_offset", generator, (25.0, 25.0)))


def test_what_is_hidden_beside_a_cause_may_take_any_size(ideal: Ideal, case: Case) -> None:
    generator = np.random.default_rng(0)
    gain, control = (sized(case, name, generator, (10.0, 10.0)) for name in ("actuator_gain", "controller_gain"))
    assert "speed_scale" not in same(ideal, gain)
    assert "speed_scale" in same(ideal, gain, (control,))


def test_of_two_causes_each_is_weighed_beside_the_other(ideal: Ideal, case: Case) -> None:
    generator = np.random.default_rng(0)
    filtered = sized(case, "torque_filter", generator, (6.0, 6.0))
    twin, stranger = replace(filtered, name="speed_filter"), sized(case, "actuator_gain", generator, (6.0, 6.0))
    assert ideal.noncentrality((filtered,), (twin,)) < 0.1 * ideal.noncentrality((filtered,))
    assert ideal.noncentrality((filtered,), (stranger,)) > 20.0
    both, alone = (ideals(replace(case, hidden=hidden), thorough=False) for hidden in ((filtered, twin), (filtered,)))
    assert both.half_power < alone.half_power / 2


def test_a_rival_that_linear_reckoning_overlooks_is_found_where_it_is_named() -> None:
    hidden = Hidden("distributed_bha", 200.0, 0.15)
    heavier = replace(draw(70200), hidden=(hidden,))
    ideal = ideal_of(heavier)
    assert "wave_speed" not in same(ideal, hidden)
    assert stands_in(ideal, hidden, "wave_speed", DISTINCT)
    assert not stands_in(ideal, hidden, "mud_drag", DISTINCT)


@pytest.mark.parametrize("removed", [False, True])
def test_a_rival_is_told_alike_whatever_else_is_named(case: Case, *, removed: bool) -> None:
    filtered = Hidden("torque_filter", 0.004, 0.5)
    hidden = replace(case, hidden=(filtered,), removed=removed)
    of_all, named = ideals(hidden), {"speed_filter", "mud_drag"}
    of_named = ideals(hidden, named)
    assert "speed_filter" in of_named.same[0]
    assert {*of_named.same[0]} & named == {*of_all.same[0]} & named
    assert replace(of_named, same=of_all.same) == of_all


def test_noise_is_recorded_as_the_speed_is(case: Case) -> None:
    wrong = Hidden("sign_or_unit", 1.0, 0.6)
    s = laplace(np.array([0.5, 2.0]))
    plain, scaled = (OwnResponses(case).noise_density(0, hidden, s) for hidden in ((), (wrong,)))
    np.testing.assert_allclose(scaled, wrong_factor(wrong.shape) ** 2 * plain)


def test_a_scale_near_that_of_a_unit_is_the_same_as_that_unit(ideal: Ideal) -> None:
    assert "sign_or_unit" in same(ideal, Hidden("speed_scale", 0.35, 0.5))
    assert "sign_or_unit" not in same(ideal, Hidden("speed_scale", 0.1, 0.5))


def test_a_rival_may_be_smaller_than_what_is_hidden(case: Case, ideal: Ideal) -> None:
    least = EFFECTS["regime_change"].range(case.world(0, hidden=()), case.context(Hidden("regime_change", 0.0, 0.5)))[0]
    assert "regime_change" in same(ideal, Hidden("parameter_drift", least, 0.5))


def test_the_drawn_size_has_the_wanted_detectability(case: Case, ideal: Ideal) -> None:
    hidden = sized(case, "drive_lag", np.random.default_rng(0), (10.0, 10.0))
    assert np.sqrt(ideal.noncentrality((hidden,))) == pytest.approx(10.0, rel=0.06)


@pytest.mark.parametrize("deviations", [0.5, 8.0])
def test_nuisances_take_up_what_they_can(case: Case, ideal: Ideal, deviations: float) -> None:
    """All but what the data sheets say of the length, also where the phase turns by more than a right angle."""
    slower = Hidden("wave_speed", deviations * case.equipment.length_relative, 0.5)
    assert ideal.noncentrality((slower,)) == pytest.approx(deviations**2, rel=0.2)


def test_a_tone_of_unknown_frequency_is_harder_to_see_than_a_line() -> None:
    """Of a line, the power over the noise is exponential where there is no tone."""
    ideal, hidden = ideal_of(plain_case(7, 1)[0]), (Hidden("aliased_tone", 1e-3, 0.5),)
    assert ideal.tones(hidden) == pytest.approx(4560.0)
    assert ideal.tones((Hidden("drive_lag", 0.01, 0.5),)) == 0.0
    p_value = 1 - 0.95 ** (1 / ideal.candidates)
    assert ideal.power(0.0, family=True, tones=1.0) == pytest.approx(p_value)
    assert ideal.power(0.0, family=True, tones=4560.0) == pytest.approx(p_value / 4560)
    assert ideal.power(25.0, family=True, tones=4560.0) < ideal.power(25.0, family=True, tones=1.0)


def test_a_test_that_does_not_know_the_cause_needs_more_of_it(ideal: Ideal) -> None:
    """A χ² of 24 degrees of freedom at seven ports holds its error rate, and its power is behind that of any one."""
    assert ideal.power_unaware(0.0) == pytest.approx(1 - 0.95 ** (1 / 7))
    for power in (0.5, 0.95):
        squared = ideal.distance_unaware(power) ** 2
        assert ideal.power_unaware(squared) == pytest.approx(power)
        assert ideal.power(squared, family=True) > power + 0.04
    hidden = (sized(ideal.case, "controller_gain", np.random.default_rng(0), (7.5, 7.5)),)
    known, gone = (
        ideals(replace(ideal.case, hidden=hidden, removed=removed), thorough=False) for removed in (False, True)
    )
    assert gone.half_power < 0.5 < known.half_power


def test_power_is_half_at_the_threshold(ideal: Ideal) -> None:
    for family in (False, True):
        threshold = ideal.threshold(family=family)
        assert ideal.power(threshold**2, family=family) == pytest.approx(0.5)
    assert ideal.threshold(family=False) == pytest.approx(1.645, abs=1e-3)
    assert 10 < ideal.candidates < 45


def test_the_same_seed_gives_the_same_case_and_half_of_them_hide_nothing() -> None:
    assert str(draw(38)) == str(draw(38))
    drawn = [draw(seed) for seed in range(40)]
    assert 10 < sum(not case.hidden for case in drawn) < 30
    assert {len(case.hidden) for case in drawn} <= {0, 1, 2}


def test_the_limit_of_a_share_is_clopper_and_pearsons() -> None:
    assert upper_limit(0, 300) == pytest.approx(1 - 0.05 ** (1 / 300))
    assert binom.cdf(15, 300, upper_limit(15, 300)) == pytest.approx(0.05)
    assert upper_limit(3, 3) == 1.0
    assert binom.sf(284, 300, lower_limit(285, 300)) == pytest.approx(0.05)
    assert lower_limit(0, 3) == 0.0
