"""What a law may be of: the bit's torque against its speed, with or without a memory, or a coupling's twist against its
torque; and what each adds to the record to first order in its curvature.

About the base model a law without a tangent answers the swing that the sweep makes at its place by a torque, or a
twist, of second order, whose way to the record is linear (the second-order Volterra kernel; Schetzen 1980, The Volterra
and Wiener Theories of Nonlinear Systems, chapter 3). By reciprocity it is the way from the top drive to that place.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.special import chdtrc

from drillid.arrays import Complex, Floats
from drillid.discrepancy.learning.law_window import LawWindow
from drillid.discrepancy.rules import NEIGHBOURS_SHARE_VARIANCE
from drillid.physics.bottom_end import above_motor, bit_load
from drillid.physics.equipment import DrillingSystem
from drillid.physics.line import input_admittance, speed_ratio
from drillid.physics.nonlinear import NonlinearRig, SpeedLaw, TwistLaw
from drillid.physics.responses import command_mobility
from drillid.physics.strings import String, cut
from drillid.physics.top_drive import torque_transfers

_MARGIN = 1.25
"""Compliance that a coupling is simulated with, per the least that keeps its twist from falling."""
_STAND = 30.0
"""m of pipe as compliant as a usual coupling."""
POWERS = (2, 3)
"""Of the swing, in the law's curves that are screened."""


@dataclass(frozen=True)
class LawKind:
    """One kind of law."""

    memory: float = 0.0
    """s, of a law of the bit."""
    place: float | None = None
    """Share of the string above a coupling; None of a law of the bit."""

    @property
    def element(self) -> str:
        """Its name in fingerprints."""
        if self.place is not None:
            return "law of a coupling"
        return "law of the bit" if self.memory == 0 else f"law of the bit with a memory of {self.memory:g} s"

    @property
    def family(self) -> str:
        """The port at which it acts."""
        if self.place is None or self.place == 1:
            return "bit"
        return "top" if self.place == 0 else "upper string" if self.place < 1 / 2 else "lower string"

    def mean(self, window: LawWindow) -> float:
        """What it acts on in the mean over a window, rad/s or N m."""
        return window.mean_speed if self.place is None else window.mean_torque

    def swing(self, window: LawWindow) -> Floats:
        """What it acts on less its mean, over one period of the sweep by the base model, rad/s or N m, (samples,)."""
        system, (s, sweep) = window.window_model.system, window.whole_sweep
        ratio, admittance = _at(system, 1.0 if self.place is None else self.place, s)
        lines = command_mobility(system, s) * sweep * ratio
        lines = lines / (1 + self.memory * s) if self.place is None else lines * admittance
        size = window.period.size
        return np.asarray(np.fft.irfft(size * np.append(0.0, lines), size), dtype=float)

    def scale(self, window: LawWindow) -> float:
        """Usual slope: the pipe's characteristic admittance, N m s/rad, or the compliance of a stand, rad/(N m)."""
        pipe = window.window_model.system.string[0]
        if self.place is None:
            return float(pipe.characteristic_admittance)
        return _STAND / float(pipe.shear_modulus * pipe.polar_moment)

    def recorded(self, window: LawWindow, answer: Floats) -> Complex:
        """Harmonics (lines,) of the record by a torque against the bit's rotation, or a twist, over a period."""
        ratio, admittance = _at(window.window_model.system, 1.0 if self.place is None else self.place, window.s)
        drive = torque_transfers(window.window_model.system.top_drive, window.s)[0]
        to_top = window.window_model.mobility(window.s) / drive * ratio
        way = -to_top if self.place is None else window.s * to_top * admittance
        return np.asarray(way * window.harmonics(answer), dtype=complex)

    def added(self, window: LawWindow, place: Floats, value: Floats) -> Complex:
        """Harmonics (lines,) that a law without a tangent at the mean adds to the record, simulated.

        Parameters
        ----------
        place, value : (points,), torques at speeds, N m and rad/s, or twists at torques, rad and N m
        """
        system = window.window_model.system
        if self.place is None:
            law = SpeedLaw(place, value, self.memory)
            with_law = window.simulated(NonlinearRig(system, law=law), window.mean_speed)
            return with_law - window.still
        depth = self.place * float(sum(section.length for section in system.string))
        # a compliance that both have keeps the twist from falling; at rest the torque is that about the mean
        least = _MARGIN * max(0.0, -float(np.diff(value).min()) / float(place[1] - place[0]))
        torque = place - window.mean_torque
        rigs = [
            NonlinearRig(system, coupling=TwistLaw(depth, torque, least * torque + twist))
            for twist in (value, 0.0 * value)
        ]
        bent, straight = (window.simulated(rig, 0.0) for rig in rigs)
        return bent - straight


KINDS = (
    LawKind(),
    *(LawKind(memory=memory) for memory in (0.3, 1.0, 3.0)),
    *(LawKind(place=place) for place in (0.0, 0.25, 0.5, 0.75, 1.0)),
)
"""Kinds that are tried."""


def _at(system: DrillingSystem, place: float, s: Complex) -> tuple[Complex, Complex]:
    """Speed at a place per that of the top drive, and the admittance below it, N m s/rad."""
    upper: String = system.string
    lower: String = ()
    if place < 1:
        upper, lower = cut(system.string, place * float(sum(section.length for section in system.string)))
    load = above_motor(system.motor, bit_load(system.bit, s), s)
    for section in reversed(lower):
        load = input_admittance(section, load, s)
    ratio, below = np.ones_like(s), load
    for section in reversed(upper):
        ratio, load = ratio * speed_ratio(section, load, s), input_admittance(section, load, s)
    return ratio, below


@dataclass(frozen=True, eq=False)
class Screened:
    """What a kind of law explains to first order in its curves."""

    kind: LawKind
    statistic: float
    """χ² of as many degrees of freedom as POWERS."""
    p_value: float


def screened(windows: Sequence[LawWindow], kept: Sequence[Any] | None = None) -> list[Screened]:
    """Score tests of every kind of law, in the lines (W, lines) that are kept.

    What neither the base model nor the law explains counts as noise.
    """
    lines = [np.ones(window.s.size, dtype=bool) for window in windows] if kept is None else kept
    rest = [window.residual[used] for window, used in zip(windows, lines, strict=True)]
    squares, count = sum(float(np.sum(np.abs(each) ** 2)) for each in rest), 2 * sum(each.size for each in rest)
    excess = NEIGHBOURS_SHARE_VARIANCE * max(squares / max(count, 1), 1.0)
    return [_screened(kind, windows, lines, rest, excess) for kind in KINDS]


def _screened(
    kind: LawKind, windows: Sequence[LawWindow], kept: Sequence[Any], rest: Sequence[Complex], excess: float
) -> Screened:
    swings = [kind.swing(window) for window in windows]
    largest = max(float(np.abs(swing).max()) for swing in swings)
    matrix, vector = np.zeros((len(POWERS), len(POWERS))), np.zeros(len(POWERS))
    for window, used, swing, residual in zip(windows, kept, swings, rest, strict=True):
        curves = [kind.recorded(window, (swing / largest) ** power) / window.error for power in POWERS]
        columns = np.stack([curve[used] for curve in curves])
        matrix += (columns.conj() @ columns.T).real
        vector += (columns.conj() @ residual).real
    statistic = float(vector @ np.linalg.lstsq(matrix, vector)[0]) / excess
    return Screened(kind, statistic, float(chdtrc(len(POWERS), statistic)))


def law_p_value(windows: Sequence[LawWindow]) -> float:
    """p-value of the base model against a law of any kind (Bonferroni)."""
    return min(len(KINDS) * min(each.p_value for each in screened(windows)), 1.0)
