"""Windows → cross spectra at the sweep's frequencies, and spectrograms (paper, figure 6).

Where the sweep is periodic, its own lines and those between them are used (`periodic`). Where it is
not, response and transient are local polynomials of frequency (`local_polynomial`). Welch's classical
averages are used where the settings choose them (`cross_spectra`).
"""

from __future__ import annotations

import functools
from typing import TYPE_CHECKING

import numpy as np
import xarray as xr
from scipy.fft import rfft

from drillid.arrays import Booleans, Floats
from drillid.datasets.measured import WINDOW_COORDINATES
from drillid.datasets.reuse import Memo, completed, row_keys
from drillid.datasets.store import Problem, WellFolders, window_place
from drillid.errors import EstimationError
from drillid.records.slower_samples import released
from drillid.spectra.cross_spectra import Spectra, stacked, welch_spectra
from drillid.spectra.distortion import DistortionLevels, distortion_levels, sweep_rate, two_octave_bands
from drillid.spectra.local_polynomial import LEAST_LINES, local_spectra
from drillid.spectra.period import sweep_period
from drillid.spectra.periodic import line_spectra
from drillid.windows.channels import sample_rate, window_channels

if TYPE_CHECKING:
    from drillid.config.listing import Well
    from drillid.config.settings import Settings, SpectraSettings


_ROUNDING = 1e-9
"""Share of a window's length that is rounding."""
_LEAST_SEGMENTS = 5
"""Half segments of the shortest window for Welch's averages: four segments that overlap by half."""


def frequency_grid(period: float, settings: SpectraSettings, rate: float) -> Floats:
    """Harmonics of the period between the settings' lowest and highest frequency, Hz."""
    highest = min(settings.frequency_maximum_hz, 0.4 * rate)
    first = int(np.ceil(settings.frequency_minimum_hz * period - 1e-9))
    return np.arange(first, int(highest * period + 1e-9) + 1) / period


def usual_sweep(periods: Floats, settings: SpectraSettings, rate: float) -> tuple[float, Floats]:
    """Period of most windows' sweeps, s, 0 where none is periodic; and the grid, Hz, for all of their spectra.

    `periods` (window,), s, are 0 where the sweep is not periodic.
    """
    repeating = periods[periods > 0]
    found = list(dict.fromkeys(repeating.tolist()))
    alike = [np.count_nonzero(is_usual(repeating, period, rate)) for period in found]
    usual = found[int(np.argmax(alike))] if found else 0.0
    return usual, frequency_grid(usual or settings.segment_s / 2, settings, rate)


def is_usual(periods: Floats, usual: float, rate: float) -> Booleans:
    """Where the sweep has the usual period, to a sample: clocks drift, and a short window tells it less precisely."""
    return (periods > 0) & (np.abs(periods - usual) * rate < 1)


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
    """Spectra of all windows of a well; none for a well without windows, for which the windows stage has the reason."""
    records, windows = folders.read("records", "records"), folders.read("windows", "windows").load()
    if windows.sizes["window"] == 0:
        return []
    rate, chosen, memo = sample_rate(records), settings.spectra, Memo(folders, "spectra")
    rows, contents = range(windows.sizes["window"]), windows["key"].values.tolist()

    def period(row: int) -> float:
        sweep, *_ = released(window_channels(records, windows, row), rate).channels
        return sweep_period(sweep, rate, chosen.frequency_minimum_hz)

    periods = np.array(
        [memo.result(memo.key("period", contents[row], rate), functools.partial(period, row)) for row in rows]
    )
    usual, frequencies = usual_sweep(periods, chosen, rate)
    if frequencies.size < 2:
        raise EstimationError(
            "spectra",
            f"no two lines lie between {chosen.frequency_minimum_hz:g} and {0.4 * rate:g} Hz, 0.4 of the sample rate",
            "Lower spectra.frequency_minimum_hz, or log faster",
        )
    # the same in all windows, so that they have the same frequencies
    segment = min(chosen.spectrogram_segment_s, float(windows["samples"].min()) / (2 * rate))
    repeats = is_usual(periods, usual, rate)
    factor = _sweep_rate(records, windows, repeats, rate, usual, frequencies)
    longest = int(windows["samples"].max())
    # shorter windows have spectrograms that end earlier
    times = spectrogram(np.zeros(longest), rate, segment, chosen.frequency_maximum_hz)[1]

    def make(missing: list[int]) -> xr.Dataset:
        lines, others = [], []
        for row in missing:
            channels = released(window_channels(records, windows, row), rate).channels
            sweep, speed, command = channels
            spectra = _estimated(channels, rate, periods[row], usual, frequencies, chosen)
            torque = command if np.isfinite(command).all() else sweep
            distortion = _distortion(spectra, frequencies, usual, factor if repeats[row] else np.nan)
            lines.append(spectra)
            shown = _spectrograms(torque, speed, rate, segment, chosen.frequency_maximum_hz)
            others.append(xr.merge([shown.reindex(spectrogram_time=times), distortion]))
        return xr.merge(
            [
                stacked(lines, frequencies),
                xr.concat(others, "window", coords="minimal", compat="override", join="exact"),
            ]
        )

    keys = row_keys(folders.basis, contents, rate, usual, frequencies.tolist(), factor, longest, segment)
    dataset = completed(folders.earlier("spectra", "spectra"), keys, "window", make)
    dataset = dataset.assign(sweep_period=("window", periods)).drop_vars(WINDOW_COORDINATES, errors="ignore")
    folders.write("spectra", "spectra", dataset.assign_coords({name: windows[name] for name in WINDOW_COORDINATES}))
    memo.save()
    samples = windows["samples"].values
    faults = [_fault(samples[row] / rate, periods[row], usual, frequencies, rate, chosen) for row in rows]
    return [Problem(window_place(windows, row), *fault) for row, fault in zip(rows, faults, strict=True) if fault]


def _estimated(
    channels: Floats, rate: float, period: float, usual: float, frequencies: Floats, settings: SpectraSettings
) -> Spectra:
    """Spectra of one window."""
    sweep, speed, command = channels
    if is_usual(np.asarray(period), usual, rate) and settings.estimator != "welch":
        return line_spectra(sweep, speed, command, rate, period, frequencies, settings.noise_lines)
    if sweep.size < _needed(frequencies, settings, rate):
        return Spectra.missing(frequencies.size)
    if settings.estimator == "welch":
        return welch_spectra(sweep, speed, command, rate, 2 / (frequencies[1] - frequencies[0]), frequencies)
    return local_spectra(sweep, speed, command, rate, frequencies, settings.noise_lines // 4)


def _needed(frequencies: Floats, settings: SpectraSettings, rate: float) -> int:
    """Number of samples of a window that an estimate without a periodic sweep needs."""
    lines = _LEAST_SEGMENTS if settings.estimator == "welch" else LEAST_LINES
    return int(np.ceil(lines / (frequencies[1] - frequencies[0]) * rate * (1 - _ROUNDING)))


def _fault(
    seconds: float, period: float, usual: float, frequencies: Floats, rate: float, settings: SpectraSettings
) -> tuple[str, str] | None:
    """What is wrong with a window, and the remedy."""
    repeats, welch = bool(is_usual(np.asarray(period), usual, rate)), settings.estimator == "welch"
    if repeats and not welch:
        return None
    needed = _needed(frequencies, settings, rate)
    if round(seconds * rate) < needed:
        return _too_short(needed / rate)
    return _not_periodic(period, usual) if usual and not repeats else None


def _sweep_rate(
    records: xr.Dataset,
    windows: xr.Dataset,
    repeating: Booleans,
    rate: float,
    period: float,
    frequencies: Floats,
) -> float:
    """Time in which the first periodic sweep passes a factor e, s; NaN where it is not exponential."""
    if period == 0 or not repeating.any():
        return np.nan
    [sweep] = window_channels(records, windows, int(np.argmax(repeating)), ("torque_sweep",))
    try:
        harmonics = rfft(sweep[: round(period * rate)])[np.rint(frequencies * period).astype(int)]
        return sweep_rate(harmonics, frequencies, period)
    except EstimationError:
        return np.nan


def _distortion(spectra: Spectra, frequencies: Floats, period: float, factor: float) -> xr.Dataset:
    """Levels by bands of one window, NaN where its sweep is not exponential or not periodic."""
    edges = two_octave_bands(frequencies)
    if np.isnan(factor):
        nothing = np.full(edges.size - 1, np.nan)
        levels = DistortionLevels(edges, *4 * [nothing], *2 * [np.zeros(edges.size - 1, dtype=bool)])
    else:
        levels = distortion_levels(spectra, frequencies, period, factor, edges)
    columns = {f"{name}_level": ("band", getattr(levels, name)) for name in ("response", "noise", "even", "odd")}
    detected = {name: ("band", getattr(levels, name)) for name in ("even_detected", "odd_detected")}
    return xr.Dataset(columns | detected, {"band": edges[:-1], "band_end": ("band", edges[1:])})


def _not_periodic(period: float, usual: float) -> tuple[str, str]:
    period_words = (
        f"repeats every {period:.2f} s, not every {usual:.2f} s as in the other windows"
        if period
        else "does not repeat"
    )
    return (
        f"the sweep {period_words}; its spectra are estimated as if it were not periodic, with larger variance",
        "Keep one periodic sweep through a window",
    )


def _too_short(needed: float) -> tuple[str, str]:
    return (
        f"is too short for a sweep that does not repeat in it: {needed:.0f} s are needed",
        "Lengthen windows.length_s or shorten spectra.segment_s",
    )


def _spectrograms(torque: Floats, speed: Floats, rate: float, segment: float, highest: float) -> xr.Dataset:
    frequencies, times, torque_power = spectrogram(torque, rate, segment, highest)
    dims = ("spectrogram_frequency", "spectrogram_time")
    return xr.Dataset(
        {
            "torque_spectrogram": (dims, torque_power.astype(np.float32)),
            "speed_spectrogram": (dims, spectrogram(speed, rate, segment, highest)[2].astype(np.float32)),
        },
        {"spectrogram_frequency": frequencies, "spectrogram_time": times},
    )
