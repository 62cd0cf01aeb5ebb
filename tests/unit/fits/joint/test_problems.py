"""Windows that the joint fit counts less are one row."""

from types import SimpleNamespace
from typing import Any

import numpy as np
import xarray as xr

from drillid.fits.joint.dataset import _problems


def test_windows_that_contradict_the_others_are_one_row() -> None:
    fits = xr.Dataset({"hole_depth": ("window", [1000.0, 1010.0, 1020.0])}, {"window": [4, 5, 6]})
    fit: Any = SimpleNamespace(weight=np.array([0.5, 1.0, 0.25]), agreement=np.array([1e-9, 0.5, 1e-4]))
    [problem] = _problems(fit, fits)
    assert problem.where == "windows 4, 6 at 1000.0 to 1020.0 m"
    assert "p-value 1e-09" in problem.what
    assert "it counts 25 to 50 % in the joint fit" in problem.what
    fit.weight = np.ones(3)
    assert _problems(fit, fits) == []
