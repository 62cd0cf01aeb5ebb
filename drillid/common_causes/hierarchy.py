"""One cause over the wells of a group: sizes of the wells are Gaussian about one that they have in common.

Four answers are compared: no well has the cause, all have it at one size, all have it at sizes of their own, one well
has it alone. Evidence is the log Bayes factor against the first. The likelihood of a size comes from scores and
information (`drillid.common_causes.pooling`); the common size is integrated over a grid.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.optimize import brentq
from scipy.special import chdtrc, logsumexp, ndtr

from drillid.arrays import Floats
from drillid.common_causes.pooling import Quadratic, Wells, apart, together
from drillid.discrepancy.catalogue import Size
from drillid.discrepancy.inference.coordinates import Extension
from drillid.discrepancy.inference.screen import tail_p_value

_SCALES = (0.04, 0.2, 1.0, 5.0)
"""Prior standard deviations, taken as equally likely, relative to the usual size: what only a fleet shows is small."""
_COARSE, _POINTS = 21, 41
"""Points of the grid to either side of zero, and about the likeliest size."""
_SPREADS = (0.1, 0.3, 1.0)
"""Standard deviations of the wells' sizes that are tried, relative to the common size."""
_DRAWS = 20_000
_NEAR = 8.0
"""Standard errors about the likeliest size that the grid is refined over."""


@dataclass(frozen=True, eq=False)
class CommonCause:
    """One candidate over a group."""

    number: int
    """Its number among the candidates."""
    extension: Extension
    gain: float
    """Largest log-likelihood ratio of one common size, against none."""
    common: float
    """Log evidence of one common size."""
    spread: float
    """Log evidence that all wells have it at sizes of their own."""
    one_well: float
    """Log evidence that a single well has it."""
    size: float
    """Mean of the common size."""
    size_low: float
    """95 % interval."""
    size_high: float
    at_bound: bool
    """Whether the likeliest size is the largest that any well holds, beyond which their likelihoods say nothing."""
    heterogeneity: float
    """p-value of the wells' scatter about the common size (Cochran 1954, Biometrics 10, 101–129)."""
    deviations: Floats
    """(N,) each well's size less the common one, in its standard errors with the rig's coordinates held at those of all
    wells; NaN where it does not show the size.
    """
    alone: Floats
    """(N,) log evidence that each well has it alone."""

    @property
    def shared(self) -> float:
        """Log evidence that all wells have it."""
        return float(np.logaddexp(self.common, self.spread) - np.log(2.0))


def sizes_grid(size: Size, largest: float) -> Floats:
    """Sizes up to a largest one within the physical bounds, finer near zero, with zero among them."""
    up = min(size.high, largest) * np.linspace(0.0, 1.0, _COARSE) ** 2
    if size.low >= 0:
        return np.asarray(up, dtype=float)
    down = max(size.low, -largest) * np.linspace(1.0, 0.0, _COARSE)[:-1] ** 2
    return np.concatenate([down, up])


def log_prior(grid: Floats, size: Size) -> Floats:
    """Log prior masses of the grid's sizes, (G,)."""
    deviations = size.typical * np.array(_SCALES)
    density = np.exp(-0.5 * (grid / deviations[:, None]) ** 2) / deviations[:, None]
    mass = density.sum(0) * np.gradient(grid)
    return np.asarray(np.log(np.maximum(mass, np.finfo(float).tiny)) - np.log(mass.sum()), dtype=float)


def common_cause(wells: Wells, number: int, extension: Extension) -> CommonCause:
    """Judge one candidate, by its number."""
    size = extension.cause.size
    largest = max(float(each.sizes[number].max()) for each in wells.sets)
    grid, at = _resolved(wells, number, sizes_grid(size, largest))
    zero = wells.at(number, np.zeros(1))
    prior, curve = log_prior(grid, size), together(wells, at) - together(wells, zero)[0]
    common = float(logsumexp(curve + prior))
    each = logsumexp(apart(wells, at, zero) + prior, axis=1)
    mass = np.exp(curve + prior - common)
    low, high = _interval(grid, mass)
    step = max((high - low) / 4, 1e-6 * largest)
    deviations, spreads = _scatter(wells, number, float(mass @ grid), step, largest, at)
    mean, low, high = (float(np.clip(value, size.low, size.high)) for value in _over_spreads(grid, mass, spreads))
    finite = np.isfinite(deviations)
    freedom = int(finite.sum()) - 1
    return CommonCause(
        number=number,
        extension=extension,
        gain=float(curve.max()),
        common=common,
        spread=common + float(logsumexp([each.evidence for each in spreads]) - np.log(len(spreads))),
        one_well=float(logsumexp(each) - np.log(each.size)),
        size=mean,
        size_low=low,
        size_high=high,
        at_bound=_is_end(grid, float(grid[np.argmax(curve)])),
        heterogeneity=float(chdtrc(freedom, np.sum(deviations[finite] ** 2))) if freedom > 0 else float("nan"),
        deviations=deviations,
        alone=each,
    )


def standard_errors_off(wells: Wells, number: int, extension: Extension, size: float) -> float:
    """How far a size, of a candidate by its number, lies from the likeliest one of all wells together: the root of the
    likelihood ratio in standard errors, with the rigs' coordinates integrated out (Wilks 1938).
    """
    largest = max(abs(size), *(float(each.sizes[number].max()) for each in wells.sets))
    _, at = _resolved(wells, number, sizes_grid(extension.cause.size, largest))
    fall = together(wells, at).max() - together(wells, wells.at(number, np.array([size])))[0]
    return float(np.sqrt(2 * max(fall, 0.0)))


def _is_end(grid: Floats, size: float) -> bool:
    """Whether a size is an end of the grid; zero does not count as one."""
    return size != 0 and size in (grid[0], grid[-1])


def _resolved(wells: Wells, number: int, grid: Floats) -> tuple[Floats, Quadratic]:
    """The grid with further points about the likeliest size, as narrow as the likelihood there, and the wells there."""
    at = wells.at(number, grid)
    for _ in range(2):
        curve = together(wells, at)
        place = int(np.clip(np.argmax(curve), 1, grid.size - 2))
        # a parabola through the likeliest size and its neighbours
        curvature = -2 * float(
            np.polyfit(grid[place - 1 : place + 2] - grid[place], curve[place - 1 : place + 2], 2)[0]
        )
        step = float(grid[place + 1] - grid[place - 1])
        error = min(curvature**-0.5, step) if curvature > 0 else step
        near = grid[np.argmax(curve)] + _NEAR * error * np.linspace(-1.0, 1.0, _POINTS)
        near = np.setdiff1d(near[(near > grid[0]) & (near < grid[-1])], grid)
        order = np.argsort(np.append(grid, near))
        grid, at = np.append(grid, near)[order], at.with_sizes(wells.at(number, near), order)
    return grid, at


@dataclass(frozen=True)
class _Spread:
    """Sizes of their own with some standard deviation, against one common size."""

    evidence: float
    """Log Bayes factor."""
    offset: float
    """By how much the mean of the sizes is likelier to be larger."""
    variance: float
    """What it adds to the variance of that mean."""


def _scatter(
    wells: Wells, number: int, mean: float, step: float, widest: float, everywhere: Quadratic
) -> tuple[Floats, list[_Spread]]:
    """The wells' deviations (N,) from a common size, and what each of the spreads that are tried makes of it.

    Parameters
    ----------
    step : over which the likelihoods are differentiated in size
    widest : prior standard deviation of the common size
    everywhere : the wells' likelihoods over the grid
    """
    at = wells.at(number, mean + step * np.array([-1.0, 0.0, 1.0]))
    modes = _rig_modes(wells, at.score[:, 1], at.information[:, 1])
    own = modes[wells.rig]
    slopes = at.score - np.einsum("ngrq,nq->ngr", at.information, own)
    value = _held(at, own)
    slope = (value[:, 2] - value[:, 0]) / (2 * step)
    curvature = np.maximum(-(value[:, 2] - 2 * value[:, 1] + value[:, 0]) / step**2, 0.0)
    border = (slopes[:, 2] - slopes[:, 0]) / (2 * step)
    score = np.concatenate([slopes[:, 1], slope[:, None]], axis=1)
    upper = np.concatenate([at.information[:, 1], -border[:, :, None]], axis=2)
    # a well's parabola gains no more than its likelihood does on the grid, or than one within a standard error does
    gain = np.maximum(_held(everywhere, own).max(axis=1) - value[:, 1], 0.5)
    bent = np.maximum(
        np.maximum(curvature, slope**2 / (2 * gain)), _least_curvature(wells, at.information[:, 1], border)
    )
    lower = np.concatenate([-border, bent[:, None]], axis=1)
    information = np.concatenate([upper, lower[:, None]], axis=1)
    alike, *spread = (
        _pooled(wells, modes, score, information, (share * mean) ** 2, widest) for share in (0.0, *_SPREADS)
    )
    deviations = np.where(bent > 0, slope / np.sqrt(np.where(bent > 0, bent, 1.0)), np.nan)
    return deviations, [_Spread(*np.subtract(each, alike)) for each in spread]


def _over_spreads(grid: Floats, mass: Floats, spreads: Sequence[_Spread]) -> tuple[float, float, float]:
    """Mean and central 95 % interval of the common size, which is known less well where the wells' own sizes differ:
    the mixture over no spread and each of some, by their posterior probabilities.

    Parameters
    ----------
    mass : of the grid's sizes where all wells have the same size
    """
    evidence = np.array([np.log(len(spreads)), *(each.evidence for each in spreads)])
    weights = np.exp(evidence - logsumexp(evidence))
    offsets = np.array([0.0, *(each.offset for each in spreads)])
    # the grid resolves no more than its steps
    variances = np.maximum([0.0, *(each.variance for each in spreads)], 0.0) + mass @ np.gradient(grid) ** 2 / 12
    places = grid + offsets[:, None]

    def below(size: float) -> float:
        return float(weights @ (ndtr((size - places) / np.sqrt(variances)[:, None]) @ mass))

    beyond = 10 * np.sqrt(variances.max())
    ends = places.min() - beyond, places.max() + beyond
    low, high = (brentq(lambda size, share=share: below(size) - share, *ends) for share in (0.025, 0.975))
    return float(weights @ (places @ mass)), float(low), float(high)


def _least_curvature(wells: Wells, information: Floats, border: Floats) -> Floats:
    """Least curvature (N,) in size at which the information of rig's coordinates and size has no negative part."""
    share = wells.prior[wells.rig] / np.bincount(wells.rig)[wells.rig][:, None]
    whole = information + share[:, :, None] * np.eye(share.shape[1])
    return np.asarray(np.einsum("nr,nr->n", border, np.linalg.solve(whole, border[:, :, None])[..., 0]), dtype=float)


def _held(at: Quadratic, own: Floats) -> Floats:
    """Log-likelihoods (N, G) with the rigs' coordinates (N, R) held."""
    pull = at.score - 0.5 * np.einsum("ngrq,nq->ngr", at.information, own)
    return np.asarray(at.value + np.einsum("ngr,nr->ng", pull, own), dtype=float)


def _rig_modes(wells: Wells, score: Floats, information: Floats) -> Floats:
    """Coordinates (rigs, R) of the rigs at a common size, less those of the data sheets."""
    modes = []
    for rig, prior in enumerate(wells.prior):
        members = wells.rig == rig
        modes.append(np.linalg.solve(information[members].sum(0) + np.diag(prior), score[members].sum(0)))
    return np.stack(modes)


def _pooled(
    wells: Wells, modes: Floats, score: Floats, information: Floats, variance: float, widest: float
) -> tuple[float, float, float]:
    """Wells' sizes with a variance about a common one near the expansion: log evidence up to a constant, the common
    size less that of the expansion, and its variance.
    """
    own = information[:, -1, -1]
    shrunk = variance / (1 + variance * own)
    total = -0.5 * float(np.sum(np.log1p(variance * own))) + 0.5 * float(np.sum(shrunk * score[:, -1] ** 2))
    column = information[:, :, -1]
    matrices = information - shrunk[:, None, None] * column[:, :, None] * column[:, None, :]
    vectors = score - shrunk[:, None] * score[:, -1:] * column
    count = wells.prior.shape[1]
    matrix, vector = np.zeros((1, 1)), np.zeros(1)
    for rig, prior in enumerate(wells.prior):
        members = wells.rig == rig
        whole, right = matrices[members].sum(0), vectors[members].sum(0)
        right[:count] -= prior * modes[rig]
        inner = whole[:count, :count] + np.diag(prior)
        solved = np.linalg.solve(inner, np.column_stack([whole[:count, count:], right[:count]]))
        total += 0.5 * float(right[:count] @ solved[:, -1]) - 0.5 * float(np.linalg.slogdet(inner)[1])
        matrix = matrix + whole[count:, count:] - whole[count:, :count] @ solved[:, :-1]
        vector = vector + right[count:] - whole[count:, :count] @ solved[:, -1]
    # a prior of the common size as wide as the grid
    left = max(float(matrix[0, 0]), widest**-2.0)
    best = float(vector[0]) / left
    return float(total + 0.5 * best**2 * left - 0.5 * np.log(left)), best, 1 / left


def _interval(grid: Floats, mass: Floats) -> tuple[float, float]:
    """Central 95 % interval of a distribution on a grid."""
    cumulated = (np.cumsum(mass) - 0.5 * mass) / mass.sum()
    low, high = np.interp([0.025, 0.975], cumulated, grid)
    return float(low), float(high)


def family_p_value(gain: float, correlation: Floats) -> float:
    """p-value of the largest log-likelihood ratio of any candidate where no well has a cause, by draws.

    Along each direction of each candidate the ratio is half the square of a normal score of positive sign (Chernoff
    1954, Ann. Math. Stat. 25, 573–578). Causes that look alike have scores alike, and count less than as many others.

    Parameters
    ----------
    correlation : of the scores, (K, K)
    """
    values, vectors = np.linalg.eigh(correlation)
    root = vectors * np.sqrt(np.maximum(values, 0.0))
    draws = np.random.default_rng(0).standard_normal((_DRAWS, values.size)) @ root.T
    return tail_p_value(gain, 0.5 * np.maximum(draws, 0.0).max(axis=1) ** 2)
