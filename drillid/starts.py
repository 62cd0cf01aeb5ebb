"""Starting points of a fit, without advance information: any string, any pipe, any top drive.

The inverse of the mobility is linear in top-drive inertia and string impedance,
1/M − A H = e^(sT_d) (J_td s + Y_in), so that for each trial of the non-linear parameters the
two linear ones follow in closed form.
"""

import itertools

import numpy as np
from numpy.typing import NDArray

from drillid.physics.equipment import STEEL_DENSITY, STEEL_SHEAR_MODULUS
from drillid.physics.model import DELAY, INERTIA_TD, LENGTH, POLAR_MOMENT, KnownEquipment
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

_LENGTH_STEP = 1.015
_BHA_LENGTHS = (30.0, 200.0, 600.0)
"""BHA inertia of the trials, as that of so many metres of the pipe."""
_DAMPINGS = ((100.0, 3e8, 0.1), (100.0, 3e8, 1.0))
"""κ, δ and the BHA damping as a share of the pipe's characteristic admittance, of the trials."""
_DELAYS = np.linspace(0.0, 0.12, 25)
_MOST_FREQUENCIES = 160


def starting_points(
    frequency: Floats, mobility: Complex, variance: Floats, known: KnownEquipment, prior: Floats, count: int
) -> list[Floats]:
    """The best `count` trials whose lengths differ, best first, each of shape (8,).

    Only trials that are better than those a little longer and shorter count, as their neighbours
    lead to the same optimum.
    """
    thin = slice(None, None, max(1, -(-frequency.size // _MOST_FREQUENCIES)))
    s, measured = laplace(frequency[thin]), mobility[thin]
    weight = np.abs(measured) ** 2 / np.sqrt(variance[thin])
    inverse = 1 / measured - control(known.controller, s)
    delay = float(prior[DELAY]) if np.isfinite(prior[DELAY]) else _delay(s, inverse, weight)
    target = inverse * np.exp(-s * delay)
    trials = [
        trial for shape in itertools.product(_BHA_LENGTHS, _DAMPINGS) for trial in _trials(s, target, weight, *shape)
    ]
    trials.sort(key=lambda trial: trial[0])
    chosen: list[Floats] = []
    for _, point in trials:
        if all(abs(np.log(point[LENGTH] / other[LENGTH])) > 2 * np.log(_LENGTH_STEP) for other in chosen):
            point[DELAY] = delay
            chosen.append(point)
        if len(chosen) == count:
            break
    return chosen


def _delay(s: Complex, inverse: Complex, weight: Floats) -> float:
    """Delay that makes 1/M − A H most like an inertia and a resistance, e^(sT_d) (J s + Y)."""
    costs = []
    for delay in _DELAYS:
        rest = inverse * np.exp(-s * delay)
        inertia = np.sum(weight**2 * rest.imag * s.imag) / np.sum((weight * s.imag) ** 2)
        resistance = np.sum(weight**2 * rest.real) / np.sum(weight**2)
        costs.append(np.sum(weight**2 * np.abs(rest - inertia * s - resistance) ** 2))
    return float(_DELAYS[int(np.argmin(costs))])


def _trials(
    s: Complex, target: Complex, weight: Floats, bha_length: float, damping: tuple[float, float, float]
) -> list[tuple[float, Floats]]:
    """Cost and point of the trial lengths of least cost in their neighbourhood, for one shape of the lower end."""
    kappa, delta, bha_share = damping
    lengths = np.geomspace(BOUNDS[0, LENGTH], BOUNDS[1, LENGTH], _length_count())[:, None]
    alpha, beta = STEEL_DENSITY * s + kappa, STEEL_SHEAR_MODULUS / s + delta
    specific = np.sqrt(alpha * beta)
    bha_inertia = STEEL_DENSITY * bha_length
    bha_damping = bha_share * np.sqrt(STEEL_DENSITY * STEEL_SHEAR_MODULUS)
    load = bha_inertia * s + bha_damping
    tangent = np.tanh(np.sqrt(alpha / beta) * lengths)
    per_polar = specific * (load + specific * tangent) / (specific + load * tangent)

    w2 = weight**2
    ss, pp = np.sum(w2 * np.abs(s) ** 2), np.sum(w2 * np.abs(per_polar) ** 2, axis=1)
    sp = np.sum(w2 * (np.conj(s) * per_polar).real, axis=1)
    st, pt = np.sum(w2 * (np.conj(s) * target).real), np.sum(w2 * (np.conj(per_polar) * target).real, axis=1)
    determinant = ss * pp - sp**2
    inertia, polar = (pp * st - sp * pt) / determinant, (ss * pt - sp * st) / determinant
    inertia = np.clip(inertia, *BOUNDS[:, INERTIA_TD])
    polar = np.clip(polar, *BOUNDS[:, POLAR_MOMENT])
    misfit = target - inertia[:, None] * s - polar[:, None] * per_polar
    costs = np.sum(w2 * np.abs(misfit) ** 2, axis=1)
    around = np.concatenate([[np.inf], costs, [np.inf]])
    least = (costs <= around[:-2]) & (costs <= around[2:])
    return [
        (
            float(cost),
            np.array([kappa, delta, length, moment, 0.0, inertia_td, moment * bha_damping, moment * bha_inertia]),
        )
        for cost, length, moment, inertia_td in zip(
            costs[least], lengths[least, 0], polar[least], inertia[least], strict=True
        )
    ]


def _length_count() -> int:
    return int(np.ceil(np.log(BOUNDS[1, LENGTH] / BOUNDS[0, LENGTH]) / np.log(_LENGTH_STEP))) + 1
