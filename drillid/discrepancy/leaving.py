"""Intervals whose damping or inertia leaves its run, as verdicts: the way of drilling changes from there to there."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray
from scipy.special import expit, ndtr, stdtrit

from drillid.discrepancy.causes import CATALOGUE
from drillid.discrepancy.gain import Gain
from drillid.discrepancy.pooled import evidence_of_chance
from drillid.discrepancy.verdict import UNKNOWN, Verdict
from drillid.statistics import ONE_SIDED, TWO_SIDED

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

Floats = NDArray[np.float64]
Bools = NDArray[np.bool_]

_NAME = "regime_change"


def change_verdict(
    tracks: Mapping[str, tuple[Floats, Floats]],
    inside: Bools,
    usual: Bools,
    from_m: float,
    to_m: float,
    chance: float,
    said: str,
) -> Verdict:
    """The verdict on one flagged interval.

    Without a sure gain on held-out windows the change has no name and is `unknown`.

    Parameters
    ----------
    tracks : value and standard error of damping_bha and inertia_bha in every window of the well
    inside : the interval's windows
    usual : the run's other windows that are not flagged
    chance : of so clear a flag anywhere in a well without anything unusual
    said : what stands out, in words
    """
    damping, error = tracks["damping_bha"]
    there, level = _mean(damping[inside], error[inside]), _mean(damping[usual], error[usual])
    size, deviation = there[0] - level[0], float(np.hypot(there[1], level[1]))
    gain = held_out_gain(
        [(value[inside], error[inside], value[usual], error[usual]) for value, error in tracks.values()]
    )
    named = gain.low > 0
    return Verdict(
        verdict=_NAME if named else UNKNOWN,
        family=CATALOGUE[_NAME].family,
        probability=probability(chance),
        from_m=from_m,
        to_m=to_m,
        cause=_NAME if named else "",
        size=size,
        size_low=size - TWO_SIDED * deviation,
        size_high=size + TWO_SIDED * deviation,
        unit=CATALOGUE[_NAME].size.unit,
        gain=gain.value,
        gain_low=gain.low,
        gain_high=gain.high,
        held_out_windows=gain.windows,
        what_would_separate="a caliper log, cuttings returns and downhole vibration data",
        evidence=said,
    )


def probability(chance: float) -> float:
    """Largest probability of a change that a chance supports, at even odds.

    The chance stands for a Bayes factor of no more than `pooled.evidence_of_chance` says.
    """
    return float(expit(evidence_of_chance(chance)))


def held_out_gain(tracks: Sequence[tuple[Floats, Floats, Floats, Floats]]) -> Gain:
    """Log score of each of the interval's windows from its other windows, less that from the rest of the run.

    Both predict a Gaussian: the mean of their windows, with the errors of both and the scatter of the rest of the
    run. A window that is alone has no others: its own log-likelihood ratio less one for the fitted level stands in
    (Akaike 1974, IEEE Transactions on Automatic Control 19, 716–723), with twice its mean as variance.

    Parameters
    ----------
    tracks : value and error inside, value and error in the rest, of each parameter
    """
    gains = np.sum([_gains(*track) for track in tracks], axis=0)
    value, count = float(gains.mean()), gains.size
    if count == 1:
        error, held_out = np.sqrt(2 * max(value + 1, 0.5)), 0
    else:
        # as far as Student's t asks for so few
        few = stdtrit(count - 1, ndtr(ONE_SIDED)) / ONE_SIDED
        error, held_out = few * gains.std(ddof=1) / np.sqrt(count), count
    return Gain(value, float(error), held_out)


def _gains(value: Floats, error: Floats, rest: Floats, rest_error: Floats) -> Floats:
    """Differences of log scores of one parameter, (windows of the interval,)."""
    level = _mean(rest, rest_error)
    scatter = max(float(np.var(rest - level[0])) - float(np.mean(rest_error**2)), 0.0)
    usual = _log_density(value - level[0], error**2 + level[1] ** 2 + scatter)
    if value.size == 1:
        return np.asarray(_log_density(np.zeros(1), error**2 + scatter) - 1 - usual, dtype=float)
    others = [_mean(np.delete(value, place), np.delete(error, place)) for place in range(value.size)]
    mean, deviation = np.array(others).T
    return np.asarray(_log_density(value - mean, error**2 + deviation**2 + scatter) - usual, dtype=float)


def _log_density(deviation: Floats, variance: Floats | float) -> Floats:
    """Of a Gaussian, up to a constant."""
    return np.asarray(-0.5 * (deviation**2 / variance + np.log(variance)), dtype=float)


def _mean(value: Floats, error: Floats) -> tuple[float, float]:
    """Mean weighted by information, with its standard error."""
    weight = error**-2.0
    return float(np.sum(weight * value) / np.sum(weight)), float(np.sum(weight) ** -0.5)
