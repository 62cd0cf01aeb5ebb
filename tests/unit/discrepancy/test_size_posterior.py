"""Intervals of sizes against draws from their prior and their errors."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.stats import norm, t

from drillid.arrays import Floats
from drillid.discrepancy.catalogue import CATALOGUE, Size
from drillid.discrepancy.inference.coordinates import COORDINATES, DEGREES, MEASURED, SHARED, Extension, Point
from drillid.discrepancy.inference.heavy_tails import HeavyTailedFit
from drillid.discrepancy.inference.priors import Priors
from drillid.discrepancy.inference.set_fit import SetFit
from drillid.discrepancy.inference.size_posterior import fitted_size_interval, size_interval
from drillid.discrepancy.rules import STUDENT_TAIL, WIDE_PRIOR

ONE_SIDED, TWO_SIDED = Size("lag", "s", 1.0, 0.0, 1e3), Size("gain", "1", 1.0, -1e3, 1e3)


def _fitted(size: float, error: float) -> tuple[float, float]:
    """Estimate and error of a fit whose prior is the wide one, from an estimate by the data alone."""
    precision = error**-2 + WIDE_PRIOR**-2
    return size * error**-2 / precision, precision**-0.5


@pytest.mark.parametrize("size", [ONE_SIDED, TWO_SIDED], ids=["one-sided", "two-sided"])
def test_intervals_hold_95_percent_of_sizes_from_the_prior(size: Size) -> None:
    generator = np.random.default_rng(0)
    drawn = generator.standard_normal(4000) * generator.choice([1.0, WIDE_PRIOR], 4000)
    if size.low == 0:
        drawn = np.abs(drawn)
    seen = drawn + 0.8 * generator.standard_normal(drawn.size)
    if size.low == 0:
        drawn, seen = drawn[seen > 0], seen[seen > 0]
    held = [
        low <= true <= high
        for true, estimate in zip(drawn, seen, strict=True)
        for low, high in [size_interval(*_fitted(estimate, 0.8), size)]
    ]
    assert 0.94 < np.mean(held) < 0.965


def test_a_size_that_the_data_tell_has_the_interval_of_the_data() -> None:
    low, high = size_interval(*_fitted(3.0, 0.01), ONE_SIDED)
    assert (low, high) == pytest.approx((3 - 0.0196, 3 + 0.0196), abs=1e-4)


def test_bounds_end_an_interval() -> None:
    assert size_interval(*_fitted(0.1, 0.5), ONE_SIDED)[0] >= 0
    assert size_interval(*_fitted(9.9, 0.5), Size("lag", "s", 1.0, 0.0, 10.0))[1] == 10.0


def test_far_below_a_bound_an_interval_has_the_tail_that_is_left() -> None:
    error, below = 0.1, -10.0
    low, high = size_interval(*_fitted(below, error), ONE_SIDED)
    # so far out the tail of a normal distribution is an exponential one
    assert low == 0.0
    assert high == pytest.approx(-np.log(0.025) * error**2 / -below, rel=0.05)


GAIN = Extension(CATALOGUE["controller_gain"], 0.0)
TOLERANCE, DATA_ERROR = 0.02, 0.005
SIZES = np.linspace(-1.0, 1.5, 5001)


def _told_by_two_data_sheets(size: float, off: Floats, noise: Floats) -> SetFit:
    """A fit of a size of which the data tell its sums with P and with I, (2,) each."""
    gains = [COORDINATES.index("P"), COORDINATES.index("I")]
    error, sums = np.ones(SHARED), np.zeros((2, SHARED + 1))
    error[gains] = TOLERANCE
    sums[[0, 1], gains], sums[:, SHARED] = 1.0, 1.0
    information, wide = sums.T @ sums / DATA_ERROR**2, WIDE_PRIOR * GAIN.cause.size.typical
    right = (size + off + noise) @ sums / DATA_ERROR**2
    rig = Priors(error, DEGREES, MEASURED)
    priors = rig.and_normal(np.array([wide]))
    equations = HeavyTailedFit(information, priors)
    starts = np.zeros((3, SHARED + 1))
    starts[[1, 2], gains] = 1.0
    at = equations.optima(right[None], starts[:, None]).at[0]
    point, off_prior = Point(at[:SHARED], np.zeros((1, 4)), at[SHARED:], np.zeros(1)), at[:SHARED] / error
    precision = priors.precision(at / priors.error)
    return SetFit(point, 0.0, 0.0, information + np.diag(precision), 0.0, off_prior, rig)


def _posterior(seen: Floats) -> Floats:
    """Posterior density of SIZES, given a size's two sums with gains that are off, (2,), by quadrature."""
    noise = DATA_ERROR * np.linspace(-5.0, 5.0, 41)
    density = sum(norm.pdf(SIZES, scale=scale * GAIN.cause.size.typical) / 2 for scale in (1.0, WIDE_PRIOR))
    for each in seen:
        off = (each - SIZES[:, None] - noise) / TOLERANCE
        density = density * (t.pdf(off, float(STUDENT_TAIL)) @ norm.pdf(noise, scale=DATA_ERROR))
    return np.asarray(density / density.sum(), dtype=float)


def _central(density: Floats) -> Floats:
    return np.interp([0.025, 0.975], np.cumsum(density), SIZES)


def test_an_interval_is_that_of_the_posterior_though_two_data_sheets_contradict_each_other() -> None:
    generator = np.random.default_rng(2)
    for apart in (0.0, 2.0, 4.0, 6.0, 10.0):
        off = TOLERANCE * np.array([apart, 0.0])
        noise = DATA_ERROR * generator.standard_normal(2)
        found = fitted_size_interval([(_told_by_two_data_sheets(0.3, off, noise), 0.0)], (GAIN,), 0)
        exact = _central(_posterior(0.3 + off + noise))
        assert found == pytest.approx(exact, abs=0.02 * np.ptp(exact))


def test_an_interval_over_several_models_is_that_of_the_mean_of_their_posteriors() -> None:
    sizes = (0.3, 0.36)
    fits = [_told_by_two_data_sheets(size, np.zeros(2), np.zeros(2)) for size in sizes]
    first, second = (_posterior(np.full(2, size)) for size in sizes)
    for odds in (1.0, 0.2, 1e-9):
        found = fitted_size_interval([(fits[0], 7.0), (fits[1], 7.0 + np.log(odds))], (GAIN,), 0)
        exact = _central((first + odds * second) / (1 + odds))
        assert found == pytest.approx(exact, abs=0.02 * np.ptp(exact))


def test_a_fit_of_no_mass_does_not_count_even_if_its_size_has_no_error() -> None:
    good = _told_by_two_data_sheets(0.3, np.zeros(2), np.zeros(2))
    bad = replace(good, information=np.full_like(good.information, np.nan))
    alone = fitted_size_interval([(good, 0.0)], (GAIN,), 0)
    assert fitted_size_interval([(good, 0.0), (bad, -30.0)], (GAIN,), 0) == alone
