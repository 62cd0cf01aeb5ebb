"""Recorders: each fault has the size that it states, and none where it has no size."""

import numpy as np
import pytest
from scipy.signal import butter, freqs

from drillid.arrays import Floats
from drillid.errors import SettingsError
from drillid.simulation.recorder import Recorder, Tone

FINE, ROW = 0.0025, 0.02
TIME = FINE * np.arange(40000, dtype=float)
ROWS = ROW * np.arange(5000, dtype=float)


def tone(time: Floats, frequency: float) -> Floats:
    return np.asarray(np.sin(2 * np.pi * frequency * time), dtype=float)


def amplitude(rows: Floats, frequency: float) -> complex:
    """Complex amplitude of a tone with a whole number of periods in the rows, relative to a sine."""
    return complex(2j * np.mean(rows * np.exp(-2j * np.pi * frequency * ROWS)))


def test_a_plain_recorder_takes_every_nth_sample() -> None:
    signal = np.random.default_rng(0).standard_normal(TIME.size)
    assert Recorder(ROW).record(signal, FINE).tobytes() == signal[::8].tobytes()
    sized = Recorder(ROW, np.inf, 4, 0.0, 0.0, (Tone(60.0, 0.0),), 0.0, 1.0, 0.0)
    assert sized.record(signal, FINE).tobytes() == signal[::8].tobytes()


def test_the_clock_shows_the_signal_late_and_later() -> None:
    rows = Recorder(ROW, clock_offset=0.013, clock_drift=1e-3).record(tone(TIME, 1.0), FINE)
    expected = tone(ROWS - 0.013 - 1e-3 * ROWS, 1.0)
    np.testing.assert_allclose(rows[5:], expected[5:], atol=1e-8)


@pytest.mark.parametrize("every", [2, 3, 5, 7])
def test_rows_hold_a_sample_from_its_own_time_until_the_next(every: int) -> None:
    rows = Recorder(ROW, held=every * ROW).record(TIME, FINE)
    np.testing.assert_allclose(rows, np.repeat(ROWS[::every], every)[: ROWS.size], atol=1e-9)


@pytest.mark.parametrize("order", [1, 2, 4])
def test_the_filter_has_its_corner_and_order(order: int) -> None:
    recorder = Recorder(ROW, filter_frequency=5.0, filter_order=order)
    whole = slice(2500, None)
    for frequency in (0.5, 5.0, 20.0):
        rows = recorder.record(tone(TIME, frequency), FINE)
        passed = abs(2 * np.mean(rows[whole] * np.exp(-2j * np.pi * frequency * ROWS[whole])))
        # the trapezoidal rule warps what is fast beside the samples
        ratio = np.tan(np.pi * frequency * FINE) / (np.pi * 5.0 * FINE)
        assert passed == pytest.approx(1 / np.sqrt(1 + ratio ** (2 * order)), rel=0.01)


@pytest.mark.parametrize("order", [1, 2])
def test_the_filter_lags_as_an_analog_one_does(order: int) -> None:
    recorder = Recorder(ROW, filter_frequency=0.2 / FINE, filter_order=order)
    whole, frequency = slice(2500, None), 2.0
    rows = recorder.record(tone(TIME, frequency), FINE)
    response = np.mean(rows[whole] * np.exp(-2j * np.pi * frequency * ROWS[whole]))
    sent = np.mean(tone(ROWS, frequency)[whole] * np.exp(-2j * np.pi * frequency * ROWS[whole]))
    numerator, denominator = butter(order, 0.4 * np.pi / FINE, analog=True)
    _, expected = freqs(numerator, denominator, [2 * np.pi * frequency])
    assert abs(response / sent - expected[0]) < 1e-4


def test_a_tone_above_half_the_row_rate_is_aliased_unless_filtered() -> None:
    """53 Hz in rows of 50 Hz is 3 Hz."""
    signal = np.zeros(TIME.size)
    aliased = Recorder(ROW, tones=(Tone(53.0, 0.4),)).record(signal, FINE)
    assert abs(amplitude(aliased, 3.0)) == pytest.approx(0.4, rel=1e-9)
    filtered = Recorder(ROW, filter_frequency=10.0, filter_order=4, tones=(Tone(53.0, 0.4),)).record(signal, FINE)
    assert abs(amplitude(filtered, 3.0)) < 1e-3


def test_a_tone_between_the_samples_of_the_signal_keeps_its_size() -> None:
    rows = Recorder(ROW, clock_offset=FINE / 2, tones=(Tone(53.0, 0.4),)).record(np.zeros(2000), FINE)
    time = ROW * np.arange(rows.size) - FINE / 2
    assert rows == pytest.approx(0.4 * np.sin(2 * np.pi * 53.0 * time))


def test_resolution_is_the_step_of_the_rows() -> None:
    rows = Recorder(ROW, resolution=0.03).record(tone(TIME, 0.1), FINE)
    np.testing.assert_allclose(rows / 0.03, np.rint(rows / 0.03), atol=1e-9)
    error = rows - tone(ROWS, 0.1)
    assert np.abs(error).max() <= 0.015 * (1 + 1e-9)
    assert error.std() == pytest.approx(0.03 / np.sqrt(12), rel=0.05)


def test_scale_and_sign_are_those_stated() -> None:
    np.testing.assert_allclose(Recorder(ROW, scale=-1.3558).record(TIME, FINE), -1.3558 * ROWS)


def test_noise_has_its_size_and_seed() -> None:
    recorder = Recorder(ROW, noise=0.2)
    first, again, other = (recorder.record(0 * TIME, FINE, np.random.default_rng(seed)) for seed in (1, 1, 2))
    assert first.std() == pytest.approx(0.2, rel=5 / np.sqrt(2 * first.size))
    assert np.array_equal(first, again)
    assert not np.array_equal(first, other)


@pytest.mark.parametrize(
    ("recorder", "message"),
    [
        (Recorder(0.021), "not a whole number"),
        (Recorder(ROW, filter_frequency=300.0), "cannot act on samples"),
        (Recorder(ROW, noise=0.1), "needs a random generator"),
    ],
)
def test_unusable_recorders_are_refused(recorder: Recorder, message: str) -> None:
    with pytest.raises(SettingsError, match=message):
        recorder.record(TIME, FINE)
