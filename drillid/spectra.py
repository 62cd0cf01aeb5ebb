"""Windows → cross spectra at the sweep's frequencies, and spectrograms (paper, figure 6).

A sweep that repeats has all its power on every n-th line of the window's spectrum, n being
the number of periods; the lines between hold noise alone. So the response is read from the
former without leakage, and its noise from the latter. Where the sweep does not repeat, Welch's
averages over Hann segments take their place.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
import xarray as xr
from numpy.typing import NDArray
from scipy.fft import irfft, next_fast_len, rfft

from drillid.schema import WINDOW_COORDINATES
from drillid.store import Problem, WellFolders, window_place
from drillid.windows import sample_rate

if TYPE_CHECKING:
    from drillid.config import Settings, SpectraSettings
    from drillid.sheets import Well

Floats = NDArray[np.float64]
Complex = NDArray[np.complex128]

_CHANNELS = ("torque_sweep", "speed", "torque_command")
_NOT_REPEATING = 0.01
"""Share of the sweep's power that may differ from one period to the next."""
_LEAST_SEGMENTS = 5
"""Half segments that a window must hold for Welch's averages: four segments that overlap by half."""
_SHORTEST_PERIOD = 1.0
"""Periods of the lowest frequency that the sweep's own period must hold at least."""


@dataclass(frozen=True)
class Spectra:
    """Spectra of one window on its frequency grid, each of shape (frequency,); units as in the schema."""

    sweep_power: Floats
    speed_power: Floats
    speed_noise: Floats
    cross_speed: Complex
    cross_command: Complex
    averages: Floats
    degrees_of_freedom: Floats

    @staticmethod
    def of_nothing(size: int) -> Spectra:
        """Spectra of a window from which none can be made."""
        nothing, count = np.full(size, np.nan), np.full(size, 2.0)
        return Spectra(nothing, nothing, nothing, nothing + 0j, nothing + 0j, count, count - 1)


def sweep_period(sweep: Floats, rate: float, lowest_frequency: float) -> float:
    """Period (s) at which a sweep repeats itself; 0 where it does not within half of the window.

    The shortest lag at which the sweep, less its mean, differs from itself by less than 1 % of its power.
    """
    sweep, samples = sweep - sweep.mean(), sweep.size
    points = next_fast_len(2 * samples, real=True)
    product = irfft(np.abs(rfft(sweep, points)) ** 2, points)[: samples // 2 + 1]
    energy = np.concatenate([[0.0], np.cumsum(sweep**2)])
    lags = np.arange(product.size)
    both = energy[samples - lags] + energy[samples] - energy[lags]
    if energy[-1] == 0:
        return 0.0
    difference = 1 - 2 * product / np.maximum(both, np.finfo(float).tiny)
    shortest = int(_SHORTEST_PERIOD * rate / lowest_frequency)
    inner = difference[1:-1]
    lowest_point = (inner <= difference[:-2]) & (inner <= difference[2:]) & (inner < _NOT_REPEATING)
    found = np.flatnonzero(lowest_point) + 1
    found = found[found >= shortest]
    return float(found[0] / rate) if found.size else 0.0


def line_spectra(
    sweep: Floats, speed: Floats, command: Floats, rate: float, period: float, frequencies: Floats, noise_lines: int
) -> Spectra:
    """Spectra at the harmonics of a repeating sweep, from the whole periods in the window.

    The noise at a harmonic is taken from the nearest `noise_lines` lines between harmonics, and
    what of it varies linearly over them (drift, transients) is taken off the harmonic itself: a
    local polynomial estimate (Pintelon and Schoukens 2012, chapter 7) of order one.
    """
    periods = int(speed.size / rate / period + 1e-9)
    samples = round(periods * period * rate)
    spectrum_sweep, spectrum_speed, spectrum_command = (
        rfft(channel[:samples] - channel[:samples].mean()) * (2 / samples) for channel in (sweep, speed, command)
    )
    harmonics = np.rint(frequencies * period).astype(int) * periods
    offsets = _noise_offsets(periods, noise_lines)
    around = harmonics[:, None] + offsets
    noise_amplitudes, command_noise = (
        np.where(around < 0, np.conj(spectrum[np.abs(around)]), spectrum[np.abs(around)])
        for spectrum in (spectrum_speed, spectrum_command)
    )
    mean = noise_amplitudes.mean(axis=1, keepdims=True)
    slope = noise_amplitudes @ offsets / (offsets @ offsets)
    residual = noise_amplitudes - mean - slope[:, None] * offsets
    freedom = offsets.size - 2
    per_line = np.sum(np.abs(residual) ** 2, axis=1) / freedom * (1 + 1 / offsets.size)
    speed_line = spectrum_speed[harmonics] - mean[:, 0]
    sweep_line, command_line = spectrum_sweep[harmonics], spectrum_command[harmonics] - command_noise.mean(axis=1)
    noise = per_line * periods
    return Spectra(
        sweep_power=np.abs(sweep_line) ** 2,
        speed_power=np.abs(speed_line) ** 2 + noise * (periods - 1) / periods,
        speed_noise=noise,
        cross_speed=speed_line * np.conj(sweep_line),
        cross_command=command_line * np.conj(sweep_line),
        averages=np.full(harmonics.size, float(periods)),
        degrees_of_freedom=np.full(harmonics.size, float(freedom)),
    )


def _noise_offsets(periods: int, noise_lines: int) -> NDArray[np.int64]:
    reach = np.arange(1, noise_lines * 2 + 1)
    between = reach[reach % periods != 0][: (noise_lines + 1) // 2]
    return np.concatenate([-between[::-1], between])


def welch_spectra(
    sweep: Floats, speed: Floats, command: Floats, rate: float, segment: float, frequencies: Floats
) -> Spectra:
    """Spectra by averaging half-overlapping Hann segments of `segment` s (Welch 1967).

    Frequencies lie two lines of a segment apart, so that neighbours are nearly independent.
    """
    samples = round(segment * rate)
    starts = np.arange(0, speed.size - samples + 1, max(1, samples // 2))
    taper = np.hanning(samples + 1)[:-1]
    taper = taper * (2 / taper.sum())
    lines = np.rint(frequencies * segment).astype(int)
    spectrum_sweep, spectrum_speed, spectrum_command = (
        rfft(np.stack([(channel[a : a + samples] - channel[a : a + samples].mean()) * taper for a in starts]))[:, lines]
        for channel in (sweep, speed, command)
    )
    segments = starts.size
    averages = segments / (1 + 2 / 36 * (1 - 1 / segments))
    sweep_power, speed_power = (np.mean(np.abs(x) ** 2, axis=0) for x in (spectrum_sweep, spectrum_speed))
    cross_speed = np.mean(spectrum_speed * np.conj(spectrum_sweep), axis=0)
    unexplained = speed_power - np.abs(cross_speed) ** 2 / sweep_power
    freedom = max(averages - 1, np.finfo(float).tiny)
    return Spectra(
        sweep_power=sweep_power,
        speed_power=speed_power,
        speed_noise=np.maximum(unexplained, 0) * averages / freedom,
        cross_speed=cross_speed,
        cross_command=np.mean(spectrum_command * np.conj(spectrum_sweep), axis=0),
        averages=np.full(lines.size, averages),
        degrees_of_freedom=np.full(lines.size, averages - 1),
    )


def frequency_grid(period: float, settings: SpectraSettings, rate: float) -> Floats:
    """Harmonics of the period between the settings' lowest and highest frequency, Hz."""
    highest = min(settings.frequency_maximum_hz, 0.4 * rate)
    first = int(np.ceil(settings.frequency_minimum_hz * period - 1e-9))
    return np.arange(first, int(highest * period + 1e-9) + 1) / period


def spectrogram(channel: Floats, rate: float, segment: float, highest: float) -> tuple[Floats, Floats, Floats]:
    """Power density (frequency, time) of a channel up to `highest` Hz, over half-overlapping Hann segments."""
    from scipy.signal import ShortTimeFFT
    from scipy.signal.windows import hann

    length = round(segment * rate)
    transform = ShortTimeFFT(hann(length, sym=False), length // 2, rate, scale_to="psd", fft_mode="onesided2X")
    first, last = transform.lower_border_end[1], transform.upper_border_begin(channel.size)[1]
    power = transform.spectrogram(channel - channel.mean(), p0=first, p1=last)
    frequencies, times = transform.f, transform.t(channel.size, p0=first, p1=last)
    kept = frequencies <= highest
    return frequencies[kept], times, power[kept]


def process(well: Well, folders: WellFolders, settings: Settings) -> list[Problem]:
    """Spectra of all windows of a well; nothing of a well without any, as the windows stage says why."""
    records, windows = folders.read("records", "records"), folders.read("windows", "windows").load()
    if windows.sizes["window"] == 0:
        return []
    rate, chosen = sample_rate(records), settings.spectra
    periods = np.array(
        [
            sweep_period(_channel(records, window, "torque_sweep"), rate, chosen.frequency_minimum_hz)
            for window in _rows(windows)
        ]
    )
    repeating = periods[periods > 0]
    grid_period = float(np.median(repeating)) if repeating.size else chosen.segment_s / 2
    frequencies = frequency_grid(grid_period, chosen, rate)
    pieces, problems = [], []
    for number, window in enumerate(_rows(windows)):
        sweep, speed, command = (
            _channel(records, window, name) for name in ("torque_sweep", "speed", "torque_command")
        )
        if abs(periods[number] - grid_period) < 0.5 / rate:
            spectra = line_spectra(sweep, speed, command, rate, grid_period, frequencies, chosen.noise_lines)
        elif sweep.size >= _LEAST_SEGMENTS * grid_period * rate:
            spectra = welch_spectra(sweep, speed, command, rate, 2 * grid_period, frequencies)
            problems.append(_not_repeating(windows, number, periods[number], grid_period))
        else:
            spectra = Spectra.of_nothing(frequencies.size)
            problems.append(_too_short(windows, number, _LEAST_SEGMENTS * grid_period))
        torque = command if np.isfinite(command).all() else sweep
        pieces.append(xr.merge([_cross_spectra(spectra, frequencies), _spectrograms(torque, speed, rate, chosen)]))
    dataset = xr.concat(pieces, "window", coords="minimal", compat="override", join="exact").assign(
        sweep_period=("window", periods)
    )
    folders.write("spectra", "spectra", dataset.assign_coords({name: windows[name] for name in WINDOW_COORDINATES}))
    return problems


def _rows(windows: xr.Dataset) -> list[tuple[int, int]]:
    return list(zip(windows["first_sample"].values.tolist(), windows["samples"].values.tolist(), strict=True))


def _channel(records: xr.Dataset, window: tuple[int, int], name: str) -> Floats:
    first, samples = window
    return np.asarray(records[name][first : first + samples].values, dtype=float)


def _not_repeating(windows: xr.Dataset, row: int, period: float, usual: float) -> Problem:
    found = (
        f"repeats every {period:.2f} s, not every {usual:.2f} s as in the other windows"
        if period
        else "does not repeat"
    )
    return Problem(
        window_place(windows, row),
        f"the sweep {found}; its spectra are averages over segments, with fewer degrees of freedom",
        "Keep one periodic sweep through a window",
    )


def _too_short(windows: xr.Dataset, row: int, needed: float) -> Problem:
    return Problem(
        window_place(windows, row),
        f"is too short for a sweep that does not repeat in it: {needed:.0f} s are needed for averages over segments",
        "Lengthen windows.length_s or shorten spectra.segment_s",
    )


def _cross_spectra(spectra: Spectra, frequencies: Floats) -> xr.Dataset:
    return xr.Dataset(
        {name: ("frequency", values) for name, values in vars(spectra).items()}, {"frequency": frequencies}
    )


def _spectrograms(torque: Floats, speed: Floats, rate: float, settings: SpectraSettings) -> xr.Dataset:
    segment, highest = settings.spectrogram_segment_s, settings.frequency_maximum_hz
    frequencies, times, torque_power = spectrogram(torque, rate, segment, highest)
    dims = ("spectrogram_frequency", "spectrogram_time")
    return xr.Dataset(
        {
            "torque_spectrogram": (dims, torque_power.astype(np.float32)),
            "speed_spectrogram": (dims, spectrogram(speed, rate, segment, highest)[2].astype(np.float32)),
        },
        {"spectrogram_frequency": frequencies, "spectrogram_time": times},
    )
