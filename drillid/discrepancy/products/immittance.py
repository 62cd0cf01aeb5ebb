"""What the model lacks at the port that localises an unknown misfit: admittance, rational fit, interpretation.

The smooth disturbance of `unknown` has a Gaussian posterior; its mean is the admittance that the data show at the port
in addition to the model's. It is fitted by AAA (Nakatsukasa, Sète and Trefethen 2018, SIAM Journal on Scientific
Computing 40, A1494–A1522) and read as a spring, an inertia and a damping, or as a gain and a delay.
"""

from __future__ import annotations

import warnings
from dataclasses import dataclass

import numpy as np
from scipy.special import softmax

from drillid.arrays import Complex, Floats
from drillid.discrepancy.inference import unknown
from drillid.discrepancy.inference.coordinates import Extension
from drillid.discrepancy.inference.projection import Projection, project
from drillid.discrepancy.inference.set_fit import SetFit
from drillid.discrepancy.inference.set_model import SetModel
from drillid.discrepancy.inference.smooth import smooth_functions
from drillid.discrepancy.rules import PART_READ

_TERMS = 8
"""Largest number of support points of the rational fit."""
_ROWS = 200
"""Frequencies at which posterior draws of the curve are compared."""


@dataclass(frozen=True, eq=False)
class Immittance:
    """The admittance, or the relative change, that the model lacks at a port."""

    port: str
    values: Complex
    """(F,) posterior mean of the admittance, N m s/rad; at `unknown.RELATIVE` ports the share of what they multiply."""
    deviation: Floats
    """(F,) posterior standard deviation of real and imaginary part."""
    rational: Complex
    """(F,) the rational fit; where it is passive its real part is nowhere negative."""
    passive: bool
    """Whether the admittance supplies no energy anywhere in the band, within twice its deviation."""
    reading: str
    """Physical interpretation, in words."""


def missing_immittance(model: SetModel, fit: SetFit, port: str, extensions: tuple[Extension, ...] = ()) -> Immittance:
    """De-embed the part that a model lacks at a port, from all windows together.

    Parameters
    ----------
    fit : of the model with `extensions`
    port : one of `unknown.PORTS`
    """
    projection = project(model, fit, extensions, unknown.directions(model, fit, extensions, port))
    mean, covariance = _posterior(projection)
    basis = smooth_functions(model.evidence.frequency, unknown.FUNCTIONS)
    half = basis.shape[0]
    relative, scale = port in unknown.RELATIVE, 1.0
    if not relative:
        system = model.window_model_at(fit.point).system
        scale = float(np.mean(system.string[0].characteristic_admittance))
    values = np.asarray(scale * (mean[:half] + 1j * mean[half:]) @ basis, dtype=complex)
    variances = [np.einsum("kf,kl,lf->f", basis, block, basis) for block in _blocks(covariance, half)]
    deviation = scale * np.sqrt(np.maximum(sum(variances) / 2, 0.0))
    rational = _rational(model.evidence.frequency, values, deviation)
    passive = relative or bool(np.all(rational.real >= -2 * deviation))
    if passive and not relative:
        # within its deviation the part is taken to be passive
        rational = rational + max(0.0, -float(rational.real.min()))
    reading = _read_factor if relative else _read_admittance
    response = np.concatenate([scale * basis.T, 1j * scale * basis.T], axis=1)
    return Immittance(port, values, deviation, rational, passive, reading(model.s, mean, covariance, response))


def _blocks(covariance: Floats, half: int) -> tuple[Floats, Floats]:
    return covariance[:half, :half], covariance[half:, half:]


def _posterior(projection: Projection) -> tuple[Floats, Floats]:
    """Mean and covariance of the disturbance's coefficients, averaged over amplitudes and smoothness by evidence."""
    evidence, means, covariances = [], [], []
    for root in unknown.prior_roots():
        information, score = root.T @ projection.information @ root, root.T @ projection.score
        for amplitude in unknown.AMPLITUDES:
            covariance = np.linalg.inv(information + np.eye(score.size) / amplitude**2)
            mean = covariance @ score
            log_determinant = np.linalg.slogdet(np.eye(score.size) + amplitude**2 * information)[1]
            evidence.append(0.5 * score @ mean - 0.5 * log_determinant)
            means.append(root @ mean)
            covariances.append(root @ covariance @ root.T)
    share = softmax(evidence)
    mean = np.einsum("a,ai->i", share, np.array(means))
    offset = np.array(means) - mean
    within = np.einsum("a,aij->ij", share, np.array(covariances))
    return mean, within + np.einsum("a,ai,aj->ij", share, offset, offset)


def _rational(frequency: Floats, values: Complex, deviation: Floats) -> Complex:
    """AAA on the curve and its mirror image at negative frequencies, so that coefficients are real."""
    from scipy.interpolate import AAA

    step = max(1, frequency.size // _ROWS)
    s = 2j * np.pi * frequency[::step]
    largest = float(np.abs(values).max())
    tolerance = max(float(np.median(deviation)) / max(largest, 1e-300), 1e-6)
    points, curve = np.concatenate([s, s.conj()]), np.concatenate([values[::step], values[::step].conj()])
    with warnings.catch_warnings():
        # few terms are wanted, whether or not they reach the tolerance
        warnings.simplefilter("ignore", RuntimeWarning)
        fitted = AAA(points, curve, rtol=min(tolerance, 0.5), max_terms=_TERMS, clean_up=False)
    return np.asarray(fitted(2j * np.pi * frequency), dtype=complex)


def _weighted(response: Complex, covariance: Floats, mean: Floats, shapes: Complex) -> tuple[Floats, Floats]:
    """Least-squares coefficients of shapes (F, n) in the curve response @ mean, with their standard errors."""
    target = response @ mean
    rows = np.concatenate([shapes.real, shapes.imag])
    inverse = np.linalg.pinv(rows)
    value = inverse @ np.concatenate([target.real, target.imag])
    from_mean = inverse @ np.concatenate([response.real, response.imag])
    return value, np.sqrt(np.diag(from_mean @ covariance @ from_mean.T))


def _read_admittance(s: Complex, mean: Floats, covariance: Floats, response: Complex) -> str:
    """Read as an inertia, a damping and a spring in parallel at the port."""
    shapes = np.stack([s, np.ones_like(s), 1 / s], axis=1)
    value, error = _weighted(response, covariance, mean, shapes)
    parts = (("an inertia", "kg m²"), ("a damping", "N m s/rad"), ("a spring", "N m/rad"))
    readings = [
        f"{name} of {coefficient:.3g} ± {deviation:.2g} {unit}"
        for (name, unit), coefficient, deviation in zip(parts, value, error, strict=True)
        if abs(coefficient) > PART_READ * deviation
    ]
    return _listed(readings, "in addition to the model's")


def _read_factor(s: Complex, mean: Floats, covariance: Floats, response: Complex) -> str:
    """Read as a gain and a delay."""
    value, error = _weighted(response, covariance, mean, np.stack([np.ones_like(s), -s], axis=1))
    readings = []
    if abs(value[0]) > PART_READ * error[0]:
        readings.append(f"a gain of {100 * value[0]:.2g} ± {100 * error[0]:.1g} %")
    if abs(value[1]) > PART_READ * error[1]:
        readings.append(f"a delay of {1e3 * value[1]:.3g} ± {1e3 * error[1]:.2g} ms")
    return _listed(readings, "in addition to the model's")


def _listed(readings: list[str], ending: str) -> str:
    if not readings:
        return "no spring, inertia, damping, gain or delay explains it by itself"
    return f"{', '.join(readings)} {ending}"
