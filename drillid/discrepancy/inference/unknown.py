"""What the catalogue does not hold: smooth disturbances of unknown shape at the ports, or data sheets that do not fit.

At each port the response is disturbed by a smooth complex function of log frequency, with a Gaussian prior of unknown
amplitude: a discrepancy in the sense of Kennedy and O'Hagan (2001, Journal of the Royal Statistical Society B 63,
425–464), written in a basis so that it is one more linear model. What the fitted figures take up of it shows where the
data sheets know them: one of these, or all, may lie off the data sheets by more than their tolerances.
"""

from collections.abc import Iterable
from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np

from drillid.arrays import Complex, Floats
from drillid.discrepancy.inference.set_fit import SetFit
from drillid.discrepancy.inference.set_model import DATA_SHEET, SCALED, Extension, SetModel
from drillid.physics.equipment import DrillingSystem
from drillid.physics.line import speed_ratio
from drillid.physics.responses import bit_speed_ratio, string_admittance
from drillid.physics.top_drive import torque_transfers

RELATIVE = ("record", "drive", "control")
"""Ports at which a disturbance multiplies what is recorded, the torque that is made, or what the control answers."""
PORTS = (*RELATIVE, "top", "upper string", "lower string", "bit")
"""At the others it adds an admittance: at the string's top, at a third and at two thirds of the pipe, at the bit."""
ON_DATA_SHEET = "papers"
CHANNELS = (*PORTS, ON_DATA_SHEET)
"""Where what is unknown may show."""
_IN_WORDS = {
    "length": "length of the string",
    "polar_moment": "polar moment of the pipe",
    "delay": "delay of the drive",
    "inertia_td": "inertia of the top drive",
    "P": "P gain of the control",
    "I": "I gain of the control",
    "clock": "offset between the clocks",
}
_PLACES = {"upper string": 1 / 3, "lower string": 2 / 3}
FUNCTIONS = 12
"""Smooth functions over the band, each with real and imaginary part."""
_REACHES = (0.0, 6.0)
"""Functions over which a disturbance stays alike, as tried: rough, and as smooth as a gain or a delay."""
AMPLITUDES = 10.0 ** np.arange(-2.5, 0.6, 0.5)
"""Standard deviations tried, relative to the response or to the pipe's characteristic admittance."""
_OFF_DATA_SHEET = np.array([3.0, 10.0, 30.0])
"""The same of figures off the data sheets, in tolerances."""


def smooth_functions(frequency: Floats, count: int) -> Floats:
    """Cubic B-splines over log frequency, (count, F)."""
    from scipy.interpolate import BSpline

    position = np.log(frequency / frequency[0]) / np.log(frequency[-1] / frequency[0])
    inner = np.linspace(0.0, 1.0, count - 2)
    knots = np.concatenate([[0.0] * 3, inner, [1.0] * 3])
    return np.asarray(BSpline.design_matrix(np.clip(position, 0.0, 1.0), knots, 3).toarray().T, dtype=float)


def directions(model: SetModel, fit: SetFit, extensions: tuple[Extension, ...], channel: str) -> Complex:
    """Whitened directions (W, K, rows) of what is unknown, the same in all windows.

    A disturbance at a port has 2 FUNCTIONS of them; of data sheets each figure that they know has one, in tolerances.
    """
    if channel == ON_DATA_SHEET:
        slopes = model.linearised(fit.point, extensions).jacobian[:, DATA_SHEET]
        return np.asarray(slopes * model.prior_error[DATA_SHEET, None], dtype=complex)
    basis = smooth_functions(model.evidence.frequency, FUNCTIONS)
    real = model.changed(*(one[:, None] * basis for one in _sensitivity(model, fit, extensions, channel)))
    return np.concatenate([real, 1j * real], axis=1)


def _sensitivity(model: SetModel, fit: SetFit, extensions: tuple[Extension, ...], port: str) -> tuple[Complex, Complex]:
    """Change of the mobilities and of the control's responses, (W, F) each, by a disturbance of one at a port."""
    window_model, s = model.window_model_at(fit.point, extensions), model.s
    shape = (model.evidence.windows, s.size)
    mobility, answer = (np.broadcast_to(one, shape) for one in (window_model.mobility(s), window_model.control(s)))
    if port == "record":
        # the control acts on the speed itself, so that its answer to the record turns the other way
        return mobility, -answer
    if port == "drive":
        return mobility * (1 - mobility * answer), np.zeros_like(answer)
    if port == "control":
        return -(mobility**2) * answer, answer
    drive, _ = torque_transfers(window_model.system.top_drive, s)
    sensitivity = (
        -(mobility**2) / (window_model.recording.transfer(s) * drive) * _speed_at(port, window_model.system, s) ** 2
    )
    return sensitivity * window_model.system.string[0].characteristic_admittance, np.zeros_like(answer)


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


def furthest_off_data_sheet(fit: SetFit) -> str:
    """Which fitted figure lies furthest off the data sheets, in words."""
    tolerances = fit.off_data_sheet[list(DATA_SHEET)]
    place = int(np.argmax(np.abs(tolerances)))
    name, side = _IN_WORDS[SCALED[DATA_SHEET[place]]], "above" if tolerances[place] > 0 else "below"
    return f"the fitted {name} lies {abs(tolerances[place]):.1f} tolerances {side} the data sheets"


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


def log_evidence(channel: str, score: Floats, information: Floats) -> Floats:
    """Log Bayes factor of something unknown against nothing, averaged over its size.

    A disturbance is as smooth as any of `prior_roots`; off the data sheets are all of their figures or one of them.

    Parameters
    ----------
    channel : one of CHANNELS
    score : shape (..., K)
    information : shape (K, K)
    """
    if channel == ON_DATA_SHEET:
        every = np.eye(len(DATA_SHEET))
        return _averaged(score, information, [every, *every[:, :, None]], _OFF_DATA_SHEET)
    return _averaged(score, information, prior_roots(), AMPLITUDES)


def _averaged(score: Floats, information: Floats, roots: Iterable[Floats], amplitudes: Floats) -> Floats:
    """Log Bayes factor of Gaussian sizes with covariances a² R Rᵀ, averaged over factors R and over amplitudes a."""
    from scipy.special import logsumexp

    each, variance = [], amplitudes[:, None] ** 2
    for root in roots:
        values, vectors = np.linalg.eigh(root.T @ information @ root)
        values = np.maximum(values, 0.0)
        power = (score @ root @ vectors) ** 2
        shrunk = variance / (1 + variance * values)
        each.append(0.5 * power @ shrunk.T - 0.5 * np.sum(np.log1p(variance * values), axis=1))
    joined = np.concatenate(each, axis=-1)
    return np.asarray(logsumexp(joined, axis=-1) - np.log(joined.shape[-1]), dtype=float)
