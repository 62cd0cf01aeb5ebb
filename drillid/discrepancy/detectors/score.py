"""Scores of what a cause would add to the speed, against noise whose size changes in time.

The whitened error is white but not of constant size, so that variances are summed over blocks of the record as they
are there (White 1980, Econometrica 48, 817–838, for blocks); Student's t counts how few blocks may bear a column.
"""

from dataclasses import dataclass, field, replace

import numpy as np
from scipy.interpolate import PchipInterpolator
from scipy.special import fdtrc, ndtr, ndtri, stdtr

from drillid.arrays import Floats, Indices
from drillid.discrepancy.detectors.detection import Lines
from drillid.discrepancy.detectors.residual_record import ResidualRecord
from drillid.discrepancy.rules import AMPLITUDE_REACH, LEAST_BLOCKS, LEAST_MISSING_SHARE, TAIL

_BLOCK_S = 4.0
_DRAWS = 4000
_LEAST_P_VALUE, _LARGEST_P_VALUE = 1e-300, 1 - 1e-12
_DEPENDENT = 1e-9
"""Share of a column that must be left when others are taken out."""


@dataclass(frozen=True, eq=False)
class Candidate:
    """What a cause would add to the speed, one column a setting."""

    cause: str
    columns: Floats
    """(settings, samples), rad/s per unit of amplitude; whitened once `whitened` has been called."""
    settings: Floats | None = None
    """(settings,) sizes that are searched, the amplitude being free; None where the amplitude is the size."""
    one_sided: bool = False
    """Whether only a positive amplitude makes sense."""
    together: bool = False
    """Whether the columns are parts of one thing, whose modulus is the size."""
    whole: bool = False
    """Whether the size is the setting at which the amplitude is one, if there is one, and not the most likely one."""


@dataclass(frozen=True, eq=False)
class Score:
    """How a cause stands out of the noise."""

    normal: float
    """Standard normal without the cause; the search over settings is counted."""
    size: float
    size_error: float
    log_ratio: float
    amplitudes: Floats = field(default_factory=lambda: np.empty(0))
    """(settings,) of the candidate's columns; 0 but for the best."""
    misfit: float = np.nan
    """Standard normal where the record follows the cause, large where something like it does more; NaN if not asked."""
    by_shape: tuple[tuple[float, float], ...] = ()
    """Size and its error at each of several columns, NaN where too little of the record bears one."""
    apart: float = np.nan
    """Standard deviations between what this and the other way of the same change say of the record; NaN if not told."""
    lines: Lines | None = None
    """Of a tone, all lines of the record that stand out."""


def whitened(candidate: Candidate, residual: ResidualRecord) -> Candidate:
    """The candidate as the noise sees it."""
    return replace(candidate, columns=residual.whitened(candidate.columns))


def without(series: Floats, others: Floats) -> Floats:
    """Rows (..., samples) less their projection on other rows (further, samples)."""
    return without_basis(series, orthonormal(others))


def without_basis(series: Floats, basis: Floats) -> Floats:
    """Rows (..., samples) less their projection on orthonormal rows (rank, samples)."""
    return np.asarray(series - (series @ basis.T) @ basis, dtype=float)


def orthonormal(rows: Floats) -> Floats:
    """Orthonormal rows (rank, samples) that span what rows (further, samples) span."""
    scale = np.sqrt(np.sum(rows**2, axis=1))
    if not np.any(scale > 0):
        return np.empty((0, rows.shape[1]))
    _, values, basis = np.linalg.svd(rows[scale > 0] / scale[scale > 0, None], full_matrices=False)
    return np.asarray(basis[values > 1e-6 * values[0]], dtype=float)


def score(
    candidate: Candidate, error: Floats, residual: ResidualRecord, *, inflation: float | None = None
) -> Score | None:
    """Score of a whitened candidate; None where no column is borne by enough of the record.

    Parameters
    ----------
    error : (samples,) whitened like the candidate
    inflation : variance of a sum over the noise per variance found from `error`; that of the remainder where not given
    """
    if candidate.together:
        return _score_together(candidate, error, residual)
    columns = candidate.columns
    energy = np.sum(columns**2, axis=1)
    usable = np.flatnonzero(energy > _DEPENDENT * max(float(energy.max()), 1e-300))
    amplitude = columns[usable] @ error / energy[usable]
    deviation, blocks = _deviations(columns[usable], error, amplitude, residual)
    deviation *= np.sqrt(residual.inflation if inflation is None else inflation)
    borne = blocks >= LEAST_BLOCKS
    if candidate.settings is not None:
        # what a drive leaves out it leaves out wholly: a small share of it is another cause's
        borne &= amplitude + AMPLITUDE_REACH * deviation > LEAST_MISSING_SHARE
    usable = usable[borne]
    amplitude, deviation, blocks = (values[borne] for values in (amplitude, deviation, blocks))
    by_shape = np.full((columns.shape[0], 2), np.nan)
    by_shape[usable, 0] = amplitude
    by_shape[usable, 1] = np.abs(amplitude) / _to_normal(np.abs(amplitude) / deviation, blocks, two_sided=False)
    if usable.size == 0:
        return None
    ratio = amplitude / deviation
    normal = _to_normal(ratio if candidate.one_sided else -np.abs(ratio), blocks, two_sided=not candidate.one_sided)
    best = int(np.argmax(normal))
    unit = columns[usable] / np.sqrt(energy[usable])[:, None]
    overall = _normal_of_maximum(float(normal[best]), unit @ unit.T, two_sided=not candidate.one_sided)
    size, size_error = float(amplitude[best]), float(deviation[best])
    if candidate.settings is not None:
        # the whole of what is left out, not some share of it
        settings, ratio = candidate.settings[usable], columns[usable] @ error - energy[usable] / 2
        size, size_error = (
            _setting_of_whole(settings, ratio, amplitude, deviation)
            if candidate.whole
            else _size_of_setting(settings, ratio)
        )
    told = (np.maximum if candidate.one_sided else np.hypot)(amplitude[best : best + 1], 0.0) / deviation[best]
    log_ratio = 0.5 * float(_to_normal(told, blocks[best : best + 1], two_sided=False)[0]) ** 2
    amplitudes = np.zeros(columns.shape[0])
    amplitudes[usable[best]] = amplitude[best]
    shapes = () if candidate.settings is not None or len(columns) == 1 else tuple(map(tuple, by_shape.tolist()))
    return Score(overall, size, size_error, log_ratio, amplitudes, by_shape=shapes)


def block_starts(residual: ResidualRecord) -> Indices:
    """First sample of each block."""
    return np.arange(0, residual.samples, round(_BLOCK_S * residual.record.rate))


def _deviations(columns: Floats, error: Floats, amplitude: Floats, residual: ResidualRecord) -> tuple[Floats, Floats]:
    """Standard error of each amplitude before inflation, and how many blocks bear its column."""
    starts = block_starts(residual)
    products = np.add.reduceat(columns * (error - amplitude[:, None] * columns), starts, axis=1)
    shares = np.add.reduceat(columns**2, starts, axis=1)
    energy = shares.sum(axis=1)
    shares = shares / energy[:, None]
    # one amplitude taken out of few blocks takes their own errors with it
    products = products / np.maximum(1 - shares, 0.1)
    return np.sqrt(np.sum(products**2, axis=1)) / energy, 1 / np.sum(shares**2, axis=1)


def _to_normal(ratio: Floats, freedom: Floats, *, two_sided: bool) -> Floats:
    """Student's ratios as standard normal values; of two-sided ratios the modulus' p-value."""
    p_value = stdtr(freedom, -ratio) if not two_sided else 2 * stdtr(freedom, ratio)
    return np.asarray(-ndtri(np.clip(p_value, _LEAST_P_VALUE, _LARGEST_P_VALUE)), dtype=float)


def _normal_of_maximum(largest: float, correlation: Floats, *, two_sided: bool) -> float:
    """Standard normal value of the largest of dependent ones.

    The maximum's distribution is drawn; beyond its upper 2 % the tail of one value is carried on, multiplied by as
    many values as the draws there amount to.
    """
    count = correlation.shape[0]
    if count == 1:
        return largest
    values, vectors = np.linalg.eigh(correlation)
    root = vectors * np.sqrt(np.maximum(values, 0.0))
    drawn = root @ np.random.default_rng(0).standard_normal((count, _DRAWS))
    if two_sided:
        drawn = -ndtri(np.clip(2 * ndtr(-np.abs(drawn)), _LEAST_P_VALUE, _LARGEST_P_VALUE))
    maxima = np.sort(drawn.max(axis=0))
    border = float(np.quantile(maxima, 1 - TAIL))
    if largest > border:
        p_value = TAIL * ndtr(-largest) / ndtr(-border)
    else:
        p_value = 1 - np.searchsorted(maxima, largest) / _DRAWS
    return float(-ndtri(np.clip(p_value, _LEAST_P_VALUE, 1 - 1 / _DRAWS)))


def _size_of_setting(settings: Floats, ratio: Floats) -> tuple[float, float]:
    """Most likely setting, and how far settings reach whose log-likelihood is less by no more than a half.

    Between settings the log-likelihood is taken as a parabola. Settings that are not known give NaN.
    """
    if not np.isfinite(settings).all():
        return np.nan, np.inf
    order = np.argsort(settings)
    settings, ratio = settings[order], ratio[order]
    best = int(np.argmax(ratio))
    near = slice(max(best - 1, 0), best + 2)
    spacing = float(np.max(np.abs(settings[near] - settings[best]))) if settings.size > 1 else np.inf
    if not 0 < best < settings.size - 1:
        return float(settings[best]), spacing
    a, b, _ = np.polyfit(settings[near] - settings[best], ratio[near], 2)
    shift, width = -b / (2 * a), np.sqrt(-0.5 / a)
    return float(settings[best] + shift), float(np.hypot(width, spacing / np.sqrt(12)))


def _setting_of_whole(settings: Floats, ratio: Floats, amplitude: Floats, deviation: Floats) -> tuple[float, float]:
    """Setting at which a rising amplitude is one, the nearest to the most likely, and its error.

    Without any, as where the limit is hardly ever left, it is the most likely one.

    Between settings the amplitude follows a monotone cubic in their logarithm (Fritsch and Butland 1984, SIAM Journal
    on Scientific and Statistical Computing 5, 300–304).
    """
    if settings.size < 2 or not np.isfinite(settings).all():
        return _size_of_setting(settings, ratio)
    order = np.argsort(settings)
    place = np.log(settings[order])
    curve = PchipInterpolator(place, amplitude[order])
    roots = np.array([root for root in curve.solve(1.0, extrapolate=False) if curve(root, 1) > 0])
    if roots.size == 0:
        return _size_of_setting(settings, ratio)
    root = float(roots[np.argmin(np.abs(roots - np.log(settings[np.argmax(ratio)])))])
    size = float(np.exp(root))
    return size, size * float(np.interp(root, place, deviation[order]) / curve(root, 1))


def _score_together(candidate: Candidate, error: Floats, residual: ResidualRecord) -> Score | None:
    """Score of all amplitudes: T² of Hotelling (1931, Annals of Mathematical Statistics 2, 360–378) over the blocks."""
    columns = candidate.columns
    count, gram = columns.shape[0], columns @ columns.T
    shares = np.add.reduceat(np.sum(columns**2, axis=0), block_starts(residual))
    blocks = float(np.sum(shares) ** 2 / max(float(np.sum(shares**2)), np.finfo(float).tiny))
    if not np.trace(gram) > 0 or blocks < max(LEAST_BLOCKS, 2 * count):
        return None
    amplitude: Floats = np.asarray(np.linalg.solve(gram, columns @ error), dtype=float)
    products = np.add.reduceat(columns * (error - amplitude @ columns), block_starts(residual), axis=1)
    inverse = np.linalg.inv(gram)
    covariance = inverse @ (products @ products.T) @ inverse * residual.inflation
    total = float(amplitude @ np.linalg.solve(covariance, amplitude))
    freedom = blocks - count + 1
    p_value = fdtrc(count, freedom, total * freedom / (count * blocks))
    size = float(np.hypot.reduce(amplitude))
    along = amplitude / max(size, 1e-300)
    error_of_size = float(np.sqrt(along @ covariance @ along))
    return Score(normal_of_p_value(float(p_value)), size, error_of_size, total / 2, amplitude)


def normal_of_p_value(p_value: float) -> float:
    """Standard normal value that is exceeded with a probability."""
    return float(-ndtri(np.clip(p_value, _LEAST_P_VALUE, _LARGEST_P_VALUE)))
