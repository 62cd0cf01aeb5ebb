"""Schedule of a stand as drilled, and torque noise that varies along it."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from drillid.arrays import Booleans, Floats
from drillid.errors import SettingsError


@dataclass(frozen=True)
class StandSchedule:
    """One stand from standstill to standstill: start of rotation, bit set on bottom, drilling, connection."""

    speed: float
    """rad/s, set point while drilling."""
    weight: float
    """N, on the bit while drilling."""
    start: float = 10.0
    """s, at rest before the rotation starts."""
    speeding_up: float = 10.0
    """s, from rest to full speed; the same for slowing down."""
    off_bottom: float = 20.0
    """s, at full speed before the bit is set on bottom, and after it is lifted."""
    setting_down: float = 10.0
    """s, until the bit carries its full weight; the same for lifting."""
    drilling: float = 600.0
    """s, at full speed and weight."""
    connection: float = 60.0
    """s, at rest at the end."""

    def __post_init__(self) -> None:
        ramps, holds = (self.speeding_up, self.setting_down), (self.start, self.off_bottom, self.drilling)
        if min(ramps) <= 0 or min(*holds, self.connection, self.speed, self.weight) < 0:
            raise SettingsError(
                "stand", "a duration, the speed or the weight is negative, or a ramp has no length", "Correct it"
            )

    @property
    def duration(self) -> float:
        """Seconds of the whole stand."""
        return float(self._corners()[-1])

    def _corners(self) -> Floats:
        lengths = [self.start, self.speeding_up, self.off_bottom, self.setting_down, self.drilling]
        lengths += [self.setting_down, self.off_bottom, self.speeding_up, self.connection]
        return np.concatenate([[0.0], np.cumsum(lengths)])

    def speed_set(self, time: Floats) -> Floats:
        """Set point (rad/s) at times in s since the stand's beginning; zero before and after it."""
        corners = self._corners()
        return self.speed * np.interp(time, corners[[1, 2, 7, 8]], [0.0, 1.0, 1.0, 0.0])

    def weight_on_bit(self, time: Floats) -> Floats:
        """Weight on the bit (N) at times in s since the stand's beginning."""
        corners = self._corners()
        return self.weight * np.interp(time, corners[[3, 4, 5, 6]], [0.0, 1.0, 1.0, 0.0])

    def is_drilling(self, time: Floats) -> Booleans:
        """Times of full speed and weight."""
        corners = self._corners()
        return np.asarray((time >= corners[4]) & (time < corners[5]), dtype=bool)


def varying_noise(
    generator: np.random.Generator, time_step: float, rms: ArrayLike, bandwidth: ArrayLike, samples: int
) -> Floats:
    """Gaussian noise through a first-order low pass, with rms and corner frequency that vary in time.

    Parameters
    ----------
    time_step : s
    rms : root mean square, one or (samples,), applied behind the filter
    bandwidth : Hz, corner frequency of the low pass, one or (samples,)
    samples : length of the noise

    Returns
    -------
    (samples,) in the unit of `rms`. Unevenly cut rock is best simulated by such noise on the weight on bit,
    which never drives the bit.
    """
    memory = np.exp(-2 * np.pi * np.broadcast_to(np.asarray(bandwidth, dtype=float), samples) * time_step)
    steps = generator.standard_normal(samples)
    steps[1:] *= np.sqrt(1 - memory[1:] ** 2)
    unit = np.empty(samples)
    state = 0.0
    for number, (kept, step) in enumerate(zip(memory.tolist(), steps.tolist(), strict=True)):
        state = step + kept * state if number else step
        unit[number] = state
    return np.asarray(np.broadcast_to(np.asarray(rms, dtype=float), samples) * unit, dtype=float)
