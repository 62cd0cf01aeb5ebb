"""The far end of the measurement: what sensor, filter and clock of a channel make of the true signal.

A recorded response is the true one times the transfer R of its signal's channel, over that of the channel that it
is referred to. What the speed control feeds back is its sensor's speed; a scale of that sensor therefore changes
the rig itself, while one of the record alone does not.
"""

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from drillid.arrays import Complex
from drillid.errors import SettingsError
from drillid.physics.equipment import DrillingSystem, Figure


@dataclass(frozen=True)
class Recording:
    """How one channel is recorded, R(s) = c e^(−s t₀ + s²σ²/2) B(s); the defaults show the truth.

    B is a Butterworth low pass (Butterworth 1930, Experimental Wireless 7, 536–541). Time stamps of normal jitter
    σ act by their mean, as does the jitter of a drive's delay.
    """

    scale: Figure = 1.0
    """c, recorded per true value; −1 for a wrong sign."""
    clock_offset: Figure = 0.0
    """t₀, s; positive where the row at time t shows the signal of t − t₀."""
    clock_jitter: Figure = 0.0
    """σ, s, root mean square."""
    filter_frequency: Figure = np.inf
    """Hz, where B passes half the power."""
    filter_order: int = 2

    def __post_init__(self) -> None:
        if self.filter_order < 1:
            raise SettingsError("recording", f"a filter has no order {self.filter_order}", "Give 1 or more")

    def transfer(self, s: Complex) -> Complex:
        """R(s), recorded per true signal; broadcasts, and is a Dual where a figure or s is one."""
        clock = np.exp(np.square(s * self.clock_jitter) / 2 - s * self.clock_offset)
        transfer: Complex = (
            self.scale * clock / _butterworth(s / (2 * np.pi * self.filter_frequency), self.filter_order)
        )
        return transfer


def _butterworth(s: Any, order: int) -> Any:
    """Normalised Butterworth polynomial: 1 + s for an odd order, and 1 + 2 sin(θ) s + s² for each pair of zeros."""
    polynomial = 1 + s if order % 2 else 1 + 0 * s
    for pair in range(order // 2):
        angle = np.pi * (2 * pair + 1) / (2 * order)
        polynomial = polynomial * (1 + 2 * np.sin(angle) * s + np.square(s))
    return polynomial


def recorded(response: Any, s: Complex, signal: Recording, reference: Recording | None = None) -> Any:
    """A response as the records show it.

    Parameters
    ----------
    response : true signal per true reference, of any drillid.physics.responses
    signal, reference : how the channel of each is recorded; a reference without one is recorded as it is
    """
    seen = response * signal.transfer(s)
    return seen if reference is None else seen / reference.transfer(s)


def sensed(system: DrillingSystem, scale: Figure) -> DrillingSystem:
    """The rig whose speed control reads `scale` times the true speed.

    Its A H ω becomes A H c ω, so the controller acts as one of c times the gains. Where it feeds the string's torque
    back, c A E Z/c F (T_m − c J s ω) holds that loop as it is but for the acceleration, which the sensor gives too.
    """
    controller = system.top_drive.controller
    matching = controller.matching
    if matching is not None:
        matching = replace(matching, impedance=matching.impedance / scale, inertia=matching.inertia * scale)
    seeing = replace(
        controller,
        proportional=controller.proportional * scale,
        integral=controller.integral * scale,
        compensated_inertia=controller.compensated_inertia * scale,
        matching=matching,
    )
    return replace(system, top_drive=replace(system.top_drive, controller=seeing))
