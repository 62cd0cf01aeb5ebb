"""Starting points of a fit without prior knowledge: any string, any pipe, any top drive; compiled.

The inverse of the mobility is nearly linear in three of the unknowns: 1/M − A H = e^(sT_d) (J_td s + IP y), with y the
input admittance per polar moment. With T_d = T₀ + ΔT and r = e^(−sT₀) (1/M − A H), r = J_td s + IP y + ΔT s r to first
order in ΔT. So for each trial of length and lower end the three follow in closed form.
"""

import math

import numpy as np
from numpy.typing import NDArray

from drillid.arrays import Complex, Floats
from drillid.fits.likelihood import compiled
from drillid.physics.eight_parameters import KnownEquipment
from drillid.physics.equipment import STEEL_DENSITY, STEEL_SHEAR_MODULUS
from drillid.physics.kernel import falling, inverse, root
from drillid.physics.parameters import BOUNDS, DELAY, DELTA, INERTIA_TD, LENGTH, POLAR_MOMENT, SCALES
from drillid.physics.responses import laplace
from drillid.physics.top_drive import control

Singles = NDArray[np.float32]
"""Single precision is enough, as the search only ranks trials; the processor handles twice as many numbers at once."""
COST, TRIAL_LENGTH, INERTIA, POLAR, DELAY_CHANGE, SHAPE = range(6)
"""Columns of the trials."""
_DELAYS = 61
"""Number of trial delays between 0 and the largest."""

_LENGTHS = np.arange(200.0, 1e4, 25.0)
_ENDS = np.array(
    [
        [kappa, delta, STEEL_DENSITY * length, share * np.sqrt(STEEL_DENSITY * STEEL_SHEAR_MODULUS)]
        for kappa, delta in ((100.0, 2e8), (250.0, 7e8))
        for length in (30.0, 200.0, 600.0)
        for share in (0.1, 0.8)
    ]
)
"""Lower ends of the trials, per polar moment: κ, δ, inertia of a length of pipe, and damping as a share of its
characteristic admittance."""
_APART = 60.0
"""m, least difference in length between two starting points."""
_MOST_TRIALS = 2000
WIDEST, PER_FREQUENCY = 0.05, 1 / 12
"""Bins in which neighbouring frequencies are averaged: their largest width, Hz, and width per frequency."""


@compiled
def bins(frequency: Floats, widest: float, relative: float) -> tuple[Floats, int]:
    """Number of the bin of each frequency; bins are as wide as a share of their frequency, up to the widest, Hz."""
    place = np.zeros(frequency.size)
    start, count = frequency[0], 0
    for k in range(frequency.size):
        if frequency[k] - start >= min(relative * start, widest) * (1 - 1e-9) and k > 0:
            start = frequency[k]
            count += 1
        place[k] = count
    return place, count + 1


@compiled
def thinned(
    frequency: Floats, mobility: Complex, variance: Floats, freedom: Floats, widest: float, relative: float
) -> tuple[Floats, Complex, Floats, Floats]:
    """Means of neighbouring frequencies with equal weights, in bins; variance and freedom are those of the means."""
    place, count = bins(frequency, widest, relative)
    mean_frequency, mean, spread = np.zeros(count), np.zeros(count, np.complex128), np.zeros(count)
    total, members = np.zeros(count), np.zeros(count)
    for k in range(frequency.size):
        i = int(place[k])
        members[i] += 1.0
        mean_frequency[i] += frequency[k]
        mean[i] += mobility[k]
        spread[i] += variance[k]
        total[i] += freedom[k]
    return mean_frequency / members, mean / members, spread / members**2, total


@compiled
def coarse_delay(s: Complex, inverted: Complex, weight: Floats, largest: float) -> float:
    """Delay that makes 1/M − A H most like e^(sT_d) (J s + Y), an inertia and a resistance behind a delay."""
    best, found = math.inf, 0.0
    ss = rr = 0.0
    for k in range(s.size):
        ss += weight[k] * s[k].imag ** 2
        rr += weight[k]
    for trial in range(_DELAYS):
        delay = largest * trial / (_DELAYS - 1)
        st = rt = tt = 0.0
        for k in range(s.size):
            rest = inverted[k] * falling(delay * s[k])
            st += weight[k] * s[k].imag * rest.imag
            rt += weight[k] * rest.real
            tt += weight[k] * (rest.real**2 + rest.imag**2)
        inertia, resistance = max(st / ss, 0.0), max(rt / rr, 0.0)
        cost = tt - 2.0 * (inertia * st + resistance * rt) + inertia**2 * ss + resistance**2 * rr
        if cost < best:
            best, found = cost, delay
    return found


@compiled
def _prepare(
    s: Complex, shunt: Complex, series: Complex, end: Floats, step: float, work: Singles, first: float
) -> None:
    """Characteristic admittance, load sum and difference and both exponentials of all frequencies, per polar moment.

    Rows of `work` (8, frequency) are real and imaginary parts of Y₀, of Y_L + Y₀, of Y_L − Y₀ times the decay to the
    first length, and of the decay of one step; `end` is κ, δ, inertia and damping of the lower end.
    """
    for k in range(s.size):
        elastic = series[k] + end[1]
        gamma = root((shunt[k] + end[0]) * inverse(elastic))
        own = elastic * gamma
        load = end[2] * s[k] + end[3]
        start, single = falling(2.0 * first * gamma), falling(2.0 * step * gamma)
        turned = (load - own) * start
        work[0, k], work[1, k] = own.real, own.imag
        work[2, k], work[3, k] = (load + own).real, (load + own).imag
        work[4, k], work[5, k] = turned.real, turned.imag
        work[6, k], work[7, k] = single.real, single.imag


@compiled
def _products(given: Singles, work: Singles, sums: Floats) -> None:
    """Sums over frequency of |y|², and of y times s, target and delay's slope; then moves on to the next length.

    Rows of `given` (6, frequency) are the weight, s, and real and imaginary parts of target and slope.
    """
    one = np.float32(1.0)
    yy = ys = yt = yd = np.float32(0.0)
    for k in range(given.shape[1]):
        ar, ai, br, bi = work[2, k], work[3, k], work[4, k], work[5, k]
        nr, ni, dr, di = ar + br, ai + bi, ar - br, ai - bi
        scale = one / (dr * dr + di * di)
        qr, qi = (nr * dr + ni * di) * scale, (ni * dr - nr * di) * scale
        yr, yi = work[0, k] * qr - work[1, k] * qi, work[0, k] * qi + work[1, k] * qr
        w = given[0, k]
        yy += w * (yr * yr + yi * yi)
        ys += w * yi * given[1, k]
        yt += w * (yr * given[2, k] + yi * given[3, k])
        yd += w * (yr * given[4, k] + yi * given[5, k])
        work[4, k], work[5, k] = br * work[6, k] - bi * work[7, k], br * work[7, k] + bi * work[6, k]
    sums[0], sums[1], sums[2], sums[3] = yy, ys, yt, yd


@compiled
def search(
    s: Complex,
    shunt: Complex,
    series: Complex,
    target: Complex,
    weight: Floats,
    ends: Floats,
    lengths: Floats,
    bounds: Floats,
    trials: Floats,
) -> int:
    """Trials (trial, 6) that are better than those a little longer and shorter; returns their number.

    Parameters
    ----------
    target : r, (frequency,)
    weight : one over the variance of 1/M, (frequency,)
    ends : κ, δ, inertia and damping of the lower end per polar moment, (shape, 4)
    lengths : evenly spaced, m
    bounds : least and largest inertia of the top drive, then polar moment, (4,)
    """
    slope = s * target
    ss = sd = dd = st = dt = tt = 0.0
    for k in range(s.size):
        ss += weight[k] * s[k].imag ** 2
        sd += weight[k] * s[k].imag * slope[k].imag
        dd += weight[k] * (slope[k].real ** 2 + slope[k].imag ** 2)
        st += weight[k] * s[k].imag * target[k].imag
        dt += weight[k] * (slope[k].real * target[k].real + slope[k].imag * target[k].imag)
        tt += weight[k] * (target[k].real ** 2 + target[k].imag ** 2)
    given, work = np.empty((6, s.size), np.float32), np.empty((8, s.size), np.float32)
    given[0], given[1] = weight, s.imag
    given[2], given[3], given[4], given[5] = target.real, target.imag, slope.real, slope.imag
    sums, found = np.empty(4), np.empty((lengths.size, 4))
    count = 0
    for shape in range(ends.shape[0]):
        _prepare(s, shunt, series, ends[shape], lengths[1] - lengths[0], work, lengths[0])
        for i in range(lengths.size):
            _products(given, work, sums)
            _solve_three(ss, sd, dd, st, dt, tt, sums, bounds, found[i])
        for i in range(lengths.size):
            before = found[i - 1, 0] if i > 0 else math.inf
            after = found[i + 1, 0] if i + 1 < lengths.size else math.inf
            if found[i, 0] <= before and found[i, 0] <= after and count < trials.shape[0]:
                trials[count, COST], trials[count, TRIAL_LENGTH] = found[i, 0], lengths[i]
                trials[count, INERTIA], trials[count, POLAR] = found[i, 1], found[i, 2]
                trials[count, DELAY_CHANGE], trials[count, SHAPE] = found[i, 3], shape
                count += 1
    return count


@compiled
def _solve_three(
    ss: float, sd: float, dd: float, st: float, dt: float, tt: float, sums: Floats, bounds: Floats, found: Floats
) -> None:
    """Least squares for J_td, IP and ΔT: cost and the three, (4,); J_td and IP are brought within their bounds."""
    yy, ys, yt, yd = sums[0], sums[1], sums[2], sums[3]
    # the part explained by the change of delay is removed from all others
    aa, ab, bb = ss - sd * sd / dd, ys - sd * yd / dd, yy - yd * yd / dd
    at, bt = st - sd * dt / dd, yt - yd * dt / dd
    determinant = aa * bb - ab * ab
    if not determinant > 1e-14 * aa * bb:
        found[0] = math.inf
        return
    inertia = min(max((bb * at - ab * bt) / determinant, bounds[0]), bounds[1])
    polar = min(max((bt - ab * inertia) / bb, bounds[2]), bounds[3])
    inertia = min(max((at - ab * polar) / aa, bounds[0]), bounds[1])
    change = (dt - sd * inertia - yd * polar) / dd
    cost = tt + inertia**2 * ss + polar**2 * yy + change**2 * dd
    cost += 2.0 * (inertia * polar * ys + inertia * change * sd + polar * change * yd)
    cost -= 2.0 * (inertia * st + polar * yt + change * dt)
    found[0], found[1], found[2], found[3] = cost, inertia, polar, change


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
    lead to the same optimum. A length on the rig's data sheets is a start of its own, at the end.
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
