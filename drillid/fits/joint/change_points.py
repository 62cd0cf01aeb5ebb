"""How fast parameters walk with depth, and where they jump instead: formations, hole sections, BHA runs.

Both are judged by evidence, the integral of likelihood times prior over all coordinates. Under the
model without a jump, the evidence with it over that without has an expectation of at most one,
so it exceeds tests/α with a chance of at most α/tests (Markov's inequality; Robbins 1970):
over all places, parameters and lengths, at most a share α of wells without a change is given one.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from scipy.special import logsumexp

from drillid.arrays import Floats
from drillid.fits.joint.coordinates import WALKING
from drillid.fits.joint.kernel import interval_evidence
from drillid.fits.joint.smoother import Gaussian, backward, forward

_USUAL_WALK = 0.05
"""Scale of the gamma prior of walks, with shape 2 to keep them off 0 (Chung et al. 2013); a mean of 10 % over 100 m."""
_GRID = np.geomspace(0.003, 3.0, 16)
"""Walks to be tried, rms change of the state over 100 m."""
_LOG_PRIOR = 2 * np.log(_GRID / _USUAL_WALK) - _GRID / _USUAL_WALK
_LOG_PRIOR -= logsumexp(_LOG_PRIOR)
USUAL_JUMP = float(np.log(3.0))
"""Standard deviation of a jump of the state: a factor of three."""
_LEAST_GAP = 1.0
"""m; windows closer together than this are taken as this far apart."""
_PER = 100.0
"""m of depth to which the variance of a random walk refers."""
_LONGEST = 12
"""Number of windows in the longest interval whose two ends are searched for together."""
_ROUNDS = 3


def walked_distance(bit_depth: Floats) -> Floats:
    """Distance between successive windows in units of 100 m, shape (window − 1,)."""
    return np.asarray(np.maximum(np.abs(np.diff(bit_depth)), _LEAST_GAP) / _PER)


@dataclass(frozen=True)
class Jump:
    """A jump of one walking coordinate between two successive windows."""

    before: int
    """Window below which it lies."""
    coordinate: int
    """Place in the state."""


@dataclass(frozen=True)
class Change:
    """A jump that the evidence demands."""

    parameter: int
    """Index among the eight parameters."""
    depth: float
    """Most probable depth, m."""
    depth_from: float
    """Limits of the depth interval that contains it with 95 % probability, m."""
    depth_to: float
    probability: float
    """Its posterior probability, with one change expected a priori in the whole well, anywhere and of any parameter."""


@dataclass(frozen=True)
class Track:
    """Factors of successive windows, the prior, and how the state moves between windows.

    walks : rms change of each walking coordinate over 100 m, shape (walking,)
    jumps : places where one of them may jump
    """

    prior: Gaussian
    factors: Gaussian
    bit_depth: Floats
    walks: Floats
    jumps: tuple[Jump, ...]

    @property
    def gaps(self) -> Floats:
        """Distance between successive windows in units of 100 m, shape (window − 1,)."""
        return walked_distance(self.bit_depth)

    @property
    def steps(self) -> Floats:
        """Variance of the state's step between successive windows, shape (window − 1, walking)."""
        steps = self.gaps[:, None] * self.walks**2
        for jump in self.jumps:
            steps[jump.before, jump.coordinate] += USUAL_JUMP**2
        return np.asarray(steps)

    def trials(self, coordinate: int) -> Floats:
        """Steps with each walk of the grid for one coordinate, shape (window − 1, grid, walking)."""
        tried = np.tile(self.steps[:, None, :], (1, _GRID.size, 1))
        tried[..., coordinate] += self.gaps[:, None] * (_GRID**2 - self.walks[coordinate] ** 2)
        return tried


def probable_walks(track: Track) -> Floats:
    """Walks of largest posterior probability, found on the grid one after the other, shape (walking,)."""
    for _ in range(_ROUNDS):
        before = track.walks
        for coordinate in range(track.walks.size):
            evidence = forward(track.prior, track.factors, track.trials(coordinate))[-1].log_integral()
            walks = track.walks.copy()
            walks[coordinate] = _GRID[int(np.argmax(evidence + _LOG_PRIOR))]
            track = replace(track, walks=walks)
        if np.array_equal(before, track.walks):
            break
    return track.walks


def strongest_jumps(track: Track, error_rate: float) -> tuple[Jump, ...]:
    """The jump that the evidence demands most, else the two ends of an interval; empty if it demands neither.

    Half of the error rate goes to single jumps, half to intervals.
    """
    for look in (log_gains_of_jumps, log_gains_of_intervals):
        gains = np.stack([look(track, coordinate) for coordinate in range(track.walks.size)], axis=-1)
        tests = np.count_nonzero(np.isfinite(gains))
        if not tests:
            continue
        place = np.unravel_index(int(np.nanargmax(gains)), gains.shape)
        if float(gains[place]) > np.log(tests / (error_rate / 2)):
            first, *lengths, coordinate = (int(each) for each in place)
            return tuple(Jump(end, coordinate) for end in (first, *(first + 1 + length for length in lengths)))
    return ()


@dataclass(frozen=True)
class _Sides:
    """Evidence from either side of a jump of one coordinate, for all places and all walks of the grid.

    steps : shape (window − 1, grid, walking)
    without : logarithm of the evidence without the jump
    """

    steps: Floats
    leap: Floats
    ahead: Gaussian
    behind: Gaussian
    without: float

    @staticmethod
    def of(track: Track, coordinate: int) -> _Sides:
        steps = track.trials(coordinate)
        ahead = forward(track.prior, track.factors, steps)
        leap = USUAL_JUMP**2 * (np.arange(track.walks.size) == coordinate)
        without = float(logsumexp(ahead[-1].log_integral() + _LOG_PRIOR))
        return _Sides(steps, leap, ahead, backward(track.factors, steps), without)


def log_gains_of_jumps(track: Track, coordinate: int) -> Floats:
    """Logarithm of the evidence with a jump over that without it, each averaged over the walks of the grid.

    Returns
    -------
    Gains below each window, shape (window − 1,)
    """
    sides = _Sides.of(track, coordinate)
    crossed = sides.ahead[:-1].walked(sides.steps + sides.leap) * sides.behind[1:]
    return np.asarray(logsumexp(crossed.log_integral() + _LOG_PRIOR, axis=-1) - sides.without)


def log_gains_of_intervals(track: Track, coordinate: int) -> Floats:
    """The same for two jumps, below a window and below another a little deeper.

    Returns
    -------
    Gains, shape (window − 1, longest interval − 1); NaN where the second place lies beyond the last window
    """
    sides, factors = _Sides.of(track, coordinate), track.factors
    count = sides.steps.shape[0]
    longest = max(min(_LONGEST, count - 1), 0)
    evidence = np.full((count, longest, _GRID.size), np.nan)
    interval_evidence(*sides.ahead.parts, *sides.behind.parts, *factors.parts, sides.steps, sides.leap, evidence)
    return np.asarray(logsumexp(evidence + _LOG_PRIOR, axis=-1) - sides.without)


def dated(track: Track) -> tuple[Change, ...]:
    """Each jump with its depth interval and probability, the other jumps held fixed."""
    changes = []
    for jump in track.jumps:
        others = replace(track, jumps=tuple(other for other in track.jumps if other != jump))
        gains = log_gains_of_jumps(others, jump.coordinate)
        taken = [other.before for other in others.jumps if other.coordinate == jump.coordinate]
        gains[taken] = -np.inf
        share = np.exp(gains - logsumexp(gains))
        sums = np.cumsum(share)
        first, last = int(np.searchsorted(sums, 0.025)), int(np.searchsorted(sums, 0.975))
        best = int(np.argmax(share))
        # a sidetrack begins above the bottom of the hole before it
        around = track.bit_depth[min(first, best) : min(max(last, best), gains.size - 1) + 2]
        odds = np.exp(min(float(logsumexp(gains)) - np.log(gains.size * track.walks.size), 700.0))
        changes.append(
            Change(
                WALKING[jump.coordinate],
                float(track.bit_depth[best : best + 2].mean()),
                float(around.min()),
                float(around.max()),
                float(odds / (1 + odds)),
            )
        )
    return tuple(sorted(changes, key=lambda change: (change.depth, change.parameter)))
