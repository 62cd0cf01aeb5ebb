"""Scores of what a cause would add to the speed, against noise whose level changes in time.

The whitened residual is white but heteroscedastic, so that variances are summed over blocks of the record (White 1980,
Econometrica 48, 817–838, for blocks); Student's t accounts for the few blocks in which a column may have its energy.
"""

from dataclasses import dataclass, field, replace

import numpy as np
from scipy.special import fdtrc, ndtr, ndtri, stdtr

from drillid.arrays import Floats, Indices
from drillid.discrepancy.detectors.detection import SpectralLines
from drillid.discrepancy.detectors.residual_record import ResidualRecord
from drillid.discrepancy.rules import AMPLITUDE_REACH, LEAST_BLOCKS, LEAST_MISSING_SHARE, MOST_MISSING_SHARE, TAIL

_BLOCK_S, _BRIEF_BLOCK_S = 4.0, 0.5
_DRAWS = 4000
_LEAST_P_VALUE, _LARGEST_P_VALUE = 1e-300, 1 - 1e-12
_DEPENDENT = 1e-9
"""Share of the largest energy below which a column counts as linearly dependent on those projected out."""


@dataclass(frozen=True, eq=False)
class Candidate:
    """Speed that a cause would add, one column for each setting."""

    cause: str
    columns: Floats
    """(settings, samples), rad/s per unit of amplitude; (settings, whitened samples) after `whitened`."""
    settings: Floats | None = None
    """(settings,) sizes searched over with a free amplitude; None where the amplitude is the size."""
    one_sided: bool = False
    """Whether only a positive amplitude makes sense."""
    together: bool = False
    """Whether the columns are fitted jointly; the size is then the modulus of their amplitudes."""
    at_unit_amplitude: bool = False
    """Whether the size is the setting at which the amplitude is one, where there is one, not the most likely one."""
    brief: bool = False
    """Whether what it adds lies in a few brief events, each of which is a block of its own."""


@dataclass(frozen=True, eq=False)
class Score:
    """Result of the test for one cause."""

    normal: float
    """Standard normal without the cause; corrected for the search over settings."""
    size: float
    size_error: float
    log_ratio: float
    amplitudes: Floats = field(default_factory=lambda: np.empty(0))
    """(settings,) of the candidate's columns; 0 except for the best."""
    misfit: float = np.nan
    """Standard normal where the record follows the cause, large where something similar fits better; NaN where not
    tested."""
    by_shape: tuple[tuple[float, float], ...] = ()
    """Size and standard error for each of several columns, NaN where a column has its energy in too few blocks."""
    separation: float = np.nan
    """Standard deviations between the records predicted by this and by the other course of the same parameter; NaN
    where there is none."""
    lines: SpectralLines | None = None
    """Of a tone, all lines of the record that stand out."""


def whitened(candidate: Candidate, residual: ResidualRecord) -> Candidate:
    """The candidate with whitened columns."""
    return replace(candidate, columns=residual.whitened(candidate.columns))


def without(series: Floats, others: Floats) -> Floats:
    """Rows (..., samples) less their projection on other rows (others, samples)."""
    basis = _orthonormal(others)
    return np.asarray(series - (series @ basis.T) @ basis, dtype=float)


def _orthonormal(rows: Floats) -> Floats:
    """Orthonormal basis (rank, samples) of the span of rows (count, samples)."""
    scale = np.sqrt(np.sum(rows**2, axis=1))
    if not np.any(scale > 0):
        return np.empty((0, rows.shape[1]))
    _, values, basis = np.linalg.svd(rows[scale > 0] / scale[scale > 0, None], full_matrices=False)
    return np.asarray(basis[values > 1e-6 * values[0]], dtype=float)


def score(
    candidate: Candidate, error: Floats, residual: ResidualRecord, *, inflation: float | None = None
) -> Score | None:
    """Score of a whitened candidate; None where every column has its energy in too few blocks.

    Where no setting has a possible amplitude, it is no detection but a window that was looked at: its value is the
    median of all so low, as to leave it out would keep those windows alone whose noise looks like the cause.

    Parameters
    ----------
    error : (whitened samples,) residual, whitened like the candidate
    inflation : variance of a sum over the noise relative to that estimated from `error`; by default that of the
        residual record
    """
    if candidate.together:
        return _score_together(candidate, error, residual)
    columns = candidate.columns
    energy = np.sum(columns**2, axis=1)
    usable = np.flatnonzero(energy > _DEPENDENT * max(float(energy.max()), 1e-300))
    amplitude = columns[usable] @ error / energy[usable]
    starts = block_starts(residual, error.size, _BRIEF_BLOCK_S if candidate.brief else _BLOCK_S)
    deviation, blocks = _deviations(columns[usable], error, amplitude, starts)
    deviation *= np.sqrt(residual.inflation if inflation is None else inflation)
    supported = blocks >= LEAST_BLOCKS
    usable = usable[supported]
    amplitude, deviation, blocks = (values[supported] for values in (amplitude, deviation, blocks))
    by_shape = np.full((columns.shape[0], 2), np.nan)
    by_shape[usable, 0] = amplitude
    by_shape[usable, 1] = np.abs(amplitude) / _to_normal(np.abs(amplitude) / deviation, blocks, two_sided=False)
    if usable.size == 0:
        return None
    ratio = amplitude / deviation
    normal = _to_normal(ratio if candidate.one_sided else -np.abs(ratio), blocks, two_sided=not candidate.one_sided)
    bounds = _possible_ratios(candidate, deviation)
    possible = (ratio > bounds[0]) & (ratio < bounds[1])
    unit = columns[usable] / np.sqrt(energy[usable])[:, None]
    if not possible.any():
        median = (1 + _chance_of_any(unit @ unit.T, bounds)) / 2
        return Score(normal_of_p_value(median), np.nan, np.inf, 0.0, np.zeros(columns.shape[0]))
    overall = _normal_of_maximum(
        float(normal[possible].max()), unit @ unit.T, bounds, two_sided=not candidate.one_sided
    )
    usable, normal = usable[possible], normal[possible]
    amplitude, deviation, blocks = (values[possible] for values in (amplitude, deviation, blocks))
    best = int(np.argmax(normal))
    size, size_error = float(amplitude[best]), float(deviation[best])
    if candidate.settings is not None:
        # at the full missing torque, not a share of it
        settings, ratio = candidate.settings[usable], columns[usable] @ error - energy[usable] / 2
        size, size_error = (
            _setting_at_unity(settings, ratio, amplitude, deviation)
            if candidate.at_unit_amplitude
            else _size_of_setting(settings, ratio)
        )
    best_ratio = (np.maximum if candidate.one_sided else np.hypot)(amplitude[best : best + 1], 0.0) / deviation[best]
    log_ratio = 0.5 * float(_to_normal(best_ratio, blocks[best : best + 1], two_sided=False)[0]) ** 2
    amplitudes = np.zeros(columns.shape[0])
    amplitudes[usable[best]] = amplitude[best]
    shapes = () if candidate.settings is not None or len(columns) == 1 else tuple(map(tuple, by_shape.tolist()))
    return Score(overall, size, size_error, log_ratio, amplitudes, by_shape=shapes)


def _possible_ratios(candidate: Candidate, deviation: Floats) -> tuple[Floats, Floats]:
    """Least and largest possible amplitude of each column in its standard errors (columns,)."""
    if candidate.settings is None:
        return np.full(deviation.size, -np.inf), np.full(deviation.size, np.inf)
    # a limit withholds all of the missing torque: an amplitude far from 1 belongs to another cause
    return LEAST_MISSING_SHARE / deviation - AMPLITUDE_REACH, MOST_MISSING_SHARE / deviation


def block_starts(residual: ResidualRecord, samples: int, block_s: float = _BLOCK_S) -> Indices:
    """First sample of each block of a series that has so many samples over the record."""
    return np.arange(0, samples, round(block_s * samples * residual.record.rate / residual.samples))


def _deviations(columns: Floats, error: Floats, amplitude: Floats, starts: Indices) -> tuple[Floats, Floats]:
    """Standard error of each amplitude before inflation, and the effective number of blocks of its column."""
    products = np.add.reduceat(columns * (error - amplitude[:, None] * columns), starts, axis=1)
    shares = np.add.reduceat(columns**2, starts, axis=1)
    energy = shares.sum(axis=1)
    shares = shares / energy[:, None]
    # an amplitude fitted to few blocks absorbs part of their errors
    products = products / np.maximum(1 - shares, 0.1)
    return np.sqrt(np.sum(products**2, axis=1)) / energy, 1 / np.sum(shares**2, axis=1)


def _to_normal(ratio: Floats, freedom: Floats, *, two_sided: bool) -> Floats:
    """Student's t ratios as standard normal values of the same p-value, two-sided for the modulus of the ratio."""
    p_value = stdtr(freedom, -ratio) if not two_sided else 2 * stdtr(freedom, ratio)
    return np.asarray(-ndtri(np.clip(p_value, _LEAST_P_VALUE, _LARGEST_P_VALUE)), dtype=float)


def _normal_of_maximum(largest: float, correlation: Floats, bounds: tuple[Floats, Floats], *, two_sided: bool) -> float:
    """Standard normal value of the maximum of those of correlated normal variables that are within bounds, corrected
    for the search.

    The distribution of the maximum is simulated; its upper 2 % are extrapolated as the tail of a single normal
    variable, scaled to agree there.
    """
    count = correlation.shape[0]
    if count == 1:
        return largest
    draws = _drawn(correlation)
    possible = (draws > bounds[0][:, None]) & (draws < bounds[1][:, None])
    if two_sided:
        draws = -ndtri(np.clip(2 * ndtr(-np.abs(draws)), _LEAST_P_VALUE, _LARGEST_P_VALUE))
    maxima = np.sort(np.where(possible, draws, -np.inf).max(axis=0))
    threshold = float(np.quantile(maxima, 1 - TAIL, method="higher"))
    if np.isinf(threshold):
        p_value = min(count * ndtr(-largest), TAIL)
    elif largest > threshold:
        p_value = TAIL * ndtr(-largest) / ndtr(-threshold)
    else:
        p_value = 1 - np.searchsorted(maxima, largest) / _DRAWS
    return float(-ndtri(np.clip(p_value, _LEAST_P_VALUE, 1 - 1 / _DRAWS)))


def _chance_of_any(correlation: Floats, bounds: tuple[Floats, Floats]) -> float:
    """Probability that any of correlated standard normal variables is within its bounds."""
    draws = _drawn(correlation)
    return float(np.mean(((draws > bounds[0][:, None]) & (draws < bounds[1][:, None])).any(axis=0)))


def _drawn(correlation: Floats) -> Floats:
    """Draws (count, _DRAWS) of correlated standard normal variables."""
    values, vectors = np.linalg.eigh(correlation)
    root = vectors * np.sqrt(np.maximum(values, 0.0))
    return np.asarray(root @ np.random.default_rng(0).standard_normal((len(root), _DRAWS)), dtype=float)


def _size_of_setting(settings: Floats, ratio: Floats) -> tuple[float, float]:
    """Maximum-likelihood setting, and the half-width of the interval in which the log-likelihood falls by a half.

    Between settings the log-likelihood is interpolated by a parabola. Unknown settings give NaN.
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


def _setting_at_unity(settings: Floats, ratio: Floats, amplitude: Floats, deviation: Floats) -> tuple[float, float]:
    """Setting at which a rising amplitude crosses one, the crossing nearest to the most likely setting, and its error.

    Where there is none, as where the limit is hardly ever exceeded, the most likely setting is returned.

    Between settings the amplitude follows a monotone cubic in their logarithm (Fritsch and Butland 1984, SIAM Journal
    on Scientific and Statistical Computing 5, 300–304).
    """
    from scipy.interpolate import PchipInterpolator

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
    """Joint score of amplitudes: T² of Hotelling (1931, Annals of Mathematical Statistics 2, 360–378) over blocks."""
    columns = candidate.columns
    count, gram = columns.shape[0], columns @ columns.T
    starts = block_starts(residual, error.size)
    shares = np.add.reduceat(np.sum(columns**2, axis=0), starts)
    blocks = float(np.sum(shares) ** 2 / max(float(np.sum(shares**2)), np.finfo(float).tiny))
    if not np.trace(gram) > 0 or blocks < max(LEAST_BLOCKS, 2 * count):
        return None
    amplitude: Floats = np.asarray(np.linalg.solve(gram, columns @ error), dtype=float)
    products = np.add.reduceat(columns * (error - amplitude @ columns), starts, axis=1)
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
    """Standard normal value with this upper-tail probability."""
    return float(-ndtri(np.clip(p_value, _LEAST_P_VALUE, _LARGEST_P_VALUE)))
