"""The true models of the proof of learning are what the simulator's rigs have, by linear theory."""

from dataclasses import replace

import numpy as np
import pytest

from benchmarks.blind.hidden import Hidden
from benchmarks.learn.cases import well
from benchmarks.learn.effects import HIDEABLE
from drillid.discrepancy.catalogue import OperatingPoint, WindowModel
from drillid.physics.responses import command_mobility, laplace
from drillid.physics.sensor import Recording

S = laplace(np.geomspace(0.05, 4.0, 80))
SIZES = {"mounted_inertia": 40.0, "rippled_pipe": 0.2, "second_motor": 3e-5, "drive_lag": 0.03, "mud_drag": 300.0}


@pytest.mark.parametrize(("name", "size"), SIZES.items())
def test_the_true_model_is_the_rig_that_is_simulated(name: str, size: float) -> None:
    case = well(3, 0, windows=4)
    shape = 0.4
    point = OperatingPoint(*(np.array([[segment.pipe_length] for segment in case.segments]) for _ in range(3)))
    ((extension,), *_) = HIDEABLE[name].extensions(shape)
    model = WindowModel(case.world(0).linear(0.5), Recording())
    by_truth = extension.cause.extend(model, size, extension.shape, replace(point, length=point.length[0])).mobility(S)
    simulated = command_mobility(case.world(0, hidden=(Hidden(name, size, shape),)).linear(0.5), S)
    np.testing.assert_allclose(by_truth, simulated, atol=1e-6 * np.abs(simulated).max())
