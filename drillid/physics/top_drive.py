"""The upper end: drive, speed control and the top drive's inertia (paper, figure 1).

The drive's torque on the inertia is T_m = W T_sweep − V ω (N m), with ω the top drive's speed; W is the
`command_transfer`, V the `feedback`. The torque into the string is T_m − J_td s ω.
"""

from dataclasses import replace
from typing import Any

import numpy as np

from drillid.arrays import Complex, Floats
from drillid.physics.equipment import Controller, ImpedanceMatching, TopDrive
from drillid.physics.held_control import held_logarithm


def control(controller: Controller, s: Complex, interval: Any = 0.0) -> Complex:
    """A E H (N m s/rad): reduction of the torque command per speed, without feedback of the string's torque.

    A = P + I/s − J_c s/(1 + s τ_c): P, PI, or PI with inertia compensation (Kyllingstad and Nessjøen 2009,
    SPE/IADC 119660).

    Parameters
    ----------
    interval : s, at which a computer evaluates A E by the trapezoidal rule, s → 2/h tanh(sh/2) (Åström and Wittenmark
        1997, Computer-Controlled Systems, chapter 8); other rules for the integral differ by a multiple of I h/2 in P.
        H, before the reading, is analogue. 0 where control is continuous.
    """
    half = 0.5 * interval
    computed = np.tanh(s * half) / half if np.any(half) else s
    filtered: Complex = _unfiltered(controller, computed) / (1 + s * controller.speed_filter)
    return filtered


def _unfiltered(controller: Controller, s: Complex) -> Any:
    """A E, N m s/rad."""
    compensation = controller.compensated_inertia * s / (1 + s * controller.compensation_filter)
    return after_gains(controller, s, controller.proportional + controller.integral / s - compensation)


def after_gains(controller: Controller, s: Complex, torque: Any = 1.0) -> Any:
    """The torque of the control's gains as commanded, after its further factor and torque filter."""
    shaped = torque if controller.shaping is None else torque * controller.shaping.factor(s)
    return shaped / (1 + s * controller.torque_filter)


def gain_responses(controller: Controller, s: Complex) -> Complex:
    """What P and I each contribute to the control's response, (2, frequency), N m s/rad."""
    alone = (replace(controller, integral=0.0), replace(controller, proportional=0.0))
    return np.stack([control(replace(part, compensated_inertia=0.0), s) for part in alone])


def with_gains(controller: Controller, factors: Floats) -> Controller:
    """The controller with P and I times factors (2,)."""
    proportional, integral = controller.proportional * factors[0], controller.integral * factors[1]
    return replace(controller, proportional=proportional, integral=integral)


def matching_transfer(matching: ImpedanceMatching, s: Complex) -> Complex:
    """Z F, rad/(N m s): reduction of the set-point speed per string torque."""
    transfer: Complex = matching.impedance / (1 + s * matching.low_pass)
    if matching.high_pass is not None:
        lagging = s * matching.high_pass
        transfer = transfer * lagging / (1 + lagging)
    return transfer


def drive(top_drive: TopDrive, s: Complex) -> Complex:
    """D e^(−sT_d + s²(σ² + v)/2 − s³κ/6): motor torque per commanded torque, with gain, first-order lag and delay.

    A delay with Gaussian jitter σ that is drawn anew faster than the rig responds acts by its mean, the moment
    generating function of the jitter. Control that samples and holds adds v to its variance, and a third cumulant κ.
    """
    variance = top_drive.delay_jitter * top_drive.delay_jitter + top_drive.hold_variance
    higher = held_logarithm(s, top_drive.hold_skewness, *top_drive.hold_higher)
    delayed = np.exp(np.square(s) * variance / 2 - s * top_drive.delay + higher)
    torque: Complex = top_drive.gain * delayed / (1 + s * top_drive.lag)
    return torque if top_drive.shaping is None else torque * top_drive.shaping.factor(s)


def torque_transfers(top_drive: TopDrive, s: Complex) -> tuple[Complex, Complex]:
    """W and V of T_m = W T_sweep − V ω.

    Without feedback of the string's torque W = D and V = D A E H. With it, T_com = −A E (H ω + Z F T_string),
    T_string = T_m − J s ω and T_m = D (T_sweep + T_com) give

        W = D/(1 + D A E Z F),   V = D A E (H − Z F J s)/(1 + D A E Z F),

    so that J_td s + V → 1/(Z F) for a stiff controller, a prompt drive and J = J_td.

    Returns
    -------
    command_transfer : W, dimensionless
    feedback : V, N m s/rad
    """
    controller, driven = top_drive.controller, drive(top_drive, s)
    if controller.matching is None:
        return driven, driven * control(controller, s)
    reduction = matching_transfer(controller.matching, s)
    loop, closing = driven * _unfiltered(controller, s), matching_denominator(top_drive, s)
    speed_filter = 1 / (1 + s * controller.speed_filter)
    return driven / closing, loop * (speed_filter - reduction * controller.matching.inertia * s) / closing


def matching_denominator(top_drive: TopDrive, s: Complex) -> Any:
    """1 + D A E Z F, the denominator of W and V, dimensionless; 1 without feedback of the string's torque."""
    controller = top_drive.controller
    if controller.matching is None:
        return 1.0
    return 1 + drive(top_drive, s) * _unfiltered(controller, s) * matching_transfer(controller.matching, s)


def top_admittance(top_drive: TopDrive, s: Complex) -> Complex:
    """Y_top = J_td s + V, terminating the string at its upper end, N m s/rad."""
    admittance: Complex = top_drive.inertia * s + torque_transfers(top_drive, s)[1]
    return admittance
