"""Interval changes: intervals of depth whose fitted parameters deviate from the level of their run."""

from __future__ import annotations

from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np
import pandas as pd
from scipy.special import expit

from drillid.arrays import Booleans, Floats, Integers
from drillid.discrepancy.catalogue import CATALOGUE
from drillid.discrepancy.catalogue.time import rise
from drillid.discrepancy.detectors.pooling import evidence_of_p_value
from drillid.discrepancy.predictive_gain import PredictiveGain
from drillid.discrepancy.verdicts.verdict import UNKNOWN, Verdict
from drillid.statistics import ONE_SIDED, TWO_SIDED, pairwise_distance, student

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    import xarray as xr

    from drillid.config.rig import Rig


_LEAST_WINDOWS = 6
"""Least number of windows in a run for which its level is defined."""
_MEDIAN_VARIANCE = np.pi / 2
"""Variance of the median of Gaussian values, relative to that of the mean."""
_TINY = 1e-300
_QN = 2.2219
"""Standard deviation of a Gaussian relative to the lower quartile of the distances between pairs."""
_QN_SMALL = {5: 0.844, 6: 0.611, 7: 0.857, 8: 0.669, 9: 0.872}
_QN_EFFICIENCY, _QN_SLOWNESS = 0.8227, 6.8
"""Asymptotic efficiency, and its approach: simulated samples of n = 5 to 60 have the efficiency over 1 + 6.8/n."""
EVIDENCE = {"damping_pull": "BHA damping", "inertia_pull": "BHA inertia"}

_CAUSE = next(cause for cause in CATALOGUE.values() if cause.marks_intervals)
"""Cause that an interval change is named as."""


def run_pulls(value: Floats, error: Floats, run: Integers) -> tuple[Floats, Floats]:
    """Standardised deviation of each window from the others of its run, and the one-sided p-value of being above them.

    The level is the median of the others. The deviation is tested by two scales, of which the larger p-value counts:
    the standard errors, with a Gaussian, and the others' own scatter, with Student's t. So a run with large scatter of
    unknown origin is flagged no more often than a quiet one, and errors that are stated too small flag nothing.

    Each window is compared with those that deviate less, as windows of one interval would mask each other, and its
    p-value is no smaller than those of windows that deviate more. The first window that is flagged wrongly has
    then nothing unusual among the windows it is compared with, or too much of it.

    Returns
    -------
    pull : deviation from all others over the larger scale, shape (window,); NaN in a run of too few windows
    p_value : shape (window,)
    """
    pulls, p_values = np.full(value.shape, np.nan), np.full(value.shape, np.nan)
    for number in np.unique(run):
        members = np.flatnonzero((run == number) & np.isfinite(value) & np.isfinite(error))
        if members.size < _LEAST_WINDOWS:
            continue
        deviations = np.array(
            [_deviation(np.roll(value[members], -row), np.roll(error[members], -row)) for row in range(members.size)]
        )
        pulls[members] = deviations[:, 0] / np.maximum(1.0, deviations[:, 1])
        order = members[np.argsort(-deviations[:, 0], kind="stable")]
        p_values[order] = _p_values(value[order], error[order])
    return pulls, p_values


def _p_values(value: Floats, error: Floats) -> Floats:
    """p-values of the windows of a run, which are in descending order of their deviation."""
    from scipy.special import ndtr, stdtr

    p_values = np.ones(value.size)
    for row in range(value.size - _LEAST_WINDOWS + 1):
        stated, scatter = _deviation(value[row:], error[row:])
        others = value.size - row - 1
        freedom = _QN_EFFICIENCY * others / (1 + _QN_SLOWNESS / others)
        p_values[row] = max(ndtr(-stated), stdtr(freedom, -stated / scatter))
    return np.maximum.accumulate(p_values)


def _deviation(value: Floats, error: Floats) -> tuple[float, float]:
    """Deviation of the first window from the others, and the others' scatter, each relative to standard errors."""
    others = value.size - 1
    level = float(np.median(value[1:]))
    variance = error[0] ** 2 + _MEDIAN_VARIANCE * np.mean(error[1:] ** 2) / others
    scatter = _standard_deviation((value[1:] - level) / error[1:])
    return float((value[0] - level) / np.sqrt(variance)), max(scatter, _TINY)


def _standard_deviation(value: Floats) -> float:
    """Robust standard deviation with a breakdown point of one half: Q_n of Rousseeuw and Croux (1993).

    Journal of the American Statistical Association 88, 1273–1283. It is the k-th smallest distance between two
    values, k = h (h − 1)/2 with h = ⌊n/2⌋ + 1, times a factor that makes it unbiased for a Gaussian.
    """
    size = value.size
    half = size // 2 + 1
    distance = pairwise_distance(np.sort(value), half * (half - 1) // 2)
    return _QN * _QN_SMALL.get(size, size / (size + (1.4 if size % 2 else 3.8))) * distance


def flag(p_values: list[Floats], error_rate: float) -> Booleans:
    """Windows with a significant rise in any track, by Holm's step-down over all windows and tracks.

    The probability of any flag in a well without changes is at most `error_rate`.
    """
    p_value = np.concatenate(p_values)
    order = np.argsort(np.where(np.isfinite(p_value), p_value, np.inf))
    bound = error_rate / np.arange(np.count_nonzero(np.isfinite(p_value)), 0, -1)
    passed = p_value[order][: bound.size] <= bound
    count = bound.size if passed.all() else int(np.argmin(passed))
    flagged = np.zeros(p_value.size, dtype=bool)
    flagged[order[:count]] = True
    return np.asarray(flagged.reshape(len(p_values), -1).any(axis=0), dtype=bool)


def bridged(flagged: Booleans, run: Integers, tracks: Sequence[tuple[Floats, Floats]]) -> Booleans:
    """Flags, extended to windows between two flagged intervals of a run where it does not return to its level.

    The windows between belong to the intervals where they are together likelier at the level of these than at that of
    the run's other windows (Neyman and Pearson 1933, Philosophical Transactions of the Royal Society A 231, 289–337).

    Parameters
    ----------
    flagged, run : of every window
    tracks : value and error of each parameter in every window, NaN where there is none
    """
    found = flagged.copy()
    rows = np.flatnonzero(flagged).tolist()
    for first, last in pairwise(rows):
        between = np.arange(first + 1, last)
        if between.size == 0 or run[first] != run[last]:
            continue
        own = (run == run[first]) & ~np.isin(np.arange(run.size), between)
        sides = own & flagged & (_interval_of(flagged, first) | _interval_of(flagged, last))
        if sum(_log_ratio(*track, between, sides, own & ~flagged) for track in tracks) > 0:
            found[between] = True
    return found


def _interval_of(flagged: Booleans, row: int) -> Booleans:
    """The successive flagged windows about one of them."""
    number = np.cumsum(np.diff(flagged, prepend=False))
    return np.asarray(number == number[row], dtype=bool)


def _log_ratio(value: Floats, error: Floats, between: Integers, sides: Booleans, rest: Booleans) -> float:
    """Log-likelihood ratio of the level of some windows against that of the rest, for those between."""
    known = np.isfinite(value) & np.isfinite(error)
    inside, usual, tested = sides & known, rest & known, between[known[between]]
    if not inside.any() or not usual.any() or tested.size == 0:
        return 0.0
    levels = [_mean(value[rows], error[rows]) for rows in (inside, usual)]
    scatter = _scatter(value[usual], error[usual], levels[1][0])
    densities = [
        _log_density(value[tested] - mean, error[tested] ** 2 + deviation**2 + scatter) for mean, deviation in levels
    ]
    return float(np.sum(densities[0] - densities[1]))


def intervals(windows: xr.Dataset, discrepancy: xr.Dataset, run: Integers) -> pd.DataFrame:
    """Intervals of successive flagged windows of one run, a row each, with the evidence in words."""
    numbers = interval_numbers(discrepancy["flagged"].values, run)
    rows = []
    for number in range(numbers.max(initial=-1) + 1):
        members = np.flatnonzero(numbers == number)
        strongest = {name: float(np.nanmax(discrepancy[name].values[members])) for name in EVIDENCE}
        evidence = [rise(EVIDENCE[name], pull) for name, pull in strongest.items() if pull > 2]
        # depth goes back where a hole is drilled anew beside the first one
        ends = float(windows["depth_from"][members].min()), float(windows["depth_to"][members].max())
        rows.append((*ends, members.size, *strongest.values(), "; ".join(evidence)))
    return pd.DataFrame(rows, columns=["from_m", "to_m", "windows", *EVIDENCE, "evidence"])


def interval_numbers(flagged: Booleans, run: Integers) -> Integers:
    """Number of the interval that each flagged window is part of, −1 for others, shape (window,)."""
    begins = flagged & ~np.append(False, flagged[:-1] & (run[1:] == run[:-1]))
    return np.where(flagged, np.cumsum(begins) - 1, -1)


def runs(rig: Rig, bit_depth: Floats) -> Integers:
    """Number of the bottom-hole assembly run that each bit depth (m) belongs to, by the tally."""
    beginnings = sorted(collars.from_depth for collars in rig.collars)
    return np.searchsorted(beginnings, bit_depth, side="right").astype(np.int64)


def change_verdict(
    tracks: Mapping[str, tuple[Floats, Floats]],
    inside: Booleans,
    usual: Booleans,
    from_m: float,
    to_m: float,
    p_value: float,
    evidence: str,
) -> Verdict:
    """The verdict on one flagged interval.

    Without a significant predictive gain on held-out windows the change is not named: the verdict is `unknown`.

    Parameters
    ----------
    tracks : value and standard error of damping_bha and inertia_bha in every window of the well
    inside : the interval's windows
    usual : the run's other windows that are not flagged
    p_value : probability of so significant a flag anywhere in a well without changes
    evidence : what stands out, in words
    """
    damping, error = tracks["damping_bha"]
    scatter = _scatter(damping[usual], error[usual], _mean(damping[usual], error[usual])[0])
    mean, level = (_mean(damping[rows], np.sqrt(error[rows] ** 2 + scatter)) for rows in (inside, usual))
    size, deviation = mean[0] - level[0], float(np.hypot(mean[1], level[1]))
    gain = held_out_gain(
        [(value[inside], error[inside], value[usual], error[usual]) for value, error in tracks.values()]
    )
    named = gain.low > 0
    return Verdict(
        verdict=_CAUSE.name if named else UNKNOWN,
        family=_CAUSE.family,
        probability=probability(p_value),
        from_m=from_m,
        to_m=to_m,
        cause=_CAUSE.name if named else "",
        size=size,
        size_low=size - TWO_SIDED * deviation,
        size_high=size + TWO_SIDED * deviation,
        unit=_CAUSE.size.unit,
        predictive_gain=gain.value,
        predictive_gain_low=gain.low,
        predictive_gain_high=gain.high,
        held_out_windows=gain.windows,
        what_would_separate="a caliper log, cuttings returns and downhole vibration data",
        evidence_nats=evidence_of_p_value(p_value),
        evidence=evidence,
    )


def probability(p_value: float) -> float:
    """Largest posterior probability of a change that a p-value supports, at even prior odds.

    The Bayes factor is bounded by `detectors.pooling.evidence_of_p_value`.
    """
    return float(expit(evidence_of_p_value(p_value)))


def held_out_gain(tracks: Sequence[tuple[Floats, Floats, Floats, Floats]]) -> PredictiveGain:
    """Mean log score of the interval's windows predicted from its other windows, less that from the rest of the run.

    Both predictions are Gaussian about the mean of their windows, with the errors of both and the scatter of the rest
    of the run. A single window has no others: its own log-likelihood ratio less one for each fitted level takes their
    place (Akaike 1974, IEEE Transactions on Automatic Control 19, 716–723), with twice its mean as variance.

    Parameters
    ----------
    tracks : value and error inside, value and error in the rest, of each parameter
    """
    gains = np.sum([_gains(*track) for track in tracks], axis=0)
    value, count = float(gains.mean()), gains.size
    if count == 1:
        error, held_out = np.sqrt(2 * max(value + len(tracks), 0.5)), 0
    else:
        # Student's t quantile for few windows, relative to the normal one
        widening = student(ONE_SIDED, count - 1) / ONE_SIDED
        error, held_out = widening * gains.std(ddof=1) / np.sqrt(count), count
    return PredictiveGain(value, float(error), held_out)


def _gains(value: Floats, error: Floats, rest: Floats, rest_error: Floats) -> Floats:
    """Differences of log scores of one parameter, (windows of the interval,)."""
    level = _mean(rest, rest_error)
    scatter = _scatter(rest, rest_error, level[0])
    usual = _log_density(value - level[0], error**2 + level[1] ** 2 + scatter)
    if value.size == 1:
        return np.asarray(_log_density(np.zeros(1), error**2 + scatter) - 1 - usual, dtype=float)
    others = [_mean(np.delete(value, place), np.delete(error, place)) for place in range(value.size)]
    mean, deviation = np.array(others).T
    return np.asarray(_log_density(value - mean, error**2 + deviation**2 + scatter) - usual, dtype=float)


def _scatter(value: Floats, error: Floats, level: float) -> float:
    """Variance of windows about their estimated level beyond their errors."""
    squares = float(np.sum((value - level) ** 2)) / max(value.size - 1, 1)
    return max(squares - float(np.mean(error**2)), 0.0)


def _log_density(deviation: Floats, variance: Floats | float) -> Floats:
    """Log density of a Gaussian, up to a constant."""
    return np.asarray(-0.5 * (deviation**2 / variance + np.log(variance)), dtype=float)


def _mean(value: Floats, error: Floats) -> tuple[float, float]:
    """Inverse-variance weighted mean, with its standard error."""
    weight = error**-2.0
    return float(np.sum(weight * value) / np.sum(weight)), float(np.sum(weight) ** -0.5)
