"""State of a joint fit ↔ the eight parameters of its windows."""

import numpy as np

from drillid.fits.joint.coordinates import shared_figures, to_parameters, to_state
from tests.simulated import DEEP, SHALLOW

VALUES = np.stack([DEEP.parameters, SHALLOW.parameters])
LOGGED = np.array([3000.0, 870.0])
FACTOR, OFFSET = 1.02, -7.0


def test_parameters_come_back_and_the_length_follows_factor_and_offset() -> None:
    state = to_state(VALUES, FACTOR, OFFSET)
    values, _ = to_parameters(state, LOGGED)
    expected = VALUES.copy()
    expected[:, 2] = FACTOR * LOGGED + OFFSET
    np.testing.assert_allclose(values, expected, rtol=1e-12)


def test_shared_figures_are_in_si() -> None:
    found = shared_figures(to_state(VALUES, FACTOR, OFFSET))
    np.testing.assert_allclose(found, np.column_stack([VALUES[:, [4, 5, 3]], [FACTOR] * 2, [OFFSET] * 2]), rtol=1e-12)


def test_derivatives_are_those_of_central_differences() -> None:
    state, step = to_state(VALUES, FACTOR, OFFSET), 1e-6
    _, slopes = to_parameters(state, LOGGED)
    for place in range(state.shape[1]):
        ends = [
            to_parameters(state + step * sign * (np.arange(state.shape[1]) == place), LOGGED)[0] for sign in (1, -1)
        ]
        np.testing.assert_allclose(slopes[..., place], (ends[0] - ends[1]) / (2 * step), rtol=1e-6, atol=1e-12)
