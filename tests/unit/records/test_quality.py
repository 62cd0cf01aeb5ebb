"""Steps of a recorded channel are found among rows that are not on them."""

import numpy as np
import pytest

from drillid.records.quality import quantisation_step


def test_lattice_is_found_among_interpolated_rows() -> None:
    generator = np.random.default_rng(1)
    values = 0.03 * np.rint((10 + 0.3 * generator.standard_normal(5000)) / 0.03)
    values[::10] = (values[1::10] + values[2::10] + generator.uniform(0, 0.03, 500)) / 2
    assert quantisation_step(values) == pytest.approx(0.03, rel=1e-6)
    assert quantisation_step(generator.standard_normal(5000)) is None
