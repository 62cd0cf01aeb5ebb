"""Even and odd distortion is detected at the stated error rate, each in its own place."""

import numpy as np
import pytest
from scipy.fft import rfft
from scipy.signal import lfilter
from scipy.stats import binom

from drillid.errors import EstimationError
from drillid.excitation.torques import SWEEP_BANDS, exponential_sweeps, linear_sweep
from drillid.spectra.distortion import DistortionLevels, distortion_levels, sweep_rate
from drillid.spectra.periodic import line_spectra

RATE, PERIOD = 50.0, 120.0
TIME = np.arange(int(600 * RATE)) / RATE
FREQUENCY = np.arange(6, 468) / PERIOD
EDGES = np.array([0.05, 0.215, 0.93, 2.0, 3.9])
SWEEP = exponential_sweeps(TIME, 500.0, period=PERIOD)


def spectrum(sweep: np.ndarray) -> np.ndarray:
    return rfft(sweep[: int(PERIOD * RATE)])[np.rint(FREQUENCY * PERIOD).astype(int)]


def levels(seed: int, driven: np.ndarray) -> DistortionLevels:
    noise = lfilter([1.0], [1.0, -1.97, 0.985], np.random.default_rng(seed).normal(size=2 * TIME.size))[-TIME.size :]
    speed = lfilter([0.0, 0.02, 0.01], [1.0, -1.7, 0.8], np.tile(driven, 2))[-TIME.size :] + 5.0 * noise
    spectra = line_spectra(SWEEP, speed, SWEEP, RATE, PERIOD, FREQUENCY, 40)
    return distortion_levels(spectra, FREQUENCY, PERIOD, sweep_rate(spectrum(SWEEP), FREQUENCY, PERIOD), EDGES)


def test_the_rate_of_the_sweep_is_found_and_a_linear_sweep_is_refused() -> None:
    lower, upper = SWEEP_BANDS[1]
    assert sweep_rate(spectrum(SWEEP), FREQUENCY, PERIOD) == pytest.approx(PERIOD / np.log(upper / lower), rel=0.01)
    with pytest.raises(EstimationError, match="not exponential"):
        sweep_rate(spectrum(linear_sweep(TIME, 500.0, (0.05, 4.0), PERIOD)), FREQUENCY, PERIOD)


def test_a_linear_system_shows_distortion_at_most_at_the_error_rate() -> None:
    found = [levels(seed, SWEEP) for seed in range(80)]
    windows = sum(bool(one.even_detected.any() or one.odd_detected.any()) for one in found)
    assert binom.sf(windows - 1, 80, 0.01) > 1e-3
    assert np.isnan(found[0].even[0])  # too few lines below 0.215 Hz


def test_squares_show_as_even_and_cubes_as_odd() -> None:
    even, odd = levels(3, SWEEP + 1e-3 * SWEEP**2), levels(3, SWEEP + 2e-6 * SWEEP**3)
    assert even.even_detected[2:].all()
    assert odd.odd_detected[1:].all()
    assert np.all(even.even[1:] > 2 * even.odd[1:])
    assert np.all(odd.odd[1:3] > 2 * odd.even[1:3])
