"""Starting points of a fit without advance information: any string, any pipe, any top drive; compiled.

The inverse of the mobility is nearly linear in three of the unknowns: 1/M − A H = e^(sT_d) (J_td s + IP y), with y the
input admittance per polar moment. With T_d = T₀ + ΔT and r = e^(−sT₀) (1/M − A H), r = J_td s + IP y + ΔT s r to first
order in ΔT. So for each trial of length and lower end the three follow in closed form.
"""

import math

import numpy as np
from numpy.typing import NDArray

from drillid.fit_model import Complex, Floats, compiled, falling, inverse, root

Singles = NDArray[np.float32]
"""Numbers of the search, which only ranks trials: the processor does twice as many at once."""

COST, LENGTH, INERTIA, POLAR, DELAY_CHANGE, SHAPE = range(6)
"""Columns of the trials."""
_DELAYS = 61
"""Trial delays between 0 and the largest."""


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
                trials[count, COST], trials[count, LENGTH] = found[i, 0], lengths[i]
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
    # what the delay's change explains is taken out of all others
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
