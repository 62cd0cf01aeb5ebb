"""Expected responses of a case's windows, whitened by their noise."""

from collections.abc import Sequence

import numpy as np

from benchmarks.blind.hidden import Hidden
from benchmarks.blind.ideal.responses import NUISANCES, WINDOW_S, Responses, Sealed
from drillid.arrays import Floats
from drillid.excitation.torques import SWEEP_PERIOD, exponential_sweeps

SPARSE = 2
"""Decimation of the sweep's lines; the weight of those used is raised accordingly."""
_FIRST, _LAST = 6, 478
"""Harmonics of the sweep from 0.05 to 4 Hz."""
_CONTROL_FLOOR = 3e-3
"""Relative error of the control's response at each of some 40 independent frequencies, common to all windows, from
sampling of the torque command."""
_CONTROL_LINES = 40
_STEP = 1e-6
_SAMPLES = 6000
"""Samples of the sweep's period, from which its lines are computed."""


class Theory:
    """Whitened responses of a case's windows: real and imaginary part have unit variance.

    Parameters
    ----------
    parts : number of parts of a window, each with the value of a changing cause at its time
    """

    def __init__(self, case: Sealed, responses: Responses, parts: int = 1) -> None:
        self.case, self.responses = case, responses
        self.windows = responses.windows
        self.shares = (np.arange(parts) + 0.5) / parts
        harmonics = np.arange(_FIRST, _LAST, SPARSE)
        self.s = np.asarray(2j * np.pi * harmonics / SWEEP_PERIOD, dtype=complex)
        sweep = exponential_sweeps(np.arange(_SAMPLES) * SWEEP_PERIOD / _SAMPLES, responses.sweep)
        self.line = np.abs(np.fft.rfft(sweep)[harmonics]) * 2 / _SAMPLES
        # the noise is that of the rig with its hidden causes
        windows = range(self.windows)
        self.weights = [[self._weight(number, share) for share in self.shares] for number in windows]
        self.control_weights = [self._control_weight(number) for number in windows]

    def _weight(self, window: int, share: float) -> Floats:
        """(F,) one over the standard deviation of real and imaginary part of the mobility of one part of the window."""
        density = self.responses.noise_density(window, self.case.hidden, self.s, share)
        variance = 2 * density / WINDOW_S / self.line**2
        return np.asarray(np.sqrt(2 * SPARSE / variance / self.shares.size), dtype=float)

    def _control_weight(self, window: int) -> Floats:
        """(F,) the same of the control's response, whose error is noise of the speed sensor."""
        ((mobility, control),) = self.responses.expected(window, self.case.hidden, None, self.s, (0.5,))
        line = np.abs(mobility) * self.line
        sensor = 2 * self.responses.sensor_density(window, self.case.hidden) / WINDOW_S / line**2 / SPARSE
        floor = _CONTROL_FLOOR**2 * self.s.size / _CONTROL_LINES * self.windows
        return np.asarray(np.sqrt(2 / (sensor + floor) / self.shares.size) / np.abs(control), dtype=float)

    def response(self, window: int, hidden: tuple[Hidden, ...] = (), nuisances: Floats | None = None) -> Floats:
        """Whitened responses of a window with causes and changed nuisances, (rows,)."""
        expected = self.responses.expected(window, hidden, nuisances, self.s, self.shares)
        pieces = []
        for (mobility, control), weight in zip(expected, self.weights[window], strict=True):
            pieces.append(mobility * weight)
            if self.case.command_logged:
                pieces.append(control * self.control_weights[window])
        joined = np.concatenate(pieces)
        return np.concatenate([joined.real, joined.imag])

    def slopes(self, window: int, nuisances: Floats, hidden: tuple[Hidden, ...] = ()) -> Floats:
        """Derivatives of the whitened responses with respect to the nuisances, (rows, 11)."""
        here = self.response(window, hidden, nuisances)
        steps = _STEP * np.eye(len(NUISANCES))
        return np.stack([(self.response(window, hidden, nuisances + step) - here) / _STEP for step in steps], axis=1)


def compressed(columns: Sequence[Floats]) -> Floats:
    """Triangular factor of columns (rows, C) of one window, which has the same inner products."""
    factor = np.linalg.qr(np.column_stack(list(columns)), mode="r")
    return np.asarray(factor, dtype=float)
