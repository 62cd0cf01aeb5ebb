"""Walks and jumps found in tracks that are Gaussian by construction, at the stated error rate."""

from dataclasses import replace

import numpy as np
from scipy.stats import binom

from drillid.arrays import Floats
from drillid.fits.joint.change_points import (
    Jump,
    Track,
    dated,
    log_gains_of_intervals,
    log_gains_of_jumps,
    probable_walks,
    strongest_jumps,
)
from drillid.fits.joint.coordinates import FIRST_GAIN, SIZE, WALKING
from drillid.fits.joint.smoother import Gaussian
from drillid.physics.parameters import DAMPING_BHA, INERTIA_BHA

GAP = 15.0
"""m between windows."""
DEVIATIONS = np.array([0.5, 0.3, 0.2, 0.1, *(0.05,) * (SIZE - len(WALKING))])
"""Errors of one window's figures."""
ERROR_RATE = 0.05


def track(windows: int, walk: float, seed: int, jumps: dict[int, Floats] | None = None) -> Track:
    """A track whose truth walks by `walk` per 100 m and jumps below the given windows."""
    random = np.random.default_rng(seed)
    steps = random.standard_normal((windows, len(WALKING))) * walk * np.sqrt(GAP / 100)
    for window, size in (jumps or {}).items():
        steps[window + 1] += size
    truth = np.zeros((windows, SIZE))
    truth[:, : len(WALKING)] = np.cumsum(steps, axis=0)
    # the control's gains, last of the state, are as they are known
    seen = truth.copy()
    seen[:, :FIRST_GAIN] += random.standard_normal((windows, FIRST_GAIN)) * DEVIATIONS[:FIRST_GAIN]
    nothing = np.zeros(windows)
    factors = Gaussian.expanded(seen, nothing, np.zeros(seen.shape), np.tile(np.diag(DEVIATIONS**-2), (windows, 1, 1)))
    prior = Gaussian.normal(np.zeros(SIZE), np.full(SIZE, 2.0))
    return Track(prior, factors, 1000 + GAP * np.arange(windows), np.full(len(WALKING), 0.1), ())


def settled(found: Track) -> Track:
    return replace(found, walks=probable_walks(found))


def test_steady_tracks_are_given_a_change_no_more_often_than_stated() -> None:
    tracks = [settled(track(9, walk, seed)) for seed in range(12) for walk in (0.0, 0.1)]
    found = sum(bool(strongest_jumps(each, ERROR_RATE)) for each in tracks)
    assert found <= binom.ppf(0.999, len(tracks), ERROR_RATE)


def test_the_expectation_of_evidence_for_a_jump_that_is_not_there_is_one() -> None:
    """Over draws from the model without it, averaged over the prior of walks; here about its middle."""
    tracks = [track(6, 0.1, seed) for seed in range(25)]
    gains = np.concatenate([log_gains_of_jumps(each, figure) for each in tracks for figure in range(len(WALKING))])
    assert np.exp(gains).mean() < 1.2


def test_a_jump_is_found_in_its_parameter_and_dated() -> None:
    for seed in range(5):
        jumping = settled(track(16, 0.05, seed, {9: np.array([0.0, 0.0, 0.0, -0.7])}))
        [jump] = strongest_jumps(jumping, ERROR_RATE)
        assert WALKING[jump.coordinate] == INERTIA_BHA
        [change] = dated(settled(replace(jumping, jumps=(jump,))))
        assert change.parameter == INERTIA_BHA
        assert change.depth_from <= 1000 + GAP * 9.5 <= change.depth_to
        assert abs(change.depth - (1000 + GAP * 9.5)) <= GAP
        assert change.probability > 0.95


def test_a_change_at_a_sidetrack_lies_between_a_shallow_and_a_deep_end() -> None:
    jumping = track(16, 0.05, 0, {9: np.array([0.0, 0.0, 0.0, -0.7])})
    depth = jumping.bit_depth - 60.0 * (np.arange(16) > 9)
    sidetracked = settled(replace(jumping, bit_depth=depth, jumps=(Jump(9, 3),)))
    [change] = dated(sidetracked)
    assert change.depth_from <= depth[10] < depth[9] <= change.depth_to
    assert change.depth_from <= change.depth <= change.depth_to


def test_an_interval_is_found_with_both_its_ends() -> None:
    """Either end alone would be a poor explanation."""
    bump = np.array([0.0, 0.0, 1.2, 0.0])
    found = settled(track(16, 0.05, 3, {6: bump, 9: -bump}))
    damping = WALKING.index(DAMPING_BHA)
    both = np.nanmax(log_gains_of_intervals(found, damping))
    assert both > np.max(log_gains_of_jumps(found, damping)) + 3
    jumps = strongest_jumps(found, ERROR_RATE)
    if len(jumps) == 1:
        jumps += strongest_jumps(settled(replace(found, jumps=jumps)), ERROR_RATE)
    assert [(WALKING[jump.coordinate], jump.before) for jump in jumps] == [(DAMPING_BHA, 6), (DAMPING_BHA, 9)]


def test_walks_are_told_from_rest() -> None:
    walking, resting = (np.median([probable_walks(track(40, walk, seed)) for seed in range(4)]) for walk in (0.5, 0.0))
    assert 0.25 < walking < 1.0
    assert resting < 0.2


def test_a_single_window_has_no_jumps() -> None:
    alone = track(1, 0.1, 0)
    assert strongest_jumps(alone, ERROR_RATE) == ()
    assert dated(alone) == ()
