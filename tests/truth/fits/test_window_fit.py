"""Fits without advance information find what the time-domain simulator was given, within their own standard errors."""

from dataclasses import dataclass, replace

import numpy as np
import pytest

from drillid.arrays import Floats
from drillid.fits.window_fit import Fit, Prior, fit
from drillid.physics.parameters import PARAMETERS
from tests.simulated import DEEP, SHALLOW, Truth
from tests.truth.measured import SETTINGS, measured

SEEDS = range(8)
JUDGED = ("inertia_td", "delay", "polar_moment", "length", "inertia_bha")


@dataclass(frozen=True)
class Trials:
    """Fits of one rig's windows."""

    truth: Truth
    fits: list[Fit]

    def pulls(self, parameter: str) -> Floats:
        """Value less truth over the standard error, shape (seed,)."""
        index = list(PARAMETERS).index(parameter)
        errors = [found.value[index] - self.truth.parameters[index] for found in self.fits]
        return np.divide(errors, [found.error[index] for found in self.fits])


@pytest.fixture(scope="module", params=[DEEP, SHALLOW], ids=["deep", "shallow"])
def trials(request: pytest.FixtureRequest) -> Trials:
    truth: Truth = request.param
    fits = [fit(measured(truth, seed), truth.known, Prior.silent(), SETTINGS.fits) for seed in SEEDS]
    return Trials(truth, fits)


@pytest.mark.parametrize("parameter", JUDGED)
def test_values_are_off_by_no_more_than_their_errors_tell(trials: Trials, parameter: str) -> None:
    pulls = trials.pulls(parameter)
    assert np.abs(pulls).max() < 3.8, pulls  # 1 of 1000 right errors would fail
    assert 0.3 < np.sqrt(np.mean(pulls**2)) < 1.6, pulls


def test_errors_are_neither_too_small_nor_too_large(trials: Trials) -> None:
    """Of all parameters together."""
    pulls = np.concatenate([trials.pulls(parameter) for parameter in JUDGED])
    assert np.sqrt(np.mean(pulls**2)) == pytest.approx(1, abs=0.25), pulls


def test_residuals_are_as_large_as_the_noise(trials: Trials) -> None:
    assert np.mean([found.chi2_per_dof for found in trials.fits]) == pytest.approx(1, abs=0.03)


def test_every_fit_is_accepted(trials: Trials) -> None:
    assert [found.reason for found in trials.fits] == [""] * len(trials.fits)
    assert all(found.accepted for found in trials.fits)


def test_damping_far_beyond_the_usual_leaves_intervals_their_width() -> None:
    pipe, collars = (replace(each, delta=1.5e10) for each in (SHALLOW.pipe, SHALLOW.collars))
    truth = replace(SHALLOW, pipe=pipe, collars=collars, bit_noise=20.0)
    found = fit(measured(truth, 3), truth.known, Prior.silent(), SETTINGS.fits)
    assert np.all((found.lower <= found.value) & (found.value <= found.upper))
    off = np.abs(found.value - truth.parameters) / found.error
    assert all(off[list(PARAMETERS).index(parameter)] < 4 for parameter in JUDGED)
