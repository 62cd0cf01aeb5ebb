"""Errors of sizes that data sheets determine, which are wrong more often than a normal distribution tells."""

import numpy as np
import pytest

from drillid.discrepancy.inference.coordinates import COORDINATES, DEGREES, MEASURED, SHARED, Point
from drillid.discrepancy.inference.priors import Priors
from drillid.discrepancy.inference.set_fit import SetFit
from drillid.statistics import TWO_SIDED


def size_error(coordinate: str, prior_error: float, data_error: float) -> float:
    """Error of a size of which the data tell only its sum with a coordinate, with so much of an error."""
    place, error = COORDINATES.index(coordinate), np.ones(SHARED)
    error[place] = prior_error
    information = np.zeros((SHARED + 1, SHARED + 1))
    priors = Priors(error, DEGREES, MEASURED)
    np.fill_diagonal(information[:SHARED, :SHARED], priors.precision(np.zeros(SHARED)))
    information[np.ix_([place, SHARED], [place, SHARED])] += data_error**-2
    point = Point(np.zeros(SHARED), np.zeros((1, 4)), np.array([0.0]), np.zeros(1))
    fit = SetFit(point, 0.0, 0.0, information, 0.0, np.zeros(SHARED), priors)
    return float(fit.size_errors[0])


@pytest.mark.parametrize("coordinate", ["clock", "P", "inertia_td"])
@pytest.mark.parametrize("data_error", [0.1, 1.0, 10.0])
def test_95_percent_of_sizes_lie_in_their_intervals_where_data_sheets_have_heavy_tails(
    coordinate: str, data_error: float
) -> None:
    generator = np.random.default_rng(1)
    off = generator.standard_t(3, 100_000) + data_error * generator.standard_normal(100_000)
    covered = np.mean(np.abs(off) < TWO_SIDED * size_error(coordinate, 1.0, data_error))
    assert 0.945 < covered < 0.965


def test_what_no_data_sheet_states_keeps_its_error() -> None:
    assert size_error("kappa", 1.0, 0.5) == pytest.approx(np.hypot(1.0, 0.5))
