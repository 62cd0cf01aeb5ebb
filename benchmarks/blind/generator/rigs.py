"""Random rigs, strings and operating points, and data sheets that are right within their tolerances."""

from dataclasses import dataclass

import numpy as np

from drillid.fits.datasheet import DataSheet
from drillid.physics.equipment import Bit, Controller, Section, TopDrive, polar_moment

PIPES = ((0.0889, 0.0702), (0.1016, 0.0848), (0.1143, 0.0972), (0.127, 0.1086), (0.1397, 0.1214), (0.1492, 0.1297))
"""Outer and inner diameter of drill pipes from 3½" to 5⅞", m (API RP 7G)."""
SWEEP = 500.0
"""N m, amplitude of each of the three sweeps for 5½" pipe; other pipes in proportion to their polar moment."""
STAND = 28.0
"""m of pipe."""
TIME_STEP = 0.005
"""s, of the simulation; its command mobility is right to within 0.1 % up to 4 Hz (0.04 % rms)."""
CLOCK_ERROR = 0.002
"""s, standard uncertainty between the clocks of speed and torque."""
WINDOW_COUNTS = (1, 2, 4, 8, 12, 24)
_COUNT_PROBABILITIES = (0.30, 0.25, 0.20, 0.12, 0.08, 0.05)
_REFERENCE = polar_moment(0.1397, 0.1214)
LOCAL_STEPS = np.array([0.15, 0.10, 0.15])
"""Deviation of a window's κ, δ and damping at the bit from the set's, relative."""
_MEMORY = 0.8
"""Autocorrelation of that deviation from window to window."""
_LARGEST_PHASE = 0.5
"""rad, largest phase lag by the delay at the crossover of proportional gain and top-drive inertia."""


@dataclass(frozen=True)
class DrillingSegment:
    """One window of drilling, with the parameters that vary between windows."""

    hole_depth: float
    """m."""
    pipe_length: float
    """m."""
    kappa: float
    delta: float
    damping_bha: float
    speed: float
    """rad/s, set point."""
    bit_noise: float
    """N m rms."""


@dataclass(frozen=True)
class Equipment:
    """A rig and its operation in all windows; the pipe's length and damping are those of the first."""

    pipe: Section
    collars: Section
    top_drive: TopDrive
    bit: Bit
    control_interval: float
    """s."""
    sweep_amplitude: float
    """N m."""
    bit_torque: float
    """N m, mean."""
    weight_on_bit: float
    """N."""
    noise_bandwidth: float
    """Hz, of the torque noise at the bit."""
    noise_swing: float
    """Standard deviation of the logarithm of the slowly varying noise level."""
    sensor_noise: float
    """rad/s rms, of the recorded speed."""
    resolution: float
    """rad/s, of the recorded speed; fine."""
    length_relative: float
    """Relative standard uncertainty of the pipe's travel time."""
    slowness: float
    """Relative change of the pipe's travel time, within that uncertainty."""
    clock: float
    """s, delay of the recorded speed, within CLOCK_ERROR."""

    @property
    def delay(self) -> float:
        """Effective delay, s, including the hold of the command between two speed readings."""
        held = self.control_interval if self.control_interval > TIME_STEP else 0.0
        return float(self.top_drive.delay + held / 2)


def draw_equipment(generator: np.random.Generator) -> Equipment:
    """A rig whose torques scale with its pipe."""
    outer, inner = PIPES[generator.integers(len(PIPES))]
    moment = polar_moment(outer, inner)
    relative = moment / _REFERENCE
    length, kappa, delta = (_log_uniform(generator, *span) for span in ((1000.0, 5000.0), (50.0, 400.0), (1.5e8, 7e8)))
    collar_length = float(generator.uniform(60.0, 220.0))
    collar_outer = outer * generator.uniform(1.1, 1.5)
    pipe = Section(length, moment, kappa, delta)
    own = float(pipe.characteristic_admittance)
    inertia = _log_uniform(generator, 500.0, 3500.0) * np.sqrt(relative)
    delay = float(generator.uniform(0.02, 0.07))
    length_relative = float(generator.uniform(0.01, 0.03))
    gain = float(min(own * generator.uniform(1.5, 6.0), _LARGEST_PHASE * inertia / delay))
    return Equipment(
        pipe=pipe,
        collars=Section(collar_length, polar_moment(collar_outer, 0.45 * collar_outer), kappa, delta),
        top_drive=TopDrive(float(inertia), delay, Controller(gain, float(gain * generator.uniform(0.2, 0.8)))),
        bit=Bit(float(relative * generator.uniform(10.0, 60.0)), float(own * generator.uniform(0.02, 0.4))),
        control_interval=TIME_STEP,
        sweep_amplitude=SWEEP * relative,
        bit_torque=float(generator.uniform(3000.0, 8000.0)) * relative,
        weight_on_bit=float(generator.uniform(5e4, 2e5)),
        noise_bandwidth=_log_uniform(generator, 0.8, 4.0),
        noise_swing=float(generator.uniform(0.0, 0.3)),
        sensor_noise=_log_uniform(generator, 1e-3, 5e-3),
        resolution=float(generator.choice([0.0, 1e-4])),
        length_relative=length_relative,
        slowness=float(length_relative * generator.standard_normal()),
        clock=float(CLOCK_ERROR * generator.standard_normal()),
    )


def draw_segments(
    generator: np.random.Generator, equipment: Equipment, count: int | None = None
) -> tuple[DrillingSegment, ...]:
    """Successive windows of drilling ahead, two a stand; κ, δ and the bit's damping follow a random process."""
    if count is None:
        count = int(generator.choice(WINDOW_COUNTS, p=_COUNT_PROBABILITIES))
    base = np.array([equipment.pipe.kappa, equipment.pipe.delta, equipment.bit.damping])
    deviation = generator.standard_normal(3)
    speed = float(generator.uniform(7.0, 18.0))
    scale = equipment.sweep_amplitude / SWEEP
    noise = _log_uniform(generator, 100.0, 600.0) * scale
    segments = []
    for number in range(count):
        deviation = _MEMORY * deviation + np.sqrt(1 - _MEMORY**2) * generator.standard_normal(3)
        kappa, delta, damping = (float(value) for value in base * np.exp(LOCAL_STEPS * deviation))
        added = STAND * (number // 2)
        length = float(equipment.pipe.length) + added
        depth = length + float(equipment.collars.length) + STAND / 2 * (number % 2)
        rotation = speed * float(generator.uniform(0.85, 1.15))
        level = noise * float(np.exp(0.15 * generator.standard_normal()))
        segments.append(DrillingSegment(depth, length, kappa, delta, damping, rotation, level))
    return tuple(segments)


def draw_data_sheet(generator: np.random.Generator, equipment: Equipment) -> DataSheet:
    """The rig's data sheet: values in error by normal variables of its tolerances."""
    delay_error = float(generator.uniform(0.003, 0.005))
    inertia_relative, moment_relative, collar_relative, gain_relative = 0.02, 0.05, 0.1, 0.02
    deviation = generator.standard_normal(6)
    true = equipment.top_drive.controller
    controller = Controller(
        true.proportional * (1 + gain_relative * deviation[0]), true.integral * (1 + gain_relative * deviation[1])
    )
    inertia = float(equipment.top_drive.inertia * (1 + inertia_relative * deviation[2]))
    moment = float(equipment.pipe.polar_moment * (1 + moment_relative * deviation[3]))
    return DataSheet(
        controller=controller,
        controller_relative=gain_relative,
        collar_length=float(equipment.collars.length),
        collar_polar_moment=float(equipment.collars.polar_moment * (1 + collar_relative / 2 * deviation[4])),
        collar_relative=collar_relative,
        delay=equipment.delay + delay_error * deviation[5],
        delay_error=delay_error,
        inertia_td=inertia,
        inertia_td_error=inertia_relative * inertia,
        polar_moment=moment,
        polar_moment_error=moment_relative * moment,
        length_relative=equipment.length_relative,
        clock_error=CLOCK_ERROR,
        control_interval=equipment.control_interval,
    )


def _log_uniform(generator: np.random.Generator, low: float, high: float) -> float:
    return float(np.exp(generator.uniform(np.log(low), np.log(high))))
