"""Clock offset between the channels of a log, from how the torque command answers sweep and speed."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from drillid.arrays import Complex, Floats
from drillid.errors import EstimationError
from drillid.spectra.cross_spectra import Spectra

_SEARCHED = np.arange(-3, 3.01, 0.05)
"""Offsets among which the search begins, s: closer than half a cycle of the highest frequencies."""
_STEPS = 8
"""Of Gauss and Newton; the problem is linear but for the offset."""


@dataclass(frozen=True)
class ChannelOffset:
    """How late the torque command is recorded, against the sweep, and the control that this implies."""

    offset: float
    """s; positive where the command's row at time t shows what was commanded at t − offset."""
    standard_error: float
    """s."""
    proportional: float
    """N m s/rad."""
    integral: float
    """N m/rad."""


def channel_offset(spectra: Spectra, frequencies: Floats) -> ChannelOffset:
    """Offset of the torque command's record against that of the sweep, with P and I of the speed control.

    The command is T_com = T_sweep − (P + I/s) ω, without any noise of its own. A record that is late
    by τ shows it times exp(−sτ): C exp(sτ) − 1 + (P + I/s) M = 0 for the responses C and M of command
    and speed to the sweep, fitted over the frequencies by least squares, with weights of the sweep's
    power. The standard error comes from what the fit leaves over, so that it holds for quantisation
    and noise of the record as well. A speed that is recorded late is taken for a lag of the control
    and shifts P, and a little τ.

    Parameters
    ----------
    spectra : of one window with a logged command, (frequency,)
    frequencies : (frequency,) Hz

    Raises
    ------
    EstimationError
        If the command is not logged.
    """
    s = np.asarray(2j * np.pi * frequencies, dtype=complex)
    command, speed = (cross / spectra.sweep_power for cross in (spectra.cross_command, spectra.cross_speed))
    if not (np.isfinite(command).all() and np.isfinite(speed).all()):
        raise EstimationError("channel offset", "sweep, speed and torque command are needed", "Log all three")
    weight = np.sqrt(spectra.sweep_power)
    loop = np.stack([speed, speed / s], axis=1) * weight[:, None]
    offset = _coarse(loop, command, s, weight)
    for _ in range(_STEPS):
        # (P + I/s) enters linearly, so that each offset solves for it afresh
        turned = command * np.exp(s * offset)
        rows = _real(np.concatenate([loop, (s * turned * weight)[:, None]], axis=1))
        target = _real((1 - turned) * weight)
        found = np.linalg.lstsq(rows, target, rcond=None)[0]
        offset += float(found[2])
    left = target - rows @ found
    covariance = np.linalg.inv(rows.T @ rows) * (left @ left) / (left.size - found.size)
    return ChannelOffset(offset, float(np.sqrt(covariance[2, 2])), float(found[0]), float(found[1]))


def _coarse(loop: Complex, command: Complex, s: Complex, weight: Floats) -> float:
    """The searched offset at which some P + I/s leaves least."""
    directions = np.linalg.qr(_real(loop))[0]
    targets = (1 - command * np.exp(np.outer(_SEARCHED, s))) * weight
    explained = np.sum((np.concatenate([targets.real, targets.imag], axis=1) @ directions) ** 2, axis=1)
    return float(_SEARCHED[np.argmin(np.sum(np.abs(targets) ** 2, axis=1) - explained)])


def _real(values: Complex) -> Floats:
    return np.concatenate([values.real, values.imag])
