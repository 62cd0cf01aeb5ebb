"""Detections of a recorded speed that holds the last of rarer samples.

A row that holds a sample of an earlier time is late by its age, which rises from zero to the interval of the samples
and falls back with each new one. Where the speed follows the sweep, ages make images of it, at multiples of the
samples' rate beside its own frequencies, in proportion to its acceleration. The interval gives their frequencies and
their amplitudes as well, so that one whose images are not as large as they should be is rejected.
"""

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from scipy.fft import fft, fftfreq, ifft, next_fast_len
from scipy.interpolate import CubicSpline
from scipy.optimize import minimize_scalar
from scipy.special import i0e, logsumexp, stdtr

from drillid.arrays import Complex, Floats, Integers
from drillid.discrepancy.detectors.detector import Detector, Inspection
from drillid.discrepancy.detectors.residual_record import ResidualRecord
from drillid.discrepancy.detectors.score import Score, normal_of_p_value
from drillid.statistics import TWO_SIDED

_SHORTEST, _LONGEST = 1.05, 0.5
"""Intervals tried: from the longer one of rows and samples times this, whose images lie clear of the sweep, up to s."""
_FINER = 4
"""Intervals tried within the resolution of a record in frequency."""
_IMAGES, _FAR = 3, 20.0
"""Images on either side of each frequency that are taken into account at least, and Hz, up to which they all are."""
_MULTIPLES = 3
"""Multiples of an interval that are tried beside it."""
_HIDDEN = 0.25
"""Frequencies of the speed do not count where the number of their periods in an interval is within this of a whole one,
as the record hardly shows them.
"""
_PHASES = 64
"""Times of a sample tried, per interval."""
_LOWEST = 0.3
"""Hz, below which noise of the rock and slow changes of the speed hide images."""
_LIKELY = 0.5
"""Share of the greatest log-likelihood ratio from which an interval is looked at closely: of several whose images fall
on the same lines of a record, amplitudes and further images tell which it is."""
_CLOSELY = 6
"""Number of intervals that are looked at closely at most."""
_APART = 0.5
"""Hz, by which their rates differ at least."""
_REFINED = 2
"""Number of them that are refined within the resolution of the record."""
_BETWEEN = (0.0, 0.01, 0.02, 0.03)
"""s, intervals of a control tried, between whose samples rows may lie on lines."""
_STEPS = 12
"""Intervals tried about each."""
_AMPLITUDE = 0.3
"""Error of the images' amplitude by the model: the sweep's response in the record is not quite that of the speed."""
_BLOCKS = 64
"""Blocks of a record whose scatter gives the error of an amplitude."""
_SPEED = 1
"""Place of the speed among a record's channels."""


class SampleAndHoldDetector(Detector):
    """A recorded speed that holds the last of rarer samples."""

    accuracy = 1e-4

    def score(self, name: str, inspection: Inspection) -> Score | None:
        """That of the likeliest interval; without a size where the record does not have its images."""
        return HeldSpeed(inspection.residual).score()


@dataclass(frozen=True, eq=False)
class Held:
    """A record as it is where its speed holds samples for an interval."""

    interval: float
    """s."""
    log_ratio: float
    """Log-likelihood ratio against rows with samples of their own."""
    amplitude: float
    """Of the images in the record, relative to those of the interval."""
    amplitude_error: float


class HeldSpeed:
    """Intervals at which the recorded speed may be renewed, against a window's residual record.

    Where rows show the samples of a control, these are tested, at their own times. Intervals shorter than those of rows
    and samples are not tried: images of several of them fall on the same frequencies.
    """

    def __init__(self, residual: ResidualRecord) -> None:
        self._residual, shown, rate = residual, residual.record.samples, residual.record.rate
        places, speed, step = np.arange(residual.samples, dtype=float), residual.speed, 1.0
        if shown is not None:
            inside = (shown.places >= 0) & (shown.places <= residual.samples - 1)
            places, speed, step = shown.places[inside], shown.channels[_SPEED, inside], shown.interval
        self._time: Floats = places / rate
        self._number: Integers = np.rint((places - places[0]) / step).astype(np.int64)
        self._step = step / rate
        repeated = residual.speed - residual.speed_residual
        self._swing: Floats = repeated - repeated.mean()
        """(samples of the record,) rad/s, the repeated speed about its mean."""
        self._spectrum: Complex = fft(self._swing)
        self._taper = self._at_samples(residual.taper)
        error = fft((speed - self._at_samples(repeated)) * self._taper)
        self._weighted: Floats = np.asarray(ifft(error * self._weight).real * self._taper, dtype=float)

    @cached_property
    def log_evidence(self) -> float:
        """Log Bayes factor of an interval, with all phases and all logarithms of intervals equally likely before."""
        interval, _, by_phase = self._scan
        return float(logsumexp(by_phase, b=interval / interval.sum()))

    @cached_property
    def likeliest(self) -> Held | None:
        """The likeliest interval; None where its images are not in the record, or not as large as it makes them."""
        if not self.log_evidence > 0:
            return None
        roughly = [self._examined(interval, 0.0) for interval in self._likely()]
        roughly.sort(key=lambda held: -held.log_ratio)
        found = max((self._refined(held.interval) for held in roughly[:_REFINED]), key=lambda held: held.log_ratio)
        reach = _AMPLITUDE + TWO_SIDED * found.amplitude_error
        return found if abs(found.amplitude - 1) < reach else None

    def score(self) -> Score:
        """Score of the likeliest interval; without a size where there is none.

        By Markov's inequality a Bayes factor exceeds any value x with probability at most 1/x without the cause.
        """
        held = self.likeliest
        if held is None:
            return Score(normal_of_p_value(1.0), np.nan, np.inf, 0.0)
        ratio = held.amplitude / held.amplitude_error
        p_value = max(float(np.exp(-self.log_evidence)), float(stdtr(_BLOCKS - 1, -ratio)))
        error = held.interval * self._step / self._time[-1] / ratio
        return Score(normal_of_p_value(p_value), held.interval, error, held.log_ratio)

    @cached_property
    def _weight(self) -> Floats:
        """One over the noise's variance per sample at each line of the samples, both signs; 0 below the band."""
        residual, count = self._residual, self._time.size
        interval = (self._time[-1] - self._time[0]) / (count - 1)
        frequency = np.abs(fftfreq(count, interval))
        near = np.interp(frequency, residual.frequency, residual.noise)
        noise = np.where(frequency > residual.highest, residual.sensor_floor, near)
        variance = noise / (residual.record.rate * interval * np.sum(residual.taper**2))
        return np.where(frequency > _LOWEST, 1 / np.maximum(variance, np.finfo(float).tiny), 0.0)

    def _at_samples(self, series: Any) -> Any:
        """Smooth series (..., samples of the record) at the samples that the rows show."""
        if self._residual.record.samples is None:
            return series
        return CubicSpline(self._residual.time, series, axis=-1)(self._time)

    @cached_property
    def _scan(self) -> tuple[Floats, Floats, Floats]:
        """Intervals (interval,), the log-likelihood ratio of the first images of each at their best phase, and the
        logarithm of the mean likelihood ratio over phases.
        """
        residual, count = self._residual, self._time.size
        inside = residual.frequency < residual.highest
        slope = self._at_samples(residual.filtered(residual.s * inside, self._swing))
        size = next_fast_len(_FINER * (int(self._number[-1]) + 1))
        product = np.zeros(size)
        product[self._number] = self._weighted * slope
        power = np.abs(fft(slope * self._taper)) ** 2 / count
        energy = ifft(fft(power) * fft(self._weight)).real
        duration = size * self._step
        shortest = _SHORTEST * max(self._step, 1 / residual.record.rate)
        number = np.arange(int(duration / _LONGEST), int(duration / shortest))
        interval = duration / number
        line = np.rint(number / duration * (self._time[-1] + self._time[1] - 2 * self._time[0])).astype(int) % count
        # the first harmonic of a saw tooth as high as the interval
        amplitude = interval / np.pi
        matched, half_energy = amplitude * np.abs(fft(product))[number % size], amplitude**2 / 4 * energy[line]
        return interval, matched - half_energy, matched + np.log(i0e(matched)) - half_energy

    def _likely(self) -> Floats:
        """Intervals whose first images are likely, none about a likelier one, where its lines beside the sweep's
        period lie; and their multiples, of which these would be further images.
        """
        interval, ratio, _ = self._scan
        likely: list[float] = []
        left, least = ratio.copy(), _LIKELY * float(ratio.max())
        while left.max() > max(least, 0.0) and len(likely) < _CLOSELY:
            likely.append(float(interval[np.argmax(left)]))
            left[np.abs(1 / interval - 1 / likely[-1]) < _APART] = -np.inf
        multiples = np.multiply.outer(np.arange(1, _MULTIPLES + 1), likely).ravel()
        return multiples[multiples <= _LONGEST]

    def _refined(self, interval: float) -> Held:
        """The likeliest interval within the resolution of the record about one, at the likeliest lines between samples
        of a control which the rows do not show.
        """
        half = interval**2 / self._time[-1] / 2
        found = minimize_scalar(
            lambda tried: -self._examined(tried, 0.0).log_ratio,
            bounds=(interval - half, interval + half),
            method="bounded",
            options={"maxiter": _STEPS},
        )
        tried = _BETWEEN if self._residual.record.samples is None else _BETWEEN[:1]
        return max((self._examined(float(found.x), between) for between in tried), key=lambda held: held.log_ratio)

    def _examined(self, interval: float, between: float) -> Held:
        """A record against the images of an interval at their best phase.

        Parameters
        ----------
        between : s, interval of a control between whose samples rows lie on lines; 0 where they do not
        """
        images = self._images(interval, between)
        phases = 2 * np.pi * np.arange(_PHASES) / _PHASES
        turned = np.exp(-1j * np.multiply.outer(phases, _numbers(interval)))
        matched = 2 * (turned @ (images @ self._weighted)).real
        best = int(np.argmax(matched))
        tapered = images * self._taper
        energy = 2 * float(np.sum(np.abs(fft(tapered)) ** 2 * self._weight)) / self._time.size
        starts = np.linspace(0, self._time.size, _BLOCKS, endpoint=False).astype(int)
        parts = np.add.reduceat(2 * (turned[best] @ images).real * self._weighted, starts)
        shares = np.add.reduceat(np.sum(np.abs(tapered) ** 2, axis=0), starts)
        scatter = parts - matched[best] * shares / shares.sum()
        return Held(
            interval,
            log_ratio=float(matched[best]) - energy / 2,
            amplitude=float(matched[best]) / energy,
            amplitude_error=float(np.sqrt(np.sum(scatter**2))) / energy,
        )

    def _images(self, interval: float, between: float) -> Complex:
        """Images (image, sample) of the repeated speed in the samples that the rows show, less what of them repeats
        with the sweep, rad/s.
        """
        residual, repeated = self._residual, self._repeated(interval, between)
        images = _carried(self._at_samples(repeated), interval, self._time)
        if not residual.periods:
            return images
        rows = _carried(repeated, interval, residual.time)
        kept = residual.without_sweep(rows.real) + 1j * residual.without_sweep(rows.imag)
        return np.asarray(images - self._at_samples(rows - kept), dtype=complex)

    def _repeated(self, interval: float, between: float) -> Complex:
        """The repeated speed (image, samples) as its images at positive multiples of an interval's rate have it, before
        they are carried there, rad/s.

        A sample held for an interval T repeats a line at a frequency f at f + n/T, with a share f T/(f T + n) of its
        height in the record; lines between samples of another interval attenuate both (Oppenheim and Schafer 2010,
        Discrete-Time Signal Processing, chapter 4).
        """
        residual = self._residual
        frequency = fftfreq(residual.samples, 1 / residual.record.rate)
        cycles = frequency * interval
        shown = (np.abs(cycles) < 0.5) | (np.abs(cycles - np.rint(cycles)) > _HIDDEN)
        counted = shown & (np.abs(frequency) < residual.highest)
        spectrum = np.where(counted, self._spectrum, 0.0)
        number = _numbers(interval)[:, None]
        passed = (np.sinc((frequency + number / interval) * between) / np.sinc(frequency * between)) ** 2
        return np.asarray(ifft(spectrum * passed * cycles / np.where(counted, cycles + number, 1.0)), dtype=complex)


def _numbers(interval: float) -> Integers:
    """Multiples (image,) of an interval's rate that carry its images."""
    return np.arange(1, max(_IMAGES, int(np.ceil(_FAR * interval))) + 1)


def _carried(series: Complex, interval: float, time: Floats) -> Complex:
    """Series (image, time) carried to one, two, ... times the rate of an interval."""
    return np.asarray(series * np.exp(2j * np.pi * _numbers(interval)[:, None] * time / interval), dtype=complex)
