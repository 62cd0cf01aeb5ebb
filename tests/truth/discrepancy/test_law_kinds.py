"""Kinds of laws: what each adds to the record is what the simulator adds; a law with a memory and a coupling are
learnt, and linear rigs seldom show a law.
"""

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import pytest

from drillid.arrays import Floats
from drillid.discrepancy.gather import Series
from drillid.discrepancy.learning.examined_law import law_windows, with_law
from drillid.discrepancy.learning.law import LearntLaw, learnt_law
from drillid.discrepancy.learning.law_kinds import KINDS, BitLaw, ControlLaw, CouplingLaw, LawKind, law_p_value
from drillid.discrepancy.learning.law_spline import LawSpline
from drillid.discrepancy.learning.law_window import LawWindow
from drillid.discrepancy.verdicts.examination import Examination
from drillid.discrepancy.verdicts.verdict import NONE, UNKNOWN, Verdict
from drillid.physics.nonlinear import ErrorLaw, NonlinearRig, SpeedLaw, TwistLaw
from tests.simulated import RATE, Truth
from tests.truth.discrepancy.test_learnt_law import DRAG, SWEPT, Growing, examined

MEMORY = 1.0
SOFT, SOFTER = 2e-4, 8e-7
"""rad/(N m) and rad/(N m)²: a coupling twists by SOFT T + SOFTER T²/2, T the torque above that in the mean."""

HARDER = 400.0
"""N m s³/rad³."""


@dataclass(frozen=True)
class Following(Truth):
    """A rig with a drag at the bit that bends with a speed that follows the bit's."""

    @property
    def system(self) -> NonlinearRig:
        """All of the equipment."""
        speed = np.linspace(-20.0, 60.0, 801)
        return NonlinearRig(super().system, law=SpeedLaw(speed, 3 * DRAG * (speed - 10.5) ** 2, MEMORY))


@dataclass(frozen=True)
class Coupled(Truth):
    """A rig with a coupling half way down that softens as its torque rises."""

    @property
    def system(self) -> NonlinearRig:
        """All of the equipment."""
        torque = np.linspace(-245.0, 245.0, 99) + self.bit_torque
        above = torque - self.bit_torque
        return NonlinearRig(
            super().system, coupling=TwistLaw(0.5 * self.bit_depth, torque, SOFT * torque + SOFTER * above**2 / 2)
        )


@dataclass(frozen=True)
class Hardening(Truth):
    """A rig whose control has a gain that grows by HARDER times the squared speed error."""

    @property
    def system(self) -> NonlinearRig:
        """All of the equipment."""
        error = np.linspace(-4.0, 4.0, 801)
        return NonlinearRig(super().system, control_law=ErrorLaw(error, HARDER * error**3 / 3))


def windows_of(examination: Examination, series: list[Series]) -> list[LawWindow]:
    """Their windows."""

    def channels(row: int) -> tuple[Floats, Floats]:
        return series[row].sweep, series[row].speed

    return law_windows(examination, channels, RATE)


@pytest.fixture(scope="module")
def linear() -> list[LawWindow]:
    """Windows of a rig without a law."""
    return windows_of(*examined(SWEPT, 91))


@pytest.mark.parametrize("kind", KINDS, ids=str)
def test_what_a_law_adds_to_first_order_is_what_the_simulator_adds(linear: list[LawWindow], kind: LawKind) -> None:
    window = linear[0]
    mean, swing = kind.mean(window), kind.swing(window)
    largest = float(np.abs(swing).max())
    bend = 0.05 * kind.scale(window) / largest
    law = LawSpline(np.array([mean]), np.array([bend]), mean - largest, mean + largest)
    simulated, to_first_order = kind.added(window, *law.drawn(mean)), kind.recorded(window, bend / 2 * swing**2)
    # the simulator puts a coupling at the nearest spring, half an element from where a short assembly's torque vanishes
    assert np.linalg.norm(simulated - to_first_order) < 0.35 * np.linalg.norm(simulated)


def test_linear_rigs_seldom_show_a_law(linear: list[LawWindow]) -> None:
    windows = [*linear, *windows_of(*examined(SWEPT, 93)), *windows_of(*examined(SWEPT, 95))]
    p_values = [law_p_value([window]) for window in windows]
    assert min(p_values) > 0.005
    assert np.median(p_values) > 0.1


def learnt(truth: Truth, seed: int) -> LearntLaw:
    """The law of two windows of a rig."""
    return learnt_law(windows_of(*examined(truth, seed)))


def test_a_drag_with_a_memory_is_learnt_with_its_size() -> None:
    found = learnt(Following(**vars(replace(SWEPT, bit_noise=20.0))), 97)
    assert found.offered
    assert found.kind == BitLaw(MEMORY)
    rise, error = found.change
    own = found.spline
    assert abs(rise - 6 * DRAG * (own.high - own.low)) < 3 * error + 0.2 * rise
    assert "with a memory of 1 s" in found.words
    assert "a drag of" in found.fingerprint.resembles


def test_a_coupling_that_softens_is_learnt_with_its_size() -> None:
    found = learnt(Coupled(**vars(replace(SWEPT, bit_noise=10.0))), 99)
    assert found.offered
    assert isinstance(found.kind, CouplingLaw)
    assert abs(found.kind.at - 0.5) <= 0.25
    rise, error = found.change
    own = found.spline
    # the base model lacks the coupling's own compliance, by which the torque there swings otherwise
    assert rise / (own.high - own.low) == pytest.approx(SOFTER, rel=0.5)
    assert rise > 3 * error
    assert "softens" in found.fingerprint.resembles


def test_a_gain_that_grows_with_the_error_is_learnt_with_its_size() -> None:
    found = learnt(Hardening(**vars(SWEPT)), 101)
    assert found.offered
    assert found.kind == ControlLaw()
    (value,), (variance,) = found.fingerprint.described[0].values, np.diag(found.fingerprint.described[0].covariance)
    # other parameters of the base model have taken some of it
    assert value == pytest.approx(HARDER, rel=0.35)
    assert value > 3 * np.sqrt(variance)
    assert "a gain of the speed control" in found.fingerprint.resembles


def test_a_law_that_surely_shows_makes_unknown_of_none() -> None:
    examination, series = examined(Growing(**vars(SWEPT)), 71)
    (before,) = examination.verdicts
    nothing = replace(before, verdict=NONE, family="")

    def told(verdict: Verdict, **changed: Any) -> Examination:
        own = replace(examination, verdicts=(verdict,), **changed)
        return with_law(own, lambda row: (series[row].sweep, series[row].speed), RATE)

    (verdict,) = told(nothing).verdicts
    assert verdict.verdict == UNKNOWN
    assert verdict.family == "bit"
    assert "where all is linear" in verdict.evidence
    assert told(nothing).fingerprint is not None
    named = replace(before, verdict="quantisation", family="sensor")
    first, second = told(named).verdicts
    assert first == named
    assert second.verdict == UNKNOWN
