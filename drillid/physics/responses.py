"""Responses of the whole drilling system: command mobility, bit mobility, steps of the bit's speed."""

import numpy as np
from numpy.typing import NDArray
from scipy.fft import irfft, next_fast_len

from drillid.physics.equipment import Controller, DrillingSystem, TopDrive
from drillid.physics.line import Complex, input_admittance, input_impedance

Steps = tuple[NDArray[np.float64], NDArray[np.float64]]

_IMAGES = 1e-12
"""Size of the periodic images that the inverse Laplace transform leaves."""
_FINEST_INTERVAL_S = 0.004
"""Spacing in time at which the inverse Laplace transform is computed."""
_LEAST_INERTIA = 1e-6
"""kg m²; stands for a bit without inertia, whose speed steps at once."""


def laplace(frequency: NDArray[np.float64]) -> Complex:
    """S = 2πjf for frequencies in Hz."""
    return np.asarray(2j * np.pi * np.asarray(frequency), dtype=complex)


def control(controller: Controller, s: Complex) -> Complex:
    """A E H (N m s/rad): torque that the speed controller takes back per speed."""
    gain = controller.proportional + controller.integral / s
    taken_back: Complex = gain / ((1 + s * controller.speed_filter) * (1 + s * controller.torque_filter))
    return taken_back


def drive(top_drive: TopDrive, s: Complex) -> Complex:
    """D e^(−sT_d): motor torque per commanded torque."""
    torque: Complex = np.exp(-s * top_drive.delay) / (1 + s * top_drive.lag)
    return torque


def top_admittance(top_drive: TopDrive, s: Complex) -> Complex:
    """Y_top = J_td s + D e^(−sT_d) A H, what the string sees at its upper end, N m s/rad."""
    admittance: Complex = top_drive.inertia * s + drive(top_drive, s) * control(top_drive.controller, s)
    return admittance


def bit_load(system: DrillingSystem, s: Complex) -> Complex:
    """Y_L = J_bha s + Y_bha, N m s/rad."""
    admittance: Complex = system.bit.inertia * s + system.bit.damping
    return admittance


def string_admittance(system: DrillingSystem, s: Complex) -> Complex:
    """Y_in, torque into the string per speed at its upper end, N m s/rad; sections cascade from the bit up."""
    admittance = bit_load(system, s)
    for section in reversed(system.string):
        admittance = input_admittance(section, admittance, s)
    return admittance


def command_mobility(system: DrillingSystem, s: Complex) -> Complex:
    """M = D e^(−sT_d) / (J_td s + Y_in + D e^(−sT_d) A H), rad/(N m s)."""
    return drive(system.top_drive, s) / (top_admittance(system.top_drive, s) + string_admittance(system, s))


def bit_mobility(system: DrillingSystem, s: Complex, *, stiff: bool = False) -> Complex:
    """Bit speed per torque on the bit, rad/(N m s); `stiff` clamps the top drive."""
    if not stiff:
        above = top_admittance(system.top_drive, s)
        for section in system.string:
            above = input_admittance(section, above, s)
        return 1 / (bit_load(system, s) + above)
    impedance = np.zeros_like(s)
    for section in system.string:
        impedance = input_impedance(section, impedance, s)
    return 1 / (bit_load(system, s) + 1 / impedance)


def bit_step_response(system: DrillingSystem, duration: float, interval: float, *, stiff: bool = False) -> Steps:
    """Bit speed after a unit torque step at the bit.

    The bit mobility over s is inverted on a line right of the imaginary axis (Dubner and
    Abate 1968) by one FFT. The step into bit and lowest section without reflections is
    known in closed form and taken out first, so that the remainder's spectrum falls fast.
    Against 30-digit inversion the error is below 1e-6 of the largest value up to half of
    the duration and below 1e-4 at its end.

    Parameters
    ----------
    duration, interval : length and spacing of the lags, s; lag 0 is the instant before the step

    Returns
    -------
    lags : shape (lag,), s
    bit_speed : shape (..., lag), rad/s per N m
    """
    lags = np.arange(0.0, duration + interval / 2, interval)
    oversampling = int(np.ceil(interval / _FINEST_INTERVAL_S))
    points = next_fast_len(2 * lags.size * oversampling, real=True)
    period = points * interval / oversampling
    shift = -np.log(_IMAGES) / period
    s = shift + laplace(np.arange(points // 2 + 1) / period)
    lowest = system.string[-1]
    resistance = lowest.polar_moment * np.sqrt(lowest.density * lowest.shear_modulus) + system.bit.damping
    inertia = np.maximum(system.bit.inertia, _LEAST_INERTIA)
    remainder = bit_mobility(system, s, stiff=stiff) / s - 1 / (s * (inertia * s + resistance))
    reflections = irfft(remainder, points)[..., : lags.size * oversampling : oversampling] * points / period
    bit_speed = reflections * np.exp(shift * lags) - np.expm1(-resistance / inertia * lags) / resistance
    bit_speed[..., 0] = 0.0
    return lags, bit_speed
