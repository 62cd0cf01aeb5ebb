"""Spikes and runs of samples, and the quantisation step of a channel among rows that are not on it."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from drillid.records.quality import quantisation_step, runs, spikes, stuck
from tests.raw_logs import RATE


def test_the_quantisation_step_is_found_among_interpolated_rows() -> None:
    generator = np.random.default_rng(1)
    values = 0.03 * np.rint((10 + 0.3 * generator.standard_normal(5000)) / 0.03)
    values[::10] = (values[1::10] + values[2::10] + generator.uniform(0, 0.03, 500)) / 2
    assert quantisation_step(values) == pytest.approx(0.03, rel=1e-6)
    assert quantisation_step(generator.standard_normal(5000)) is None


def test_spikes_of_noise_stay_within_the_error_rate() -> None:
    noise = np.random.default_rng(6).normal(size=1_000_000)
    assert spikes(noise, RATE, 1e-4).sum() <= 100 + 4 * 10


@given(height=st.floats(0.5, 1e3), at=st.integers(10, 2980), width=st.integers(1, 3))
@settings(max_examples=60, deadline=None)
def test_steps_and_kinks_are_no_spikes_but_spikes_on_them_are(height: float, at: int, width: int) -> None:
    noise = np.random.default_rng(7).normal(0, 0.01, 3000)
    place = np.arange(3000)
    assert not spikes(np.where(place < at, height, 0.0) + noise, RATE, 1e-6)[max(0, at - 4) : at + 4].any()
    assert not spikes(np.abs(place - at) * height + noise, RATE, 1e-6)[max(0, at - 4) : at + 4].any()
    bump = noise.copy()
    bump[at : at + width] += height
    assert spikes(bump, RATE, 1e-6)[at : at + width].all()


def test_runs() -> None:
    assert runs(np.array([True, False, True, True])).tolist() == [[0, 1], [2, 4]]
    assert runs(np.zeros(3, dtype=bool)).size == 0


@pytest.mark.parametrize(("samples", "found"), [(99, False), (100, False), (101, True)])
def test_a_sensor_is_stuck_once_it_keeps_a_value_longer_than_stated(samples: int, found: bool) -> None:
    signal = np.arange(1.0, 1001.0)
    signal[300 : 300 + samples] = signal[300]
    marks = stuck(signal, np.ones(1000, dtype=bool), RATE, longest_s=2.0)
    assert marks.tolist() == [found and 300 <= place < 300 + samples for place in range(1000)]


def test_a_value_of_zero_or_without_others_that_move_is_no_stuck_sensor() -> None:
    signal = np.arange(1.0, 1001.0)
    signal[300:600] = signal[300]
    assert not stuck(signal, np.zeros(1000, dtype=bool), RATE, longest_s=2.0).any()
    signal[300:600] = 0.0
    assert not stuck(signal, np.ones(1000, dtype=bool), RATE, longest_s=2.0).any()
