"""Where along the string the model goes wrong: measured less modelled reflection seen from the string's top.

The mobility gives the string's input admittance, and that the reflection of the wave that runs down the pipe. What
the model leaves of it, brought back to the time domain, is an echo at the distance where something sends waves up
that the model does not (time-domain reflectometry).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.special import ndtri

from drillid.arrays import Complex, Floats
from drillid.discrepancy.inference.projection import project
from drillid.discrepancy.inference.set_fit import SetFit
from drillid.discrepancy.inference.set_model import Extension, SetModel
from drillid.physics.equipment import STEEL_DENSITY, STEEL_SHEAR_MODULUS
from drillid.physics.line import propagation
from drillid.physics.responses import string_admittance
from drillid.physics.top_drive import torque_transfers

PLACES = 200
"""Distances along the string."""
_WORTH = 0.1
"""Echo that is worth knowing: frequencies whose noise is below it count alike."""


@dataclass(frozen=True, eq=False)
class Reflectogram:
    """Echoes that the model does not explain, averaged over a set's windows."""

    distance: Floats
    """(PLACES,) m along the string from its top."""
    reflection: Floats
    """(PLACES,) 1, of the wave that runs down."""
    level: Floats
    """(PLACES,) size that noise alone passes nowhere, but for the error rate."""


def reflectogram(model: SetModel, fit: SetFit, extensions: tuple[Extension, ...], error_rate: float) -> Reflectogram:
    """The reflectogram of what a fitted model leaves over.

    Each distance is a linear function of the whitened residuals; its noise is what of that function the fitted
    figures leave free. The level counts every distance as a test of its own (Šidák 1967).

    Parameters
    ----------
    error_rate : chance that noise alone passes the level anywhere
    """
    longest = float(np.max(model.evidence.operating_points.bit_depth))
    distance = np.linspace(0.0, 1.05 * longest, PLACES)
    projection = project(model, fit, extensions, _directions(model, fit, extensions, distance))
    deviation = np.sqrt(np.diag(projection.information))
    limit = float(-ndtri(-np.expm1(np.log1p(-error_rate) / PLACES) / 2))
    return Reflectogram(distance, projection.score, limit * deviation)


def _directions(model: SetModel, fit: SetFit, extensions: tuple[Extension, ...], distance: Floats) -> Complex:
    """Functions (W, PLACES, rows) whose products with the whitened residuals are the reflection at each distance.

    Windows and frequencies count by the noise of their reflection, times a Hann window so that one echo does not
    ring.
    """
    window_model = model.window_model_at(fit.point, extensions)
    s, system, mobility = model.s, window_model.system, window_model.mobility(model.s)
    admittance, characteristic = string_admittance(system, s), propagation(system.string[0], s)[1]
    command, _ = torque_transfers(system.top_drive, s)
    # R = (Y₀ − Y)/(Y₀ + Y) with Y = W R_record/M less what the top drive takes
    of_admittance = -2 * characteristic / (characteristic + admittance) ** 2
    per_mobility = of_admittance * -command * window_model.recording.transfer(s) / mobility**2
    good = model.weight > 0
    per_residual = np.where(good, per_mobility / np.where(good, model.weight, 1.0), 0.0)
    share = np.where(good, np.hanning(s.size + 2)[1:-1] / (np.abs(per_residual) ** 2 + _WORTH**2), 0.0)
    weighted = per_residual * share / share.sum()
    delay = 2 * distance * np.sqrt(STEEL_DENSITY / STEEL_SHEAR_MODULUS)
    turned = np.exp(delay[:, None] * s)
    found = np.conj(weighted[:, None, :] * turned)
    missing = np.zeros((*found.shape[:2], model.rows - s.size), dtype=complex)
    return np.concatenate([found, missing], axis=-1)


def echoes(found: Reflectogram) -> list[tuple[float, float]]:
    """Distance (m) and size of every local extreme beyond the level, largest first."""
    size = np.abs(found.reflection)
    inner = (size[1:-1] >= size[:-2]) & (size[1:-1] >= size[2:]) & (size[1:-1] > found.level[1:-1])
    rows = np.flatnonzero(inner) + 1
    return sorted(
        ((float(found.distance[row]), float(found.reflection[row])) for row in rows), key=lambda one: -abs(one[1])
    )
