"""Even and odd distortion of a periodic exponential sweep, from its early arrival in the impulse response."""

from __future__ import annotations

import itertools
from dataclasses import dataclass

import numpy as np
from scipy.fft import irfft

from drillid.arrays import Booleans, Complex, Floats
from drillid.errors import EstimationError
from drillid.spectra.cross_spectra import Spectra

_EXPONENTIAL = 0.8
"""Alignment of group delay with the logarithm of frequency below which a sweep is not exponential."""
_RATES = np.arange(0.05, 4.0, 0.002)
"""Grid of rates, periods of the sweep per factor e of frequency."""
_LEAST_LINES = 40
"""Lines of a band below which the time resolution of its impulse response does not separate arrivals."""
_WIDTH = 0.06
"""Share of the period after the arrival of a distortion over which its power is summed."""


@dataclass(frozen=True, eq=False)
class DistortionLevels:
    """Root mean square of the speed by bands, rad/s, each (band,)."""

    edges: Floats
    """(band + 1,) Hz."""
    response: Floats
    noise: Floats
    """Noise in the mean of all periods."""
    even: Floats
    """Even-order distortion in excess of the noise; 0 where there is no excess, NaN in bands of too few lines."""
    odd: Floats
    even_detected: Booleans
    """Whether even-order distortion is detected, at the error rate shared among bands and orders."""
    odd_detected: Booleans


def sweep_rate(cross_phase: Complex, frequencies: Floats, period: float) -> float:
    """Time in which a periodic exponential sweep passes a factor e of frequency, s.

    Parameters
    ----------
    cross_phase : (frequency,) sweep's spectrum at successive harmonics of the period
    frequencies : (frequency,) Hz
    period : s

    Raises
    ------
    EstimationError
        If the group delay is not that of an exponential sweep.
    """
    turn = cross_phase[1:] * np.conj(cross_phase[:-1])
    # the group delay modulo the period, as a phase
    share = np.conj(turn) / np.maximum(np.abs(turn), np.finfo(float).tiny)
    middle = np.log(np.sqrt(frequencies[1:] * frequencies[:-1]))
    alignment = np.abs(np.exp(-2j * np.pi * np.outer(_RATES, middle)) @ share) / middle.size
    best = int(np.argmax(alignment))
    if alignment[best] < _EXPONENTIAL:
        raise EstimationError("distortion levels", "the sweep is not exponential", "Use an odd multisine instead")
    return float(_RATES[best] * period)


def distortion_levels(
    spectra: Spectra, frequencies: Floats, period: float, rate: float, edges: Floats, error_rate: float = 0.01
) -> DistortionLevels:
    """Levels of even and odd distortion and noise, with detection at a stated error rate.

    Order n of an exponential sweep is the sweep itself, earlier by `rate` ln n, so that in the
    impulse response of each band it precedes the linear part (Farina 2000). The power there is
    compared with the noise's variance (F-test); bands of fewer than 40 lines have too little time
    resolution. Order two stands for even, three for odd. The linear response must have decayed
    before the arrivals, modulo the period.

    Parameters
    ----------
    spectra : of a periodic sweep, (frequency,)
    frequencies : (frequency,) Hz, successive harmonics
    period : s
    rate : s, of `sweep_rate`
    edges : (band + 1,) Hz
    """
    bands = [(frequencies >= low) & (frequencies < high) for low, high in itertools.pairwise(edges)]
    line = spectra.cross_speed / np.sqrt(spectra.sweep_power)
    response = np.sqrt([np.sum(np.abs(line[band]) ** 2) / 2 for band in bands])
    noise = np.array([np.sum((spectra.speed_noise / spectra.averages)[band]) / 2 for band in bands])
    powers, detected = np.empty((2, len(bands))), np.empty((2, len(bands)), dtype=bool)
    p_value = error_rate / detected.size
    for number, band in enumerate(bands):
        for order in (2, 3):
            excess, significant = _arrival(spectra, frequencies, band, period, rate * np.log(order), p_value)
            powers[order - 2, number], detected[order - 2, number] = excess * noise[number], significant
    levels = np.sqrt(np.maximum(powers, 0))
    return DistortionLevels(edges, response, np.sqrt(noise), levels[0], levels[1], detected[0], detected[1])


def _arrival(
    spectra: Spectra, frequencies: Floats, band: Booleans, period: float, early: float, p_value: float
) -> tuple[float, bool]:
    """Power that arrives earlier by `early` (s), in excess of the noise, per the band's noise; and whether detected."""
    from scipy.special import fdtri

    count = np.count_nonzero(band)
    if count < _LEAST_LINES:
        return np.nan, False
    lines = np.rint(frequencies * period).astype(int)
    spectrum = np.zeros(2 * int(lines[-1]) + 1, dtype=complex)
    # tapered, and not weighted by the sweep's uneven power, so that the strong linear part does not spread in time
    taper = np.hanning(count + 2)[1:-1]
    spectrum[lines[band]] = taper * (spectra.cross_speed / spectra.sweep_power)[band]
    noise = taper**2 * (spectra.speed_noise / spectra.averages / spectra.sweep_power)[band]
    samples = 2 * (spectrum.size - 1)
    power = irfft(spectrum, samples) ** 2 * samples**2 / (2 * np.sum(noise))
    inside = np.mod(np.arange(samples) / samples * period + early, period) < _WIDTH * period
    ratio = float(power[inside].mean())
    freedom = 2 * _WIDTH * np.sum(noise) ** 2 / np.sum(noise**2)
    shared = spectra.degrees_of_freedom / np.maximum(spectra.averages - 1, 1)
    noise_freedom = 2 * count / float(np.mean(shared)) * float(np.mean(spectra.degrees_of_freedom))
    return (ratio - 1) * _WIDTH, bool(ratio > fdtri(freedom, noise_freedom, 1 - p_value))


def two_octave_bands(frequencies: Floats) -> Floats:
    """Edges of equal bands of two octaves or more over a frequency grid, (band + 1,) Hz."""
    count = max(1, int(np.log2(frequencies[-1] / frequencies[0]) / 2))
    edges = np.geomspace(frequencies[0], frequencies[-1], count + 1)
    edges[0], edges[-1] = edges[0] * (1 - 1e-9), edges[-1] * (1 + 1e-9)
    return edges
