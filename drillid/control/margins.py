"""Loop of the speed control, its margins and its stability.

The loop is opened where the torque command goes to the drive. With T_com = −A E (H ω + Z F T_string),
T_string = T_m − J s ω, T_m = D T_com and ω = T_m/(J_td s + Y_in), a unit of torque returns as −L,

    L(s) = D A E [(H − Z F J s)/(J_td s + Y_in) + Z F],

which is D e^(−sT_d) A H/(J_td s + Y_in) without feedback of the string's torque.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from drillid.arrays import Booleans, Complex, Floats, Integers
from drillid.errors import EstimationError
from drillid.physics.equipment import Controller, DrillingSystem, window_shape
from drillid.physics.responses import bit_mobility, laplace, string_admittance
from drillid.physics.top_drive import control, drive, matching_transfer

Loop = Callable[[Complex], Complex]
"""L of the Laplace variable (frequency,); the result may have leading axes."""

GRID = np.geomspace(1e-3, 50.0, 3000)
"""Hz; each mode of a string of a few kilometres spans some hundred points."""
_LARGEST_TURN = 0.2
"""rad; largest change of arg(1 + L) between neighbouring frequencies in the count of encirclements.

A mode that the control moves just across the imaginary axis makes it turn once within a band that may be narrower
than the first spacing of frequencies, and by little beside it.
"""
_MOST_HALVINGS = 24


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


def loop_transfer(system: DrillingSystem, s: Complex) -> Complex:
    """L(s) of the module docstring, dimensionless; broadcast shape of the system's parameters and s."""
    return _loop(system.top_drive.controller, _controlled(system, s), s)


class Loops:
    """Loops of one system under one controller after the other; what none of them changes is found once per grid."""

    def __init__(self, system: DrillingSystem) -> None:
        self._system = system
        self._known: dict[bytes, tuple[Complex, Complex]] = {}

    def under(self, controller: Controller) -> Loop:
        """L of the Laplace variable under a controller."""
        return lambda s: _loop(controller, self._controlled(s), s)

    def _controlled(self, s: Complex) -> tuple[Complex, Complex]:
        key = s.tobytes()
        if key not in self._known:
            self._known[key] = _controlled(self._system, s)
        return self._known[key]


def _controlled(system: DrillingSystem, s: Complex) -> tuple[Complex, Complex]:
    """D e^(−sT_d), dimensionless, and the top drive's speed per torque of its motor, 1/(J_td s + Y_in), rad/(N m s)."""
    return drive(system.top_drive, s), 1 / (system.top_drive.inertia * s + string_admittance(system, s))


def _loop(controller: Controller, controlled: tuple[Complex, Complex], s: Complex) -> Complex:
    driven, speed_per_torque = controlled
    speed_filter = 1 / (1 + s * controller.speed_filter)
    gain = driven * control(replace(controller, speed_filter=0.0), s)
    if controller.matching is None:
        loop: Complex = gain * speed_filter * speed_per_torque
        return loop
    reduction = matching_transfer(controller.matching, s)
    speed_loop = speed_filter - reduction * controller.matching.inertia * s
    return np.asarray(gain * (speed_loop * speed_per_torque + reduction), dtype=complex)


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


def unstable_poles(
    loop: Loop,
    *,
    integrating: Booleans | bool,
    open_loop: Integers | int = 0,
    lowest: float = 1e-4,
    highest: float = 200.0,
) -> Integers:
    """Poles of the closed loop in the right half plane by the Nyquist criterion.

    Where L itself has none, the phase of 1 + L changes by π/2 for a stable closed loop where L has an integrator, and
    by 0 where it has none, less π for each unstable pole; each pole of L adds π. Frequencies are inserted where the
    phase changes too much between neighbours.

    Parameters
    ----------
    integrating : whether L grows as 1/s towards low frequency
    open_loop : poles of L in the right half plane; both of the shape of the loop's leading axes, or one for all
    lowest, highest : Hz, beyond which the phase of 1 + L must be constant

    Returns
    -------
    Number of poles, in the shape of the loop's leading axes.

    Raises
    ------
    EstimationError
        If a pole lies on the imaginary axis, the phase of 1 + L still changes at the highest frequency, or L is not
        finite somewhere.
    """
    frequency = np.geomspace(lowest, highest, 1200)
    values = _return_difference(loop, frequency)
    for _ in range(_MOST_HALVINGS):
        steps = np.angle(values[..., 1:] / values[..., :-1])
        wide = np.abs(steps) > _LARGEST_TURN
        coarse = np.flatnonzero(wide.reshape(-1, wide.shape[-1]).any(axis=0))
        if coarse.size == 0:
            return _count(steps.sum(axis=-1), values, integrating) + open_loop
        between = np.sqrt(frequency[coarse] * frequency[coarse + 1])
        frequency = np.insert(frequency, coarse + 1, between)
        values = np.insert(values, coarse + 1, _return_difference(loop, between), axis=-1)
    raise EstimationError(
        "stability of the loop",
        "a pole lies on the imaginary axis",
        "Change the gains slightly; they are at the stability limit",
    )


def _return_difference(loop: Loop, frequency: Floats) -> Complex:
    """1 + L (..., frequency)."""
    values = 1 + np.asarray(loop(laplace(frequency)), dtype=complex)
    if not np.all(np.isfinite(values)):
        raise EstimationError(
            "stability of the loop", "its transfer is not finite at some frequency", "Check the system's parameters"
        )
    return values


def _count(turned: Floats, values: Complex, integrating: Booleans | bool) -> Integers:
    # beyond the grid 1 + L tends to ∓j∞ or a real number at low frequency, and to a positive one at high; +j∞ and a
    # negative number begin half a turn away on the positive real axis of s, as for an odd number of poles
    begin = np.where(integrating, -np.pi / 2, 0.0)
    beyond = np.angle((values[..., 0] * np.exp(-1j * begin)) ** 2) / 2 - np.angle(values[..., -1])
    poles = -(begin + turned + beyond) / np.pi
    whole = np.rint(poles)
    if np.max(np.abs(poles - whole)) > 1e-6:
        raise EstimationError(
            "stability of the loop", "the count of encirclements is not an integer", "Use a wider band"
        )
    return np.asarray(whole, dtype=np.int64)


def growing_poles(system: DrillingSystem) -> Integers:
    """Poles of L in the right half plane, in the shape of the system's samples.

    They are the growing motion of the rig under a constant torque of its drive, which only a bit whose torque falls
    with speed can feed. Counted by the ratio of the admittance at the bit to that with a strongly damped bit.
    """
    bit, shape = system.bit, window_shape(system)
    if not bit.cutting and np.all(np.asarray(bit.damping) >= 0):
        return np.zeros(shape, dtype=np.int64)
    free = replace(system, top_drive=replace(system.top_drive, controller=Controller(0.0)))
    calm = replace(free, bit=replace(bit, damping=system.string[-1].characteristic_admittance, cutting=()))
    poles = unstable_poles(lambda s: bit_mobility(calm, s) / bit_mobility(free, s) - 1, integrating=False)
    return np.broadcast_to(poles, shape)


def is_stable(system: DrillingSystem) -> bool:
    """Whether every sample of the system is stable under its speed control."""
    return is_stable_loop(lambda s: loop_transfer(system, s), system.top_drive.controller, growing_poles(system))


def is_stable_loop(loop: Loop, controller: Controller, open_loop: Integers | int = 0) -> bool:
    """Whether every sample of a loop under this controller is stable when closed; see `unstable_poles`."""
    integral = np.asarray(controller.integral)
    integrating = (integral[..., 0] if integral.ndim else integral) != 0
    return not np.any(unstable_poles(loop, integrating=integrating, open_loop=open_loop))
