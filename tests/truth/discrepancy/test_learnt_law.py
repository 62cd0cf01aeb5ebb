"""A bit whose drag grows with the square of its speed, simulated in time: its law is learnt, and none of a damper."""

from dataclasses import dataclass, replace

import numpy as np
import pytest
import xarray as xr

from drillid.arrays import Floats
from drillid.discrepancy.base_rates import BaseRates
from drillid.discrepancy.catalogue import CATALOGUE
from drillid.discrepancy.gather import Series
from drillid.discrepancy.inference.base_fit import fit_base
from drillid.discrepancy.inference.screen import screen
from drillid.discrepancy.learning import law_window
from drillid.discrepancy.learning.examined_law import law_windows, with_law
from drillid.discrepancy.learning.law import LearntLaw, learnt_law
from drillid.discrepancy.products.extended_model import COORDINATES, extension_variables, simulated_rigs
from drillid.discrepancy.sets import ExaminedSet
from drillid.discrepancy.verdicts.examination import Examination
from drillid.discrepancy.verdicts.verdict import Verdict
from drillid.physics.nonlinear import NonlinearRig, SpeedLaw
from drillid.simulation.simulate import simulate
from tests.simulated import RATE, SHALLOW, WINDOW_S, Truth, drilled
from tests.truth.discrepancy.wells import evidence_of, windows_of

DRAG = 6.0
"""N m s²/rad²."""
SWEPT = replace(SHALLOW, sweep_amplitude=600.0)
"""A sweep by which the bit's speed swings by a fifth."""


@dataclass(frozen=True)
class Growing(Truth):
    """A rig with a drag of DRAG ω |ω| at the bit."""

    @property
    def system(self) -> NonlinearRig:
        """All of the equipment."""
        speed = np.linspace(-20.0, 60.0, 801)
        return NonlinearRig(super().system, law=SpeedLaw(speed, DRAG * speed * np.abs(speed)))


def examined(truth: Truth, seed: int) -> tuple[Examination, list[Series]]:
    """Two windows of a rig, with an unknown verdict on them."""
    stands = [drilled(truth, 2 * WINDOW_S, seed)]
    model, base = fit_base(evidence_of(truth, stands))
    before = screen(model, base, (), [CATALOGUE["drive_lag"]], np.random.default_rng(0))
    unknown = Verdict("unknown", "bit", 0.9, 0.0, 1000.0)
    return Examination(
        (unknown,), model, base, base, (), before, before, None, (), BaseRates(), before.p_value
    ), windows_of(stands)


def learnt(examination: Examination, windows: list[Series]) -> LearntLaw:
    """The law of these windows, offered or not."""

    def channels(row: int) -> tuple[Floats, Floats]:
        return windows[row].sweep, windows[row].speed

    return learnt_law(law_windows(examination, channels, RATE))


@pytest.fixture(scope="module")
def growing() -> tuple[Examination, list[Series]]:
    """Windows of the rig whose drag grows."""
    return examined(Growing(**vars(SWEPT)), 71)


def test_drag_that_grows_with_the_square_is_learnt_with_its_size(growing: tuple[Examination, list[Series]]) -> None:
    found = learnt(*growing)
    assert found.offered
    own = found.spline
    speed, torque, error = found.drawn()
    inner = (speed > own.low) & (speed < own.high)
    mean = found.mean
    truth = DRAG * (speed - mean) ** 2
    bend = torque - found.slope_in_model * (speed - mean)
    assert np.abs(bend - truth)[inner].max() < 0.35 * truth[inner].max()
    assert np.mean(np.abs(bend - truth)[inner] < 3 * error[inner] + 0.05 * truth[inner].max()) > 0.9


def test_the_verdict_tells_of_the_law_and_its_gain(growing: tuple[Examination, list[Series]]) -> None:
    examination, windows = growing
    told = with_law(examination, lambda row: (windows[row].sweep, windows[row].speed), RATE)
    assert told.law is not None
    (verdict,) = told.verdicts
    assert verdict.verdict == "unknown"
    assert "the bit's damping changes by" in verdict.evidence
    assert verdict.predictive_gain_low > 0


def test_the_stored_law_is_simulated_as_it_was_learnt(growing: tuple[Examination, list[Series]]) -> None:
    examination, windows = growing
    told = with_law(examination, lambda row: (windows[row].sweep, windows[row].speed), RATE)
    assert told.law is not None
    speed, torque, error = told.law.drawn()
    variables = extension_variables([ExaminedSet(np.arange(2), told)], 2)
    variables |= {"window_set": ("window", np.zeros(2, dtype=int))}
    variables |= {
        f"law_{name}": (("set", "law_point"), values[None])
        for name, values in (("speed", speed), ("torque", torque), ("error", error))
    }
    others = ("coupling_torque", "coupling_twist", "control_speed_error", "control_torque")
    variables |= dict.fromkeys(others, (("set", "law_point"), np.full((1, speed.size), np.nan)))
    variables |= {"law_memory": ("set", [0.0])}
    rig = simulated_rigs(xr.Dataset(variables, {"coordinate": list(COORDINATES)}))[1]
    assert rig.law is not None
    _, own = told.law.spline.drawn(windows[1].speed.mean())
    np.testing.assert_allclose(rig.law.torque, own, atol=0.05 * np.ptp(own))
    still = np.zeros(400)
    result = simulate(rig, still, still + windows[1].speed.mean(), still)
    np.testing.assert_allclose(result.bit_speed, windows[1].speed.mean(), rtol=1e-3)


def test_a_rig_that_cannot_be_simulated_keeps_its_verdict(
    growing: tuple[Examination, list[Series]], monkeypatch: pytest.MonkeyPatch
) -> None:
    examination, windows = growing
    # a wave passes the collars within such a step
    monkeypatch.setattr(law_window, "TIME_STEP", 0.02)
    told = with_law(examination, lambda row: (windows[row].sweep, windows[row].speed), RATE)
    assert told.law is None
    assert told.verdicts == examination.verdicts


def test_no_law_is_offered_of_a_damper() -> None:
    examination, windows = examined(SWEPT, 81)
    assert not learnt(examination, windows).offered
