"""Sizes that detections state, on rigs of the second world, which shares no model with the detectors."""

from dataclasses import replace

import pytest

from benchmarks.blind.engines import evidence_of
from benchmarks.blind.hidden import Hidden, altered
from benchmarks.blind.other_world.cases import Case, plain_case
from drillid.discrepancy.detectors.pooling import PooledDetection, pool

SURE = 3.0
"""Standard errors within which 99.7 % of sizes lie."""


def hiding(seed: int, name: str, size: float, windows: int) -> Case:
    """A rig of the second world with a cause of a size that the ideal test cannot miss."""
    return replace(plain_case(seed, windows)[0], hidden=(Hidden(name, size, 0.5),))


def detected(case: Case) -> PooledDetection:
    """The detection of a case's only cause."""
    return next(found for found in pool(evidence_of(case).detections) if found.cause == case.hidden[0].name)


def assert_size_holds(case: Case, largest_error: float) -> None:
    """Fail where a size is off by more than its error allows, or the error is so large that it says nothing."""
    found, true = detected(case), case.hidden[0].size
    assert abs(found.size - true) < SURE * found.size_error
    assert found.size_error < largest_error * abs(true)


@pytest.mark.parametrize("seed", [420104, 420110])
def test_a_drift_from_little_damping_to_ten_times_that_of_the_pipe(seed: int) -> None:
    assert_size_holds(hiding(seed, "parameter_drift", 1500.0, 4), 0.2)


@pytest.mark.parametrize(("seed", "size"), [(420304, 2.63e-6), (420305, 2.16e-6)])
def test_noise_that_the_control_reads_as_well_hides_no_drift_of_the_clock(seed: int, size: float) -> None:
    assert_size_holds(hiding(seed, "clock_drift", size, 4), 0.1)


@pytest.mark.parametrize(("seed", "size"), [(420300, 1.96e-4), (420305, 1.28e-4)])
def test_jitter_between_rows_that_show_the_interval_of_the_control(seed: int, size: float) -> None:
    assert_size_holds(hiding(seed, "delay_jitter", size, 2), 0.2)


def test_the_size_of_jitter_is_unknown_where_rows_do_not_show_for_how_long_it_holds() -> None:
    case = hiding(420301, "delay_jitter", 1.7e-4, 2)
    unknown = detected(case)
    assert unknown.p_value < 1e-6
    assert not unknown.size_error > 0
    slow = replace(case, rig=altered(case.rig, control=altered(case.rig.control, interval=0.025)))
    assert detected(slow).size_error > 0
