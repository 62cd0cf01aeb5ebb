"""Control that samples and holds is no cause, however seldom it reads the speed: rigs of the second world show it."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from benchmarks.blind import world
from benchmarks.blind.engines import evidence_of
from benchmarks.blind.other_world.cases import plain_case
from drillid.discrepancy.catalogue import CATALOGUE
from drillid.discrepancy.detectors.detection import Detection
from drillid.discrepancy.evidence import Evidence
from drillid.discrepancy.inference.base_fit import fit_base, fits_at_intervals
from drillid.discrepancy.inference.coordinates import Extension
from drillid.discrepancy.inference.screen import screen
from drillid.discrepancy.inference.search import search
from drillid.discrepancy.inference.set_fit import fit_set
from drillid.discrepancy.inference.set_model import SetModel
from drillid.discrepancy.inference.size_posterior import fitted_size_interval
from drillid.discrepancy.verdicts.engine import examine
from drillid.physics.responses import laplace

INTERVAL, OFFSET, LATE = 0.0475, -0.003, 0.02
"""s, of the control; between the clocks; and by which the data sheet's delay is wrong."""


LOGGED, UNLOGGED = ("hold", True), ("interpolate", False)
"""What the recorder does between samples, and whether it keeps the command."""


@pytest.fixture(scope="module", params=[LOGGED, UNLOGGED], ids=["command", "no command"])
def evidence(request: Any, tmp_path_factory: pytest.TempPathFactory) -> Evidence:
    kind, command_logged = request.param
    case, _ = plain_case(902, 6)
    rig = case.rig
    control, recording = replace(rig.control, interval=INTERVAL), replace(rig.recording, kind=kind, offset=OFFSET)
    drive = replace(rig.drive, delay=rig.delay - INTERVAL / 2)
    seldom = replace(rig, control=control, recording=recording, drive=drive)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(world, "FOLDER", tmp_path_factory.mktemp("cases"))
        sheet = replace(case.sheet, delay=rig.delay + LATE)
        return evidence_of(replace(case, rig=seldom, sheet=sheet, command_logged=command_logged))


def test_a_control_that_reads_seldom_is_no_cause(evidence: Evidence) -> None:
    examination = examine(evidence)
    assert examination.p_value > 0.01
    assert [verdict.verdict for verdict in examination.verdicts] == ["none"]


def test_rows_tell_the_interval_as_closely_as_they_say(evidence: Evidence) -> None:
    sheet = evidence.data_sheet
    assert sheet.control_interval_relative < 0.01
    assert sheet.control_interval == pytest.approx(INTERVAL, rel=sheet.control_interval_relative)


def test_an_interval_that_no_data_sheet_states_is_found(evidence: Evidence) -> None:
    sheet = replace(evidence.data_sheet, control_interval=np.nan)
    model, fit = fit_base(replace(evidence, data_sheet=sheet))
    found = model.window_model_at(fit.point).control_interval
    # to a step between the intervals tried
    np.testing.assert_allclose(found, INTERVAL, rtol=0.12)


@pytest.mark.parametrize("evidence", [UNLOGGED], ids=["no command"], indirect=True)
def test_a_wrong_unit_is_named_though_the_base_model_takes_another_interval_for_a_part_of_it(
    evidence: Evidence,
) -> None:
    wrong = in_wrong_unit(evidence, 30 / np.pi)
    assert [verdict.verdict for verdict in examine(wrong).verdicts] == ["sign_or_unit"]


@pytest.mark.parametrize("evidence", [UNLOGGED], ids=["no command"], indirect=True)
def test_what_changes_within_a_window_does_not_take_the_place_of_a_wrong_unit(evidence: Evidence) -> None:
    """Both are named, the one with more evidence first."""
    wrong = in_wrong_unit(evidence, 1.3558)
    jumps = tuple(Detection("regime_change", window, 6.0, 50.0, 8.0, 18.0) for window in range(wrong.windows))
    found = examine(replace(wrong, detections=jumps)).verdicts
    assert [verdict.verdict for verdict in found] == ["regime_change", "sign_or_unit|speed_scale"]
    assert found[0].evidence_nats > found[1].evidence_nats


def in_wrong_unit(evidence: Evidence, factor: float) -> Evidence:
    """Evidence whose speed is recorded so many times too large, without detections and the control's interval."""
    sheet = replace(evidence.data_sheet, control_interval=np.nan, delay=evidence.data_sheet.delay - LATE)
    mobility, variance = evidence.mobility * factor, evidence.variance * factor**2
    return replace(evidence, data_sheet=sheet, mobility=mobility, variance=variance, detections=())


@pytest.mark.parametrize("evidence", [UNLOGGED], ids=["no command"], indirect=True)
def test_impedances_times_a_factor_are_a_record_divided_by_it(evidence: Evidence) -> None:
    """Whatever the windows' deviations are, which the factor leaves as they are."""
    sheet = replace(evidence.data_sheet, collar_length=0.0)
    model = SetModel(replace(evidence, data_sheet=sheet))
    point = model.start()
    assert point.shared[7] != 0
    point = replace(point, local=0.3 * np.random.default_rng(1).standard_normal(point.local.shape))
    unit = Extension(CATALOGUE["sign_or_unit"], 6.2832)
    scaled = replace(point.at_impedances(unit.shape), sizes=np.ones(1), shapes=np.zeros(1))
    np.testing.assert_allclose(model.residual(scaled, (unit,)), model.residual(point, ()), rtol=1e-9)


def test_no_cause_fits_worse_than_none_does(evidence: Evidence) -> None:
    """Size zero is among those of every cause, whatever interval of the control a fit starts from."""
    evidence = evidence.subset(np.arange(2))
    late = np.exp(-0.0103 * laplace(evidence.frequency))
    offset = replace(
        evidence,
        data_sheet=replace(evidence.data_sheet, control_interval=np.nan),
        mobility=evidence.mobility * late,
        control=None if evidence.control is None else evidence.control / late,
    )
    model, base = fit_base(offset)
    causes = [cause for cause in CATALOGUE.values() if not cause.size.fixed]
    screened = screen(model, base, (), causes, np.random.default_rng(1))
    for found in search(model, base, (), screened, causes, time_varying={}, all_causes=True, rejected=True):
        assert found.fit.cost < base.cost + 0.1, found.name


@pytest.mark.parametrize("evidence", [UNLOGGED], ids=["no command"], indirect=True)
def test_a_size_is_uncertain_by_the_interval_of_the_control_that_no_data_sheet_states(evidence: Evidence) -> None:
    lag = (Extension(CATALOGUE["drive_lag"], 0.0),)
    late = replace(evidence, mobility=evidence.mobility / (1 + 0.02 * laplace(evidence.frequency))).subset(np.arange(2))
    counts, widths = [], []
    for stated in (evidence.data_sheet.control_interval, np.nan):
        model, base = fit_base(replace(late, data_sheet=replace(late.data_sheet, control_interval=stated)))
        fits = fits_at_intervals(model, fit_set(model, replace(base.point, sizes=np.array([0.02])), lag), lag)
        counts.append(len(fits))
        widths.append([np.ptp(fitted_size_interval(some, lag, 0)) for some in (fits[:1], fits)])
    assert counts[0] == 1 < counts[1]
    assert widths[0][0] == widths[0][1]
    assert widths[1][0] < widths[1][1]
