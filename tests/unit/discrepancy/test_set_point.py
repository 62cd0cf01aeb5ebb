"""A logged set point tells the scale of the recorded speed, where the control holds the mean speed at it."""

from dataclasses import replace

import numpy as np
import pytest

from drillid.discrepancy.detectors.set_point import holds_set_point, set_point_detection, speed_ratio
from drillid.discrepancy.gather import gather_well
from drillid.discrepancy.verdicts.engine import examine
from drillid.physics.equipment import Controller
from tests.simulated import RIG, Processed

SCALE = 1.05


def test_rounding_that_all_windows_share_is_no_scale() -> None:
    noise = 1e-4 * np.random.default_rng(1).standard_normal(24)
    rounded, scaled = (set_point_detection(ratio + noise) for ratio in (100.4 / 100, SCALE))
    assert rounded is not None
    assert scaled is not None
    assert rounded.score < 1
    assert scaled.score > 5
    assert abs(scaled.size - 0.05) < scaled.size_error < 0.006


def test_a_window_without_its_set_point_tells_nothing() -> None:
    speed = np.full(100, 10.5)
    assert speed_ratio(speed, speed / SCALE) == pytest.approx(SCALE)
    for missing in (np.full(100, np.nan), np.zeros(100)):
        assert np.isnan(speed_ratio(speed, missing))
    assert set_point_detection(np.full(3, np.nan)) is None
    assert not holds_set_point(Controller(350.0, 0.0))


def test_a_well_with_a_set_point_has_its_speed_scale_named(healthy: Processed, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("drillid.discrepancy.gather.detect", lambda record: ())
    names = (("records", "records"), ("windows", "windows"), ("spectra", "spectra"), ("mobility", "mobility"))
    records, *others = (healthy.dataset(*name) for name in (*names, ("fits", "fits")))
    mean = float(records["speed"].mean())
    plain = gather_well(RIG, records, *others)
    assert plain.detections == ()
    evidence = gather_well(
        RIG, records.assign(speed_set=("time", np.full(records.sizes["time"], mean / SCALE))), *others
    )
    assert evidence.control is not None
    # the responses of a speed that reads as much too high
    scaled = replace(
        evidence,
        mobility=SCALE * evidence.mobility,
        variance=SCALE**2 * evidence.variance,
        control=evidence.control / SCALE,
    )
    (verdict,) = examine(scaled).verdicts
    assert verdict.verdict == "speed_scale"
    assert verdict.size_low < 0.05 < verdict.size_high
