"""Margins of the loop of the speed control, and its stability."""

from dataclasses import dataclass

import numpy as np

from drillid.arrays import Complex, Floats, Integers
from drillid.physics.equipment import Controller, DrillingSystem
from drillid.physics.responses import laplace
from drillid.physics.stability import (
    Loop,
    controlled,
    growing_poles,
    is_integrating,
    loop_transfer,
    loop_under,
    unstable_poles,
)

GRID = np.geomspace(1e-3, 50.0, 3000)
"""Hz; each mode of a string of a few kilometres spans some hundred points."""


@dataclass(frozen=True, eq=False)
class Margins:
    """Distances from instability, each of the shape of the loop's leading axes."""

    gain: Floats
    """Least factor above 1 by which the gain may grow; infinite without any."""
    gain_reduction: Floats
    """Largest factor below 1 to which the gain may fall; 0 without any."""
    phase: Floats
    """Least lag at a crossover, rad, that makes the loop unstable; infinite without crossover."""
    delay: Floats
    """Least further delay, s, that makes the loop unstable; infinite without crossover."""
    modulus: Floats
    """Least distance of L from −1, 1/(largest sensitivity)."""

    @property
    def sensitivity(self) -> Floats:
        """Largest sensitivity, max |1/(1 + L)|."""
        return np.asarray(1 / self.modulus, dtype=float)


class Loops:
    """Loops of one system under one controller after the other; what none of them changes is found once per grid."""

    def __init__(self, system: DrillingSystem) -> None:
        self._system = system
        self._known: dict[bytes, tuple[Complex, Complex]] = {}

    def under(self, controller: Controller) -> Loop:
        """L of the Laplace variable under a controller."""
        return lambda s: loop_under(controller, self._controlled(s), s)

    def _controlled(self, s: Complex) -> tuple[Complex, Complex]:
        key = s.tobytes()
        if key not in self._known:
            self._known[key] = controlled(self._system, s)
        return self._known[key]


def margins(loop: Loop, frequency: Floats = GRID) -> Margins:
    """Margins of a loop that is stable when closed, read from L on a grid (Hz) with crossings in between.

    Crossings of the unit circle and of the negative real axis are interpolated linearly in log |L| and phase; the
    modulus margin is the least distance of −1 from the chords between neighbouring points.
    """
    values = np.asarray(loop(laplace(frequency)), dtype=complex)
    chord = np.diff(values, axis=-1)
    span = np.maximum(np.abs(chord) ** 2, np.finfo(float).tiny)
    along = np.clip(np.real(-(1 + values[..., :-1]) * np.conj(chord)) / span, 0, 1)
    modulus = np.min(np.abs(1 + values[..., :-1] + along * chord), axis=-1)
    size, turn = np.log(np.abs(values)), np.angle(-values)
    step = np.angle(values[..., 1:] / values[..., :-1])
    gain, reduction = _gain_margins(size, turn, step)
    phase, delay = _phase_margins(size, turn, step, frequency)
    return Margins(gain, reduction, phase, delay, modulus)


def _gain_margins(size: Floats, turn: Floats, step: Floats) -> tuple[Floats, Floats]:
    """From |L| where its phase passes −180°, excluding jumps by a full turn; (...) each."""
    start, end = turn[..., :-1], turn[..., :-1] + step
    crosses = (start * end <= 0) & (step != 0)
    share = np.divide(-start, step, out=np.zeros_like(step), where=step != 0)
    at_crossing = size[..., :-1] + share * np.diff(size, axis=-1)
    gain = np.exp(np.min(np.where(crosses & (at_crossing < 0), -at_crossing, np.inf), axis=-1))
    reduction = np.exp(np.max(np.where(crosses & (at_crossing >= 0), -at_crossing, -np.inf), axis=-1))
    return gain, reduction


def _phase_margins(size: Floats, turn: Floats, step: Floats, frequency: Floats) -> tuple[Floats, Floats]:
    """Least phase margin at |L| = 1, and least delay that uses it up; (...) each."""
    rise = np.diff(size, axis=-1)
    crosses = (size[..., :-1] * size[..., 1:] <= 0) & (rise != 0)
    share = np.divide(-size[..., :-1], rise, out=np.zeros_like(rise), where=rise != 0)
    angle = turn[..., :-1] + share * step
    speed = 2 * np.pi * (frequency[:-1] + share * np.diff(frequency))
    phase = np.min(np.where(crosses, np.abs(angle), np.inf), axis=-1)
    delay = np.min(np.where(crosses, np.mod(angle, 2 * np.pi) / speed, np.inf), axis=-1)
    return phase, delay


def is_stable(system: DrillingSystem) -> bool:
    """Whether every sample of the system is stable under its speed control."""
    return is_stable_loop(lambda s: loop_transfer(system, s), system.top_drive.controller, growing_poles(system))


def is_stable_loop(loop: Loop, controller: Controller, open_loop: Integers | int = 0) -> bool:
    """Whether every sample of a loop under this controller is stable when closed; see `unstable_poles`."""
    return not np.any(unstable_poles(loop, integrating=is_integrating(controller), open_loop=open_loop))
