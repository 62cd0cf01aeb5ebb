"""Standard errors of a fit against a posterior drawn by brute force."""

import numpy as np
import pytest
from scipy.stats import norm

from drillid.arrays import Floats
from drillid.fits.window_fit import Fit, Measured, Prior, fit
from drillid.physics.eight_parameters import drilling_system
from drillid.physics.parameters import BOUNDS, PARAMETERS, SCALES
from drillid.physics.responses import command_mobility, laplace
from tests.simulated import SHALLOW, Truth
from tests.truth.measured import SETTINGS, measured

DELTA = list(PARAMETERS).index("delta")
CHAINS, STEPS, BURN_IN = 40, 900, 200


def log_posterior(points: Floats, data: Measured, truth: Truth) -> Floats:
    """Of parameters (chain, 8) with the logarithm of internal damping in its place.

    Gaussian errors, everything equally likely within the bounds but internal damping, which lies
    within a factor of three of its usual size.
    """
    values = points.copy()
    values[:, DELTA] = np.exp(points[:, DELTA])
    inside = np.all((values >= BOUNDS[0]) & (values <= BOUNDS[1]), axis=1)
    fitted = command_mobility(drilling_system(np.clip(values, *BOUNDS), truth.known), laplace(data.frequency))
    squares = np.sum(np.abs((fitted - data.mobility) * data.weight) ** 2, axis=1)
    damping = ((points[:, DELTA] - np.log(SCALES[DELTA])) / np.log(3)) ** 2
    return np.where(inside, -(squares + damping) / 2, -np.inf)


def drawn(found: Fit, data: Measured, truth: Truth) -> Floats:
    """Samples (sample, 8) of random-walk Metropolis chains that all start near the optimum."""
    random = np.random.default_rng(3)
    errors = found.error.copy()
    errors[DELTA] = 1.0
    covariance = found.correlation * np.outer(errors, errors)
    root = np.linalg.cholesky(covariance + np.diag(1e-6 * errors**2)) * 1.6 / np.sqrt(errors.size)
    start = found.value.copy()
    start[DELTA] = np.log(start[DELTA])
    points = np.tile(start, (CHAINS, 1))
    height = log_posterior(points, data, truth)
    samples = []
    for _ in range(STEPS):
        trial = points + random.standard_normal(points.shape) @ root.T
        trial_height = log_posterior(trial, data, truth)
        taken = np.log(random.random(CHAINS)) < trial_height - height
        points, height = np.where(taken[:, None], trial, points), np.where(taken, trial_height, height)
        samples.append(points)
    return np.concatenate(samples[BURN_IN:])


@pytest.fixture(scope="module")
def both() -> tuple[Fit, Floats]:
    data = measured(SHALLOW, 0)
    found = fit(data, SHALLOW.known, Prior.silent(), SETTINGS.fits)
    return found, drawn(found, data, SHALLOW)


@pytest.mark.parametrize("parameter", ["inertia_td", "delay", "polar_moment"])
def test_half_widths_are_those_of_the_sampled_posterior(both: tuple[Fit, Floats], parameter: str) -> None:
    found, samples = both
    index = list(PARAMETERS).index(parameter)
    low, high = np.quantile(samples[:, index], [0.025, 0.975])
    assert found.error[index] == pytest.approx((high - low) / 2 / norm.ppf(0.975), rel=0.25)
    assert low < found.value[index] < high
