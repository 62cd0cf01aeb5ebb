"""Evidence from time series and from a well's datasets is the same, and holds what the data sheets say."""

from dataclasses import replace

import numpy as np
import pytest

from drillid.config.settings import Settings
from drillid.datasets.codes import Gate
from drillid.discrepancy.detectors.detection import Detection
from drillid.discrepancy.evidence import Evidence, OperatingPoints
from drillid.discrepancy.gather import Series, assembled, gather, gather_well
from drillid.discrepancy.inference.base_fit import fit_base, log_mass
from drillid.discrepancy.inference.coordinates import COORDINATES, DEVIATION, Point
from drillid.discrepancy.inference.set_fit import SetFit, fit_set
from drillid.discrepancy.inference.set_model import SetModel
from drillid.discrepancy.verdicts import engine
from drillid.discrepancy.verdicts.engine import at_even_odds, examine
from drillid.discrepancy.verdicts.verdict import Verdict
from drillid.errors import EstimationError
from drillid.physics.parameters import LENGTH
from drillid.windows.channels import window_channels
from tests.simulated import RATE, RIG, SHALLOW, Processed


@pytest.fixture(scope="module")
def of_well(healthy: Processed) -> Evidence:
    names = (("records", "records"), ("windows", "windows"), ("spectra", "spectra"), ("mobility", "mobility"))
    datasets = [healthy.dataset(*name) for name in (*names, ("fits", "fits"))]
    return gather_well(RIG, *datasets)


def test_a_well_gives_what_its_time_series_give(healthy: Processed, of_well: Evidence) -> None:
    records, windows = healthy.dataset("records", "records"), healthy.dataset("windows", "windows")
    series = [Series(*window_channels(records, windows, row)) for row in range(windows.sizes["window"])]
    own = gather(series, RATE, of_well.operating_points, of_well.data_sheet, Settings())
    assert own.windows == of_well.windows == 4
    np.testing.assert_array_equal(own.used, of_well.used)
    assert own.control is not None
    assert of_well.control is not None
    # stages keep single precision
    used = own.used
    assert np.all(np.abs(own.mobility - of_well.mobility)[used] < 0.01 * np.sqrt(own.variance[used]))
    assert np.all(np.abs(own.control / of_well.control - 1)[used] < 0.01)
    np.testing.assert_allclose(own.fitted[:, LENGTH], of_well.fitted[:, LENGTH], rtol=1e-3)
    assert {(detection.cause, detection.window) for detection in own.detections} == {
        (detection.cause, detection.window) for detection in of_well.detections
    }


def test_the_control_response_is_the_data_sheet_controller(of_well: Evidence) -> None:
    assert of_well.control is not None
    gains = SHALLOW.top_drive.controller
    expected = gains.proportional + gains.integral / (2j * np.pi * of_well.frequency)
    error = np.abs(of_well.control / expected - 1)[of_well.used]
    assert np.median(error) < 1e-3


def test_a_set_without_any_fit_is_refused(of_well: Evidence) -> None:
    with pytest.raises(EstimationError, match="no window has a fit"):
        examine(replace(of_well, fitted=np.full_like(of_well.fitted, np.nan)))


def test_what_no_data_sheet_states_is_not_off_one(of_well: Evidence) -> None:
    _, base = fit_base(of_well)
    assert _moved(base, "damping_bha").data_sheet_cost == base.data_sheet_cost
    assert _moved(base, "delay").data_sheet_cost > base.data_sheet_cost + 5


def _moved(base: SetFit, name: str) -> SetFit:
    off = base.off_data_sheet.copy()
    off[COORDINATES.index(name)] += 10.0
    return replace(base, off_data_sheet=off)


def test_a_model_of_windows_that_agree_has_more_mass_the_less_they_may_differ(of_well: Evidence) -> None:
    masses = []
    for share in (1.0, 0.5, 0.25):
        model = SetModel(of_well, share * DEVIATION)
        masses.append(log_mass(model, fit_set(model, model.start())))
    assert masses == sorted(masses)


def test_without_causes_what_is_wrong_is_unknown_or_nothing(of_well: Evidence) -> None:
    late = replace(of_well, data_sheet=replace(of_well.data_sheet, delay=2 * of_well.data_sheet.delay))
    assert [each.verdict for each in examine(of_well, catalogue=[]).verdicts] == ["none"]
    assert examine(late, catalogue=[]).verdicts[0].verdict in ("none", "unknown")


def test_a_window_without_a_fit_takes_part(of_well: Evidence) -> None:
    fitted = of_well.fitted.copy()
    fitted[1] = np.nan
    with_gap, whole = examine(replace(of_well, fitted=fitted)).verdicts, examine(of_well).verdicts
    assert [verdict.verdict for verdict in with_gap] == [verdict.verdict for verdict in whole]


def test_a_base_model_at_a_poor_minimum_is_found_again_from_beside_a_cause(
    of_well: Evidence, monkeypatch: pytest.MonkeyPatch
) -> None:
    def poor_at_first(evidence: Evidence, *further: Point) -> tuple[SetModel, SetFit]:
        model, base = fit_base(evidence, *further)
        if further:
            return model, base
        far = base.point.shared.copy()
        far[COORDINATES.index("length")] = -0.3
        point = replace(base.point, shared=far)
        cost = model.misfit(point, ()) / 2
        return model, replace(base, point=point, cost=cost, chi2=2 * cost)

    whole = examine(of_well)
    monkeypatch.setattr(engine, "fit_base", poor_at_first)
    again = examine(of_well)
    _, poor = poor_at_first(of_well)
    assert poor.cost > again.base.cost + 100
    assert again.base.cost == pytest.approx(whole.base.cost, abs=0.1)
    assert [verdict.verdict for verdict in again.verdicts] == ["none"]


@pytest.mark.parametrize(("log_evidence", "verdict"), [(-1.5, "none"), (7.0, "none"), (30.0, "unknown")])
def test_a_misfit_is_unknown_where_that_is_likelier_right_than_wrong(
    of_well: Evidence, log_evidence: float, verdict: str
) -> None:
    examination = examine(of_well)
    probability = examination.base_rates.probability(["unknown"], log_evidence)
    misfit = Verdict("unknown", "string", probability, 1000.0, 1010.0, evidence_nats=log_evidence)
    (stated,) = at_even_odds(replace(examination, verdicts=(misfit,))).verdicts
    assert stated.verdict == verdict
    assert stated.probability > 0.5


def test_a_detection_that_predicts_no_window_takes_nothing_from_none(of_well: Evidence) -> None:
    detections = tuple(Detection("stuck_slip_regimes", row, 2.6, 0.5, 0.1, 0.0) for row in range(of_well.windows))
    clear, stated = (examine(replace(of_well, detections=each)).verdicts[0] for each in ((), detections))
    assert stated.verdict == "none"
    assert stated.probability > clear.probability - 0.05


def test_a_very_large_change_in_a_single_window_has_an_interval_of_its_logarithm(of_well: Evidence) -> None:
    change = Detection("regime_change", 0, 6.0, 1250.0, 850.0, 18.0, 0.0)
    (stated,) = examine(replace(of_well, detections=(change,))).verdicts
    assert stated.verdict == "regime_change"
    assert 0 < stated.size_low < 1250.0 < stated.size_high
    opposed = (change, replace(change, window=1, size=-1250.0))
    assert "regime_change" not in [each.verdict for each in examine(replace(of_well, detections=opposed)).verdicts]


def test_a_weak_detection_of_stick_slip_takes_no_place_of_a_torque_limit(of_well: Evidence) -> None:
    detections = tuple(
        Detection(cause, row, score, size, error, score**2 / 2, 0.0)
        for cause, score, size, error in (("torque_limit", 15.0, 4e3, 10.0), ("stuck_slip_regimes", 4.0, 1.2, 0.1))
        for row in range(of_well.windows)
    )
    (stated,) = examine(replace(of_well, detections=detections)).verdicts
    assert stated.verdict == "torque_limit"
    swapped = tuple(replace(each, score=19.0 - each.score, log_ratio=50.0) for each in detections)
    (stated,) = examine(replace(of_well, detections=swapped)).verdicts
    assert stated.verdict == "stuck_slip_regimes"
    beyond_doubt = tuple(replace(each, score=60.0, log_ratio=1800.0) for each in detections)
    (stated,) = examine(replace(of_well, detections=beyond_doubt)).verdicts
    assert stated.verdict == "stuck_slip_regimes"


@pytest.mark.parametrize(
    ("separation", "verdict"),
    [(np.nan, "parameter_drift|regime_change"), (1.0, "parameter_drift|regime_change"), (2.0, "parameter_drift")],
)
def test_two_courses_of_a_change_are_a_class_where_they_predict_nearly_the_same(
    of_well: Evidence, separation: float, verdict: str
) -> None:
    detections = tuple(
        Detection(cause, row, score, 100.0, 15.0, 18.0, 0.0, separation=separation)
        for cause, score in (("parameter_drift", 6.0), ("regime_change", 5.95))
        for row in range(of_well.windows)
    )
    verdicts = examine(replace(of_well, detections=detections)).verdicts
    assert [stated.verdict for stated in verdicts] == [verdict]


def test_windows_without_their_operating_points_are_refused(of_well: Evidence) -> None:
    nothing = np.zeros(1000)
    with pytest.raises(EstimationError, match="Give one for each window"):
        gather([Series(nothing, nothing, nothing)], RATE, of_well.operating_points, of_well.data_sheet, Settings())
    none = OperatingPoints(*(values[:0] for values in vars(of_well.operating_points).values()))
    with pytest.raises(EstimationError, match="Give one for each window"):
        gather([], RATE, none, of_well.data_sheet, Settings())


def test_a_band_counts_in_all_windows_or_in_none(of_well: Evidence, healthy: Processed) -> None:
    mobility = healthy.dataset("mobility", "mobility").copy(deep=True)
    gate = mobility["gate"].values
    gate[:] = Gate.USED
    gate[0, 10], gate[1:, 20], gate[0, 30] = Gate.TOO_INCOHERENT, Gate.TOO_INCOHERENT, Gate.TOO_COHERENT
    used = assembled(mobility, of_well.operating_points, of_well.data_sheet, of_well.fitted, ()).used
    assert used[:, 10].all()
    assert not used[:, 20].any()
    assert used[:, 30].tolist() == [False, True, True, True]
    gate[:] = Gate.TOO_INCOHERENT
    gate[2, 40] = Gate.USED
    used = assembled(mobility, of_well.operating_points, of_well.data_sheet, of_well.fitted, ()).used
    assert np.argwhere(used).tolist() == [[2, 40]]
