"""Limits of a drive and play of its gear, sample by sample."""

import numpy as np

from drillid.arrays import Floats
from drillid.physics.kernel import compiled


@compiled
def rate_limited(series: Floats, steps: Floats) -> Floats:
    """A series (samples,) limited to each of several largest changes per sample (steps,); shape (steps, samples)."""
    limited = np.empty((steps.size, series.size))
    for row in range(steps.size):
        current, step = series[0], steps[row]
        for sample in range(series.size):
            current = min(max(series[sample], current - step), current + step)
            limited[row, sample] = current
    return limited


@compiled
def lacking_after_steps(series: Floats, step: float) -> tuple[Floats, Floats]:
    """Shortfall of a rate-limited torque from a command that is held between its samples.

    Each step of the command takes time to follow, however small it is.

    Parameters
    ----------
    series : (samples,) N m, the command
    step : N m, largest change of the torque in a sample interval

    Returns
    -------
    lacking : (samples,) N m, mean until the next sample
    centroid : (samples,) in time of the shortfall until then, in sample intervals
    """
    lacking, centroid = np.zeros(series.size), np.zeros(series.size)
    current = series[0]
    for sample in range(1, series.size):
        gap = series[sample] - current
        moved = min(max(gap, -step), step)
        share = min(abs(gap) / step, 1.0)
        lacking[sample] = gap - moved * (1 - share / 2)
        if share > 0:
            centroid[sample] = share**2 * (gap / 2 - moved / 3) / lacking[sample]
        current += moved
    return lacking, centroid


@compiled
def withheld_by_play(torque: Floats, step: float, inertia: float, half_play: float) -> Floats:
    """What a gear with play adds to the torque that a rigid gear would transmit, (samples,) N m.

    While the teeth are apart it transmits none. When they meet, without rebound, the motor gives back the momentum
    that it gained.

    Parameters
    ----------
    torque : (samples,) N m, through a rigid gear
    step : s, between samples
    inertia : kg m², above the gear
    half_play : rad
    """
    added = np.empty(torque.size)
    twist, speed = (half_play if torque[0] >= 0 else -half_play), 0.0
    for sample in range(torque.size):
        free = twist + step * (speed + step * torque[sample] / inertia)
        turned = min(max(free, -half_play), half_play)
        after = (turned - twist) / step
        added[sample] = inertia * (speed - after) / step
        twist, speed = turned, after
    return added
