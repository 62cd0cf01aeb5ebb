"""Detections of tones in the record: spectral lines that stand out, between the harmonics of the sweep or at them.

Between harmonics a line is in the part of the record that is not periodic with the sweep. At or beside a harmonic a
tone looks like the response to the sweep; it is distinguished from it by the smoothness of that response, which is
interpolated from the neighbouring harmonics.
"""

from dataclasses import dataclass

import numpy as np
from scipy.fft import irfft, rfft, rfftfreq
from scipy.special import fdtri

from drillid.arrays import Booleans, Complex, Floats, Indices
from drillid.discrepancy.detectors.detection import SpectralLines
from drillid.discrepancy.detectors.detector import Detector, Inspection, is_clear
from drillid.discrepancy.detectors.residual_record import ResidualRecord
from drillid.discrepancy.detectors.score import Score, normal_of_p_value
from drillid.discrepancy.rules import IMAGES_RATE, LINE_KEPT, RESPONSE_MISSING, TONE_WITH_SIZE
from drillid.physics.top_drive import control
from drillid.records.quality import quantisation_step

_OWN_LINES, _CLOSE_LINES, _FAR_LINES = 3, 10, 22
"""Lines on either side of a tone that estimate its noise: from the first beyond its leakage to the last used. Where
the close ones alone are louder, as on a narrow line of the rock's noise, their mean counts."""
_ABSORBED = 1
"""Half lines on either side of a harmonic in which much of a tone is removed with the periodic part; farther off 92 %
remains."""
_FREEDOM = 2.0 * (_FAR_LINES - _OWN_LINES)
"""Degrees of freedom of that noise estimate."""
_ORDER, _NEAR_HARMONICS, _FAR_HARMONICS = 2, 4, 15
"""Order of the local polynomial; harmonics on either side that it is fitted to, and that estimate its noise."""
_WIDEST = 1.0
"""Noise that the interpolation adds, relative to a harmonic's own, up to which it is used."""
_LOWEST, _HIGHEST = 0.05, 0.48
"""Lowest frequency of a tone, Hz, and highest, as a share of the samples' rate."""
_ABOVE_ROUNDING, _IMAGE = 16.0, 0.25
"""Power relative to that of the sweep's rounding above which a line of the sweep is an image, as rounding exceeds it
once in e^16; and the share of a line of the speed above which an image explains it."""
_LEAST_KEPT = 0.1
"""Least share of a tone assumed to remain, in the correction for what is removed with the sweep."""


@dataclass(frozen=True, eq=False)
class SpectralLine:
    """The line that stands out most from its neighbours."""

    place: int
    """Index in half lines, as for all lines here."""
    height: complex
    score: Score


@dataclass(frozen=True, eq=False)
class _Residual:
    """Speed explained by neither the sweep nor other causes, by one method of removing the response to the sweep."""

    series: Floats
    """(samples,) rad/s."""
    noise: Floats
    """(half line,) factor on the noise power that the method adds; infinite where it gives no residual."""
    attenuates: bool
    """Whether the method removes part of a tone as well."""


def strongest_line(residual: ResidualRecord, explained: Floats | None = None) -> SpectralLine | None:
    """The line that stands out most; None where the record has none to test.

    A line's power over the mean of ν neighbours follows F(2, 2ν); a resonance of the string is as wide as its
    neighbours, so that it does not stand out. Lines are spaced by half a line, so that no tone falls between them.

    Parameters
    ----------
    explained : (samples,) rad/s, speed explained by other causes; zero where not given
    """
    frequency = rfftfreq(2 * residual.samples, 1 / residual.record.rate)
    usable = (frequency > _LOWEST) & (frequency < _HIGHEST * residual.sample_rate)
    usable[-2 * _FAR_LINES :] = False
    if not usable.any():
        return None
    explained = np.zeros(residual.samples) if explained is None else explained
    series = residual.speed_residual - residual.without_sweep(explained)
    off_harmonics = _Residual(series, np.ones(frequency.size), attenuates=True)
    methods = [off_harmonics, *([_interpolated(residual, explained)] if residual.periods else [])]
    spectra = [_spectrum(residual, method.series) for method in methods]
    powers = np.stack([_power(residual, method, spectrum) for method, spectrum in zip(methods, spectra, strict=True)])
    around = np.maximum(*(_mean_beside(powers[0], reach) for reach in (_CLOSE_LINES, _FAR_LINES)))
    noise = np.tile(around, (len(methods), 1))
    if residual.periods:
        # images of the sweep and of its response, as of samples that are held, lie beside all harmonics alike
        own_leakage = -(-_OWN_LINES // residual.periods)
        alike = _beside_harmonics(powers[0], residual.periods, own_leakage, missing=0.0)
        noise[0] = np.where(alike > fdtri(_FREEDOM, _FREEDOM, 1 - IMAGES_RATE) * around, alike, around)
        interpolated = _beside_harmonics(powers[1], residual.periods, _NEAR_HARMONICS, missing=np.inf)
        noise[1] = np.maximum(noise[1], interpolated)
    tried = np.stack([usable & np.isfinite(method.noise) for method in methods])
    own = tried.copy()
    own[0] &= ~_is_image(residual, spectra[0])
    ratio = np.where(own, powers / np.maximum(noise, np.finfo(float).tiny), 0.0)
    best, place = (int(index) for index in np.unravel_index(np.argmax(ratio), ratio.shape))
    log_ratio = _FREEDOM * float(np.log1p(ratio[best, place] / _FREEDOM))
    overall = -np.expm1(tried.sum() * np.log1p(-min(np.exp(-log_ratio), 1 - 1e-12)))
    amplitude, kept = _amplitude(residual, methods[best], place)
    height, normal = complex(spectra[best][place]), normal_of_p_value(float(overall))
    # a line that stands out by chance differs from window to window and gives no size
    size_error = float(_amplitude_error(residual, place)) / kept if normal > TONE_WITH_SIZE else np.inf
    lines = _faint_lines(residual, spectra[0], ratio[0], tried[0], place)
    return SpectralLine(place, height, Score(normal, amplitude, size_error, log_ratio, lines=lines))


def _is_image(residual: ResidualRecord, spectrum: Complex) -> Booleans:
    """Half lines off the harmonics that may be images of the sweep, (half line,).

    Rows of different ages alias the sweep, and the speed with it, to other lines. The images of the sweep are the part
    of its record that does not repeat. Those of the speed are larger by the mobility at the line that was aliased, thus
    at most by the largest mobility.

    Parameters
    ----------
    spectrum : (half line,) of the residual record, rad/s
    """
    from scipy.ndimage import maximum_filter1d

    if not residual.periods:
        return np.zeros(spectrum.size, dtype=bool)
    images = irfft(rfft(residual.sweep) * residual.off_harmonics, residual.samples) * residual.taper
    # images a line or two apart cancel each other in some lines, not in all within their leakage
    power = maximum_filter1d(np.abs(rfft(images, 2 * residual.samples)) ** 2, 4 * _OWN_LINES + 1)
    step = quantisation_step(residual.sweep) or 0.0
    shown = power > _ABOVE_ROUNDING * step**2 / 12 * np.sum(residual.taper**2)
    largest = np.abs(residual.mobility[residual.inside]).max()
    return np.asarray(shown & (np.sqrt(power) * largest > _IMAGE * np.abs(spectrum)), dtype=bool)


def _faint_lines(
    residual: ResidualRecord, spectrum: Complex, ratio: Floats, tried: Booleans, strongest: int
) -> SpectralLines:
    """Lines that stand out at all and are not periodic with the sweep, at any frequency.

    Lines that are periodic with it appear alike in all windows: errors of the model in the sweep's band, distortion and
    rounding of the record beyond it.

    Parameters
    ----------
    spectrum : (half line,) of the residual record, rad/s
    ratio : (half line,) power over noise; 0 for lines that are not tested, or may be images
    tried : (half line,) lines that are tested; images among them, as what is taken for one depends on its height
    strongest : half line of the window's own detection
    """
    harmonics = np.zeros(ratio.size, dtype=bool)
    harmonics[::2] = ~residual.off_harmonics
    near = np.convolve(harmonics, np.ones(2 * _ABSORBED + 1), "same") > 0
    ratio, tried = np.where(near, 0.0, ratio), tried & ~near
    log_ratio = _FREEDOM * np.log1p(ratio / _FREEDOM)
    place = np.flatnonzero(log_ratio > LINE_KEPT)
    error = _amplitude_error(residual, place)
    height = 2 * np.abs(spectrum[place]) / residual.taper.sum()
    # both quadratures of the noise add to the power
    size = np.sqrt(np.maximum(height**2 - 2 * error**2, 0.0))
    spacing = residual.record.rate / (2 * residual.samples)
    kept = (values.astype(np.float32) for values in (log_ratio[place], size, error))
    return SpectralLines(spacing, int(np.count_nonzero(tried)), strongest, place.astype(np.int32), *kept)


class LineDetector(Detector):
    """The line that stands out most of the record's noise, whatever its cause."""

    def score(self, name: str, inspection: Inspection) -> Score | None:
        """Score of the strongest line; None where the record has none to test."""
        line = inspection.cached(strongest_line)
        return None if line is None else line.score


class ToneDetector(Detector):
    """A tone of the recording alone, to which the control does not respond."""

    # a bit that stands swings in a limit cycle, to whose higher harmonics the control may respond too little to show
    excluded_by = ("stuck_slip_regimes",)

    def score(self, name: str, inspection: Inspection) -> Score | None:
        """Score of the strongest line not explained by other causes; None where the command shows that it is motion."""
        explained = inspection.explained
        line = strongest_line(inspection.residual, explained) if explained.any() else inspection.cached(strongest_line)
        return line.score if line is not None and not is_motion(inspection.residual, line) else None


def swings_in_limit_cycle(inspection: Inspection) -> bool:
    """Whether a clear line is motion of the rig."""
    line = inspection.cached(strongest_line)
    return line is not None and is_clear(line.score) and is_motion(inspection.residual, line)


def is_motion(residual: ResidualRecord, line: SpectralLine) -> bool:
    """Whether the logged command responds to a line, as it does not to a tone of the recording alone."""
    return line.score.normal > TONE_WITH_SIZE and _control_responds(residual, line)


def _spectrum(residual: ResidualRecord, series: Floats) -> Complex:
    """Spectrum (half line,) of a tapered series (samples,)."""
    return np.asarray(rfft(series * residual.taper, 2 * residual.samples), dtype=complex)


def _power(residual: ResidualRecord, method: _Residual, spectrum: Complex) -> Floats:
    """Power of each half line relative to its noise, normalised over lines in the same place between harmonics."""
    size = method.noise.size
    modelled = np.interp(np.arange(size) / 2, np.arange(residual.frequency.size), residual.modelled_noise)
    power = np.abs(spectrum) ** 2 / modelled / method.noise
    within = 2 * int(np.flatnonzero(residual.harmonics).max()) + 1 if residual.periods else 0
    # in the sweep's band the mean over periods has removed some of the noise at and beside harmonics
    alike = [slice(place, within, 2 * residual.periods) for place in range(2 * residual.periods)]
    for lines in (*alike, slice(within, None)):
        finite = power[lines][np.isfinite(method.noise[lines])]
        if finite.size:
            power[lines] /= max(float(np.median(finite)), np.finfo(float).tiny) / np.log(2)
    return np.asarray(power, dtype=float)


def _mean_beside(power: Floats, reach: int) -> Floats:
    """Mean power of the neighbours beyond a half line's leakage, up to `reach` lines on either side."""
    beside = 2 * (reach - _OWN_LINES)
    weights = np.repeat([1.0, 0.0, 1.0], [beside, 4 * _OWN_LINES + 1, beside])
    return np.convolve(power, weights / weights.sum(), "same")


def _beside_harmonics(power: Floats, periods: int, nearest: int, *, missing: float) -> Floats:
    """Mean power of the half lines in the same position beside harmonics farther off than the `nearest`; `missing`
    where these are too few.
    """
    window = np.zeros(4 * _FAR_HARMONICS * periods + 1)
    window[:: 2 * periods] = 1
    near = 2 * nearest * periods
    window[window.size // 2 - near : window.size // 2 + near + 1] = 0
    count, total = (np.convolve(values, window, "same") for values in ((power > 0).astype(float), power))
    return np.where(count >= window.sum() / 2, total / np.maximum(count, 1.0), missing)


def _interpolated(residual: ResidualRecord, explained: Floats) -> _Residual:
    """The record less the response to the sweep: the fitted model's, corrected at each harmonic from its neighbours.

    The correction is a local polynomial (Schoukens, Vandersteen, Barbé and Pintelon 2009, Automatica 45) that is not
    fitted to the harmonic itself.
    """
    speed = residual.speed - residual.subtracted - explained - residual.response_to_sweep(residual.mobility)
    # the taper spreads a mean or trend over the lowest harmonics
    speed = residual.without_trend(speed)
    sweep, output = (
        _spectrum(residual, series)[:: 2 * residual.periods]
        for series in (residual.without_trend(residual.sweep), speed)
    )
    offsets = np.array([side * step for step in range(1, _NEAR_HARMONICS + 1) for side in (-1, 1)])
    places = np.flatnonzero(residual.harmonics)[: sweep.size - 1 - _NEAR_HARMONICS]
    around = places[:, None] // residual.periods + offsets
    inputs, outputs = (
        np.where(around < 0, np.conj(lines[np.abs(around)]), lines[np.abs(around)]) for lines in (sweep, output)
    )
    powers = (offsets[:, None] / _NEAR_HARMONICS) ** np.arange(_ORDER + 1)
    weights = np.linalg.pinv(inputs[:, :, None] * powers)[:, 0]
    relative = residual.modelled_noise[np.abs(around) * residual.periods] / residual.modelled_noise[places][:, None]
    added = np.abs(sweep[places // residual.periods]) ** 2 * np.sum(np.abs(weights) ** 2 * relative, axis=1)
    added = np.where(added > _WIDEST, np.inf, added)
    response, widened = np.zeros(residual.frequency.size, dtype=complex), np.zeros(2 * residual.frequency.size - 1)
    response[places] = np.sum(weights * outputs, axis=1)
    for beside in (-1, 0, 1):
        widened[2 * places + beside] += added * np.sinc(beside / 2) ** 2
    noise = np.where(widened > 0, 1 + widened, np.inf)
    return _Residual(speed - residual.response_to_sweep(response), noise, attenuates=False)


def _control_responds(residual: ResidualRecord, line: SpectralLine) -> bool:
    """Whether the logged command contains the control's response to a line."""
    if not residual.record.has_command:
        return False
    controller = residual.system.top_drive.controller
    feedback = residual.command - residual.sweep
    torque, speed = (_spectrum(residual, series - series.mean())[line.place] for series in (feedback, residual.speed))
    gain = np.ravel(control(controller, residual.s))[line.place // 2]
    return bool(abs(torque + gain * speed) < RESPONSE_MISSING * abs(gain * line.height))


def _amplitude_error(residual: ResidualRecord, place: int | Indices) -> Floats:
    """Standard error of the amplitude of a tone at half lines, rad/s."""
    return np.asarray(np.sqrt(2 * residual.noise[place // 2]) / residual.taper.sum(), dtype=float)


def _amplitude(residual: ResidualRecord, method: _Residual, place: int) -> tuple[float, float]:
    """Amplitude of a tone within a quarter of a line of a half line, rad/s, and the share of it that remains.

    Beside a harmonic of the sweep, part of a tone is removed with the periodic part.
    """
    taper, sample = residual.taper, np.arange(residual.samples)
    places = (place / 2 + np.linspace(-0.3, 0.3, 13)) / residual.samples
    heights = np.exp(-2j * np.pi * places[:, None] * sample) @ (method.series * taper)
    best = int(np.argmax(np.abs(heights)))
    tone = np.cos(2 * np.pi * places[best] * sample + np.angle(heights[best]))
    kept = float(2 / taper.sum() * np.sum(tone * taper * residual.without_sweep(tone))) if method.attenuates else 1.0
    kept = max(kept, _LEAST_KEPT)
    return float(np.abs(heights[best])) * 2 / taper.sum() / kept, kept
