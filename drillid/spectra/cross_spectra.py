"""Cross spectra of one window: the result of all estimators, and Welch's averaged periodograms."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields

import numpy as np
import xarray as xr
from numpy.typing import NDArray
from scipy.fft import rfft

from drillid.arrays import Complex, Floats, Integers
from drillid.datasets.measured import WINDOW_FREQUENCY


@dataclass(frozen=True)
class Spectra:
    """Spectra of one window on its frequency grid, each of shape (frequency,); units as in the schema."""

    sweep_power: Floats
    speed_power: Floats
    speed_noise: Floats
    command_noise: Floats
    cross_speed: Complex
    cross_command: Complex
    cross_noise: Complex
    averages: Floats
    degrees_of_freedom: Floats
    sweep_rounding: Floats

    @staticmethod
    def missing(size: int) -> Spectra:
        """Spectra of a window from which none can be estimated."""
        nothing, count = np.full(size, np.nan), np.full(size, 2.0)
        unknown = nothing + 0j
        return Spectra(nothing, nothing, nothing, nothing, unknown, unknown, unknown, count, count - 1, nothing)

    @staticmethod
    def joined(parts: Sequence[Spectra]) -> Spectra:
        """Spectra of one window from those of successive bands."""
        return Spectra(*(np.concatenate([getattr(part, field.name) for part in parts]) for field in fields(Spectra)))

    @staticmethod
    def of_row(spectra: xr.Dataset, row: int) -> Spectra:
        """Spectra of the window in a row of the dataset of `stacked`."""
        return Spectra(*(spectra[field.name].values[row] for field in fields(Spectra)))


def stacked(windows: Sequence[Spectra], frequencies: Floats) -> xr.Dataset:
    """Spectra of one or more windows on the same `frequencies` (Hz) as a dataset (window, frequency)."""
    columns = {
        field.name: (WINDOW_FREQUENCY, np.stack([getattr(window, field.name) for window in windows]))
        for field in fields(Spectra)
    }
    return xr.Dataset(columns, {"frequency": frequencies})


def welch_spectra(
    sweep: Floats, speed: Floats, command: Floats, rate: float, segment: float, frequencies: Floats
) -> Spectra:
    """Spectra by averaging half-overlapping Hann segments of `segment` s (Welch 1967).

    Frequencies are two lines of a segment apart, so that neighbours are nearly independent. Samples
    are rounded to single precision, 1e-7 of the channels' range, which halves the time. Overlapping
    segments share noise, of which a sweep that is alike in neighbouring segments, or is strong in a
    few of them, averages less; averages and degrees of freedom are those for the sweep as it is.
    """
    samples = round(segment * rate)
    taper = np.hanning(samples + 1)[:-1]
    taper = (taper * (2 / taper.sum())).astype(np.float32)
    lines = np.rint(frequencies * segment).astype(int)
    spectrum_sweep, spectrum_speed, spectrum_command = (
        _segment_spectra(channel, taper)[:, lines] for channel in (sweep, speed, command)
    )
    noise_gain, freedom = _freedom(spectrum_sweep, lines)
    segments = spectrum_speed.shape[0]
    sweep_power, speed_power, command_power = (
        np.mean(np.abs(x) ** 2, axis=0, dtype=float) for x in (spectrum_sweep, spectrum_speed, spectrum_command)
    )
    cross_speed, cross_command, cross = (
        np.mean(a * np.conj(b), axis=0, dtype=complex)
        for a, b in (
            (spectrum_speed, spectrum_sweep),
            (spectrum_command, spectrum_sweep),
            (spectrum_speed, spectrum_command),
        )
    )
    per_freedom = segments / np.maximum(segments - noise_gain, np.finfo(float).tiny)
    return Spectra(
        sweep_power=sweep_power,
        speed_power=speed_power,
        speed_noise=np.maximum(speed_power - np.abs(cross_speed) ** 2 / sweep_power, 0) * per_freedom,
        command_noise=np.maximum(command_power - np.abs(cross_command) ** 2 / sweep_power, 0) * per_freedom,
        cross_speed=cross_speed,
        cross_command=cross_command,
        cross_noise=(cross - cross_speed * np.conj(cross_command) / sweep_power) * per_freedom,
        averages=segments / noise_gain,
        degrees_of_freedom=freedom,
        sweep_rounding=np.zeros(lines.size),
    )


def _freedom(sweep: NDArray[np.complex64], lines: Integers) -> tuple[Floats, Floats]:
    """Noise power along a sweep (segment, line) per that of a segment, (line,), and degrees of freedom off it.

    Neighbouring Hann segments have the correlation 1/6 in even lines and −1/6 in odd ones. Off the sweep the noise
    has the projected covariance, whose power is that of a χ² of as many degrees of freedom (Satterthwaite 1946).
    """
    segments = sweep.shape[0]
    correlation = np.where(lines % 2 == 0, 1.0, -1.0) / 6
    unit = sweep / (np.linalg.norm(sweep, axis=0) + np.finfo(np.float32).tiny)
    mixed = unit.astype(complex)
    mixed[1:] += correlation * unit[:-1]
    mixed[:-1] += correlation * unit[1:]
    gain = np.sum(np.conj(unit) * mixed, axis=0).real
    of_square = segments + (segments - 1) / 18
    spread = of_square - 2 * np.sum(np.abs(mixed) ** 2, axis=0) + gain**2
    return gain, (segments - gain) ** 2 / np.maximum(spread, np.finfo(float).tiny)


def _segment_spectra(channel: Floats, taper: NDArray[np.float32]) -> NDArray[np.complex64]:
    """Spectra (segment, line) of half-overlapping segments of a channel less its mean."""
    single = (channel - channel.mean()).astype(np.float32)
    segments = np.lib.stride_tricks.sliding_window_view(single, taper.size)[:: max(1, taper.size // 2)]
    return np.asarray(rfft(segments * taper), dtype=np.complex64)
