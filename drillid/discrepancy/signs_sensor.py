"""Signs of sensor and recorder: errors that turn with the shaft, tones, coarse steps."""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.fft import rfft

from drillid.discrepancy.signs_record import Remainder
from drillid.discrepancy.signs_score import Candidate, Score, normal_of_chance
from drillid.physics.top_drive import control

Floats = NDArray[np.float64]

_OWN_LINES, _FAR_LINES = 3, 22
"""Lines on either side of a tone, from the first that it leaves alone to the last that tells its noise."""
_DOUBTFUL = 2.0
"""Score from which it is asked whether a tone is motion."""
_ANSWERED = 0.5
"""Share of the control's answer that may be missing for a line to be motion."""
_LOWEST, _HIGHEST = 0.05, 0.48
"""Lowest frequency of a tone, Hz, and highest, as a share of the rate."""
_HANN_LINES = 1 + 2 * (2 / 3) ** 2 + 2 * (1 / 6) ** 2
"""Lines per independent line under a Hann window: the sum of correlations between the power of a line and of others."""
_LEAST_KEPT = 0.1
"""Share of a tone beyond which it is not made up for what has gone with the sweep."""
_REPEATED = 3
"""Times that a value must occur to count as a step and not as chance."""
_NEIGHBOURS = 8
_UNREPEATED = 5
"""Parts of a window that stand for periods where the sweep does not repeat."""
_LATTICE_TOLERANCE = 0.02
"""Of a step."""
_ON_LATTICE = 0.8
"""Share of samples that must lie on whole steps; interpolated rows do not."""
_MATERIAL = 1.0
"""Noise of rounding per noise of all else, in the middle of the band, from which steps change what is found."""


def revolution_candidate(remainder: Remainder) -> Candidate:
    """An error of the reading in proportion to the speed, once per revolution, that the control answers."""
    return Candidate("once_per_revolution", _turning(remainder, 0), together=True)


def _turning(remainder: Remainder, further: int) -> Floats:
    """Reading (2, samples) of an error that turns with the shaft and so many times more in a period of the sweep."""
    speed, rate = remainder.speed, remainder.record.rate
    period = remainder.record.period or remainder.samples / rate / _UNREPEATED
    angle = np.cumsum(speed) / rate + 2 * np.pi * further * remainder.time / period
    controller = remainder.system.top_drive.controller
    seen = 1 - remainder.mobility * control(controller, remainder.s)
    waves = np.stack([speed * np.cos(angle), speed * np.sin(angle)])
    return remainder.filtered(seen, waves - waves.mean(axis=1)[:, None])


def beside_neighbours(remainder: Remainder, found: Score) -> Score:
    """The score of an error once per revolution, judged beside errors that turn a little faster or slower.

    Revolutions often fall on a harmonic of the sweep, as with any whole number of them a minute and a sweep of two
    minutes; the neighbours lie on harmonics as well, and share whatever the sweep leaves there. The power of one of
    2ν neighbours follows F(2, 2ν).
    """
    steps = [sign * step for step in range(1, _NEIGHBOURS + 1) for sign in (-1, 1)]
    powers = [_power(remainder, _turning(remainder, step)) for step in (0, *steps)]
    ratio = powers[0] / max(float(np.mean(powers[1:])), np.finfo(float).tiny)
    normal = normal_of_chance(float(np.exp(-len(steps) * np.log1p(ratio / len(steps)))))
    return replace(found, normal=min(found.normal, normal), log_ratio=min(found.log_ratio, 0.5 * max(normal, 0.0) ** 2))


def _power(remainder: Remainder, pair: Floats) -> float:
    """What a pair of columns explains of the record."""
    columns = remainder.whitened(pair)
    products = columns @ remainder.error
    return float(products @ np.linalg.solve(columns @ columns.T, products))


@dataclass(frozen=True, eq=False)
class Line:
    """The line that stands out most from its neighbours."""

    place: int
    score: Score


def strongest_line(remainder: Remainder, left: Floats) -> Line | None:
    """The line that stands out most; None where the record has none to look at.

    A line's power over the mean of 2ν neighbours follows F(2, 2ν); a vibration of the string covers its neighbours
    too, so that it does not stand out.

    Parameters
    ----------
    left : (samples,) rad/s, what neither the sweep nor other causes account for
    """
    hann = np.hanning(remainder.samples + 1)[:-1]
    power = np.abs(rfft(left * hann)) ** 2 / remainder.modelled_noise
    within = int(np.flatnonzero(remainder.repeating).max()) + 1 if remainder.periods else 0
    for place in range(remainder.periods):
        # in the sweep's band lines at and beside its harmonics have lost some of their noise with the mean over periods
        power[place : within : remainder.periods] /= np.median(power[place : within : remainder.periods]) / np.log(2)
    power[within:] /= np.median(power[within:]) / np.log(2)
    window = np.ones(2 * _FAR_LINES + 1)
    window[_FAR_LINES - _OWN_LINES : _FAR_LINES + _OWN_LINES + 1] = 0
    noise = np.convolve(power, window / window.sum(), "same")
    freedom = window.sum() / _HANN_LINES
    frequency = remainder.frequency
    usable = (frequency > _LOWEST) & (frequency < _HIGHEST * remainder.record.rate)
    usable[-_FAR_LINES:] = False
    if not usable.any():
        return None
    ratio = np.where(usable, power / np.maximum(noise, np.finfo(float).tiny), 0.0)
    line = int(np.argmax(ratio))
    chance = np.exp(-freedom * np.log1p(ratio[line] / freedom))
    overall = -np.expm1(usable.sum() * np.log1p(-min(chance, 1 - 1e-12)))
    error = np.sqrt(np.sum(hann**2) / np.sum(remainder.taper**2) * remainder.noise[line] / 2) * 2 / hann.sum()
    log_ratio = float(freedom * np.log1p(ratio[line] / freedom))
    amplitude, kept = _tone_amplitude(remainder, left, line)
    return Line(line, Score(normal_of_chance(float(overall)), amplitude, float(error) / kept, log_ratio))


def tone_score(remainder: Remainder, line: Line | None) -> Score | None:
    """Score of a line as a tone in the record alone; None where the command answers it as motion of the rig."""
    if line is None or (line.score.normal > _DOUBTFUL and _control_answers(remainder, line.place)):
        return None
    return line.score


def _control_answers(remainder: Remainder, line: int) -> bool:
    """Whether the logged command answers a line as motion of the rig, which a tone in the record alone is not."""
    if not remainder.record.has_command:
        return False
    hann = np.hanning(remainder.samples + 1)[:-1]
    controller = remainder.system.top_drive.controller
    given = remainder.command - remainder.sweep
    answer, asked = (rfft((series - series.mean()) * hann)[line] for series in (given, remainder.speed))
    asked = asked * np.ravel(control(controller, remainder.s))[line]
    return bool(abs(answer + asked) < _ANSWERED * abs(asked))


def _tone_amplitude(remainder: Remainder, left: Floats, line: int) -> tuple[float, float]:
    """Amplitude of a tone within half a line of a line, rad/s, and the share of it that its neighbours have left.

    Beside a harmonic of the sweep, a part of a tone goes with what repeats.
    """
    hann, sample = np.hanning(remainder.samples + 1)[:-1], np.arange(remainder.samples)
    places = (line + np.linspace(-0.6, 0.6, 25)) / remainder.samples
    found = np.exp(-2j * np.pi * places[:, None] * sample) @ (left * hann)
    best = int(np.argmax(np.abs(found)))
    turned = 2 * np.pi * places[best] * sample + np.angle(found[best])
    kept = float(2 / hann.sum() * np.sum(np.cos(turned) * hann * remainder.without_sweep(np.cos(turned))))
    kept = max(kept, _LEAST_KEPT)
    return float(np.abs(found[best])) * 2 / hann.sum() / kept, kept


def quantisation_score(remainder: Remainder) -> Score | None:
    """Steps of the recorded speed, where their rounding is a good part of the noise; else None."""
    speed = remainder.speed
    step = lattice_step(speed)
    if step is None:
        return None
    # one-sided densities, (rad/s)²/Hz
    rounding = step**2 / 6 / remainder.record.rate
    density = 2 * remainder.noise / (remainder.record.rate * np.sum(remainder.taper**2))
    usual = float(np.median(density[remainder.inside]))
    if rounding < _MATERIAL / (1 + _MATERIAL) * usual:
        return None
    return Score(normal_of_chance(0.0), step, 1e-3 * step, normal_of_chance(0.0) ** 2 / 2)


def lattice_step(values: Floats) -> float | None:
    """Step of which nearly all values are whole multiples, from a common origin; None where there is none."""
    found, counts = np.unique(values, return_counts=True)
    often = found[counts >= _REPEATED]
    if often.size < 2 or counts[counts >= _REPEATED].sum() < _ON_LATTICE * values.size:
        return None
    apart = np.diff(often)
    apart = apart[apart > 1e-9 * np.abs(often).max()]
    if apart.size == 0:
        return None
    least = float(apart.min())
    step = float(np.sum(apart) / np.sum(np.rint(apart / least)))
    place = (values - often[0]) / step
    return step if np.mean(np.abs(place - np.rint(place)) < _LATTICE_TOLERANCE) >= _ON_LATTICE else None
