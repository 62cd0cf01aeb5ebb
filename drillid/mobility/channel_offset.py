"""Clock offset between the channels of a log, from the response of the torque command to sweep and speed."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from drillid.arrays import Complex, Floats
from drillid.errors import EstimationError
from drillid.spectra.cross_spectra import Spectra

_SEARCHED = np.arange(-3, 3.01, 0.05)
"""Grid of offsets for the initial search, s: closer than half a cycle of the highest frequencies."""
_STEPS = 8
"""Gauss–Newton steps; the problem is linear except for the offset."""


@dataclass(frozen=True)
class ChannelOffset:
    """Delay of the torque command's record relative to the sweep, and the speed control that results."""

    offset: float
    """s; positive where the command recorded at time t is that of t − offset."""
    standard_error: float
    """s."""
    proportional: float
    """N m s/rad."""
    integral: float
    """N m/rad."""


def channel_offset(spectra: Spectra, frequencies: Floats) -> ChannelOffset:
    """Offset of the torque command's record against that of the sweep, with P and I of the speed control.

    The command is T_com = T_sweep − (P + I/s) ω, without noise of its own. A record delayed by τ
    multiplies it by exp(−sτ): C exp(sτ) − 1 + (P + I/s) M = 0 for the responses C and M of command
    and speed to the sweep, fitted over the frequencies by least squares weighted with the sweep's
    power. The standard error comes from the residuals, so that it includes quantisation and noise
    of the record. A delay of the speed's record is attributed to a lag of the control: it biases P,
    and τ slightly.

    Parameters
    ----------
    spectra : of one window with a logged command, (frequency,)
    frequencies : (frequency,) Hz

    Raises
    ------
    EstimationError
        If the command is not logged, or it or the speed does not respond to the sweep.
    """
    s = np.asarray(2j * np.pi * frequencies, dtype=complex)
    command, speed = (cross / spectra.sweep_power for cross in (spectra.cross_command, spectra.cross_speed))
    if not (np.isfinite(command).all() and np.isfinite(speed).all()):
        raise EstimationError("channel offset", "sweep, speed and torque command are needed", "Log all three")
    weight = np.sqrt(spectra.sweep_power)
    loop = np.stack([speed, speed / s], axis=1) * weight[:, None]
    offset = _coarse(loop, command, s, weight)
    for _ in range(_STEPS):
        # (P + I/s) enters linearly, so that it is solved for anew at each offset
        advanced = command * np.exp(s * offset)
        rows = _real(np.concatenate([loop, (s * advanced * weight)[:, None]], axis=1))
        target = _real((1 - advanced) * weight)
        solution, _, rank, _ = np.linalg.lstsq(rows, target, rcond=None)
        if rank < solution.size:
            raise EstimationError(
                "channel offset",
                "speed or torque command does not respond to the sweep",
                "Check that the sweep was on and that no channel stands still",
            )
        offset += float(solution[2])
    residual = target - rows @ solution
    covariance = np.linalg.inv(rows.T @ rows) * (residual @ residual) / (residual.size - solution.size)
    return ChannelOffset(offset, float(np.sqrt(covariance[2, 2])), float(solution[0]), float(solution[1]))


def _coarse(loop: Complex, command: Complex, s: Complex, weight: Floats) -> float:
    """The offset of the grid with the least residual for the best P + I/s."""
    directions = np.linalg.qr(_real(loop))[0]
    targets = (1 - command * np.exp(np.outer(_SEARCHED, s))) * weight
    explained = np.sum((np.concatenate([targets.real, targets.imag], axis=1) @ directions) ** 2, axis=1)
    return float(_SEARCHED[np.argmin(np.sum(np.abs(targets) ** 2, axis=1) - explained)])


def _real(values: Complex) -> Floats:
    return np.concatenate([values.real, values.imag])
