"""Filter and smoother against one dense Gaussian of all figures at once."""

import numpy as np
import pytest

from drillid.arrays import Indices
from drillid.fits.joint.smoother import Gaussian, backward, forward, smoothed

WINDOWS, WALKING, SHARED = 6, 2, 3
SIZE = WALKING + SHARED


def factors(seed: int = 0) -> Gaussian:
    """Likelihoods of windows that each leave directions open."""
    random = np.random.default_rng(seed)
    rows = random.normal(size=(WINDOWS, SIZE, 3))
    hessian = rows @ np.swapaxes(rows, 1, 2)
    return Gaussian.expanded(
        random.normal(size=(WINDOWS, SIZE)), random.normal(size=WINDOWS), random.normal(size=(WINDOWS, SIZE)), hessian
    )


PRIOR = Gaussian.normal(np.linspace(-1, 1, SIZE), np.linspace(0.5, 2, SIZE))
STEPS = np.random.default_rng(1).uniform(0.1, 1, (WINDOWS - 1, WALKING))


def dense() -> tuple[Gaussian, list[Indices]]:
    """The Gaussian of the walking figures of all windows and the shared ones, and each window's places in it."""
    total = WINDOWS * WALKING + SHARED
    information, vector, log_scale = np.zeros((total, total)), np.zeros(total), 0.0
    shared = np.arange(WINDOWS * WALKING, total)
    places = [np.concatenate([np.arange(row * WALKING, (row + 1) * WALKING), shared]) for row in range(WINDOWS)]
    parts = [(PRIOR, places[0]), *((factors()[row], places[row]) for row in range(WINDOWS))]
    for part, place in parts:
        information[np.ix_(place, place)] += part.information
        vector[place] += part.vector
        log_scale += float(part.log_scale)
    for row in range(WINDOWS - 1):
        for figure in range(WALKING):
            ends = np.array([places[row][figure], places[row + 1][figure]])
            information[np.ix_(ends, ends)] += np.array([[1, -1], [-1, 1]]) / STEPS[row, figure]
            log_scale -= 0.5 * np.log(2 * np.pi * STEPS[row, figure])
    return Gaussian(information, vector, np.asarray(log_scale)), places


def test_evidence_is_that_of_the_dense_system() -> None:
    expected = float(dense()[0].log_integral())
    np.testing.assert_allclose(smoothed(PRIOR, factors(), STEPS).log_integral(), expected, rtol=1e-10)
    assert float(forward(PRIOR, factors(), STEPS)[-1].log_integral()) == pytest.approx(expected, rel=1e-10)


def test_means_and_covariances_are_those_of_the_dense_system() -> None:
    whole, places = dense()
    mean, covariance = whole.moments()
    found_mean, found_covariance = smoothed(PRIOR, factors(), STEPS).moments()
    for row, place in enumerate(places):
        np.testing.assert_allclose(found_mean[row], mean[place], rtol=1e-9)
        np.testing.assert_allclose(found_covariance[row], covariance[np.ix_(place, place)], rtol=1e-8, atol=1e-12)


def test_both_ways_meet_anywhere() -> None:
    ahead, behind = forward(PRIOR, factors(), STEPS), backward(factors(), STEPS)
    for row in range(WINDOWS - 1):
        met = ahead[row].walked(STEPS[row]) * behind[row + 1]
        assert float(met.log_integral()) == pytest.approx(float(dense()[0].log_integral()), rel=1e-10)


def test_hypotheses_side_by_side_are_those_one_by_one() -> None:
    several = np.stack([STEPS, 2 * STEPS, 0 * STEPS], axis=1)
    together = forward(PRIOR, factors(), several)[-1].log_integral()
    alone = [float(forward(PRIOR, factors(), several[:, number])[-1].log_integral()) for number in range(3)]
    np.testing.assert_allclose(together, alone, rtol=1e-12)


def test_without_steps_everything_is_shared() -> None:
    together = PRIOR
    for row in range(WINDOWS):
        together = together * factors()[row]
    found = smoothed(PRIOR, factors(), 0 * STEPS)
    np.testing.assert_allclose(found.moments()[0], np.tile(together.moments()[0], (WINDOWS, 1)), rtol=1e-9)


def test_a_step_without_end_forgets_what_walked_and_keeps_what_is_shared() -> None:
    state = PRIOR * factors()[0] * factors()[1]
    covariance = state.moments()[1]
    forgot = state.walked(np.full(WALKING, 1e12))
    assert np.abs(forgot.information[:WALKING]).max() < 1e-9
    np.testing.assert_allclose(
        np.linalg.inv(forgot.information[WALKING:, WALKING:]), covariance[WALKING:, WALKING:], rtol=1e-6
    )


def test_silence_about_a_figure_is_no_information() -> None:
    silent = Gaussian.normal(np.array([1.0, np.nan]), np.array([0.5, np.inf]))
    np.testing.assert_allclose(silent.information, np.diag([4.0, 0.0]))
    assert silent.vector.tolist() == [4.0, 0.0]
