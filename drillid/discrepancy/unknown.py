"""What the catalogue does not hold: smooth disturbances of unknown shape at the ports of the rig.

At each port the response is disturbed by a smooth complex function of log frequency, with a Gaussian prior of unknown
amplitude: a discrepancy in the sense of Kennedy and O'Hagan (2001, Journal of the Royal Statistical Society B 63,
425–464), written in a basis so that it is one more linear model.
"""

from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from drillid.discrepancy.set_fit import SetFit
from drillid.discrepancy.set_model import Complex, Extension, SetModel
from drillid.physics.equipment import DrillingSystem
from drillid.physics.line import speed_ratio
from drillid.physics.responses import bit_speed_ratio, string_admittance
from drillid.physics.top_drive import torque_transfers

Floats = NDArray[np.float64]

PORTS = ("record", "top", "upper string", "lower string", "bit")
"""The first multiplies the response, the others add an admittance: at the string's top, at a third and at two thirds
of the pipe, at the bit."""
_PLACES = {"upper string": 1 / 3, "lower string": 2 / 3}
FUNCTIONS = 12
"""Smooth functions over the band, each with real and imaginary part."""
AMPLITUDES = 10.0 ** np.arange(-2.5, 0.6, 0.5)
"""Standard deviations tried, relative to the response or to the pipe's characteristic admittance."""


def smooth_functions(frequency: Floats, count: int) -> Floats:
    """Cubic B-splines over log frequency, (count, F)."""
    from scipy.interpolate import BSpline

    position = np.log(frequency / frequency[0]) / np.log(frequency[-1] / frequency[0])
    inner = np.linspace(0.0, 1.0, count - 2)
    knots = np.concatenate([[0.0] * 3, inner, [1.0] * 3])
    return np.asarray(BSpline.design_matrix(np.clip(position, 0.0, 1.0), knots, 3).toarray().T, dtype=float)


def directions(model: SetModel, fit: SetFit, extensions: tuple[Extension, ...], port: str) -> Complex:
    """Whitened directions (W, 2 FUNCTIONS, rows) of a disturbance at a port, the same in all windows."""
    setup = model.setup_at(fit.point, extensions)
    mobility, s = setup.mobility(model.s), model.s
    system = setup.system
    if port == "record":
        sensitivity = mobility
    else:
        drive, _ = torque_transfers(system.top_drive, s)
        sensitivity = (
            -(mobility**2) / (setup.recording.transfer(s) * drive) * system.string[0].characteristic_admittance
        )
        sensitivity = sensitivity * _speed_at(port, system, s) ** 2
    shape = (model.evidence.windows, s.size)
    weighted = np.broadcast_to(sensitivity, shape) * model.weight
    real = weighted[:, None, :] * smooth_functions(model.evidence.frequency, FUNCTIONS)
    both = np.concatenate([real, 1j * real], axis=1)
    missing = np.zeros((both.shape[0], both.shape[1], model.rows - s.size), dtype=complex)
    return np.concatenate([both, missing], axis=-1)


def _speed_at(port: str, system: DrillingSystem, s: Complex) -> Any:
    """Speed at a port per speed of the string's top; by reciprocity also the torque that reaches the top from there."""
    if port == "top":
        return 1.0
    if port == "bit":
        return bit_speed_ratio(system, s)
    pipe, *below = system.string
    share = _PLACES[port]
    lower = replace(system, string=(replace(pipe, length=pipe.length * (1 - share)), *below))
    return speed_ratio(replace(pipe, length=pipe.length * share), string_admittance(lower, s), s)


def log_evidence(score: Floats, information: Floats) -> Floats:
    """Log Bayes factor of a Gaussian disturbance against none, its amplitude averaged over AMPLITUDES.

    Parameters
    ----------
    score : shape (..., 2 FUNCTIONS)
    information : shape (2 FUNCTIONS, 2 FUNCTIONS)
    """
    from scipy.special import logsumexp

    values, vectors = np.linalg.eigh(information)
    power = (score @ vectors) ** 2
    variance = AMPLITUDES[:, None] ** 2
    shrunk = variance / (1 + variance * np.maximum(values, 0.0))
    each = 0.5 * power @ shrunk.T - 0.5 * np.sum(np.log1p(variance * np.maximum(values, 0.0)), axis=1)
    return np.asarray(logsumexp(each, axis=-1) - np.log(AMPLITUDES.size), dtype=float)
