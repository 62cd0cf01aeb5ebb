"""Rigs and excitation that the tests of the simulator share."""

import numpy as np

from drillid.arrays import Complex, Floats
from drillid.physics.equipment import Bit, Controller, DrillingSystem, Section, TopDrive, polar_moment
from drillid.simulation.simulate import TIME_STEP, Simulation

SPEED = 12.0
PERIOD = 100.0
PIPE = Section(2900.0, polar_moment(0.1397, 0.1214), kappa=200.0, delta=2.5e8)
COLLARS = Section(100.0, polar_moment(0.1651, 0.0714), kappa=200.0, delta=2.5e8)
SOFT = Section(60.0, polar_moment(0.2, 0.07), kappa=5000.0, delta=3e8, shear_modulus=61e9)
CONTROLLER = Controller(1500.0, 800.0)
TOP_DRIVE = TopDrive(1100.0, 0.0413, CONTROLLER)
SYSTEM = DrillingSystem(TOP_DRIVE, (PIPE, COLLARS), Bit(40.0, 40.0))
FREQUENCIES = np.arange(5, round(5 * PERIOD) + 1) / PERIOD


def multisine(steps: int, amplitude: float = 20.0) -> Floats:
    """All of FREQUENCIES at once with random phases and one amplitude, one period."""
    lines = np.zeros(steps // 2 + 1, dtype=complex)
    phases = np.random.default_rng(0).uniform(0, 2 * np.pi, FREQUENCIES.size)
    lines[np.rint(FREQUENCIES * PERIOD).astype(int)] = amplitude / 2 * steps * np.exp(1j * phases)
    return np.fft.irfft(lines, steps)


def lines_of(series: Floats, samples: int) -> Complex:
    """Fourier coefficients of the last period at FREQUENCIES."""
    return np.asarray(np.fft.rfft(series[-samples:])[np.rint(FREQUENCIES * PERIOD).astype(int)], dtype=complex)


def steps_in(seconds: float, time_step: float = TIME_STEP) -> int:
    """Time steps in some seconds."""
    return round(seconds / time_step)


def closure(result: Simulation) -> float:
    """What the energy balance leaves over, relative to the work supplied."""
    energies = result.energies
    assert energies is not None
    rest = energies.supplied + energies.parametric - energies.dissipated - energies.stored
    return abs(rest / energies.supplied)
