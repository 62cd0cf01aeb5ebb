"""Responses in time: the inverse Laplace transform by one FFT, right of the imaginary axis.

On the line s = a + jω the transform belongs to the response times e^(−at), so that the periodic images of
the FFT are smaller by e^(−a period) (Dubner and Abate 1968, Journal of the ACM 15, 115–123). The remaining
error is truncation at the highest frequency; callers first subtract steps and kinks in closed form.
"""

from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np
from scipy.fft import irfft, next_fast_len

from drillid.arrays import Booleans, Complex, Floats
from drillid.errors import EstimationError
from drillid.physics.dual_numbers import linear, primal
from drillid.physics.equipment import DrillingSystem, TopDrive
from drillid.physics.responses import _bit_alone, bit_mobility, command_mobility
from drillid.physics.stability import unstable_windows
from drillid.physics.top_drive import drive

IMAGES = 1e-9
"""Size of the periodic images."""
FINEST_INTERVAL_S = 0.004
"""Spacing in time at which the transform is computed."""

_PERIODS = 4
"""Period of the images in durations; the longer, the less e^(at) amplifies the truncation error."""
_LARGEST_IMAGE = 1e-3
"""Largest image of a growing response, relative to its largest value."""

Steps = tuple[Floats, Floats]
_LEAST_LAG = 1e-9
"""s; represents a drive without lag."""


def inverse_laplace(transform: Callable[[Complex], Any], duration: float, interval: float) -> tuple[Floats, Any]:
    """Response in time of a transform without steps.

    The line lies at Re s = 5.2/duration. A response that grows faster than e^(3.4 t/duration) is spoilt by its
    images; such an unstable system raises an error or, among windows, gives a row of NaN.

    Parameters
    ----------
    transform : takes s of shape (frequency,), returns an array or a Dual of shape (..., frequency)
    duration, interval : length and spacing of the lags, s

    Returns
    -------
    lags : shape (lag,), s, from 0
    response : shape (..., lag); a Dual where the transform is one

    Raises
    ------
    EstimationError
        If the transform is that of a single unstable system.
    """
    lags = np.arange(0.0, duration + interval / 2, interval)
    oversampling = int(np.ceil(interval / FINEST_INTERVAL_S))
    points = next_fast_len(_PERIODS * lags.size * oversampling, real=True)
    period = points * interval / oversampling
    shift = -np.log(IMAGES) / period
    s = shift + 2j * np.pi * np.arange(points // 2 + 1) / period
    rising = np.exp(shift * lags) * points / period

    with np.errstate(invalid="ignore"):
        # windows whose parameters are NaN stay NaN without a warning
        spectrum = transform(s)
    wrapped = linear(lambda values: np.asarray(irfft(values, points)), spectrum)
    response = linear(lambda series: series[..., : lags.size * oversampling : oversampling] * rising, wrapped)
    fault = f"its motion grows faster than e^(t/{duration / 3.4:.3g} s)"
    return lags, _of_stable(response, _has_images(primal(wrapped)), fault, "choose a shorter duration")


def _of_stable(response: Any, unstable: Booleans, fault: str, remedy: str) -> Any:
    """A response (..., lag) with NaN in unstable windows; an error for a single unstable system."""
    if not np.any(unstable):
        return response
    if unstable.ndim == 0:
        raise EstimationError(
            "response in time",
            f"the system is unstable; {fault}",
            f"Compute its modes with drillid.physics.modes, or {remedy}",
        )
    return response * np.where(unstable, np.nan, 1.0)[..., None]


def _has_images(wrapped: Floats) -> Booleans:
    """Whether a damped response (..., time) has not decayed by the end of its period, or precedes its cause.

    The truncation at the highest frequency alternates from sample to sample and is averaged out.
    """
    amplitude = np.abs(wrapped / 2 + (np.roll(wrapped, 1, axis=-1) + np.roll(wrapped, -1, axis=-1)) / 4)
    last = amplitude[..., round(0.9 * wrapped.shape[-1]) : round(0.995 * wrapped.shape[-1])]
    return np.asarray(last.max(axis=-1) > _LARGEST_IMAGE * amplitude.max(axis=-1))


def _controlled_response(
    system: DrillingSystem, transform: Callable[[Complex], Any], duration: float, interval: float
) -> tuple[Floats, Any]:
    """As `inverse_laplace`, of a system under its speed control; its poles tell whether it is unstable.

    A growing mode in which the bit, or the top drive, hardly moves leaves images too small to be seen.
    """
    lags, response = inverse_laplace(transform, duration, interval)
    try:
        unstable = unstable_windows(system)
    except EstimationError:
        # a pole at the limit of stability itself
        return lags, response
    return lags, _of_stable(response, unstable, "a mode grows under its speed control", "tune that control")


def bit_step_response(system: DrillingSystem, duration: float, interval: float, *, stiff: bool = False) -> Steps:
    """Bit speed after a unit torque step at the bit.

    The response of bit and lowest section without reflections is known in closed form and subtracted
    first, so that the spectrum of the remainder falls fast. The error is below 1e-6 of the largest
    value (against 30-digit inversion, usual rigs). A system that is unstable under its speed control raises an
    error or, among windows, gives a row of NaN; one that is clamped, see `inverse_laplace`.

    Parameters
    ----------
    duration, interval : length and spacing of the lags, s; lag 0 is the instant before the step

    Returns
    -------
    lags : shape (lag,), s
    bit_speed : shape (..., lag), rad/s per N m; a Dual where the equipment holds one
    """
    inertia, resistance = _bit_alone(system)

    def remainder(s: Complex) -> Any:
        return bit_mobility(system, s, stiff=stiff) / s - 1 / (s * (inertia * s + resistance))

    respond = inverse_laplace if stiff else partial(_controlled_response, system)
    lags, reflections = respond(remainder, duration, interval)
    bit_speed = (reflections - np.expm1(-resistance / inertia * lags) / resistance) * (lags > 0)
    return lags, bit_speed


def bit_impulse_response(system: DrillingSystem, duration: float, interval: float, *, stiff: bool = False) -> Steps:
    """Bit speed after a unit angular impulse on the bit, whose inertia must be positive.

    As `bit_step_response`, with lag 0 the instant after the impulse. The error is below 1e-4 of the first
    value; at the first lags, where the motion is fastest, it may reach 1 %.

    Returns
    -------
    lags : shape (lag,), s
    bit_speed : shape (..., lag), rad/s per N m s; a Dual where the equipment holds one
    """
    inertia, resistance = _bit_alone(system)

    def remainder(s: Complex) -> Any:
        return bit_mobility(system, s, stiff=stiff) - 1 / (inertia * s + resistance)

    respond = inverse_laplace if stiff else partial(_controlled_response, system)
    lags, reflections = respond(remainder, duration, interval)
    return lags, reflections + np.exp(-resistance / inertia * lags) / inertia


def command_step_response(system: DrillingSystem, duration: float, interval: float) -> Steps:
    """Top-drive speed after a unit step of the sweep torque.

    The response of the top drive's inertia alone to the delayed and lagged torque is subtracted first in
    closed form, without jitter and further factors of the drive. The error is below 2e-6 of the largest value.

    Returns
    -------
    lags : shape (lag,), s
    speed : shape (..., lag), rad/s per N m; a Dual where the equipment holds one
    """
    top_drive = system.top_drive

    plain = TopDrive(top_drive.inertia, top_drive.delay, top_drive.controller, top_drive.lag, top_drive.gain)

    def remainder(s: Complex) -> Any:
        return command_mobility(system, s) / s - drive(plain, s) / (top_drive.inertia * s * s)

    lags, reflections = _controlled_response(system, remainder, duration, interval)
    since = np.maximum(lags - top_drive.delay, 0.0)
    lag = np.maximum(top_drive.lag, _LEAST_LAG)
    alone = top_drive.gain / top_drive.inertia * (since + lag * np.expm1(-since / lag))
    return lags, reflections + alone
