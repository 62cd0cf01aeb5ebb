"""The Gaussian process that explains a misfit best: its port and kernel by the marginal likelihood of the data.

About the base fit the model is linear in the process, so that all nuisance parameters and the process itself are
integrated out in closed form; the chosen one is then fitted to the model itself.
"""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
from scipy.linalg import cho_factor, cho_solve
from scipy.special import logsumexp

from drillid.arrays import Floats
from drillid.discrepancy.inference.coordinates import SHARED, Extension, Point
from drillid.discrepancy.inference.projection import Projection, project
from drillid.discrepancy.inference.set_fit import SetFit, fit_set
from drillid.discrepancy.inference.set_model import SetModel
from drillid.discrepancy.inference.unknown import RELATIVE
from drillid.discrepancy.learning.process import AMPLITUDES, RATES, process_at
from drillid.physics.gaussian_process import COUNT
from drillid.physics.responses import string_admittance

_FITTED = 2
"""Ports at which a process is fitted to the model itself."""
_LEAST_PART = -1e-9
"""Lower bound of the real part of the string's admittance, relative to its largest modulus: down to it is rounding."""


def fitted_process(
    model: SetModel, base: SetFit, ports: Iterable[str]
) -> tuple[str, tuple[Extension, ...], SetFit] | None:
    """The process of largest marginal likelihood at any of some ports: port, terms and fit; None where the evidence,
    averaged over the kernels, supports none.

    A process along the string that would make the string supply energy in the band is used only where there is no
    other.
    """
    ranked = sorted((_best_kernel(model, base, port) for port in ports), key=lambda each: -each[0])
    ranked = [each for each in ranked if each[0] > 0]
    if not ranked:
        return None
    found = []
    for _, port, kernel, sizes in ranked[:_FITTED]:
        extensions = process_at(port, kernel)
        fit = fit_set(model, Point(base.point.shared, base.point.local, sizes), extensions)
        found.append((not is_passive(model, fit, extensions), -_log_marginal(fit), port, extensions, fit))
    _, _, port, extensions, fit = min(found, key=lambda each: each[:2])
    return port, extensions, fit


def is_passive(model: SetModel, fit: SetFit, extensions: tuple[Extension, ...]) -> bool:
    """Whether the string with its extensions supplies no energy at any line of the band."""
    if all(extension.cause.port in RELATIVE for extension in extensions):
        return True
    admittance = np.asarray(string_admittance(model.window_model_at(fit.point, extensions).system, model.s))
    return bool(np.all(admittance.real >= _LEAST_PART * np.abs(admittance).max()))


def _best_kernel(model: SetModel, base: SetFit, port: str) -> tuple[float, str, int, Floats]:
    """Log evidence at a port averaged over the kernels, the port, the best kernel's number, and its process's mean."""
    tried: list[tuple[float, int, Floats]] = []
    unit = AMPLITUDES.index(1.0)
    for number in range(len(RATES)):
        kernel = number * len(AMPLITUDES) + unit
        point = Point(base.point.shared, base.point.local, np.zeros(COUNT))
        directions = model.linearised(point, process_at(port, kernel)).jacobian[:, SHARED:]
        projection = project(model, base, (), directions)
        for place, amplitude in enumerate(AMPLITUDES):
            evidence, mean = _evidence(projection, amplitude)
            tried.append((evidence, number * len(AMPLITUDES) + place, mean))
    _, kernel, mean = max(tried, key=lambda each: each[0])
    averaged = float(logsumexp([evidence for evidence, _, _ in tried]) - np.log(len(tried)))
    return averaged, port, kernel, mean


def _evidence(projection: Projection, amplitude: float) -> tuple[float, Floats]:
    """Log evidence for a process of an amplitude against none, and the mean of its coefficients."""
    precision = np.eye(COUNT) + amplitude**2 * projection.information
    factor = cho_factor(precision)
    mean = cho_solve(factor, amplitude * projection.score)
    determinant = 2 * float(np.sum(np.log(np.diag(factor[0]))))
    return 0.5 * float(amplitude * projection.score @ mean) - 0.5 * determinant, np.asarray(mean, dtype=float)


def _log_marginal(fit: SetFit) -> float:
    """Laplace's approximation of the log marginal likelihood, up to terms that all processes have in common."""
    return -fit.cost - 0.5 * float(np.linalg.slogdet(fit.information)[1])
