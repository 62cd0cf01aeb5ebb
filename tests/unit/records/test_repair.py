"""Gaps are filled by a spline that may be made block by block."""

import numpy as np
import pytest
from scipy.interpolate import CubicSpline

from drillid.records import repair


def test_a_spline_made_block_by_block_is_the_whole_spline(monkeypatch: pytest.MonkeyPatch) -> None:
    random = np.random.default_rng(9)
    place = np.arange(5000)
    gone = np.sort(random.choice(place[1:-1], 700, replace=False))
    known, values = np.setdiff1d(place, gone), random.normal(size=4300)
    whole = CubicSpline(known, values)(gone)
    monkeypatch.setattr(repair, "_SPLINE_BLOCK", 300)
    np.testing.assert_allclose(repair.spline(known, values, gone), whole, rtol=1e-11, atol=1e-11)
    none = np.setdiff1d(gone, np.arange(1000, 3000))
    np.testing.assert_allclose(repair.spline(known, values, none), CubicSpline(known, values)(none), atol=1e-11)
