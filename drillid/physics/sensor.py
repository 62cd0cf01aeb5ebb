"""Measurement chain: effect of a channel's sensor, filter and clock on the true signal.

A recorded response is the true response times the transfer function R of its signal's channel over that of the
reference's channel. The speed control feeds back its sensor's speed; a scale error of that sensor therefore changes
the rig itself, while a scale error of the record alone does not.
"""

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from drillid.arrays import Complex
from drillid.errors import SettingsError
from drillid.physics.dual_numbers import primal, vanishes
from drillid.physics.equipment import DrillingSystem, Quantity, Shaping
from drillid.physics.held_control import held_logarithm

_LEAST_RENEWAL = 1e-9
"""s, in place of zero in windows of their own samples, beside others whose samples are held."""


@dataclass(frozen=True)
class Recording:
    """How one channel is recorded, R(s) = c e^(−s t₀ + s²(σ² + v)/2 − s³κ/6) B(s) U(s); the defaults record the true
    signal.

    B is a Butterworth low pass (Butterworth 1930, Experimental Wireless 7, 536–541). Gaussian
    time-stamp jitter σ acts by the mean over its distribution, as does the jitter of a drive's delay. A signal that is
    renewed at intervals T is late by a uniformly distributed time, U(s) = (1 − e^(−sT))/(sT), where rows fall anywhere
    between two renewals.
    """

    scale: Quantity = 1.0
    """c, recorded per true value; −1 for a wrong sign."""
    clock_offset: Quantity = 0.0
    """t₀, s; positive where the row at time t holds the signal of t − t₀."""
    clock_jitter: Quantity = 0.0
    """σ, s, root mean square."""
    filter_frequency: Quantity = np.inf
    """Hz, half-power frequency of B."""
    filter_order: int = 2
    renewal: Quantity = 0.0
    """T, s; 0 where every row has a sample of its own."""
    shaping: Shaping | None = None
    """Further factor of R."""
    hold_variance: Quantity = 0.0
    """v, s², addition to the variance of the time stamps by readings between the steps of a held command, as in
    `drillid.physics.held_control`."""
    hold_skewness: Quantity = 0.0
    """κ, s³, addition to their third cumulant."""
    hold_higher: tuple[Quantity, Quantity] = (0.0, 0.0)
    """s⁴ and s⁵, additions to their fourth and fifth."""

    def __post_init__(self) -> None:
        if self.filter_order < 1:
            raise SettingsError("recording", f"a filter has no order {self.filter_order}", "Give 1 or more")

    @property
    def has_filter(self) -> bool:
        """Whether B is other than 1 in any window."""
        frequency = primal(self.filter_frequency)
        return frequency != np.inf if isinstance(frequency, float) else not np.all(np.isinf(frequency))

    @property
    def lateness(self) -> Quantity:
        """Mean time by which rows are late, t₀ + T/2, s."""
        return self.clock_offset + self.renewal / 2

    @property
    def variance(self) -> Quantity:
        """Variance of that time without a held command, σ² + T²/12, s²."""
        return self.clock_jitter * self.clock_jitter + self.renewal * self.renewal / 12

    @property
    def has_factor(self) -> bool:
        """Whether R has a factor beside scale, filter and cumulants of the lateness."""
        return self.shaping is not None or not vanishes(self.renewal)

    def factor(self, s: Complex) -> Any:
        """The further factor, and what lateness by a uniformly distributed time has beyond its mean and variance."""
        shaping = 1.0 if self.shaping is None else self.shaping.factor(s)
        if vanishes(self.renewal):
            return shaping
        half = s * (self.renewal + _LEAST_RENEWAL) / 2
        return shaping * np.sinh(half) / half * np.exp(-np.square(half) / 6)

    def transfer(self, s: Complex) -> Complex:
        """R(s), recorded per true signal; broadcasts, and is a Dual where a quantity or s is one."""
        higher = held_logarithm(s, self.hold_skewness, *self.hold_higher)
        clock = np.exp(np.square(s) * (self.variance + self.hold_variance) / 2 - s * self.lateness + higher)
        low_pass = _butterworth(s / (2 * np.pi * self.filter_frequency), self.filter_order)
        transfer: Complex = self.scale * clock / low_pass * self.factor(s)
        return transfer


def _butterworth(s: Any, order: int) -> Any:
    """Normalised Butterworth polynomial: 1 + s for an odd order, and 1 + 2 sin(θ) s + s² for each pair of zeros."""
    polynomial = 1 + s if order % 2 else 1 + 0 * s
    for pair in range(order // 2):
        angle = np.pi * (2 * pair + 1) / (2 * order)
        polynomial = polynomial * (1 + 2 * np.sin(angle) * s + np.square(s))
    return polynomial


def recorded(response: Any, s: Complex, signal: Recording, reference: Recording | None = None) -> Any:
    """A response as recorded.

    Parameters
    ----------
    response : true signal per true reference, as from drillid.physics.responses
    signal, reference : how the channel of each is recorded; None for a reference that is recorded exactly
    """
    result = response * signal.transfer(s)
    return result if reference is None else result / reference.transfer(s)


def sensed(system: DrillingSystem, scale: Quantity) -> DrillingSystem:
    """The rig whose speed control reads `scale` times the true speed.

    Its A H ω becomes A H c ω, so that the controller acts with c times its gains. With feedback of the string's torque,
    c A E Z/c F (T_m − c J s ω) leaves that loop unchanged but for the acceleration, which is read by the sensor too.
    """
    controller = system.top_drive.controller
    matching = controller.matching
    if matching is not None:
        matching = replace(matching, impedance=matching.impedance / scale, inertia=matching.inertia * scale)
    scaled = replace(
        controller,
        proportional=controller.proportional * scale,
        integral=controller.integral * scale,
        compensated_inertia=controller.compensated_inertia * scale,
        matching=matching,
    )
    return replace(system, top_drive=replace(system.top_drive, controller=scaled))
