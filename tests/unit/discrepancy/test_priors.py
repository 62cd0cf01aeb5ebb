"""Priors of coordinates against scipy's distributions."""

import numpy as np
import pytest
from scipy.stats import Mixture, Normal, kstest, norm, t

from drillid.discrepancy.inference.priors import Priors
from drillid.discrepancy.rules import UNDERSTATED, UNDERSTATED_BY

PRIORS = Priors(np.array([2.0, 0.5, 3.0]), np.array([3.0, np.inf, np.inf]), np.array([False, False, True]))
CONTAMINATED = Mixture([Normal(), Normal(sigma=float(UNDERSTATED_BY))], weights=[1 - UNDERSTATED, UNDERSTATED])
DISTRIBUTIONS = (t(3.0), norm(), CONTAMINATED)
OFF = np.array([[-7.0, 2.5, 4.0], [0.3, -1.0, -0.1]])


def test_costs_are_log_densities_relative_to_their_peaks() -> None:
    for place, each in enumerate(DISTRIBUTIONS):
        expected = each.logpdf(0.0) - each.logpdf(OFF[:, place])
        np.testing.assert_allclose(PRIORS.cost(OFF)[:, place], expected, rtol=1e-12)


def test_pulls_are_slopes_of_costs_and_precisions_their_ratios_to_offsets() -> None:
    step = 1e-6
    slope = (PRIORS.cost(OFF + step) - PRIORS.cost(OFF - step)) / (2 * step) / PRIORS.error
    np.testing.assert_allclose(PRIORS.precision_and_pull(OFF)[1], -slope, rtol=1e-7)
    np.testing.assert_allclose(PRIORS.precision(OFF), slope / (OFF * PRIORS.error), rtol=1e-7)


def test_offsets_are_drawn_from_the_priors() -> None:
    drawn = PRIORS.drawn(4000, np.random.default_rng(0))
    for place, each in enumerate(DISTRIBUTIONS):
        assert kstest(drawn[:, place], each.cdf).pvalue > 0.01


def test_chosen_and_further_coordinates_keep_their_priors() -> None:
    further = PRIORS.of(np.array([2, 1])).and_normal(np.array([1.0]))
    off = np.array([4.0, 2.5, -3.0])
    assert further.cost(off) == pytest.approx([PRIORS.cost(OFF)[0, 2], 0.5 * 2.5**2, 4.5])
    assert further.precision(off)[2] == 1.0


def test_normal_priors_have_quadratic_costs() -> None:
    np.testing.assert_allclose(PRIORS.all_normal().cost(OFF), 0.5 * OFF**2)
