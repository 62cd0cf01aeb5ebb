"""The discovery engine on sealed cases: obvious causes, hidden in simulated logs, and rigs in which nothing is wrong.

The full proof is `make blind`. Seeds are fixed here; the engine sees logs and data sheets alone.
"""

from collections import Counter
from collections.abc import Iterator
from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from scipy.special import logit

from benchmarks.blind import engines
from benchmarks.blind.calibrate import uncalibrated
from benchmarks.blind.draw import obvious
from benchmarks.blind.engines import Answer, Claim, discovery, evidence_of
from benchmarks.blind.generator import cases
from benchmarks.blind.generator.cases import Case, plain_case
from benchmarks.blind.generator.effects_string import upper_share
from benchmarks.blind.hidden import Hidden
from benchmarks.blind.ideal.trace import trace
from benchmarks.blind.judge import Ideals, ideals, judge
from benchmarks.blind.other_world.cases import plain_case as other_plain_case
from benchmarks.blind.vocabulary import ERROR_RATE
from drillid.discrepancy import CATALOGUE
from drillid.discrepancy.inference import screen
from drillid.discrepancy.inference.coordinates import MEASURED
from drillid.discrepancy.inference.set_fit import fit_set
from drillid.discrepancy.inference.set_model import SetModel
from drillid.discrepancy.verdicts.engine import examine
from drillid.discrepancy.verdicts.examination import Examination
from drillid.discrepancy.verdicts.verdict import CALIBRATION, Verdict

HIDDEN = {
    "drive_lag": 1,
    "actuator_gain": 1,
    "controller_gain": 1,
    "torque_filter": 1,
    "clock_offset": 1,
    "quantisation": 1,
    "once_per_revolution": 1,
    "tapered_string": 1,
    "parameter_drift": 1,
}
"""Causes and the windows that are logged of each."""
NULLS = {2100: 1, 2101: 1, 2102: 2}
"""Seeds and windows."""
_DETECTABILITY = 25.0
_SEEDS = {name: 2000 + list(cases.EFFECTS).index(name) for name in HIDDEN}


@pytest.fixture(scope="module", autouse=True)
def _own_folder(tmp_path_factory: pytest.TempPathFactory) -> Iterator[None]:
    with pytest.MonkeyPatch.context() as patch:
        folder = Path(tmp_path_factory.mktemp("sealed"))
        patch.setattr(cases, "FOLDER", folder)
        patch.setattr(engines, "FOLDER", folder)
        yield


@cache
def hidden_case(name: str) -> Case:
    return obvious(_SEEDS[name], name, HIDDEN[name], _DETECTABILITY)


@cache
def known(name: str) -> Ideals:
    return ideals(hidden_case(name), thorough=False)


def asked(case: Case) -> Answer:
    return discovery(case)


def always(name: str) -> Answer:
    return Answer((Claim(name, 1.0, cause=name),))


@pytest.mark.parametrize("name", HIDDEN)
def test_an_obvious_cause_is_named_as_itself_or_its_exact_class(name: str) -> None:
    case = hidden_case(name)
    answer = asked(case)
    found = judge(case, answer, known(name))
    assert found.right, [(one.verdict, one.probability, one.evidence) for one in answer.verdicts]
    assert found.family_right


def test_a_drift_whose_mean_is_more_damping_than_usual_is_no_zone() -> None:
    plain = plain_case(70462)[0]
    assert [
        one.verdict for one in asked(replace(plain, hidden=(Hidden("parameter_drift", 1500.0, 0.3),))).verdicts
    ] == ["parameter_drift"]


def test_a_bit_that_stands_is_named_though_a_weakening_friction_of_the_wall_shows_more() -> None:
    answer = asked(obvious(61018, "stuck_slip_regimes", 1, _DETECTABILITY))
    assert [one.verdict for one in answer.verdicts] == ["stuck_slip_regimes"]


def test_a_filter_whose_first_order_a_delay_hides_is_seen(monkeypatch: pytest.MonkeyPatch) -> None:
    model = SetModel(evidence_of(obvious(_SEEDS["torque_filter"], "torque_filter", 1, 4.0)))
    base = fit_set(model, model.start())

    def evidence() -> float:
        screened = screen.screen(model, base, (), list(CATALOGUE.values()), np.random.default_rng(0))
        return screened.by_cause["torque_filter"]

    seen = evidence()
    monkeypatch.setattr(screen, "_SHARES", (1.0,))
    by_first_order = evidence()
    assert by_first_order < 0 < seen
    assert seen - by_first_order > 2


@pytest.mark.parametrize("seed", NULLS)
def test_nothing_is_found_where_nothing_is_wrong(seed: int) -> None:
    case, _ = plain_case(seed, NULLS[seed])
    answer = asked(case)
    assert not judge(case, answer, ideals(case)).detected, answer.verdicts


def test_an_engine_that_always_answers_the_same_fails_nearly_all() -> None:
    right: Counter[str] = Counter()
    for name in ["none", "unknown", *HIDDEN]:
        right[name] = sum(judge(hidden_case(one), always(name), known(one)).right for one in HIDDEN)
    assert right["none"] == right["unknown"] == 0
    assert all(right[name] == 1 for name in HIDDEN)


def test_what_the_catalogue_lacks_has_no_name_of_another() -> None:
    rpm = Hidden("sign_or_unit", 1.0, 0.7)
    case = replace(plain_case(2050, 1)[0], hidden=(rpm,))
    without = [cause for name, cause in CATALOGUE.items() if name != "sign_or_unit"]
    found = examine(evidence_of(case), catalogue=without, error_rate=ERROR_RATE, seed=case.seed)
    assert [one.verdict for one in found.verdicts] == ["unknown"]


def test_what_a_cause_explains_beside_a_wrong_one_is_no_evidence_for_it() -> None:
    joint = Hidden("shock_sub", 6e-5, 0.573)
    case = replace(other_plain_case(430049)[0], hidden=(joint,), removed=True)
    assert [one.verdict for one in discovery(case).verdicts] == ["unknown"]


@pytest.mark.parametrize("interval", [0.0742, 0.1483])
def test_what_looks_like_jitter_counts_for_a_held_record_alike(interval: float) -> None:
    held = Hidden("sample_and_hold", interval, 0.05)
    case = replace(other_plain_case(430202)[0], hidden=(held,))
    (verdict,) = discovery(case).verdicts
    assert verdict.verdict == "sample_and_hold"
    assert verdict.size_low <= interval <= verdict.size_high


def examined_with(hidden: Hidden, seed: int, windows: int | None = None) -> Examination:
    """The examination of a cause that is hidden in a rig of the second world."""
    return examine(evidence_of(replace(other_plain_case(seed, windows)[0], hidden=(hidden,))), error_rate=ERROR_RATE)


@pytest.mark.parametrize(
    ("seed", "windows", "slow"),
    [
        # at the interval that the base model takes, a lag and jitter are likelier
        (700167, None, Hidden("speed_filter", 0.01593262085712319, 0.23241964066298604)),
        # and so are filters of speed and torque
        (700438, 1, Hidden("recorder_filter", 0.01717807124638789, 0.011889648557428023)),
        # it is likeliest at a third interval, to which the one beside a filter of the speed leads
        (730132, None, Hidden("torque_filter", 0.015288140370755756, 0.6654348753155909)),
        # half a dozen others are likelier, one of them by far
        (730138, None, Hidden("recorder_filter", 0.01630486527020742, 0.39231336338401757)),
    ],
)
def test_a_cause_that_is_likeliest_at_another_interval_of_the_control_is_found_there(
    seed: int, windows: int | None, slow: Hidden
) -> None:
    (verdict,) = examined_with(slow, seed, windows).verdicts
    assert verdict.cause == slow.name
    assert verdict.size_low <= slow.size <= verdict.size_high


def alone(found: Examination, hidden: Hidden) -> Verdict:
    """The only verdict, which names a hidden cause with an interval that holds its size."""
    (verdict,) = found.verdicts
    assert verdict.verdict == hidden.name
    assert verdict.size_low <= hidden.size <= verdict.size_high
    return verdict


def test_a_torque_that_falls_by_another_law_than_its_detector_knows_has_the_size_of_the_responses() -> None:
    falling = Hidden("stribeck_cutting", 22.900618946447118, 0.3969899026300311)
    found = examined_with(falling, 700387)
    verdict = alone(found, falling)
    (own,) = (detection for detection in found.detections if detection.cause == falling.name)
    # far too small, and so narrow an interval that it would be preferred
    assert own.size + 4 * own.size_error < falling.size
    assert 4 * own.size_error < verdict.size_high - verdict.size_low


def test_a_drift_that_changes_the_responses_most_at_its_beginning_leaves_no_misfit() -> None:
    # from about half the pipe's characteristic admittance to fifteen times as much
    drift = Hidden("parameter_drift", 1496.0, 0.41)
    alone(examined_with(drift, 853312), drift)


def test_a_faint_misfit_that_no_cause_explains_does_not_hide_what_is_detected() -> None:
    growth = Hidden("length_growth", 110.88564733345608, 0.9484739170504057)
    found = examined_with(growth, 740088)
    assert found.before.p_value < 0.01
    alone(found, growth)


def test_a_section_of_which_the_base_model_has_taken_a_part_is_found_from_the_data_sheet() -> None:
    # the bound of a distributed inertia of the assembly is nearer than any section that is reached from the base model
    section = Hidden("extra_section", 600.0, 0.8338490204585325)
    alone(examined_with(section, 740142), section)


def test_the_lower_gain_that_a_limit_makes_is_no_second_cause() -> None:
    limit = Hidden("torque_limit", 3349.6, 0.2217)
    found = examined_with(limit, 700032)
    assert found.p_value < 1e-20
    alone(found, limit)


def test_what_images_of_a_held_record_resemble_is_no_second_cause() -> None:
    held = Hidden("sample_and_hold", 0.0757742658584387, 0.7654680568085672)
    found = examined_with(held, 590054)
    assert alone(found, held).size == pytest.approx(held.size, rel=3e-4)
    (limit,) = (detection for detection in found.detections if detection.cause == "torque_rate_limit")
    assert limit.p_value < 1e-3


def test_a_held_record_whose_responses_show_no_misfit_is_no_jitter() -> None:
    held = Hidden("sample_and_hold", 0.01, 0.22)
    case = replace(other_plain_case(580121)[0], hidden=(held,))
    found = examine(evidence_of(case), error_rate=ERROR_RATE, seed=case.seed)
    assert found.p_value > ERROR_RATE
    alone(found, held)


def test_a_held_record_whose_images_lie_above_the_band_is_not_denied_for_lack_of_jitter() -> None:
    held = Hidden("sample_and_hold", 0.055, 0.64)
    found = examined_with(held, 580088)
    alone(found, held)
    (jitter,) = (detection for detection in found.detections if detection.cause == "delay_jitter")
    assert jitter.evidence_for(held.size**2 / 12) < 0


def test_residuals_far_above_the_noise_are_unknown_however_rough_they_are() -> None:
    """A record updated every 10 ms of readings every 37.5 ms has images on the sweep's own lines."""
    found = examined_with(Hidden("sample_and_hold", 0.01, 0.0116), 720107)
    assert [verdict.verdict for verdict in found.verdicts] == ["unknown"]
    assert "the nearest known effect is" in found.verdicts[0].evidence


def test_a_bit_that_never_stands_has_no_stick_slip() -> None:
    case = replace(plain_case(1, 1)[0], hidden=(Hidden("stuck_slip_regimes", 0.6, 0.5),))
    ideal = Ideals(np.nan, np.nan, np.nan, np.nan, 30.0, (("stuck_slip_regimes",),))
    for stands in (False, True):
        assert judge(case, always("stribeck_cutting"), ideal, stands=stands).right is not stands
        assert judge(case, always("stuck_slip_regimes"), ideal, stands=stands).right


def test_what_a_rig_has_by_nature_is_no_alarm_whatever_its_score() -> None:
    plain = other_plain_case(1, 1)[0]
    case = replace(plain, rig=replace(plain.rig, control=replace(plain.rig.control, interval=0.02)))
    ideal = Ideals(0.0, 0.0, 0.0, 0.0, 30.0, ())
    for name, score in (("sample_and_hold", -np.inf), ("mud_drag", 9.0)):
        found = judge(case, replace(always(name), score=9.0), ideal)
        assert (found.detected, found.score) == (score > 0, score)


def test_that_the_bit_stands_is_no_second_cause_beside_what_makes_it_stand() -> None:
    regime, maker, other = (Claim(name, 1.0, cause=name) for name in ("stuck_slip_regimes", "drive_lag", "mud_drag"))
    both, wrong = Answer((maker, regime)), Answer((other, regime))
    case = hidden_case("drive_lag")
    for stands in (True, False):
        assert judge(case, both, known("drive_lag"), stands=stands).right is stands
        assert not judge(case, wrong, known("drive_lag"), stands=stands).right


def test_a_bit_that_never_stands_has_the_ideal_test_of_a_torque_that_falls(monkeypatch: pytest.MonkeyPatch) -> None:
    case = replace(other_plain_case(1, 1)[0], hidden=(Hidden("stuck_slip_regimes", 0.6, 0.5),))
    for stands in (False, True):
        monkeypatch.setattr("benchmarks.blind.judge.bit_stands", lambda _, stands=stands: stands)
        found = ideals(case, thorough=False)
        assert np.isnan(found.detectability) == stands
        assert stands or 0 < found.detectability < 100


def test_what_two_others_make_exactly_is_not_taken_out() -> None:
    """A record times g with a control times 1/g is an actuator times g; no search has to find it."""
    ideal = Ideals(17.0, 1.0, 1.0, 1.0, 30.0, (("actuator_gain",),))
    for name, stays in (("actuator_gain", True), ("drive_lag", False)):
        case = replace(plain_case(1, 1)[0], hidden=(Hidden(name, 0.02, 0.5),), removed=True)
        assert judge(case, always("unknown"), replace(ideal, same=((name,),))).still_there == stays


def test_a_delay_that_the_catalogue_lacks_is_no_filter() -> None:
    """Two filters come near its phase, and only the data sheets' delay and clocks tell them apart."""
    case = replace(obvious(2051, "clock_offset", 1, _DETECTABILITY), command_logged=True)
    without = [cause for name, cause in CATALOGUE.items() if name != "clock_offset"]
    found = examine(evidence_of(case), catalogue=without, error_rate=ERROR_RATE, seed=case.seed)
    (verdict,) = found.verdicts
    assert (verdict.verdict, verdict.family) == ("unknown", "data sheet")
    assert "clocks" in verdict.what_would_separate or "delay" in verdict.what_would_separate


def test_a_length_that_fits_far_off_the_data_sheet_is_wrong_though_all_residuals_are_noise() -> None:
    """A few causes of drive, recorder and string are tried; the whole catalogue says the same and takes a minute."""
    slow = Hidden("wave_speed", 0.25, 0.5)
    case = replace(plain_case(2055, 1)[0], hidden=(slow,))
    other = [CATALOGUE[name] for name in ("drive_lag", "clock_offset", "extra_section", "mud_drag", "length_growth")]
    (verdict,) = examine(evidence_of(case), catalogue=other, error_rate=ERROR_RATE, seed=case.seed).verdicts
    assert (verdict.verdict, verdict.family) == ("unknown", "data sheet")
    assert verdict.what_would_separate.startswith("the fitted length of the string lies")


@pytest.mark.parametrize(
    ("wrong", "expected"),
    [
        (("inertia_td",), ("none", "")),
        (("inertia_td", "polar_moment", "delay", "proportional", "integral"), ("unknown", "data sheet")),
    ],
)
def test_values_off_together_are_wrong_though_no_cause_explains_them(
    wrong: tuple[str, ...], expected: tuple[str, str]
) -> None:
    """One may belong to another rig."""
    case = plain_case(903, 1)[0]
    sheet = case.data_sheet
    gains = {name: 1.8 * value for name, value in vars(sheet.controller).items() if name in wrong}
    others = {name: 1.8 * value for name, value in vars(sheet).items() if name in wrong}
    stated = replace(sheet, controller=replace(sheet.controller, **gains), **others)
    causes = [CATALOGUE[name] for name in ("drive_lag", "clock_offset", "extra_section", "mud_drag", "length_growth")]
    found = examine(replace(evidence_of(case), data_sheet=stated), catalogue=causes, error_rate=ERROR_RATE)
    (verdict,) = found.verdicts
    assert (verdict.verdict, verdict.family) == expected
    assert found.base.chi2 < 1.1 * found.model.measured.residuals


@pytest.mark.parametrize("name", ["clock_offset", "wave_speed"])
def test_a_length_or_clock_within_four_tolerances_is_no_cause(name: str) -> None:
    """As one tolerance in ten is understated, a value lies so far off as often as a cause is there."""
    case = plain_case(903, 1)[0]
    sheet = evidence_of(case).data_sheet
    tolerance = sheet.clock_error if name == "clock_offset" else sheet.length_relative
    found = examine(evidence_of(replace(case, hidden=(Hidden(name, 3.7 * tolerance, 0.5),))), error_rate=ERROR_RATE)
    assert np.abs(found.base.off_data_sheet[MEASURED]).max() > 3
    assert [one.verdict for one in found.verdicts] == ["none"]


@pytest.mark.parametrize(
    ("seed", "hidden"),
    [
        (902, (Hidden("controller_gain", 0.3, 0.66), Hidden("hysteretic_damping", 0.1, 0.4))),
        (905, (Hidden("drive_lag", 0.03, 0.4), Hidden("speed_scale", 0.2, 0.66))),
    ],
)
def test_values_far_off_their_data_sheets_are_explained_by_a_second_cause(
    seed: int, hidden: tuple[Hidden, Hidden]
) -> None:
    """Beside the first, residuals are noise: the pulls off the data sheets alone tell that something is left."""
    found = discovery(replace(other_plain_case(seed, 2)[0], hidden=hidden)).verdicts
    assert len(found) == 2
    for one in hidden:
        (verdict,) = (each for each in found if one.name in each.verdict.split("|"))
        assert verdict.cause != one.name or verdict.size_low <= one.size <= verdict.size_high


def test_gains_are_named_though_one_of_them_is_stated_wrong() -> None:
    """The base model takes both for wrong statements, which linear theory about it does not doubt."""
    case = hidden_case("controller_gain")
    evidence, sheet = evidence_of(case), case.data_sheet
    controller = replace(sheet.controller, proportional=1.15 * sheet.controller.proportional)
    found = examine(replace(evidence, data_sheet=replace(sheet, controller=controller)), error_rate=ERROR_RATE)
    assert found.before.p_value > ERROR_RATE
    (verdict,) = found.verdicts
    assert verdict.verdict == "controller_gain"


def test_a_drift_that_the_catalogue_lacks_is_no_jump() -> None:
    """Its mean response over the window is that of a jump; how the answer moves on the way is not."""
    drift = Hidden("parameter_drift", 1500.0, 0.5)
    case = replace(plain_case(90078)[0], hidden=(drift,))
    without = [cause for name, cause in CATALOGUE.items() if name != drift.name]
    found = examine(evidence_of(case), catalogue=without, error_rate=ERROR_RATE, seed=case.seed)
    assert [one.verdict for one in found.verdicts] == ["unknown"]


def test_where_a_string_changes_its_size_is_told_between_the_shapes_that_are_tried() -> None:
    taper = Hidden("tapered_string", 0.8, 0.04)
    case = replace(plain_case(2052, 1)[0], hidden=(taper,))
    quiet = tuple(replace(one, bit_noise=one.bit_noise / 10) for one in case.segments)
    case = replace(
        case, segments=quiet, equipment=replace(case.equipment, sensor_noise=case.equipment.sensor_noise / 10)
    )
    found = examine(evidence_of(case), error_rate=ERROR_RATE, seed=case.seed)
    assert [one.verdict for one in found.verdicts] == [taper.name]
    assert found.extensions[0].shape == pytest.approx(upper_share(taper.shape), abs=0.01)


def test_what_one_of_two_causes_explains_is_no_rival_of_the_other() -> None:
    pair = (Hidden("clock_offset", 0.02, 0.5), Hidden("local_damping_zone", 300.0, 0.5))
    case = replace(plain_case(2053, 1)[0], hidden=pair, command_logged=True)
    # a held record is a rival of the offset in its own right
    others = [cause for name, cause in CATALOGUE.items() if name != "sample_and_hold"]
    found = examine(evidence_of(case), catalogue=others, error_rate=ERROR_RATE, seed=case.seed)
    assert {one.verdict for one in found.verdicts} == {"clock_offset|recorder_filter", "local_damping_zone"}
    assert min(uncalibrated([one.probability for one in found.verdicts], CALIBRATION["named"])) > logit(0.98)


def test_what_a_drift_of_the_clock_does_not_explain_keeps_its_name_beside_it() -> None:
    pair = (Hidden("clock_drift", 4e-6, 0.5), Hidden("local_damping_zone", 150.0, 0.5))
    case = replace(plain_case(2056, 1)[0], hidden=pair)
    found = examine(evidence_of(case), error_rate=ERROR_RATE, seed=case.seed)
    assert {one.verdict for one in found.verdicts} == {"clock_drift", "local_damping_zone"}


@pytest.mark.parametrize(
    ("name", "size", "seed", "acts"),
    [
        ("torque_limit", 1.5e3, 2057, True),
        ("torque_limit", 1e9, 2057, False),
        ("torque_rate_limit", 500.0, 2057, True),
        ("torque_rate_limit", 1e9, 2057, False),
        ("gear_backlash", 0.1, 2057, True),
        # the pipe's load keeps the teeth together
        ("gear_backlash", 0.1, 2060, False),
    ],
)
def test_a_cause_that_never_comes_to_its_threshold_leaves_no_trace(
    name: str, size: float, seed: int, *, acts: bool
) -> None:
    left = trace(replace(plain_case(seed, 1)[0], hidden=(Hidden(name, size, 0.5),)))
    assert left > 100.0 if acts else left < 0.1


@pytest.mark.parametrize(("play", "verdict"), [(0.1, "gear_backlash"), (1e-7, "none")])
def test_play_is_named_by_a_speed_measured_below_the_gear(play: float, verdict: str) -> None:
    case = replace(other_plain_case(52008, 1)[0], hidden=(Hidden("gear_backlash", play, 0.5),), command_logged=True)
    found = examine(evidence_of(case), error_rate=ERROR_RATE, seed=case.seed)
    assert [one.verdict for one in found.verdicts] == [verdict]


def test_where_no_cause_has_a_threshold_no_trace_is_known() -> None:
    assert np.isnan(trace(plain_case(2057, 1)[0]))
