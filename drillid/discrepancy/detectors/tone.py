"""Detections of tones in the record: lines that stand out, between the harmonics of the sweep or upon them.

Between harmonics a line stands in what does not repeat with the sweep. Upon and beside a harmonic a tone looks like
the answer to the sweep, and is told from it as that is smooth: by what the neighbouring harmonics say of it.
"""

from dataclasses import dataclass

import numpy as np
from scipy.fft import rfft, rfftfreq

from drillid.arrays import Complex, Floats, Indices
from drillid.discrepancy.detectors.detection import Lines
from drillid.discrepancy.detectors.detector import Detector, Inspection, is_clear
from drillid.discrepancy.detectors.residual_record import ResidualRecord
from drillid.discrepancy.detectors.score import Score, normal_of_p_value
from drillid.discrepancy.rules import LINE_KEPT, RESPONSE_MISSING, TONE_WITH_SIZE
from drillid.physics.top_drive import control

_OWN_LINES, _FAR_LINES = 3, 22
"""Lines on either side of a tone, from the first that it leaves alone to the last that tells its noise."""
_UPON = 1
"""Half lines on either side of a harmonic in which much of a tone goes with what repeats; 92 % is left farther off."""
_FREEDOM = 2.0 * (_FAR_LINES - _OWN_LINES)
"""Independent ones among them."""
_NEIGHBOURS = np.repeat(
    [1.0, 0.0, 1.0], [2 * (_FAR_LINES - _OWN_LINES), 4 * _OWN_LINES + 1, 2 * (_FAR_LINES - _OWN_LINES)]
)
_ORDER, _NEAR_HARMONICS, _FAR_HARMONICS = 2, 4, 15
"""Of the polynomial through neighbouring harmonics; how many on either side it is fitted to, and tell its noise."""
_WIDEST = 1.0
"""Noise that the neighbours add, per a harmonic's own, up to which they are asked."""
_LOWEST, _HIGHEST = 0.05, 0.48
"""Lowest frequency of a tone, Hz, and highest, as a share of the rate."""
_LEAST_KEPT = 0.1
"""Share of a tone beyond which it is not made up for what has gone with the sweep."""


@dataclass(frozen=True, eq=False)
class Line:
    """The line that stands out most from its neighbours."""

    place: int
    """In half lines, as all lines here."""
    height: complex
    score: Score


@dataclass(frozen=True, eq=False)
class _Left:
    """What neither the sweep nor other causes account for."""

    series: Floats
    """(samples,) rad/s."""
    noise: Floats
    """(half line,) that the way of leaving the sweep's answer out has added, as a factor; infinite where none."""
    loses: bool
    """Whether it takes a part of a tone with it."""


def strongest_line(residual: ResidualRecord, explained: Floats | None = None) -> Line | None:
    """The line that stands out most; None where the record has none to look at.

    A line's power over the mean of ν neighbours follows F(2, 2ν); a vibration of the string covers its neighbours
    too, so that it does not stand out. Lines lie half a line apart, so that no tone falls between them.

    Parameters
    ----------
    explained : (samples,) rad/s, what other causes account for; nothing where not given
    """
    frequency = rfftfreq(2 * residual.samples, 1 / residual.record.rate)
    usable = (frequency > _LOWEST) & (frequency < _HIGHEST * residual.record.rate)
    usable[-2 * _FAR_LINES :] = False
    if not usable.any():
        return None
    explained = np.zeros(residual.samples) if explained is None else explained
    between = _Left(residual.left - residual.without_sweep(explained), np.ones(frequency.size), loses=True)
    ways = [between, *([_beside_harmonics(residual, explained)] if residual.periods else [])]
    spectra = [_lines(residual, left.series) for left in ways]
    powers = np.stack([_power(residual, left, spectrum) for left, spectrum in zip(ways, spectra, strict=True)])
    noise = np.tile(np.convolve(powers[0], _NEIGHBOURS / _NEIGHBOURS.sum(), "same"), (len(ways), 1))
    if residual.periods:
        noise[1] = np.maximum(noise[1], _of_harmonics(powers[1], residual.periods))
    tried = np.stack([usable & np.isfinite(left.noise) for left in ways])
    ratio = np.where(tried, powers / np.maximum(noise, np.finfo(float).tiny), 0.0)
    way, place = (int(one) for one in np.unravel_index(np.argmax(ratio), ratio.shape))
    log_ratio = _FREEDOM * float(np.log1p(ratio[way, place] / _FREEDOM))
    overall = -np.expm1(tried.sum() * np.log1p(-min(np.exp(-log_ratio), 1 - 1e-12)))
    amplitude, kept = _amplitude(residual, ways[way], place)
    height, normal = complex(spectra[way][place]), normal_of_p_value(float(overall))
    # what chance has made stand out is another line in every window, and tells no size
    size_error = float(_amplitude_error(residual, place)) / kept if normal > TONE_WITH_SIZE else np.inf
    lines = _faint_lines(residual, spectra[0], ratio[0], place)
    return Line(place, height, Score(normal, amplitude, size_error, log_ratio, lines=lines))


def _faint_lines(residual: ResidualRecord, spectrum: Complex, ratio: Floats, strongest: int) -> Lines:
    """Lines that stand out at all and do not repeat with the sweep, at any frequency.

    What repeats with it stands alike in all windows: errors of a wrong model in the sweep's band, distortion and the
    record's rounding beyond it.

    Parameters
    ----------
    spectrum : (half line,) of what is left between harmonics, rad/s
    ratio : (half line,) power per noise; 0 where none is looked for
    strongest : half line of the window's own detection
    """
    repeats = np.zeros(ratio.size, dtype=bool)
    repeats[::2] = ~residual.between
    upon = np.convolve(repeats, np.ones(2 * _UPON + 1), "same") > 0
    ratio = np.where(upon, 0.0, ratio)
    log_ratio = _FREEDOM * np.log1p(ratio / _FREEDOM)
    place = np.flatnonzero(log_ratio > LINE_KEPT)
    error = _amplitude_error(residual, place)
    height = 2 * np.abs(spectrum[place]) / residual.taper.sum()
    # both quadratures of the noise add to the power
    size = np.sqrt(np.maximum(height**2 - 2 * error**2, 0.0))
    spacing = residual.record.rate / (2 * residual.samples)
    kept = (values.astype(np.float32) for values in (log_ratio[place], size, error))
    return Lines(spacing, int(np.count_nonzero(ratio)), strongest, place.astype(np.int32), *kept)


class LineDetector(Detector):
    """The line that stands out most of the record's noise, whatever its cause."""

    def score(self, name: str, inspection: Inspection) -> Score | None:
        """Score of the strongest line; None where the record has none to look at."""
        line = inspection.once(strongest_line)
        return None if line is None else line.score


class ToneDetector(Detector):
    """A tone in the record alone, to which the control does not respond."""

    def score(self, name: str, inspection: Inspection) -> Score | None:
        """Score of the strongest line beside what is explained; None where the command shows it as motion."""
        explained = inspection.explained
        line = strongest_line(inspection.residual, explained) if explained.any() else inspection.once(strongest_line)
        return line.score if line is not None and not is_motion(inspection.residual, line) else None


def swings_in_limit_cycle(inspection: Inspection) -> bool:
    """Whether a clear line is motion of the rig."""
    line = inspection.once(strongest_line)
    return line is not None and is_clear(line.score) and is_motion(inspection.residual, line)


def is_motion(residual: ResidualRecord, line: Line) -> bool:
    """Whether the logged command responds to a line, which it does not to a tone in the record alone."""
    return line.score.normal > TONE_WITH_SIZE and _control_responds(residual, line)


def _lines(residual: ResidualRecord, series: Floats) -> Complex:
    """Spectrum (half line,) of a tapered series (samples,)."""
    return np.asarray(rfft(series * residual.taper, 2 * residual.samples), dtype=complex)


def _power(residual: ResidualRecord, left: _Left, spectrum: Complex) -> Floats:
    """Power of each half line per its noise, on the average over those that lie alike between harmonics."""
    size = left.noise.size
    modelled = np.interp(np.arange(size) / 2, np.arange(residual.frequency.size), residual.modelled_noise)
    power = np.abs(spectrum) ** 2 / modelled / left.noise
    within = 2 * int(np.flatnonzero(residual.repeating).max()) + 1 if residual.periods else 0
    # in the sweep's band lines at and beside its harmonics have lost some of their noise with the mean over periods
    alike = [slice(place, within, 2 * residual.periods) for place in range(2 * residual.periods)]
    for lines in (*alike, slice(within, None)):
        told = power[lines][np.isfinite(left.noise[lines])]
        if told.size:
            power[lines] /= max(float(np.median(told)), np.finfo(float).tiny) / np.log(2)
    return np.asarray(power, dtype=float)


def _of_harmonics(power: Floats, periods: int) -> Floats:
    """Mean power of the half lines that lie alike beside further harmonics; infinite where these are too few."""
    window = np.zeros(4 * _FAR_HARMONICS * periods + 1)
    window[:: 2 * periods] = 1
    near = 2 * _NEAR_HARMONICS * periods
    window[window.size // 2 - near : window.size // 2 + near + 1] = 0
    count, total = (np.convolve(values, window, "same") for values in ((power > 0).astype(float), power))
    return np.where(count >= window.sum() / 2, total / np.maximum(count, 1.0), np.inf)


def _beside_harmonics(residual: ResidualRecord, explained: Floats) -> _Left:
    """The record less what the neighbours of each harmonic say of the answer there, beyond the fitted model's.

    They are fitted by a local polynomial (Schoukens, Vandersteen, Barbé and Pintelon 2009, Automatica 45) in which the
    harmonic itself has no word.
    """
    told = residual.speed - residual.taken - explained - residual.swept(residual.mobility)
    sweep, seen = (
        _lines(residual, series - series.mean())[:: 2 * residual.periods] for series in (residual.sweep, told)
    )
    offsets = np.array([side * step for step in range(1, _NEAR_HARMONICS + 1) for side in (-1, 1)])
    places = np.flatnonzero(residual.repeating)[: sweep.size - 1 - _NEAR_HARMONICS]
    around = places[:, None] // residual.periods + offsets
    asked, answered = (np.where(around < 0, np.conj(one[np.abs(around)]), one[np.abs(around)]) for one in (sweep, seen))
    powers = (offsets[:, None] / _NEAR_HARMONICS) ** np.arange(_ORDER + 1)
    weights = np.linalg.pinv(asked[:, :, None] * powers)[:, 0]
    added = np.abs(sweep[places // residual.periods]) ** 2 * np.sum(np.abs(weights) ** 2, axis=1)
    added = np.where(added > _WIDEST, np.inf, added)
    response, widened = np.zeros(residual.frequency.size, dtype=complex), np.zeros(2 * residual.frequency.size - 1)
    response[places] = np.sum(weights * answered, axis=1)
    for beside in (-1, 0, 1):
        widened[2 * places + beside] += added * np.sinc(beside / 2) ** 2
    return _Left(told - residual.swept(response), np.where(widened > 0, 1 + widened, np.inf), loses=False)


def _control_responds(residual: ResidualRecord, line: Line) -> bool:
    """Whether the logged command holds the control's response to a line."""
    if not residual.record.has_command:
        return False
    controller = residual.system.top_drive.controller
    given = residual.command - residual.sweep
    answer, asked = (_lines(residual, series - series.mean())[line.place] for series in (given, residual.speed))
    gain = np.ravel(control(controller, residual.s))[line.place // 2]
    return bool(abs(answer + gain * asked) < RESPONSE_MISSING * abs(gain * line.height))


def _amplitude_error(residual: ResidualRecord, place: int | Indices) -> Floats:
    """Standard error of the amplitude of a tone at half lines, rad/s."""
    return np.asarray(np.sqrt(2 * residual.noise[place // 2]) / residual.taper.sum(), dtype=float)


def _amplitude(residual: ResidualRecord, left: _Left, place: int) -> tuple[float, float]:
    """Amplitude of a tone within a quarter of a line of a half line, rad/s, and the share of it that is left.

    Beside a harmonic of the sweep, a part of a tone goes with what repeats.
    """
    taper, sample = residual.taper, np.arange(residual.samples)
    places = (place / 2 + np.linspace(-0.3, 0.3, 13)) / residual.samples
    found = np.exp(-2j * np.pi * places[:, None] * sample) @ (left.series * taper)
    best = int(np.argmax(np.abs(found)))
    tone = np.cos(2 * np.pi * places[best] * sample + np.angle(found[best]))
    kept = float(2 / taper.sum() * np.sum(tone * taper * residual.without_sweep(tone))) if left.loses else 1.0
    kept = max(kept, _LEAST_KEPT)
    return float(np.abs(found[best])) * 2 / taper.sum() / kept, kept
