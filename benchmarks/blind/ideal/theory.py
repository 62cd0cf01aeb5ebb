"""Expected responses of a window and their noise, by linear theory of the simulated rig."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from benchmarks.blind.generator.cases import RATE, WINDOW_S, Case, Hidden
from benchmarks.blind.generator.rigs import LOCAL_STEPS
from benchmarks.blind.generator.world import NUISANCES, World
from drillid.arrays import Complex, Floats
from drillid.excitation.torques import SWEEP_PERIOD, coloured_noise_density, exponential_sweeps
from drillid.physics.responses import bit_speed_ratio, command_mobility, laplace, string_admittance
from drillid.physics.top_drive import control, top_admittance

LOCAL = (0, 1, 6)
"""Indices of the nuisances that differ from window to window."""
SPARSE = 2
"""Decimation of the sweep's lines; the weight of those used is raised accordingly."""
_FIRST, _LAST = 6, 478
"""Harmonics of the sweep from 0.05 to 4 Hz."""
_CONTROL_FLOOR = 3e-3
"""Relative error of the control's response at each of some 40 independent frequencies, common to all windows, from
sampling of the torque command."""
_CONTROL_LINES = 40
_STEP = 1e-6


@dataclass(frozen=True, eq=False)
class Priors:
    """Prior standard deviations of the nuisances, in their units: of the set (11,), and of single windows (3,)."""

    shared: Floats
    local: Floats


def priors(case: Case) -> Priors:
    """From the data sheet's tolerances and the distribution that windows are drawn from."""
    known, first = case.data_sheet, case.segments[0]
    lump = np.hypot(1.0, case.equipment.collars.inertia * known.collar_relative / 50.0)
    shared = [1.5, np.log(3.0), known.length_relative, known.polar_moment_error / known.polar_moment]
    shared += [known.delay_error / 0.01, known.inertia_td_error / known.inertia_td, 2.0, lump]
    shared += [known.controller_relative, known.controller_relative, 1e3 * known.clock_error]
    units = np.array([first.kappa / 100.0, 1.0, first.damping_bha / 50.0])
    return Priors(np.array(shared), np.maximum(LOCAL_STEPS * units, 1e-3))


class Theory:
    """Whitened responses of a case's windows: real and imaginary part have unit variance.

    Parameters
    ----------
    parts : number of parts of a window, each with the value of a changing cause at its time
    """

    def __init__(self, case: Case, parts: int = 1) -> None:
        self.case = case
        self.windows = len(case.segments)
        self.shares = (np.arange(parts) + 0.5) / parts
        harmonics = np.arange(_FIRST, _LAST, SPARSE)
        self.s = laplace(harmonics / SWEEP_PERIOD)
        samples = round(SWEEP_PERIOD * RATE)
        sweep = exponential_sweeps(np.arange(samples) / RATE, case.equipment.sweep_amplitude)
        self.line = np.abs(np.fft.rfft(sweep)[harmonics]) * 2 / samples
        # the noise is that of the rig with its hidden causes
        worlds = [case.world(number) for number in range(self.windows)]
        self.weights = [
            [self._weight(world, number, share) for share in self.shares] for number, world in enumerate(worlds)
        ]
        self.control_weights = [self._control_weight(world) for world in worlds]

    def _weight(self, world: World, window: int, share: float) -> Floats:
        """(F,) one over the standard deviation of real and imaginary part of the mobility of one part of the window."""
        density = noise_density(self.case, world, window, self.s, share)
        variance = 2 * density / WINDOW_S / self.line**2
        return np.asarray(np.sqrt(2 * SPARSE / variance / self.shares.size), dtype=float)

    def _control_weight(self, world: World) -> Floats:
        """(F,) the same of the control's response, whose error is noise of the speed sensor."""
        response = np.abs(control(world.rig.system.top_drive.controller, self.s))
        recorded = world.recording(0.5, WINDOW_S).transfer(self.s)
        line = np.abs(command_mobility(world.linear(0.5), self.s) * recorded) * self.line
        sensor = 2 * sensor_density(world) / WINDOW_S / line**2 / SPARSE
        floor = _CONTROL_FLOOR**2 * self.s.size / _CONTROL_LINES * self.windows
        return np.asarray(np.sqrt(2 / (sensor + floor) / self.shares.size) / response, dtype=float)

    def response(self, window: int, hidden: tuple[Hidden, ...] = (), nuisances: Floats | None = None) -> Floats:
        """Whitened responses of a window with causes and changed nuisances, (rows,)."""
        world = self.case.world(window, nuisances, hidden)
        pieces = []
        for share, weight in zip(self.shares, self.weights[window], strict=True):
            system = world.linear(share)
            recorded = world.recording(share, WINDOW_S).transfer(self.s)
            pieces.append(command_mobility(system, self.s) * recorded * weight)
            if self.case.command_logged:
                response = control(system.top_drive.controller, self.s)
                pieces.append(response / recorded * self.control_weights[window])
        joined = np.concatenate(pieces)
        return np.concatenate([joined.real, joined.imag])

    def slopes(self, window: int, nuisances: Floats, hidden: tuple[Hidden, ...] = ()) -> Floats:
        """Derivatives of the whitened responses with respect to the nuisances, (rows, 11)."""
        here = self.response(window, hidden, nuisances)
        steps = _STEP * np.eye(len(NUISANCES))
        return np.stack([(self.response(window, hidden, nuisances + step) - here) / _STEP for step in steps], axis=1)


def noise_density(case: Case, world: World, window: int, s: Complex, share: float = 0.5) -> Floats:
    """One-sided power density of the recorded speed's noise at a share of the window, (rad/s)²/Hz."""
    system = world.linear(share)
    loaded = top_admittance(system.top_drive, s) + string_admittance(system, s)
    # by reciprocity, the response of the top to a torque at the bit is that of the bit to one at the top
    transfer = bit_speed_ratio(system, s) / loaded
    frequency = np.abs(s) / (2 * np.pi)
    bit = coloured_noise_density(frequency, case.segments[window].bit_noise, case.equipment.noise_bandwidth)
    recorded = world.recording(share, WINDOW_S).transfer(s)
    return np.asarray(np.abs(transfer * recorded) ** 2 * bit + sensor_density(world), dtype=float)


def sensor_density(world: World) -> float:
    """One-sided power density of the recorder's noise, in the recorded speed, (rad/s)²/Hz."""
    return 2 * (world.recorder.scale * world.recorder.noise) ** 2 / RATE


def compressed(columns: Sequence[Floats]) -> Floats:
    """Triangular factor of columns (rows, C) of one window, which has the same inner products."""
    factor = np.linalg.qr(np.column_stack(list(columns)), mode="r")
    return np.asarray(factor, dtype=float)
