"""Closed-form responses of a window of the second world: a chain of transmission lines under its speed control."""

from collections.abc import Callable

import numpy as np

from benchmarks.blind.hidden import altered
from benchmarks.blind.other_world.relaxation import hysteresis
from benchmarks.blind.other_world.rig import Control, Drive, Piece, Recording, Window
from drillid.arrays import Complex, Floats

_EXACT_SWITCH = 1e-9
_IMAGES = 4
"""Multiples of the control's rate, on either side, whose folding is counted."""


def laplace(frequency: Floats) -> Complex:
    """The Laplace variable at frequencies in Hz."""
    return np.asarray(2j * np.pi * np.asarray(frequency, dtype=float), dtype=complex)


def string_response(string: tuple[Piece, ...], s: Complex, load: Complex | float = 0.0) -> tuple[Complex, Complex]:
    """Torque per speed at the top, and speed at the bottom per speed at the top, of a string with its lumps.

    Parameters
    ----------
    load : torque per speed at the lower end beside that of the lumps, N m s/rad
    """
    load, ratio = load + np.zeros_like(s), np.ones_like(s)
    for piece in reversed(string):
        load = load + piece.inertia_below * s + piece.damping_below
        shunt = piece.moment * (piece.density * s + piece.wall_damping + piece.root_drag * np.sqrt(s))
        lossy = 1 + piece.loss_factor * hysteresis(s)
        series = piece.moment * (piece.shear_modulus * lossy / s + piece.steel_damping)
        # from the same root, so that both change sign together where a line amplifies its waves
        gamma = np.sqrt(shunt / series)
        own, through = series * gamma, gamma * piece.length
        # with the decaying wave exp(−γL) there is no overflow
        decay = np.exp(-through)
        tanh = (1 - decay**2) / (1 + decay**2)
        ratio = ratio * (2 * decay / (1 + decay**2)) * own / (own + load * tanh)
        load = own * (load + own * tanh) / (own + load * tanh)
    return load, ratio


def held(s: Complex, interval: float) -> Complex:
    """Response of samples that are held for an interval, (1 − exp(−s h))/(s h)."""
    if interval < _EXACT_SWITCH:
        return np.ones_like(s)
    return np.asarray((1 - np.exp(-s * interval)) / (s * interval), dtype=complex)


def control_response(control: Control, s: Complex) -> Complex:
    """Torque of the speed control per speed that it opposes, before the hold, N m s/rad.

    The integral is a sum of the errors up to now, which leads that of continuous control by half an interval.
    """
    step = 1 - np.exp(-s * control.interval)
    response = control.proportional + control.integral * control.interval / step
    response = response * read(control, s) * _trapezoidal(s, control.interval, control.torque_filter)
    if control.notch > 0:
        response = response * notch(s, control.interval, control.notch, control.notch_depth)
    return np.asarray(response, dtype=complex)


def read(control: Control, s: Complex) -> Complex:
    """Speed at the control's readings per speed: its analogue low pass."""
    return np.asarray(1 / (1 + s * control.speed_filter), dtype=complex)


def _trapezoidal(s: Complex, interval: float, time_constant: float) -> Complex:
    """A low pass by the trapezoidal rule at an interval."""
    later = np.exp(-s * interval)
    rate = 2 * time_constant * (1 - later) / interval
    return np.asarray((1 + later) / (rate + 1 + later), dtype=complex)


NOTCH_WIDTH = 0.5
"""Damping ratio of the notch's poles."""


def notch(s: Complex, interval: float, frequency: float, depth: float) -> Complex:
    """A notch by the trapezoidal rule at an interval."""
    later = np.exp(-s * interval)
    warped = 2 / interval * (1 - later) / (1 + later)
    centre = 2 * np.pi * frequency
    squared = warped**2 + centre**2
    spread = 2 * NOTCH_WIDTH * centre * warped
    return np.asarray((squared + (1 - depth) * spread) / (squared + spread), dtype=complex)


RESONANCE_DAMPING = 0.25
"""Damping ratio of a resonant torque loop."""


def drive_response(drive: Drive, interval: float, s: Complex) -> Complex:
    """Mean torque of the drive per command, with the hold of the command for an interval (s)."""
    response = drive.gain * held(s, interval) * np.exp(-s * drive.delay)
    if drive.lag > 0:
        response = response / (1 + s * drive.lag)
    if drive.jitter > 0:
        # the delay of each command differs: the mean of its phase factor
        response = response * np.exp((s * drive.jitter) ** 2 / 2)
    if drive.resonance > 0:
        centre = 2 * np.pi * drive.resonance
        response = response * centre**2 / (s**2 + 2 * RESONANCE_DAMPING * centre * s + centre**2)
    return np.asarray(response, dtype=complex)


def recorded(recording: Recording, s: Complex, share: float = 0.5, seconds: float = 600.0) -> Complex:
    """Recorded speed per speed, relative to how the other channels are recorded."""
    response = recording.scale * sampled(recording, s, share, seconds)
    if recording.held > 0:
        response = response * held(s, recording.held)
    return np.asarray(response, dtype=complex)


def sampled(recording: Recording, s: Complex, share: float, seconds: float) -> Complex:
    """Speed at the times of the control's readings as the recorder samples it, per speed."""
    offset = recording.offset + recording.drift * seconds * (share - 0.5)
    response = np.exp(-s * offset)
    if recording.filter_order == 1:
        response = response / (1 + s * recording.filter_time)
    else:
        scaled = s * recording.filter_time
        response = response / (1 + np.sqrt(2) * scaled + scaled**2)
    return np.asarray(response, dtype=complex)


def linear_string(window: Window, share: float = 0.5) -> tuple[Piece, ...]:
    """The string for small vibrations about steady rotation, at an elapsed share of the window; blades apart."""
    string, added = window.grown(share), float(window.added_damping(np.asarray(share)))
    if window.bit_friction is not None:
        added -= window.bit_friction.steepness(window.speed)
    slope = sum(contact.friction.steepness(window.speed) for contact in window.contacts)
    slope /= sum(piece.moment * piece.length for piece in string)
    weaker = [altered(piece, wall_damping=piece.wall_damping - slope) for piece in string] if slope else string
    *above, last = weaker
    return (*above, altered(last, damping_below=last.damping_below + added))


def blade_response(window: Window, s: Complex) -> Complex:
    """Torque per speed at the bit of the blades, (F,) N m s/rad; zero without blades."""
    if window.blades is None:
        return np.zeros_like(s)
    # the depth of cut is the rate of penetration times the time since the blade ahead was here
    between = 2 * np.pi / window.speed / window.blades.count
    return np.asarray(-window.blades.torque / window.speed * held(s, between), dtype=complex)


def loads(window: Window, s: Complex, share: float = 0.5) -> tuple[Complex, Complex]:
    """Admittance of the string at its top, and speed at the bit per speed at the top."""
    return string_response(linear_string(window, share), s, blade_response(window, s))


Filter = Callable[[Complex], Complex]
"""A response of the Laplace variable."""


def images(drive: Drive, interval: float, admittance: float, s: Complex, passed: Filter) -> Complex:
    """What readings of a filtered speed fold of the steps that the held command adds at multiples of its rate,
    rad/(N m s), relative to the filter's response in the band.

    There the top drive and the pipe's characteristic admittance (N m s/rad) are the load.
    """
    orders = np.arange(1, _IMAGES + 1)
    around = 2j * np.pi / max(interval, _EXACT_SWITCH) * np.concatenate([orders, -orders])
    folded = s + around[:, None]
    response = drive_response(drive, interval, folded) / (drive.inertia * folded + admittance) * passed(folded)
    return np.asarray(response.sum(axis=0) / passed(s), dtype=complex)


def images_read(control: Control, drive: Drive, admittance: float, s: Complex) -> Complex:
    """What the control's readings fold, rad/(N m s)."""
    return images(drive, control.interval, admittance, s, lambda at: read(control, at))


def images_kept(
    recording: Recording, interval: float, drive: Drive, admittance: float, s: Complex, share: float, seconds: float
) -> Complex:
    """What the recorder folds, which samples at the control's readings; a slower device folds now this and now that."""
    if recording.held > 0:
        return np.zeros_like(s)
    return images(drive, interval, admittance, s, lambda at: sampled(recording, at, share, seconds))


def recorded_responses(
    window: Window, s: Complex, share: float = 0.5, seconds: float = 600.0
) -> tuple[Complex, Complex]:
    """Command mobility (rad/(N m s)) and response of the control (N m s/rad) as recorded."""
    drive, control, recording = window.drive, window.control, window.recording
    driven = drive_response(drive, control.interval, s) / (drive.inertia * s + loads(window, s, share)[0])
    admittance = window.string[0].admittance
    plant = driven + images_read(control, drive, admittance, s)
    kept = driven + images_kept(recording, control.interval, drive, admittance, s, share, seconds)
    kept, response = kept * recorded(recording, s, share, seconds), control_response(control, s)
    return np.asarray(kept / (1 + plant * response), dtype=complex), np.asarray(response * plant / kept, dtype=complex)


def command_mobility(window: Window, s: Complex, share: float = 0.5) -> Complex:
    """Speed per torque added to the command, both at the control's readings, rad/(N m s)."""
    return recorded_responses(altered(window, recording=Recording()), s, share)[0]


def noise_response(window: Window, s: Complex, share: float = 0.5) -> Complex:
    """Speed of the top drive per torque at the bit, which by reciprocity is that at the bit per torque at the top."""
    load, ratio = loads(window, s, share)
    feedback = drive_response(window.drive, window.control.interval, s) * control_response(window.control, s)
    return np.asarray(ratio / (window.drive.inertia * s + load + feedback), dtype=complex)
