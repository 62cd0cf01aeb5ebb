"""The joint fit of a well as a dataset, and its problems."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from drillid.arrays import Floats
from drillid.datasets.measured import WINDOW_COORDINATES
from drillid.datasets.store import Problem, windows_place
from drillid.fits.joint.coordinates import GAINS, SHARED, WALKING
from drillid.fits.joint.fit import JointFit, joint_fit
from drillid.fits.joint.smoother import forward
from drillid.fits.window_fit import Measured, Prior
from drillid.physics.eight_parameters import KnownEquipment
from drillid.physics.parameters import PARAMETERS

if TYPE_CHECKING:
    from drillid.config.settings import FitsSettings


_WALKING_NAMES = [list(PARAMETERS)[index] for index in WALKING]
STATE = [*_WALKING_NAMES, *SHARED, *GAINS]
"""Names of the state's coordinates."""
_CHANGE = ("parameter", "depth", "from", "to", "probability")


def joint_dataset(
    measured: Sequence[Measured],
    known: Sequence[KnownEquipment],
    bit_depth: Floats,
    prior: Prior,
    fits: xr.Dataset,
    settings: FitsSettings,
) -> tuple[xr.Dataset, list[Problem]]:
    """Fit the windows of a well together, starting from their own fits.

    Parameters
    ----------
    measured, known, bit_depth : of each window
    prior : the data sheets on what all windows share
    fits : the windows' own fits
    """
    coordinates = {name: fits[name] for name in WINDOW_COORDINATES} | {
        "parameter": list(PARAMETERS),
        "shared": [*SHARED, *GAINS],
        "random_walk": _WALKING_NAMES,
        "state": STATE,
        "state_": STATE,
    }
    starts = fits["value"].values
    if not fits["accepted"].values.any():
        fitted = np.flatnonzero(np.isfinite(starts).all(axis=1)).tolist()
        return _nothing(len(measured)).assign_coords(coordinates), [_refused(fits, fitted)] if fitted else []
    share, informed = np.ones(len(measured)), np.flatnonzero([each.informs for each in measured])
    share[informed] = counted_once(fits["start"].values[informed], fits["end"].values[informed])
    fit = joint_fit(measured, known, bit_depth, prior, starts, settings, share)
    return _as_dataset(fit).assign_coords(coordinates), _problems(fit, fits)


def counted_once(start: NDArray[np.datetime64], end: NDArray[np.datetime64]) -> Floats:
    """Share of its time with which each window counts; time in several windows is split among them, (window,)."""
    edges = np.unique(np.concatenate([start, end]))
    inside = (start[:, None] <= edges[:-1]) & (edges[1:] <= end[:, None])
    pieces = np.where(inside, np.diff(edges) / np.timedelta64(1, "s"), 0.0)
    share: Floats = np.sum(pieces / np.maximum(inside.sum(axis=0), 1), axis=1) / pieces.sum(axis=1)
    return share


def _as_dataset(fit: JointFit) -> xr.Dataset:
    newest = forward(fit.track.prior, fit.track.factors, fit.track.steps)[-1]
    by_parameter = {"value": fit.value, "standard_error": fit.error, "lower": fit.lower, "upper": fit.upper}
    rows = [
        (list(PARAMETERS)[change.parameter], change.depth, change.depth_from, change.depth_to, change.probability)
        for change in fit.changes
    ]
    columns = zip(*rows, strict=True) if rows else [()] * len(_CHANGE)
    changes = {f"change_{name}": ("change", np.array(column)) for name, column in zip(_CHANGE, columns, strict=True)}
    return xr.Dataset(
        {name: (("window", "parameter"), values) for name, values in by_parameter.items()}
        | {
            "weight": ("window", fit.weight),
            "agreement": ("window", fit.agreement),
            "shared_value": ("shared", np.append(fit.shared, fit.gains)),
            "shared_error": ("shared", np.append(fit.shared_error, fit.gains_error)),
            "random_walk_step": ("random_walk", fit.walks),
            "last_vector": ("state", newest.vector),
            "last_information": (("state", "state_"), newest.information),
        }
        | changes
    )


def _nothing(windows: int) -> xr.Dataset:
    """The dataset of a well without any accepted fit; each failed fit has a problem row of its own."""
    sizes = {
        "window": windows,
        "parameter": len(PARAMETERS),
        "shared": len(SHARED) + len(GAINS),
        "random_walk": len(WALKING),
    }
    sizes |= {"state": len(STATE), "state_": len(STATE), "change": 0}
    dims: dict[str, tuple[str, ...]] = {
        **dict.fromkeys(("value", "standard_error", "lower", "upper"), ("window", "parameter")),
        **dict.fromkeys(("weight", "agreement"), ("window",)),
        **dict.fromkeys(("shared_value", "shared_error"), ("shared",)),
        **{f"change_{name}": ("change",) for name in _CHANGE},
        "random_walk_step": ("random_walk",),
        "last_vector": ("state",),
        "last_information": ("state", "state_"),
    }
    return xr.Dataset({name: (dim, np.full([sizes[each] for each in dim], np.nan)) for name, dim in dims.items()})


def _refused(fits: xr.Dataset, fitted: list[int]) -> Problem:
    """Why windows are not fitted together: an error of the model that all have in common is averaged as noise."""
    return Problem(
        windows_place(fits, fitted),
        "no window's own fit is accepted, so that there is no joint fit",
        "See the reasons of these fits, and what the verdicts say is wrong",
    )


def _problems(fit: JointFit, fits: xr.Dataset) -> list[Problem]:
    """A problem row for the windows that count less because they contradict the others."""
    rows = np.flatnonzero(fit.weight < 1)
    if not rows.size:
        return []
    least, most = 100 * fit.weight[rows].min(), 100 * fit.weight[rows].max()
    counted = f"{least:.0f} %" if rows.size == 1 else f"{least:.0f} to {most:.0f} %"
    return [
        Problem(
            windows_place(fits, rows.tolist()),
            f"contradicts the windows around it (p-value {fit.agreement[rows].min():.1g}) or has residuals larger than "
            f"its noise; it counts {counted} in the joint fit",
            "Look at its residuals and at the log of that time",
        )
    ]
