"""Without a cause the bit only takes power from the string: its damping is not negative."""

from dataclasses import replace

import numpy as np
import pytest

from drillid.config.rig import Rig
from drillid.discrepancy.inference.coordinates import DAMPING_BIT, LOCAL
from drillid.discrepancy.inference.set_fit import expanded
from drillid.discrepancy.verdicts.engine import examine
from drillid.discrepancy.verdicts.examination import Examination
from tests.simulated import DEEP, WINDOW_S, drilled
from tests.truth.discrepancy.wells import DESCRIBED, evidence_of

WINDOWS = 4
_SHEETS = {
    "drive_delay": {"value": "40 ms", "tolerance": "5 ms"},
    "top_drive_inertia": {"value": "1105 kg m^2", "relative": "5 %"},
    "pipe": {"outer_diameter": "139.7 mm", "inner_diameter": "121.4 mm"},
    "collars": [{"length": "100 m", "outer_diameter": "165.1 mm", "inner_diameter": "71.4 mm"}],
    "controller": {"proportional": "1500 N m s/rad", "integral": "800 N m/rad", "relative": 0.02},
}
RIG = Rig.checked(DESCRIBED.model_dump(exclude_none=True) | _SHEETS, "large rig with data sheets")


def examined(damping: float, seed: int) -> Examination:
    """A set of windows whose bit has a damping, N m s/rad, examined."""
    truth = replace(DEEP, bit=replace(DEEP.bit, damping=damping))
    return examine(evidence_of(truth, [drilled(truth, WINDOWS * WINDOW_S, seed)], RIG), error_rate=0.05, seed=seed)


@pytest.fixture(scope="module")
def falling() -> Examination:
    """Windows of a bit whose torque falls with speed."""
    return examined(-60.0, 25)


def test_a_torque_that_falls_with_speed_is_named(falling: Examination) -> None:
    assert [verdict.verdict for verdict in falling.verdicts] == ["regenerative_cutting|stribeck_cutting"]


def test_a_bit_without_damping_is_no_cause() -> None:
    assert [verdict.verdict for verdict in examined(0.0, 22).verdicts] == ["none"]


def test_a_fit_ends_at_the_least_cost_below_zero(falling: Examination) -> None:
    model, point = falling.model, falling.base.point
    assert np.all(point.shared[DAMPING_BIT] + point.local[:, LOCAL.index(DAMPING_BIT)] < 0.05)

    def cost(step: float) -> float:
        shared = point.shared.copy()
        shared[DAMPING_BIT] += step
        return expanded(model, replace(point, shared=shared), ()).cost

    assert min(cost(-0.02), cost(0.02)) > cost(0.0)
