"""The mean period of a noisy series with its error, what drives a speed over a period, and which lines are held out."""

import numpy as np
import pytest

from drillid.arrays import Complex, Floats
from drillid.discrepancy.inference.held_out_gain import every_other_line
from drillid.discrepancy.products.prediction import PHASES, at_phases, driven, mean_period

RATE = 50.0
ALL = (1e-6, RATE)


@pytest.mark.parametrize("periods", [4, 25])
def test_the_error_of_the_mean_period_falls_with_the_root_of_the_periods(periods: int) -> None:
    noise = 0.3 * np.random.default_rng(periods).standard_normal(periods * PHASES)
    mean, error = mean_period(noise, RATE, PHASES / RATE, ALL)
    assert error == pytest.approx(0.3 / np.sqrt(periods), rel=0.03)
    assert np.std(mean) == pytest.approx(0.3 / np.sqrt(periods), rel=0.05)


@pytest.mark.parametrize("amplitude", [0.0, 0.3])
def test_what_lies_beyond_the_band_is_no_error_of_the_mean(amplitude: float) -> None:
    """A tone that does not repeat with the sweep."""
    period, band, errors, spread = 60.0, (0.1, 3.0), [], []
    time = np.arange(round(10 * period * RATE)) / RATE
    for seed in range(20):
        generator = np.random.default_rng(seed)
        noise = 0.1 * generator.standard_normal(time.size)
        noise += amplitude * np.sin(2 * np.pi * (9.71 * time + generator.random()))
        mean, error = mean_period(noise, RATE, period, band)
        errors.append(error**2)
        spread.append(np.mean(mean**2))
    assert np.sqrt(np.mean(errors)) == pytest.approx(np.sqrt(np.mean(spread)), rel=0.2)


def test_the_mean_period_is_the_series_where_it_repeats_and_its_part_in_the_band() -> None:
    period = 24.0
    time = np.arange(round(3 * period * RATE)) / RATE
    series = np.sin(2 * np.pi * 5 * time / period) + 3
    mean, error = mean_period(series, RATE, period, (4.5 / period, 5.5 / period))
    expected = np.sin(2 * np.pi * 5 * np.arange(PHASES) / PHASES)
    np.testing.assert_allclose(at_phases(mean), expected, atol=5e-3)
    assert error < 1e-3
    outside, _ = mean_period(series, RATE, period, (6 / period, 9 / period))
    np.testing.assert_allclose(outside, 0.0, atol=1e-3)


@pytest.mark.parametrize("period", [60.0, 300.0])
def test_a_right_model_predicts_a_long_sweep_too(period: float) -> None:
    """The lines of 300 s to 5 Hz are more than half of the points that are stored."""

    def mobility(frequency: Floats) -> Complex:
        return np.asarray(1 / (1 + 2j * np.pi * frequency), dtype=complex)

    band, time = (0.05, 5.0), np.arange(round(2 * period * RATE)) / RATE
    phase = time % period
    sweep = np.sin(2 * np.pi * (0.1 * phase + 0.5 * (4.5 - 0.1) / period * phase**2))
    lines = np.fft.rfft(sweep)
    frequency = np.fft.rfftfreq(sweep.size, 1 / RATE)
    speed = np.fft.irfft(lines * mobility(frequency), sweep.size)
    given, measured = (mean_period(series, RATE, period, band)[0] for series in (sweep, speed))
    error = at_phases(measured - driven(mobility, given, period, band))
    assert np.std(error) < 0.01 * np.std(measured)


@pytest.mark.parametrize("lines", [slice(0, None), slice(0, None, 2), slice(1, None, 2)])
def test_half_of_the_lines_are_held_out_whichever_harmonics_a_sweep_has(lines: slice) -> None:
    used = np.zeros((2, 100), dtype=bool)
    used[:, lines] = True
    first, second = (every_other_line(used, part) for part in (0, 1))
    np.testing.assert_array_equal(first ^ second, used)
    np.testing.assert_allclose(first.sum(axis=1), used.sum(axis=1) / 2)
