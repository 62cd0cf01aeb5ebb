"""Where along the string the model is wrong: measured less modelled reflection, seen from the string's top.

The mobility gives the string's input admittance, and this the reflection of the wave that travels down the pipe. The
part that the model does not explain, transformed to the time domain, is an echo at the distance of a reflection that
the model lacks (time-domain reflectometry).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.special import ndtri

from drillid.arrays import Complex, Floats
from drillid.discrepancy.inference.coordinates import Extension
from drillid.discrepancy.inference.projection import project
from drillid.discrepancy.inference.set_fit import SetFit
from drillid.discrepancy.inference.set_model import SetModel
from drillid.physics.equipment import STEEL_DENSITY, STEEL_SHEAR_MODULUS
from drillid.physics.line import propagation
from drillid.physics.responses import string_admittance
from drillid.physics.top_drive import torque_transfers

PLACES = 200
"""Distances along the string."""
_WORTH = 0.1
"""Smallest echo of interest: frequencies whose noise is below it have equal weights."""


@dataclass(frozen=True, eq=False)
class Reflectogram:
    """Echoes that the model does not explain, averaged over a set's windows."""

    distance: Floats
    """(PLACES,) m along the string from its top."""
    reflection: Floats
    """(PLACES,) 1, relative to the incident wave."""
    level: Floats
    """(PLACES,) level that noise alone exceeds anywhere only with the error rate."""


def reflectogram(model: SetModel, fit: SetFit, extensions: tuple[Extension, ...], error_rate: float) -> Reflectogram:
    """The reflectogram of the residuals of a fitted model.

    The reflection at each distance is a linear function of the whitened residuals; its noise is the part of that
    function that the fitted coordinates do not absorb. The level is corrected for one test at every distance (Šidák
    1967).

    Parameters
    ----------
    error_rate : probability that noise alone exceeds the level anywhere
    """
    longest = float(np.max(model.evidence.operating_points.bit_depth))
    distance = np.linspace(0.0, 1.05 * longest, PLACES)
    projection = project(model, fit, extensions, _directions(model, fit, extensions, distance))
    deviation = np.sqrt(np.diag(projection.information))
    limit = float(-ndtri(-np.expm1(np.log1p(-error_rate) / PLACES) / 2))
    return Reflectogram(distance, projection.score, limit * deviation)


def _directions(model: SetModel, fit: SetFit, extensions: tuple[Extension, ...], distance: Floats) -> Complex:
    """Functions (W, PLACES, rows) whose products with the whitened residuals are the reflection at each distance.

    Windows and frequencies are weighted by the noise of their reflection, and by a Hann window against ringing.
    """
    window_model = model.window_model_at(fit.point, extensions).held()
    s, system, mobility = model.s, window_model.system, window_model.mobility(model.s)
    admittance, characteristic = string_admittance(system, s), propagation(system.string[0], s)[1]
    command, _ = torque_transfers(system.top_drive, s)
    # R = (Y₀ − Y)/(Y₀ + Y) with Y = W R_record/M less the admittance of the top drive
    of_admittance = -2 * characteristic / (characteristic + admittance) ** 2
    per_mobility = of_admittance * -command * window_model.recording.transfer(s) / mobility**2
    good = model.measured.weight > 0
    per_residual = np.where(good, per_mobility / np.where(good, model.measured.weight, 1.0), 0.0)
    share = np.where(good, np.hanning(s.size + 2)[1:-1] / (np.abs(per_residual) ** 2 + _WORTH**2), 0.0)
    weighted = per_residual * share / share.sum()
    delay = 2 * distance * np.sqrt(STEEL_DENSITY / STEEL_SHEAR_MODULUS)
    advance = np.exp(delay[:, None] * s)
    of_mobility = np.conj(weighted[:, None, :] * advance)
    of_control = np.zeros((*of_mobility.shape[:2], model.measured.count - s.size), dtype=complex)
    return np.concatenate([of_mobility, of_control], axis=-1)
