"""Causes above the string and in sensor, clock and recorder, as the second world knows them."""

from dataclasses import replace

import numpy as np

from benchmarks.blind.other_world.effect import Context, Effect, Range
from benchmarks.blind.other_world.rig import Window
from benchmarks.blind.vocabulary import tone_frequency, wrong_factor


def _controller_gain(window: Window, size: float, context: Context) -> Window:
    control = window.control
    return window.with_control(proportional=control.proportional * (1 + size), integral=control.integral * (1 + size))


def _jitter_range(window: Window, context: Context) -> Range:
    """Variances of delays of which hardly any would be negative."""
    return 1e-5, (0.4 * window.drive.delay) ** 2


def mean_load(window: Window) -> float:
    """Torque of steady drilling at the top, N m."""
    viscous = sum(piece.wall_damping * piece.moment * piece.length + piece.damping_below for piece in window.string)
    rubbing = sum(contact.friction.level(window.speed) for contact in window.contacts)
    return window.rock.mean + rubbing + viscous * window.speed


def _limit_range(window: Window, context: Context) -> Range:
    load = mean_load(window)
    return load + 0.7 * window.sweep, load + 4.0 * window.sweep


def _rate_range(window: Window, context: Context) -> Range:
    return 5.0 * window.sweep, 60.0 * window.sweep


def _gear_backlash(window: Window, size: float, context: Context) -> Window:
    """Play that opens, as the mean torque is low; the gear sits anywhere within the inertia."""
    share = float(context.generator().uniform(0.1, 0.7))
    light = replace(window.rock, mean=0.1 * window.sweep)
    string = tuple(replace(piece, wall_damping=0.2 * piece.wall_damping) for piece in window.string)
    return replace(window.with_drive(play=size, share_below_gear=share), rock=light, contacts=(), string=string)


def _recorder_filter(window: Window, size: float, context: Context) -> Window:
    return window.with_recording(filter_time=size, filter_order=1 + int(context.shape > 0.5))


def _quantisation(window: Window, size: float, context: Context) -> Window:
    return window.with_recording(resolution=size)


def _aliased_tone(window: Window, size: float, context: Context) -> Window:
    return window.with_recording(tone=size, tone_frequency=tone_frequency(context.shape))


def _sign_or_unit(window: Window, size: float, context: Context) -> Window:
    return window.with_recording(scale=1 + size * (wrong_factor(context.shape) - 1))


def _notch(window: Window, size: float, context: Context) -> Window:
    """A notch on the controller's torque against a mode of the string; the size is its depth."""
    return window.with_control(notch=0.3 * 10**context.shape, notch_depth=size)


EFFECTS = (
    Effect("drive_lag", lambda window, size, _: window.with_drive(lag=size), (1e-3, 0.15)),
    Effect("actuator_gain", lambda window, size, _: window.with_drive(gain=1 + size), (0.01, 0.5), signed=True),
    Effect("delay_jitter", lambda window, size, _: window.with_drive(jitter=float(np.sqrt(size))), _jitter_range),
    Effect("torque_limit", lambda window, size, _: window.with_drive(limit=size), _limit_range, linear=False),
    Effect("torque_rate_limit", lambda window, size, _: window.with_drive(rate=size), _rate_range, linear=False),
    Effect("controller_gain", _controller_gain, (0.02, 0.5), signed=True),
    Effect("speed_filter", lambda window, size, _: window.with_control(speed_filter=size), (3e-5, 0.15)),
    Effect("torque_filter", lambda window, size, _: window.with_control(torque_filter=size), (3e-5, 0.15)),
    Effect("gear_backlash", _gear_backlash, (0.01, 0.5), linear=False),
    Effect("speed_scale", lambda window, size, _: window.with_recording(scale=1 + size), (0.005, 0.3), signed=True),
    Effect("sign_or_unit", _sign_or_unit, (1.0, 1.0)),
    Effect(
        "clock_offset",
        lambda window, size, _: window.with_recording(offset=window.recording.offset + size),
        (3e-5, 0.3),
        signed=True,
    ),
    Effect("clock_drift", lambda window, size, _: window.with_recording(drift=size), (1e-7, 2e-3), signed=True),
    Effect("recorder_filter", _recorder_filter, (0.0045, 0.15)),
    Effect("sample_and_hold", lambda window, size, _: window.with_recording(held=size), (0.01, 0.3)),
    Effect("quantisation", _quantisation, (0.01, 1.0), linear=False),
    Effect("aliased_tone", _aliased_tone, (3e-5, 0.1), linear=False),
    Effect(
        "once_per_revolution", lambda window, size, _: window.with_recording(ripple=size), (1e-5, 0.05), linear=False
    ),
    Effect("notch_in_control", _notch, (0.003, 0.95), in_catalogue=False),
    # the size is the resonance's period: the longer, the more of the band it bends
    Effect(
        "resonant_drive", lambda window, size, _: window.with_drive(resonance=1 / size), (0.04, 0.5), in_catalogue=False
    ),
)
