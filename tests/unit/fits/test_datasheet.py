"""What a rig's data sheets and tally say, as fits take it."""

from typing import Any

import numpy as np
import pytest

from drillid.config.rig import Rig
from drillid.fits.datasheet import data_sheet
from drillid.physics.equipment import Controller, polar_moment
from drillid.physics.parameters import DELAY, INERTIA_TD, LENGTH, POLAR_MOMENT
from tests.simulated import RIG

BIT_DEPTH = 960.0
CONTROLLER = Controller(350.0, 180.0)


def rig(**changes: Any) -> Rig:
    """The shallow rig, whose collars are 60 m long, with more data sheets."""
    return Rig.checked(RIG.model_dump(exclude_none=True) | changes, "changed rig")


def test_delay_and_inertia_come_with_their_tolerances() -> None:
    described = rig(
        drive_delay={"value": "28 ms", "tolerance": "3 ms"},
        top_drive_inertia={"value": "455 kg m^2", "relative": "5 %"},
    )
    prior = data_sheet(described, CONTROLLER, BIT_DEPTH).prior(BIT_DEPTH)
    assert (prior.value[DELAY], prior.error[DELAY]) == pytest.approx((0.028, 0.003))
    assert (prior.value[INERTIA_TD], prior.error[INERTIA_TD]) == pytest.approx((455.0, 22.75))
    stated = np.isfinite(prior.value)
    assert np.flatnonzero(stated).tolist() == sorted([DELAY, INERTIA_TD])
    assert np.isfinite(prior.error[stated]).all()


def test_the_pipe_is_as_long_as_the_string_less_its_collars() -> None:
    pipe = {"outer_diameter": "88.9 mm", "inner_diameter": "70.2 mm", "relative": "4 %", "length_relative": "10 %"}
    moment = polar_moment(0.0889, 0.0702)
    for collars, length in ((RIG.model_dump()["collars"], 900.0), ([], 960.0)):
        prior = data_sheet(rig(pipe=pipe, collars=collars), CONTROLLER, BIT_DEPTH).prior(BIT_DEPTH)
        assert (prior.value[LENGTH], prior.error[LENGTH]) == pytest.approx((length, 0.1 * length))
        assert (prior.value[POLAR_MOMENT], prior.error[POLAR_MOMENT]) == pytest.approx((moment, 0.04 * moment))


def test_without_data_sheets_nothing_is_known() -> None:
    silent = data_sheet(RIG, CONTROLLER, BIT_DEPTH)
    assert np.isinf(silent.inertia_td_error)
    assert np.isnan(silent.prior(BIT_DEPTH).value).all()


def test_collars_of_the_tally_are_given_equipment() -> None:
    given = data_sheet(RIG, CONTROLLER, BIT_DEPTH).equipment
    assert given.controller is CONTROLLER
    assert given.collar_length == 60.0
    assert data_sheet(rig(collars=[]), CONTROLLER, BIT_DEPTH).equipment.collar_length == 0.0
