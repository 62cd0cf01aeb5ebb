"""The window from which a law is learnt: which of its samples count."""

from typing import Any

import numpy as np

from drillid.discrepancy.learning.law_window import LawWindow


def test_every_whole_period_of_the_record_counts() -> None:
    """Though 603 samples at 10 Hz over 20.1 s are 2.9999999999999996 in floating point."""
    periods, samples, rate = 3, 201, 10.0
    sweep = np.tile(np.sin(2 * np.pi * np.arange(samples) / samples), periods)
    speed = np.repeat([1.0, 1.0, 4.0], samples)
    no_model: Any = None
    window = LawWindow.of(no_model, (sweep, speed), rate, samples / rate, (0.05, 3.0))
    assert window is not None
    assert abs(window.mean_speed - speed.mean()) < 0.01
