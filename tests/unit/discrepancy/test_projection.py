"""How well causes can be separated, against closed forms of two directions."""

import numpy as np
import pytest

from drillid.discrepancy.inference.projection import Projection, separation, smallest_detectable

LENGTHS, ANGLE = np.array([2.0, 5.0]), 0.3
DIRECTIONS = LENGTHS[:, None] * np.array([[1.0, 0.0], [np.cos(ANGLE), np.sin(ANGLE)]])
PROJECTION = Projection(np.zeros(2), DIRECTIONS @ DIRECTIONS.T)


def test_causes_are_separated_by_the_distance_of_one_from_the_line_of_the_other() -> None:
    sizes = np.array([3.0, -0.5])
    expected = np.abs(sizes) * LENGTHS * np.sin(ANGLE)
    distance = separation(PROJECTION, sizes)
    np.testing.assert_allclose([distance[0, 1], distance[1, 0]], expected)
    np.testing.assert_allclose(np.diag(distance), 0, atol=1e-6)


def test_the_smallest_detectable_size_is_the_threshold_over_the_length() -> None:
    np.testing.assert_allclose(smallest_detectable(PROJECTION, 4.0), 4.0 / LENGTHS)


def test_a_direction_that_is_left_out_takes_its_row_and_column() -> None:
    rest = PROJECTION.without(np.array([0]))
    assert rest.information.tolist() == [[pytest.approx(25.0)]]
    assert rest.score.size == 1
