"""What the catalogue does not hold: smooth disturbances of unknown shape at the ports of the rig.

At each port the response is disturbed by a smooth complex function of log frequency, with a Gaussian prior of unknown
amplitude: a discrepancy in the sense of Kennedy and O'Hagan (2001, Journal of the Royal Statistical Society B 63,
425–464), written in a basis so that it is one more linear model.
"""

from dataclasses import replace
from functools import cache
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

RELATIVE = ("record", "drive", "control")
"""Ports at which a disturbance multiplies what is recorded, the torque that is made, or what the control answers."""
PORTS = (*RELATIVE, "top", "upper string", "lower string", "bit")
"""At the others it adds an admittance: at the string's top, at a third and at two thirds of the pipe, at the bit."""
_PLACES = {"upper string": 1 / 3, "lower string": 2 / 3}
FUNCTIONS = 12
"""Smooth functions over the band, each with real and imaginary part."""
_REACHES = (0.0, 6.0)
"""Functions over which a disturbance stays alike, as tried: rough, and as smooth as a gain or a delay."""
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
    basis = smooth_functions(model.evidence.frequency, FUNCTIONS)
    real = model.changed(*(one[:, None] * basis for one in _sensitivity(model, fit, extensions, port)))
    return np.concatenate([real, 1j * real], axis=1)


def _sensitivity(model: SetModel, fit: SetFit, extensions: tuple[Extension, ...], port: str) -> tuple[Complex, Complex]:
    """Change of the mobilities and of the control's responses, (W, F) each, by a disturbance of one at a port."""
    setup, s = model.setup_at(fit.point, extensions), model.s
    shape = (model.evidence.windows, s.size)
    mobility, answer = (np.broadcast_to(one, shape) for one in (setup.mobility(s), setup.control(s)))
    if port == "record":
        # the control acts on the speed itself, so that its answer to the record turns the other way
        return mobility, -answer
    if port == "drive":
        return mobility * (1 - mobility * answer), np.zeros_like(answer)
    if port == "control":
        return -(mobility**2) * answer, answer
    drive, _ = torque_transfers(setup.system.top_drive, s)
    sensitivity = -(mobility**2) / (setup.recording.transfer(s) * drive) * _speed_at(port, setup.system, s) ** 2
    return sensitivity * setup.system.string[0].characteristic_admittance, np.zeros_like(answer)


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


@cache
def prior_roots() -> Floats:
    """Factors R of prior covariances R Rᵀ of a disturbance of amplitude one, (smoothness, 2 FUNCTIONS, 2 FUNCTIONS)."""
    apart = np.subtract.outer(np.arange(FUNCTIONS), np.arange(FUNCTIONS))
    roots = []
    for reach in _REACHES:
        alike = np.exp(-0.5 * (apart / reach) ** 2) if reach else np.eye(FUNCTIONS)
        values, vectors = np.linalg.eigh(alike)
        roots.append(np.kron(np.eye(2), vectors * np.sqrt(np.maximum(values, 0.0))))
    return np.stack(roots)


def log_evidence(score: Floats, information: Floats) -> Floats:
    """Log Bayes factor of a Gaussian disturbance against none, averaged over how smooth it is and over AMPLITUDES.

    Parameters
    ----------
    score : shape (..., 2 FUNCTIONS)
    information : shape (2 FUNCTIONS, 2 FUNCTIONS)
    """
    from scipy.special import logsumexp

    each, variance = [], AMPLITUDES[:, None] ** 2
    for root in prior_roots():
        values, vectors = np.linalg.eigh(root.T @ information @ root)
        values = np.maximum(values, 0.0)
        power = (score @ root @ vectors) ** 2
        shrunk = variance / (1 + variance * values)
        each.append(0.5 * power @ shrunk.T - 0.5 * np.sum(np.log1p(variance * values), axis=1))
    joined = np.concatenate(each, axis=-1)
    return np.asarray(logsumexp(joined, axis=-1) - np.log(joined.shape[-1]), dtype=float)
