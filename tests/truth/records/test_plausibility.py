"""Statistics by which logs are judged, against the time-domain simulator, which knows nothing of them."""

import numpy as np
import pytest

from drillid.records.consistency import (
    Samples,
    apparent_inertia,
    response_sign,
    response_size,
    sweep_in_command,
    sweep_in_command_closely,
)
from drillid.records.plausibility import CHECKS
from tests.simulated import DEEP, RATE, SHALLOW, Truth, drilled

USUAL = {check.statistic: check.usual for check in CHECKS}


def samples(truth: Truth, **factors: float) -> Samples:
    """Ten minutes of a simulated rig, channels multiplied by factors."""
    series = drilled(truth, 600.0, 4)
    channels = {name: values * factors.get(name, 1.0) for name, values in series.items()}
    size = channels["speed"].size
    return Samples(channels, np.arange(size), np.arange(size) / RATE, np.datetime64("2025-03-03", "ns"), RATE)


@pytest.mark.parametrize("truth", [DEEP, SHALLOW], ids=["deep", "shallow"])
def test_simulated_rigs_are_usual(truth: Truth) -> None:
    recorded = samples(truth)
    for statistic in (apparent_inertia, response_size, response_sign, sweep_in_command, sweep_in_command_closely):
        found = statistic(recorded)
        if found is not None:
            assert USUAL[statistic][0] < found.value < USUAL[statistic][1], statistic.__name__
    inertia = apparent_inertia(recorded)
    assert inertia is not None
    assert 1 / 3 < inertia.value / truth.top_drive.inertia < 3


def test_passivity_gives_the_sign_of_the_speed_away() -> None:
    assert response_sign(samples(SHALLOW)).value > 0
    assert response_sign(samples(SHALLOW, speed=-1.0)).value < -1
    assert response_sign(samples(SHALLOW, torque_sweep=-1.0)).value < -1


def test_a_sweep_in_another_unit_shows_in_the_command() -> None:
    whole = sweep_in_command(samples(SHALLOW)).value
    assert whole == pytest.approx(1.0, abs=0.2)
    assert sweep_in_command(samples(SHALLOW, torque_sweep=1e-3)).value == pytest.approx(1e3 * whole)
    assert sweep_in_command(samples(SHALLOW, torque_command=1.356)).value == pytest.approx(1.356 * whole)
    assert apparent_inertia(samples(SHALLOW, torque_sweep=1e-3)).value < 2.0
