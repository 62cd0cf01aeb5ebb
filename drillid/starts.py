"""What the fit searches, and its starting points: without advance information, for any string, pipe and top drive."""

import numpy as np
from numpy.typing import NDArray

from drillid.fit_search import COST, DELAY_CHANGE, INERTIA, POLAR, SHAPE, coarse_delay, search, thinned
from drillid.fit_search import LENGTH as TRIAL_LENGTH
from drillid.physics.equipment import STEEL_DENSITY, STEEL_SHEAR_MODULUS
from drillid.physics.model import DELAY, DELTA, INERTIA_TD, LENGTH, POLAR_MOMENT, KnownEquipment
from drillid.physics.responses import laplace
from drillid.physics.top_drive import control

Floats = NDArray[np.float64]
Complex = NDArray[np.complex128]

BOUNDS = np.array(
    [
        [0.0, 1e5, 200.0, 5e-7, 0.0, 50.0, 0.0, 0.1],
        [2e4, 1e11, 1e4, 2e-4, 0.3, 2e4, 2e4, 3e3],
    ]
)
"""Least and largest value of each parameter, SI: wider than any rig."""
SCALES = np.array([100.0, 3e8, 1000.0, 1e-5, 0.01, 1000.0, 50.0, 50.0])
"""Usual size of each parameter, SI."""
USUAL = np.array(
    [
        [0.0, 3e7, 300.0, 6e-7, 0.0, 200.0, 0.0, 20.0],
        [1e3, 3e9, 9000.0, 5e-5, 0.15, 6000.0, 1e3, 1e3],
    ]
)
"""Values that are met: whoever knows no more than these knows nothing."""

_LENGTHS = np.arange(200.0, 1e4, 25.0)
_ENDS = np.array(
    [
        [kappa, delta, STEEL_DENSITY * length, share * np.sqrt(STEEL_DENSITY * STEEL_SHEAR_MODULUS)]
        for kappa, delta in ((100.0, 2e8), (250.0, 7e8))
        for length in (30.0, 200.0, 600.0)
        for share in (0.1, 0.8)
    ]
)
"""Lower ends of the trials, per polar moment: κ, δ, inertia of so many metres of pipe, and damping as a share of its
characteristic admittance."""
_APART = 60.0
"""m, between lengths of two starting points."""
_MOST_TRIALS = 2000
WIDEST, PER_FREQUENCY = 0.05, 1 / 12
"""Bins in which neighbouring frequencies are averaged: their largest width, Hz, and width per frequency."""


def to_scaled(values: Floats) -> Floats:
    """Parameters (..., 8) in SI as the solver sees them: of order one, internal damping as its logarithm."""
    scaled: Floats = values / SCALES
    scaled[..., DELTA] = np.log(scaled[..., DELTA])
    return scaled


def from_scaled(scaled: Floats) -> Floats:
    """Parameters (..., 8) in SI of scaled ones."""
    values: Floats = scaled * SCALES
    values[..., DELTA] = SCALES[DELTA] * np.exp(scaled[..., DELTA])
    return values


def thin(
    frequency: Floats, mobility: Complex, variance: Floats, freedom: Floats
) -> tuple[Floats, Complex, Floats, Floats]:
    """Frequency, mobility, variance and its degrees of freedom, averaged in bins."""
    found: tuple[Floats, Complex, Floats, Floats] = thinned(
        frequency, mobility, variance, freedom, WIDEST, PER_FREQUENCY
    )
    return found


def starting_points(
    frequency: Floats, mobility: Complex, variance: Floats, known: KnownEquipment, prior: Floats, count: int
) -> Floats:
    """The best `count` trials whose lengths differ, best first, shape (start, 8) in SI.

    Only trials that are better than those a little longer and shorter count, as their neighbours
    lead to the same optimum. A length on the rig's papers is a start of its own, at the end.
    """
    s = laplace(frequency)
    inverse = 1 / mobility - control(known.controller, s)
    weight = np.abs(mobility) ** 4 / variance
    delay = float(prior[DELAY]) if np.isfinite(prior[DELAY]) else coarse_delay(s, inverse, weight, BOUNDS[1, DELAY])
    trials = np.empty((_MOST_TRIALS, 6))
    limits = np.concatenate([BOUNDS[:, INERTIA_TD], BOUNDS[:, POLAR_MOMENT]])
    target = inverse * np.exp(-s * delay)
    shunt, series = STEEL_DENSITY * s, STEEL_SHEAR_MODULUS / s
    trials = trials[: search(s, shunt, series, target, weight, _ENDS, _LENGTHS, limits, trials)]
    trials = trials[np.argsort(trials[:, COST])]
    chosen: list[int] = []
    for row, length in enumerate(trials[:, TRIAL_LENGTH].tolist()):
        if len(chosen) == count:
            break
        if all(abs(length - trials[other, TRIAL_LENGTH]) > _APART for other in chosen):
            chosen.append(row)
    best = trials[chosen]
    if np.isfinite(prior[LENGTH]):
        best = np.concatenate([best, best[:1]])
        best[-1, TRIAL_LENGTH] = prior[LENGTH]
    end, polar = _ENDS[best[:, SHAPE].astype(int)], best[:, POLAR]
    columns = [end[:, 0], end[:, 1], best[:, TRIAL_LENGTH], polar, delay + best[:, DELAY_CHANGE], best[:, INERTIA]]
    points = np.stack([*columns, polar * end[:, 3], polar * end[:, 2]], axis=1)
    return np.asarray(np.clip(points, *BOUNDS), dtype=float)
