"""Rigs drawn at random from all that are met: strings of 300 to 9000 m, pipes of 2⅞" to 6⅝", any top drive."""

from dataclasses import replace

import numpy as np

from benchmarks.identification.windows import Run, SimulatedWindow, windows_of
from drillid.physics.equipment import Bit, Controller, Section, TopDrive, polar_moment
from tests.simulated import Truth

PIPES = (
    (0.07302, 0.05461),
    (0.0889, 0.0702),
    (0.1016, 0.0848),
    (0.1143, 0.0972),
    (0.127, 0.1086),
    (0.1397, 0.1214),
    (0.149225, 0.1297),
    (0.168275, 0.1514),
)
"""Outer and inner diameter of the usual drill pipes, m (API RP 7G)."""
LENGTHS = (300.0, 9000.0)
TOP_DRIVES = (300.0, 5000.0)
DELAYS = (0.01, 0.1)
_REFERENCE = polar_moment(0.1397, 0.1214)
_SWEEP = 500.0
_BIT_NOISE = (100.0, 600.0)
_SPEED_NOISE = 0.002
"""rad/s rms, of the speed's record: a good encoder. Without it, long strings would have no noise above 4 Hz."""
_LEAST_MARGIN = 0.5
"""Largest phase, rad, that the delay may cost at the frequency where proportional gain and top-drive inertia cross."""


def random_rig(generator: np.random.Generator) -> Truth:
    """One rig; torques go with the polar moment of its pipe, from 500 N m of sweep for the 5½" pipe.

    The proportional gain is 1 to 6 times the pipe's characteristic admittance, but no more than the drive's
    delay lets the speed control bear.
    """
    outer, inner = PIPES[generator.integers(len(PIPES))]
    kappa, delta = np.exp(generator.uniform(np.log([20.0, 1e8]), np.log([400.0, 9e8])))
    moment = polar_moment(outer, inner)
    length, inertia = np.exp(
        generator.uniform(np.log([LENGTHS[0], TOP_DRIVES[0]]), np.log([LENGTHS[1], TOP_DRIVES[1]]))
    )
    delay = generator.uniform(*DELAYS)
    collar_length = min(np.exp(generator.uniform(np.log(30.0), np.log(250.0))), 0.3 * length)
    collar_diameter = outer * generator.uniform(1.1, 1.5)
    pipe = Section(length, moment, kappa, delta)
    own = float(pipe.characteristic_admittance)
    gain = min(own * generator.uniform(1.0, 6.0), _LEAST_MARGIN * inertia / delay)
    relative = moment / _REFERENCE
    return Truth(
        pipe=pipe,
        collars=Section(collar_length, polar_moment(collar_diameter, 0.4 * collar_diameter), kappa, delta),
        top_drive=TopDrive(inertia, delay, Controller(gain, gain * generator.uniform(0.1, 0.8))),
        bit=Bit(relative * generator.uniform(5.0, 60.0), own * generator.uniform(0.0, 0.6)),
        sweep_amplitude=_SWEEP * relative,
        bit_noise=float(generator.uniform(*_BIT_NOISE)) * relative,
        bit_torque=4000.0 * relative,
    )


def random_windows(count: int = 300, seed: int = 1) -> list[SimulatedWindow]:
    """A ten-minute window of each of `count` random rigs."""
    generator = np.random.default_rng(seed)
    runs = [Run(random_rig(generator), 1, number) for number in range(count)]
    windows = windows_of(runs, "Simulating random rigs")
    return [
        replace(window, speed=window.speed + _SPEED_NOISE * generator.standard_normal(window.speed.size))
        for window in windows
    ]
