"""Loop of the speed control, and the poles of the rig under it in the right half plane.

The loop is opened where the torque command goes to the drive. With T_com = −A E (H ω + Z F T_string),
T_string = T_m − J s ω, T_m = D T_com and ω = T_m/(J_td s + Y_in), a unit of torque returns as −L,

    L(s) = D A E [(H − Z F J s)/(J_td s + Y_in) + Z F],

which is D e^(−sT_d) A H/(J_td s + Y_in) without feedback of the string's torque.
"""

from collections.abc import Callable
from dataclasses import replace
from functools import partial

import numpy as np

from drillid.arrays import Booleans, Complex, Floats, Integers
from drillid.errors import EstimationError
from drillid.physics.dual_numbers import primal
from drillid.physics.equipment import Controller, DrillingSystem, window_shape
from drillid.physics.responses import bit_mobility, laplace, string_admittance
from drillid.physics.top_drive import control, drive, matching_transfer

Loop = Callable[[Complex], Complex]
"""L of the Laplace variable (frequency,); the result may have leading axes."""

_LARGEST_TURN = 0.2
"""rad; largest change of arg(1 + L) between neighbouring frequencies in the count of encirclements.

A mode that the control moves just across the imaginary axis makes it turn once within a band that may be narrower
than the first spacing of frequencies, and by little beside it.
"""
_MOST_HALVINGS = 24


def loop_transfer(system: DrillingSystem, s: Complex) -> Complex:
    """L(s) of the module docstring, dimensionless; broadcast shape of the system's parameters and s."""
    return loop_under(system.top_drive.controller, controlled(system, s), s)


def controlled(system: DrillingSystem, s: Complex) -> tuple[Complex, Complex]:
    """D e^(−sT_d), dimensionless, and the top drive's speed per torque of its motor, 1/(J_td s + Y_in), rad/(N m s)."""
    return drive(system.top_drive, s), 1 / (system.top_drive.inertia * s + string_admittance(system, s))


def loop_under(controller: Controller, plant: tuple[Complex, Complex], s: Complex) -> Complex:
    """L under a controller of what it acts on, as from `controlled`."""
    driven, speed_per_torque = plant
    speed_filter = 1 / (1 + s * controller.speed_filter)
    gain = driven * control(replace(controller, speed_filter=0.0), s)
    if controller.matching is None:
        loop: Complex = gain * speed_filter * speed_per_torque
        return loop
    reduction = matching_transfer(controller.matching, s)
    speed_loop = speed_filter - reduction * controller.matching.inertia * s
    return np.asarray(gain * (speed_loop * speed_per_torque + reduction), dtype=complex)


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
    with speed can feed.
    """
    shape, feeding = window_shape(system), _feeding(system)
    poles = 0 if feeding is None else unstable_poles(feeding, integrating=False)
    return np.broadcast_to(np.asarray(poles, dtype=np.int64), shape)


def _feeding(system: DrillingSystem) -> Loop | None:
    """Admittance at the bit over that with a strongly damped bit, less one; None where the bit feeds no vibration."""
    bit = system.bit
    if not bit.cutting and np.all(np.asarray(primal(bit.damping)) >= 0):
        return None
    free = replace(system, top_drive=replace(system.top_drive, controller=Controller(0.0)))
    calm = replace(free, bit=replace(bit, damping=system.string[-1].characteristic_admittance, cutting=()))
    return lambda s: bit_mobility(calm, s) / bit_mobility(free, s) - 1


def is_integrating(controller: Controller) -> Booleans:
    """Whether L grows as 1/s towards low frequency, in the shape of the controller's samples."""
    integral = np.asarray(primal(controller.integral))
    return np.asarray((integral[..., 0] if integral.ndim else integral) != 0)


def unstable_windows(system: DrillingSystem) -> Booleans:
    """Whether each window's motion grows under its speed control; windows whose parameters are NaN do not.

    Quantities may be Duals.

    Raises
    ------
    EstimationError
        As `unstable_poles`.
    """

    def known(loop: Loop) -> Loop:
        def values(s: Complex) -> Complex:
            with np.errstate(invalid="ignore"):
                transfer = np.asarray(primal(loop(s)), dtype=complex)
            return np.where(np.isnan(transfer).any(axis=-1, keepdims=True), 0.0, transfer)

        return values

    feeding, integrating = _feeding(system), is_integrating(system.top_drive.controller)
    growing = 0 if feeding is None else unstable_poles(known(feeding), integrating=False)
    loop = known(partial(loop_transfer, system))
    return np.asarray(unstable_poles(loop, integrating=integrating, open_loop=growing) > 0)
