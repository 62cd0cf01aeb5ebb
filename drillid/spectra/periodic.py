"""Spectra of a window with a periodic sweep: the response from the excited lines, the noise from those between."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.fft import irfft, next_fast_len, rfft
from scipy.signal import czt

from drillid.arrays import Booleans, Complex, Floats, Integers
from drillid.records.quality import quantisation_step
from drillid.spectra.cross_spectra import Spectra
from drillid.spectra.noise import Weights, autoregressive_level, bands, burst_weights, high_pass, level_variance

_ORDER = 1
"""Order of the local polynomial of the transient: order two removes no more and adds 3 % to the variance."""
_BEYOND = 1.25
"""Highest line from which the noise is modelled, per highest line used."""
_LEAST_FREEDOM = 6
"""Least degrees of freedom of a variance, even where drift adds to it."""
_LOWER_SHARE = 0.8
"""Farthest line from which the noise of a line is estimated, per its own number: below, drift remains."""
_ROUNDS = 3
"""Iterations of the burst weights, each with the noise of the previous one."""
_LOCATED, _LEAST_AVERAGES = 3, 1.5
"""Periods from which on a burst can be located, as two deviate alike from their mean; and periods of usual noise that a
weighted mean must be worth."""

_UNANSWERED = 1e-3
"""Rate at which lines that do not answer to the sweep are taken to."""
_ROUNDING = 1e-9
"""Share of a period that is rounding."""


def whole_periods(samples: int, rate: float, period: float) -> int:
    """Number of whole periods (s) in so many samples; rounding of the division takes none away."""
    return int(samples / rate / period + _ROUNDING)


@dataclass(frozen=True)
class _Lines:
    """The lines of a record of whole periods."""

    periods: int
    seconds: float
    harmonics: Integers
    """(frequency,) excited lines."""
    offsets: Integers
    """(line,) of the unexcited lines, relative to their harmonic."""
    last: int
    """Highest line that is used, a whole number of harmonics."""
    rounding: float
    """Mean squared amplitude of the sweep's quantisation error in each of its lines."""

    def near(self, harmonic: int) -> Integers:
        """Offsets of the lines from which the noise of a harmonic and of all above it is estimated."""
        near = self.offsets[np.abs(self.offsets) <= _LOWER_SHARE * harmonic]
        return near if near.size > _ORDER + _LEAST_FREEDOM else self.offsets

    @property
    def unexcited(self) -> Booleans:
        """(last + 1,) lines without sweep."""
        return np.asarray(np.arange(self.last + 1) % self.periods != 0)


def line_spectra(
    sweep: Floats, speed: Floats, command: Floats, rate: float, period: float, frequencies: Floats, noise_lines: int
) -> Spectra:
    """Spectra at the harmonics of a periodic sweep, from the whole periods in the window.

    In n periods every n-th line contains the sweep's response, and the n − 1 lines between it and the next the spread
    between periods. Three disturbances are removed: drift as a parabola of time, by weighted least squares over all
    unexcited lines; the transient and other leakage, which are linear over the nearest `noise_lines` unexcited lines,
    weighted by the smooth spectrum of the noise (a local polynomial estimate: Pintelon and Schoukens 2012, chapter 7);
    bursts of noise, by weighting each period at each time (`noise`). What does not repeat in the sweep is removed as
    leakage is, since the command holds it too, and the response to it is no noise. The power that remains in these
    lines, divided by the smooth spectrum of the noise, gives the variance; its degrees of freedom are theirs less two,
    fewer where bursts are weighted down, and fewer for the error of the smooth spectrum, which few periods determine
    less well.

    Parameters
    ----------
    sweep, speed, command : (samples,) N m, rad/s, N m; the command may be NaN
    rate, period : Hz, s
    frequencies : (frequency,) Hz, harmonics of the period
    noise_lines : unexcited lines around each excited line
    """
    lines, (of_sweep, of_speed, of_command) = _spectra((sweep, speed, command), rate, period, frequencies, noise_lines)
    power = np.where(lines.unexcited, np.abs(of_speed) ** 2, 0.0)
    fall = high_pass(power, lines.unexcited, int(lines.harmonics[0]))
    level = fall * autoregressive_level(power / fall)
    outputs = [_without_drift(lines, channel, level) for channel in (of_speed, of_command)]
    parts = []
    for band in bands(int(lines.harmonics[0]), int(lines.harmonics[-1])):
        inside = lines.harmonics[(lines.harmonics >= band[0]) & (lines.harmonics < band[1])]
        weights, level = _weights(lines, outputs[0], band, fall)
        weighted = outputs if weights is None else [_weighted(lines, weights, output, level) for output in outputs]
        low = np.searchsorted(inside, -lines.offsets[0] / _LOWER_SHARE)
        for part in (inside[:1], inside[1:low], inside[max(low, 1) :]):
            if part.size:
                parts.append(_at_harmonics(lines, of_sweep, weighted, level, weights, part))
    return Spectra.joined(parts)


def _spectra(
    channels: tuple[Floats, ...], rate: float, period: float, frequencies: Floats, noise_lines: int
) -> tuple[_Lines, list[Complex]]:
    periods = whole_periods(channels[0].size, rate, period)
    length = periods * period * rate
    samples = round(length)
    harmonics = np.rint(frequencies * period).astype(int) * periods
    offsets = _noise_offsets(periods, noise_lines)
    needed = max(int(_BEYOND * harmonics[-1]), harmonics[-1] + offsets[-1])
    last = min(next_fast_len(-(-needed // periods), real=True), (samples - 1) // (2 * periods)) * periods
    # at a low rate some lines near the highest harmonics would lie beyond half of the rate
    offsets = offsets[harmonics[-1] + offsets <= last]
    spectra = [_transform(channel[:samples], length, last + 1) * (2 / samples) for channel in channels]
    step = quantisation_step(channels[0][:samples]) or 0.0
    # the same in each period, so that it neither falls with their number nor appears between harmonics
    rounding = 4 * periods / samples * step**2 / 12
    return _Lines(periods, samples / rate, harmonics, offsets, last, rounding), spectra


def _transform(series: Floats, length: float, lines: int) -> Complex:
    """The first lines of a record (samples,) whose length in samples need not be whole.

    What its last sample has too much or too little is a transient, which a polynomial over the lines removes.
    """
    series = series - series.mean()
    if abs(length - series.size) < _ROUNDING * length:
        return np.asarray(rfft(series)[:lines])
    return np.asarray(czt(series, lines, np.exp(-2j * np.pi / length)))


def _noise_offsets(periods: int, noise_lines: int) -> Integers:
    reach = np.arange(1, noise_lines * 2 + 1)
    unexcited = reach[reach % periods != 0][: (noise_lines + 1) // 2]
    return np.concatenate([-unexcited[::-1], unexcited])


def _without_drift(lines: _Lines, channel: Complex, level: Floats) -> Complex:
    """Lines less those of the parabola of time fitted to the unexcited lines."""
    number = np.arange(1, lines.last + 1)
    # lines of a ramp and a parabola over the window, whose ends do not meet
    shapes = np.stack([1j / number, 1 / number**2 + 0j])
    used = lines.unexcited[1:]
    weighted = shapes[:, used] / level[1:][used]
    normal = (weighted @ np.conj(shapes[:, used]).T).real
    size = np.linalg.solve(normal, (weighted @ np.conj(channel[1:][used])).real)
    return np.concatenate([channel[:1], channel[1:] - size @ shapes])


def _weights(lines: _Lines, speed: Complex, band: tuple[int, int], fall: Floats) -> tuple[Weights | None, Floats]:
    """Weights against bursts in a band, None where there are none or they do not help, and the noise's spectrum."""
    deviation = np.where(lines.unexcited, speed, 0.0)
    level = fall * autoregressive_level(np.abs(deviation) ** 2 / fall)
    weights = None
    for _ in range(_ROUNDS if lines.periods >= _LOCATED else 0):
        candidate = burst_weights(deviation, level, band, lines.periods, lines.seconds)
        if np.all(candidate.weight == 1) or candidate.averages < _LEAST_AVERAGES:
            break
        weights = candidate
        bounded = _weighted(lines, weights, speed, level)
        deviation = np.where(lines.unexcited, speed, speed - bounded)
        level = fall * autoregressive_level(np.where(lines.unexcited, np.abs(bounded) ** 2, 0.0) / fall)
    return weights, level


def _weighted(lines: _Lines, weights: Weights, channel: Complex, level: Floats) -> Complex:
    """Lines of the weighted periods; whitened for the weighting, as strong lines would leak into weak ones."""
    deviation = np.sqrt(level)
    series = irfft(channel / deviation, 2 * lines.last).reshape(lines.periods, -1)
    return np.asarray(rfft(weights.applied(series).ravel()) * deviation)


def _without_answer(of_sweep: Complex, noise: Complex, sweep_line: Complex, line: Complex) -> Complex:
    """Lines between harmonics (harmonic, offset) less the response to the sweep's part there, where they show it: a
    sweep whose amplitude changes is answered there as at its harmonics, but what its recorder adds to it is not.
    """
    power, own = (np.sum(np.abs(lines) ** 2, axis=1) for lines in (of_sweep, noise))
    shared = np.abs(np.sum(noise * np.conj(of_sweep), axis=1)) ** 2
    # squared coherence of unrelated lines is beyond by chance at the rate
    chance = 1 - _UNANSWERED ** (1 / (noise.shape[1] - 1))
    answered = (shared > chance * power * own) & (np.abs(sweep_line) ** 2 * noise.shape[1] > power)
    response = np.divide(line, sweep_line, out=np.zeros_like(line), where=answered)
    return np.asarray(noise - response[:, None] * of_sweep)


def _at_harmonics(
    lines: _Lines,
    sweep: Complex,
    outputs: list[Complex],
    level: Floats,
    weights: Weights | None,
    harmonics: Integers,
) -> Spectra:
    periods, offsets = lines.periods, lines.near(int(harmonics[0]))
    averages = float(periods) if weights is None else weights.averages
    around = harmonics[:, None] + offsets
    powers = (offsets / offsets[-1])[:, None] ** np.arange(_ORDER + 1)
    weight = level[harmonics][:, None] / level[np.abs(around)]
    # (harmonic, power, offset): with few periods the lines lie so far apart that a mode is among them
    weighted = weight[:, None] * powers.T
    projector = np.linalg.solve(weighted @ powers, weighted)
    leverage = 1 + np.sum(projector[:, 0] ** 2 / weight, axis=1)
    at_line, residuals = [], []
    # of the sweep as well: what does not repeat in it, such as a spike in its last row, is in the command too
    for channel in (sweep, *outputs):
        noise = channel[np.abs(around)]
        np.conj(noise, out=noise, where=around < 0)
        coefficients = np.einsum("hpo,ho->hp", projector, noise)
        at_line.append(channel[harmonics] - coefficients[:, 0])
        residuals.append((noise - coefficients @ powers.T) * np.sqrt(weight))
    sweep_line, speed_line, command_line = at_line
    of_speed, of_command = (
        _without_answer(residuals[0], noise, sweep_line, line)
        for line, noise in zip(at_line[1:], residuals[1:], strict=True)
    )
    freedom = float(offsets.size - _ORDER - 1)
    scale = leverage * periods / freedom * (1.0 if weights is None else (periods - 1) / weights.residual)
    speed_noise, command_noise = (np.sum(np.abs(noise) ** 2, axis=1) * scale for noise in (of_speed, of_command))
    count = np.full(harmonics.size, averages)
    spread = 1 / (freedom * (1.0 if weights is None else weights.efficiency))
    spread += level_variance(lines.last, int(np.count_nonzero(lines.unexcited)), int(offsets[-1]))
    return Spectra(
        sweep_power=np.abs(sweep_line) ** 2,
        speed_power=np.abs(speed_line) ** 2 + speed_noise * (averages - 1) / averages,
        speed_noise=speed_noise,
        command_noise=command_noise,
        cross_speed=speed_line * np.conj(sweep_line),
        cross_command=command_line * np.conj(sweep_line),
        cross_noise=np.sum(of_speed * np.conj(of_command), axis=1) * scale,
        averages=count,
        degrees_of_freedom=np.full(harmonics.size, 1 / spread),
        sweep_rounding=np.full(harmonics.size, lines.rounding),
    )
