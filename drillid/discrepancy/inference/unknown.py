"""What the catalogue lacks: disturbances of unknown shape at ports and along the pipe, and values off the data sheets.

At each port the response is disturbed by a smooth complex function of log frequency, with a Gaussian prior of unknown
amplitude: a discrepancy in the sense of Kennedy and O'Hagan (2001, Journal of the Royal Statistical Society B 63,
425–464), written in a basis so that it is one more linear model. Along the pipe its polar moment is disturbed, by sines
and cosines of the place: what repeats itself along a string reflects within a narrow band (Brillouin 1946, Wave
Propagation in Periodic Structures), which no smooth function of frequency shows. What the fitted parameters absorb of
all this shows up against the data sheets: one stated parameter, or all, may lie off them by more than the tolerances.
"""

from collections.abc import Iterable
from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np

from drillid.arrays import Complex, Floats
from drillid.discrepancy.catalogue.cause import WindowModel
from drillid.discrepancy.inference.coordinates import COORDINATES, DATA_SHEET, Extension
from drillid.discrepancy.inference.set_fit import SetFit
from drillid.discrepancy.inference.set_model import SetModel
from drillid.discrepancy.inference.smooth import smooth_functions
from drillid.discrepancy.rules import REJECTED_CHI2, WRONG_VALUES
from drillid.physics.equipment import DrillingSystem
from drillid.physics.line import profile_slopes, speed_ratio
from drillid.physics.responses import bit_speed_ratio, string_admittance
from drillid.physics.top_drive import torque_transfers

RELATIVE = ("record", "drive", "control")
"""Ports at which a disturbance multiplies the record, the torque of the drive, or the response of the control."""
PORTS = (*RELATIVE, "top", "upper string", "lower string", "bit")
"""At the others it adds an admittance: at the string's top, at a third and at two thirds of the pipe, at the bit."""
ALONG_PIPE = "pipe"
ON_DATA_SHEET = "data sheet"
ROUGH = "record"
"""Where a disturbance counts as acting that is no smooth function of frequency, such as images of other lines."""
CHANNELS = (*PORTS, ALONG_PIPE, ON_DATA_SHEET)
"""Where something unknown may show."""
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
"""Smooth functions over the band, each with real and imaginary part, and periods along the pipe, cosine and sine."""
_REACHES = (0.0, 6.0)
"""Correlation lengths tried for a disturbance, in basis functions: rough, and as smooth as a gain or a delay."""
AMPLITUDES = 10.0 ** np.arange(-2.5, 0.6, 0.5)
"""Prior standard deviations that are tried, relative to the response or to the pipe's characteristic admittance."""
_OFF_DATA_SHEET = np.array([3.0, 10.0, 30.0])
"""The same for parameters off the data sheets, in tolerances."""


def directions(model: SetModel, fit: SetFit, extensions: tuple[Extension, ...], channel: str) -> Complex:
    """Whitened directions (W, K, rows) of an unknown disturbance that is the same in all windows.

    A port and the pipe have 2 FUNCTIONS of them; the data sheets have one for each parameter that they state, in
    tolerances.
    """
    if channel == ON_DATA_SHEET:
        slopes = model.linearised(fit.point, extensions).jacobian[:, DATA_SHEET]
        return np.asarray(slopes * model.priors.error[DATA_SHEET, None], dtype=complex)
    if channel == ALONG_PIPE:
        return _along_pipe(model, fit, extensions)
    basis = smooth_functions(model.evidence.frequency, FUNCTIONS)
    sensitivities = _sensitivity(model, fit, extensions, channel)
    real = model.measured.whitened(*(sensitivity[:, None] * basis for sensitivity in sensitivities))
    return np.concatenate([real, 1j * real], axis=1)


def _sensitivity(model: SetModel, fit: SetFit, extensions: tuple[Extension, ...], port: str) -> tuple[Complex, Complex]:
    """Changes of the mobilities and of the control's responses, (W, F) each, by a unit disturbance at a port."""
    window_model, s = model.window_model_at(fit.point, extensions).held(), model.s
    shape = (model.evidence.windows, s.size)
    responses = window_model.mobility(s), window_model.control(s)
    mobility, control = (np.broadcast_to(response, shape) for response in responses)
    if port == "record":
        # the control acts on the true speed, so that its response to the recorded speed changes the opposite way
        return mobility, -control
    if port == "drive":
        return mobility * (1 - mobility * control), np.zeros_like(control)
    if port == "control":
        return -(mobility**2) * control, control
    to_admittance = _to_admittance(window_model, mobility, s) * _speed_at(port, window_model.system, s) ** 2
    return to_admittance * window_model.system.string[0].characteristic_admittance, np.zeros_like(control)


def _to_admittance(held: WindowModel, mobility: Complex, s: Complex) -> Complex:
    """Derivative of the mobility (W, F) to the string's admittance."""
    drive, _ = torque_transfers(held.system.top_drive, s)
    return np.asarray(-(mobility**2) / (held.recording.transfer(s) * drive), dtype=complex)


def _along_pipe(model: SetModel, fit: SetFit, extensions: tuple[Extension, ...]) -> Complex:
    """Whitened directions (W, 2 FUNCTIONS, rows) of relative changes of the pipe's polar moment along the string.

    They have 1 to FUNCTIONS periods along the pipe, first the cosines.
    """
    held, s = model.window_model_at(fit.point, extensions).held(), model.s
    mobility = np.broadcast_to(held.mobility(s), (model.evidence.windows, s.size))
    pipe, *below = model.window_model_at(fit.point).system.string
    load = string_admittance(replace(held.system, string=tuple(below)), s)
    to_profile = _to_admittance(held, mobility, s)[:, None] * profile_slopes(pipe, load, s, FUNCTIONS)
    return model.measured.whitened(to_profile, np.zeros_like(to_profile))


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


def evidence_off_data_sheet(model: SetModel, fit: SetFit) -> float:
    """Log Bayes factor of stated values off by a cause, against errors each of its own, where a value that no one
    measures may be plainly wrong.

    One value is off, or several are and each has even odds to be, by errors of a size of _OFF_DATA_SHEET. Unlike
    `log_evidence` it holds however far out the values are, where their heavy-tailed priors have no slope.
    """
    from scipy.special import logsumexp
    from scipy.stats import norm

    stated = [place for place in DATA_SHEET if model.is_stated[place]]
    off, priors = fit.off_data_sheet[stated], fit.priors.of(np.array(stated, dtype=int))
    more = norm.logpdf(off, scale=_OFF_DATA_SHEET[:, None]) - priors.log_density(off)
    several = np.sum(np.logaddexp(0.0, more) - np.log(2.0), axis=1, keepdims=True)
    off_by_cause = np.concatenate([more, several], axis=1)
    wrong = logsumexp(more, axis=0) - np.log(len(more)) + np.log(WRONG_VALUES)
    each_alone = np.where(priors.doubted, 0.0, np.logaddexp(np.log1p(-WRONG_VALUES), wrong))
    return float(logsumexp(off_by_cause) - np.log(off_by_cause.size) - each_alone.sum())


def leaves_rough_residuals(model: SetModel, fit: SetFit) -> bool:
    """Whether residuals are larger than noise can be, whatever the error of its estimate."""
    return fit.chi2 > REJECTED_CHI2 * model.measured.residuals


def evidence_of_roughness(model: SetModel, fit: SetFit) -> float:
    """Log Bayes factor of residuals larger than noise can be, as rough as noise, against noise at the largest error of
    its estimate: of a variance that they determine, less Schwarz's penalty of one parameter.
    """
    residuals = model.measured.residuals
    ratio = max(fit.chi2 / (REJECTED_CHI2 * residuals), 1.0)
    return float(0.5 * residuals * (ratio - 1 - np.log(ratio)) - 0.5 * np.log(residuals))


def furthest_off_data_sheet(fit: SetFit) -> str:
    """Which fitted parameter lies furthest off the data sheets, in words."""
    tolerances = fit.off_data_sheet[list(DATA_SHEET)]
    furthest = int(np.argmax(np.abs(tolerances)))
    name, side = _IN_WORDS[COORDINATES[DATA_SHEET[furthest]]], "above" if tolerances[furthest] > 0 else "below"
    return f"the fitted {name} lies {abs(tolerances[furthest]):.1f} tolerances {side} the data sheets"


@cache
def prior_roots() -> Floats:
    """Factors R of prior covariances R Rᵀ of a disturbance of amplitude one, (smoothness, 2 FUNCTIONS, 2 FUNCTIONS)."""
    distance = np.subtract.outer(np.arange(FUNCTIONS), np.arange(FUNCTIONS))
    roots = []
    for reach in _REACHES:
        correlation = np.exp(-0.5 * (distance / reach) ** 2) if reach else np.eye(FUNCTIONS)
        values, vectors = np.linalg.eigh(correlation)
        roots.append(np.kron(np.eye(2), vectors * np.sqrt(np.maximum(values, 0.0))))
    return np.stack(roots)


def log_evidence(channel: str, score: Floats, information: Floats) -> Floats:
    """Log Bayes factor of something unknown against nothing, averaged over its size.

    A disturbance has one of the priors of `prior_roots`; along the pipe it has all numbers of periods or only one; of
    the data sheets, all stated parameters are off or only one.

    Parameters
    ----------
    channel : one of CHANNELS
    score : shape (..., K)
    information : shape (K, K)
    """
    if channel == ON_DATA_SHEET:
        all_parameters = np.eye(len(DATA_SHEET))
        return _averaged(score, information, [all_parameters, *all_parameters[:, :, None]], _OFF_DATA_SHEET)
    if channel == ALONG_PIPE:
        both = np.eye(2 * FUNCTIONS)
        pairs = [both[:, [number, number + FUNCTIONS]] for number in range(FUNCTIONS)]
        return _averaged(score, information, [both, *pairs], AMPLITUDES)
    return _averaged(score, information, prior_roots(), AMPLITUDES)


def _averaged(score: Floats, information: Floats, roots: Iterable[Floats], amplitudes: Floats) -> Floats:
    """Log Bayes factor of Gaussian sizes with covariances a² R Rᵀ, averaged over factors R and over amplitudes a."""
    from scipy.special import logsumexp

    by_root, variance = [], amplitudes[:, None] ** 2
    for root in roots:
        values, vectors = np.linalg.eigh(root.T @ information @ root)
        values = np.maximum(values, 0.0)
        power = (score @ root @ vectors) ** 2
        shrunk = variance / (1 + variance * values)
        by_root.append(0.5 * power @ shrunk.T - 0.5 * np.sum(np.log1p(variance * values), axis=1))
    joined = np.concatenate(by_root, axis=-1)
    return np.asarray(logsumexp(joined, axis=-1) - np.log(joined.shape[-1]), dtype=float)
