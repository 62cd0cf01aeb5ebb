"""The joint fit of a well as a dataset, and its problems."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
import xarray as xr
from numpy.typing import NDArray
from scipy.special import chdtrc

from drillid.arrays import Floats
from drillid.datasets.measured import WINDOW_COORDINATES
from drillid.datasets.store import Problem, window_place
from drillid.fits.joint.change_points import USUAL_JUMP, walked_distance
from drillid.fits.joint.coordinates import LEAST, MOST, SHARED, WALKING, shared_figures, to_parameters
from drillid.fits.joint.fit import JointFit, joint_fit
from drillid.fits.joint.likelihood import Windows
from drillid.fits.joint.smoother import Gaussian, forward
from drillid.fits.window_fit import Measured, Prior
from drillid.physics.eight_parameters import KnownEquipment
from drillid.physics.parameters import PARAMETERS

if TYPE_CHECKING:
    from drillid.config.settings import FitsSettings


_WALKING_NAMES = [list(PARAMETERS)[index] for index in WALKING]
STATE = [*_WALKING_NAMES, *SHARED]
"""Names of the state's coordinates."""
_CHANGE = ("parameter", "depth", "from", "to", "probability")

_ITERATIONS = 30
_HALVINGS = 12
_SETTLED = 1e-6


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
        "shared": list(SHARED),
        "walking": _WALKING_NAMES,
        "state": STATE,
        "state_": STATE,
    }
    starts = fits["value"].values
    if not np.isfinite(starts).all(axis=1).any():
        return _nothing(len(measured)).assign_coords(coordinates), []
    share = counted_once(fits["start"].values, fits["end"].values)
    fit = joint_fit(measured, known, bit_depth, prior, starts, settings, share)
    return _as_dataset(fit).assign_coords(coordinates), _problems(fit, fits)


def counted_once(start: NDArray[np.datetime64], end: NDArray[np.datetime64]) -> Floats:
    """Share of each window's time where time that several windows hold is split among them, shape (window,)."""
    edges = np.unique(np.concatenate([start, end]))
    inside = (start[:, None] <= edges[:-1]) & (edges[1:] <= end[:, None])
    pieces = np.where(inside, np.diff(edges) / np.timedelta64(1, "s"), 0.0)
    share: Floats = np.sum(pieces / np.maximum(inside.sum(axis=0), 1), axis=1) / pieces.sum(axis=1)
    return share


def _as_dataset(fit: JointFit) -> xr.Dataset:
    latest = Latest.of(fit)
    by_parameter = {"value": fit.value, "standard_error": fit.error, "lower": fit.lower, "upper": fit.upper}
    figures = [
        (list(PARAMETERS)[change.parameter], change.depth, change.depth_from, change.depth_to, change.probability)
        for change in fit.changes
    ]
    columns = zip(*figures, strict=True) if figures else [()] * len(_CHANGE)
    changes = {f"change_{name}": ("change", np.array(column)) for name, column in zip(_CHANGE, columns, strict=True)}
    return xr.Dataset(
        {name: (("window", "parameter"), values) for name, values in by_parameter.items()}
        | {
            "weight": ("window", fit.weight),
            "agreement": ("window", fit.agreement),
            "shared_value": ("shared", fit.shared),
            "shared_error": ("shared", fit.shared_error),
            "walk": ("walking", fit.walks),
            "last_vector": ("state", latest.state.vector),
            "last_information": (("state", "state_"), latest.state.information),
        }
        | changes
    )


def _nothing(windows: int) -> xr.Dataset:
    """Of a well without any fit, each of which has its own problem row."""
    sizes = {"window": windows, "parameter": len(PARAMETERS), "shared": len(SHARED), "walking": len(WALKING)}
    sizes |= {"state": len(STATE), "state_": len(STATE), "change": 0}
    dims: dict[str, tuple[str, ...]] = {
        **dict.fromkeys(("value", "standard_error", "lower", "upper"), ("window", "parameter")),
        **dict.fromkeys(("weight", "agreement"), ("window",)),
        **dict.fromkeys(("shared_value", "shared_error"), ("shared",)),
        **{f"change_{name}": ("change",) for name in _CHANGE},
        "walk": ("walking",),
        "last_vector": ("state",),
        "last_information": ("state", "state_"),
    }
    return xr.Dataset({name: (dim, np.full([sizes[each] for each in dim], np.nan)) for name, dim in dims.items()})


def _problems(fit: JointFit, fits: xr.Dataset) -> list[Problem]:
    """A row for each window that counts less because it contradicts the others."""
    return [
        Problem(
            window_place(fits, row),
            f"contradicts the windows around it (p-value {fit.agreement[row]:.1g}) or has residuals larger than its "
            f"noise; it counts {100 * fit.weight[row]:.0f} % in the joint fit",
            "Look at its residuals and at the log of that time",
        )
        for row in np.flatnonzero(fit.weight < 1).tolist()
    ]


@dataclass(frozen=True)
class Latest:
    """What all windows up to the newest say of its state.

    state : normalised density of the state
    walks : rms change of the walking figures over 100 m, shape (4,)
    """

    state: Gaussian
    bit_depth: float
    logged_length: float
    walks: Floats

    @staticmethod
    def of(fit: JointFit) -> Latest:
        """After the last window of a joint fit."""
        track = fit.track
        state = forward(track.prior, track.factors, track.steps)[-1]
        return Latest(normalised(state), float(track.bit_depth[-1]), float(fit.logged_length[-1]), track.walks)

    @property
    def parameters(self) -> tuple[Floats, Floats]:
        """Values and standard errors of the newest window, each (8,), SI."""
        mean, covariance = self.state.moments()
        values, slopes = to_parameters(mean, np.asarray(self.logged_length))
        return values, np.sqrt(np.einsum("is,st,it->i", slopes, covariance, slopes))

    @property
    def shared(self) -> Floats:
        """Shared figures, SI, shape (5,)."""
        return shared_figures(self.state.moments()[0])


@dataclass(frozen=True)
class Carried:
    """The state after one window more.

    log_gains : logarithm of the evidence with a jump of each walking figure above this window over
        that without, shape (4,); more than ln(4/α) has a chance of at most α where nothing jumped
    agreement : p-value of the window's distance from what was expected
    """

    latest: Latest
    log_gains: Floats
    agreement: float


def carried_on(latest: Latest, measured: Measured, known: KnownEquipment, bit_depth: float) -> Carried:
    """Add the next window, found by Gauss–Newton steps from what the windows before let expect.

    Raises nothing; a window that contradicts the others shows in `agreement` and is the caller's to leave out.
    """
    window = Windows([measured], [known], np.array([bit_depth]))
    variance = walked_distance(np.array([latest.bit_depth, bit_depth])) * latest.walks**2
    expected = latest.state.walked(variance)
    mean = expected.moments()[0]
    factor = _factor(window, expected, mean)
    state = expected * factor
    leaps = variance + np.eye(len(WALKING)) * USUAL_JUMP**2
    size = (len(WALKING),)
    before = Gaussian(*(np.broadcast_to(part, (*size, *np.shape(part))) for part in vars(latest.state).values()))
    gains = (before.walked(leaps) * factor).log_integral() - state.log_integral()
    shift = state.moments()[0] - mean
    away = float(np.vecdot(shift, expected.information @ shift))
    carried = Latest(normalised(state), bit_depth, float(window.logged_length[0]), latest.walks)
    return Carried(carried, np.asarray(gains), float(chdtrc(shift.size, away)))


def normalised(state: Gaussian) -> Gaussian:
    """With integral one."""
    return Gaussian(state.information, state.vector, np.asarray(state.log_scale - state.log_integral()))


def _factor(window: Windows, expected: Gaussian, mean: Floats) -> Gaussian:
    """Likelihood of one window expanded about the state of largest posterior density."""

    def height(point: Floats, cost: Floats) -> float:
        away = point - mean
        return float(cost[0] + 0.5 * away @ expected.information @ away)

    point = mean
    terms = window.terms(point[None])
    least = height(point, terms[0])
    for _ in range(_ITERATIONS):
        factor = Gaussian.expanded(point[None], *terms)[0]
        step = (expected * factor).moments()[0] - point
        for halving in range(_HALVINGS):
            trial = point + 0.5**halving * step
            trial[: len(WALKING)] = np.clip(trial[: len(WALKING)], LEAST, MOST)
            trial_terms = window.terms(trial[None])
            fall = least - height(trial, trial_terms[0])
            if fall > 0:
                point, terms, least = trial, trial_terms, least - fall
                break
        if fall < _SETTLED:
            break
    return Gaussian.expanded(point[None], *terms)[0]
