"""Fleets from the time-domain simulator: what no single well shows is named for their rig, and nothing else."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from benchmarks.blind.engines import evidence_of
from benchmarks.blind.hidden import Hidden
from benchmarks.learn.fleet_cases import Fleet, plain_fleet
from drillid.common_causes.pooling import SetStatistics, Wells
from drillid.common_causes.verdicts import LONE, OwnVerdict, judge
from drillid.discrepancy.base_rates import BaseRates
from drillid.discrepancy.catalogue import CATALOGUE
from drillid.discrepancy.inference.coordinates import Extension
from drillid.discrepancy.inference.set_fit import fit_set
from drillid.discrepancy.inference.shared_likelihood import shared_likelihood
from drillid.discrepancy.verdicts.engine import examine
from drillid.discrepancy.verdicts.examination import Examination
from drillid.discrepancy.verdicts.verdict import NONE

WELLS = 5
LAG = 0.005


def rig() -> Fleet:
    """Wells of a rig whose drive's maker states the delay to 1 ms."""
    fleet = plain_fleet(101, WELLS)
    wells = []
    for case in fleet.wells:
        delay = case.equipment.delay + 0.2 * (case.data_sheet.delay - case.equipment.delay)
        wells.append(replace(case, data_sheet=replace(case.data_sheet, delay=delay, delay_error=0.001)))
    return Fleet(fleet.seed, tuple(wells))


def examined(fleet: Fleet) -> tuple[list[SetStatistics], dict[str, list[OwnVerdict]], list[str]]:
    """What the fleet keeps of each well, the wells' own names, and their verdicts."""
    sets, own, verdicts = [], dict[str, list[OwnVerdict]](), []
    for number, case in enumerate(fleet.wells):
        examination = examine(evidence_of(case))
        kept = shared_likelihood(examination.model, examination.extended, examination.extensions, examination.before)
        well = f"W{number}"
        sets.append(SetStatistics(well=well, rig="R", **vars(kept)))
        own[well] = [OwnVerdict(each.members, each.cause, each.size) for each in examination.verdicts if each.cause]
        verdicts += [each.verdict for each in examination.verdicts]
    return sets, own, verdicts


@pytest.fixture(scope="module")
def plain() -> tuple[list[SetStatistics], dict[str, list[OwnVerdict]], list[str]]:
    """The rig as it is."""
    return examined(rig())


@cache
def alone(seed: int, well: int) -> Examination:
    """What one well of a fleet shows by itself."""
    return examine(evidence_of(plain_fleet(seed, well + 1).wells[well]))


@pytest.mark.parametrize(
    ("seed", "well", "name", "shape", "far"),
    [
        (101, 0, "recorder_filter", 2.0, 0.012),
        (101, 0, "controller_gain", 0.0, 0.06),
        # fitted at the largest size from none, this one ends far off
        (150005, 1, "drive_lag", 0.0, 0.012),
    ],
)
def test_a_likelihood_between_held_sizes_is_that_of_a_fit_there(
    seed: int, well: int, name: str, shape: float, far: float
) -> None:
    candidate, examination = Extension(CATALOGUE[name], shape), alone(seed, well)
    model = examination.model.with_normal_priors()
    base = fit_set(model, examination.base.point)
    kept = shared_likelihood(examination.model, base, (), examination.before, [candidate])
    wells = Wells([SetStatistics(well="W", rig="R", **vars(replace(kept, temper=1.0, control_common=0.0)))])
    sizes = far * np.linspace(0.0, 1.0, 9)
    at = wells.at(0, sizes)
    precision = at.information[0] + np.diag(wells.prior[0])
    gained = np.sum(at.score[0] * np.linalg.solve(precision, at.score[0][..., None])[..., 0], axis=-1)
    held = at.value[0] + gained / 2
    fits = [base]
    for size in sizes[1:].tolist():
        fits.append(fit_set(model.holding(candidate, size), fits[-1].point))
    direct = np.array([-fit.cost - fit.windows_information / 2 for fit in fits])
    np.testing.assert_allclose(held - held[0], direct - direct[0], atol=0.05, rtol=0.02)


def test_a_lag_that_no_well_shows_is_named_for_the_rig() -> None:
    sets, own, verdicts = examined(rig().with_cause(Hidden("drive_lag", LAG, 0.5)))
    assert verdicts == [NONE] * WELLS
    verdict = judge("rig", "R", sets, own, 0.05, BaseRates()).verdict
    assert "drive_lag" in verdict.verdict.split("|")
    assert verdict.size_low <= LAG <= verdict.size_high


def test_a_fleet_without_a_cause_stays_silent(
    plain: tuple[list[SetStatistics], dict[str, list[OwnVerdict]], list[str]],
) -> None:
    sets, own, _ = plain
    assert judge("rig", "R", sets, own, 0.05, BaseRates()).verdict.verdict == NONE


def test_a_well_that_took_another_length_does_not_accuse_the_rig() -> None:
    # one of these fits its single window by a pipe that is 4.6 standard errors shorter than the others'
    sets, own, _ = examined(plain_fleet(140000, 3))
    assert judge("rig", "R", sets, own, 0.05, BaseRates()).verdict.verdict == NONE


def test_one_bad_sensor_is_not_given_to_the_rig(
    plain: tuple[list[SetStatistics], dict[str, list[OwnVerdict]], list[str]],
) -> None:
    sets, own, _ = plain
    fleet = rig()
    bad = replace(fleet.wells[2], hidden=(Hidden("speed_scale", 0.15, 0.5),))
    (changed,), named, _ = examined(Fleet(fleet.seed, (bad,)))
    sets = [replace(changed, well="W2") if each.well == "W2" else each for each in sets]
    result = judge("rig", "R", sets, own | {"W2": named["W0"]}, 0.05, BaseRates())
    assert result.verdict.verdict == NONE
    assert ("W2", LONE) in [(each.well, each.standing) for each in result.standings]
