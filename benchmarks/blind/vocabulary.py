"""The words of verdicts and what the proof holds of them by itself: shared by generators and judge, not by the engine.

Causes, families and units are those of the vocabulary that the engine was asked to speak; bounds are physical ones.
"""

from typing import NamedTuple

import numpy as np
from scipy.special import ndtri

NONE, UNKNOWN = "none", "unknown"
ERROR_RATE = 0.05
"""Chance of a verdict other than none where nothing is wrong, as the engine is asked for it."""


class Known(NamedTuple):
    """A cause of the vocabulary."""

    family: str
    low: float
    """Bounds of its size."""
    high: float

    @property
    def fixed(self) -> bool:
        """Whether it has no size."""
        return self.low == self.high


CAUSES = {
    "drive_lag": Known("drive", 0.0, 0.3),
    "actuator_gain": Known("drive", -0.6, 1.0),
    "delay_jitter": Known("drive", 0.0, 4e-2),
    "torque_limit": Known("drive", 0.0, 1e5),
    "torque_rate_limit": Known("drive", 0.0, 1e6),
    "controller_gain": Known("control", -0.9, 3.0),
    "speed_filter": Known("control", 0.0, 0.5),
    "torque_filter": Known("control", 0.0, 0.5),
    "gear_backlash": Known("top", 0.0, 1.0),
    "speed_scale": Known("sensor", -0.4, 0.4),
    "sign_or_unit": Known("sensor", 1.0, 1.0),
    "clock_offset": Known("sensor", -1.0, 1.0),
    "clock_drift": Known("sensor", -1e-2, 1e-2),
    "recorder_filter": Known("sensor", 0.0, 0.3),
    "sample_and_hold": Known("sensor", 0.0, 0.5),
    "quantisation": Known("sensor", 0.0, 10.0),
    "aliased_tone": Known("sensor", 0.0, 1.0),
    "once_per_revolution": Known("sensor", 0.0, 0.5),
    "extra_section": Known("string", 0.0, 1000.0),
    "tapered_string": Known("string", -0.9, 4.0),
    "local_damping_zone": Known("string", 0.0, 5e3),
    "mud_drag": Known("string", 0.0, 5e3),
    "hysteretic_damping": Known("string", 0.0, 0.3),
    "coulomb_contact": Known("string", 0.0, 5e3),
    "wave_speed": Known("string", -0.3, 0.5),
    "distributed_bha": Known("bit", 0.0, 400.0),
    "motor_compliance": Known("bit", 0.0, 1e-3),
    "regenerative_cutting": Known("bit", 0.0, 3e4),
    "stribeck_cutting": Known("bit", 0.0, 5e3),
    "stuck_slip_regimes": Known("bit", 0.0, 5.0),
    "length_growth": Known("time", 0.0, 200.0),
    "parameter_drift": Known("time", -5e3, 5e3),
    "regime_change": Known("time", -5e3, 5e3),
}
"""All causes of the vocabulary."""
FACTORS = (-1.0, 1.3558, 0.73756, 0.11298, 8.8507, 9.8067, 0.10197, 9.5493, 0.10472, 6.2832, 0.15915)
"""A wrong sign; ft-lbf, in-lbf, kgf m, rpm and rev/s, taken for SI units or the reverse."""
ALIAS_HZ = (0.4, 8.0)
"""Where an aliased tone shows."""
RECORDED_RATE = 50.0
"""Hz, of the logs."""
DISTINGUISHED_SHARE = 0.95
"""Share of sets in which a test between two causes must be right for them to be distinguishable."""
DISTINCT = float(2 * ndtri(DISTINGUISHED_SHARE))
"""Standard deviations between two causes below which it is not."""
SMOOTH_FREEDOMS, PORTS = 24, 7
"""Degrees of freedom of a smooth disturbance over the band, and ports at which it may enter."""
CLOSURE_P_VALUE = 0.025
"""Least p-value at which an extended model passes the test of its residuals: half of the error rate."""


def nearest_factor(scale: float) -> float:
    """The factor of a wrong unit that is nearest to a scale."""
    return min((factor for factor in FACTORS if factor > 0), key=lambda factor: abs(np.log(scale / factor)))


def wrong_factor(shape: float) -> float:
    """One of the factors by which a channel's sign or unit is mistaken."""
    return FACTORS[min(int(shape * len(FACTORS)), len(FACTORS) - 1)]


def tone_frequency(shape: float) -> float:
    """Frequency of a tone that the recorder's rate folds into the band, Hz."""
    return float(RECORDED_RATE + ALIAS_HZ[0] * (ALIAS_HZ[1] / ALIAS_HZ[0]) ** shape)


def members(verdict: str) -> tuple[str, ...]:
    """Causes that a verdict names."""
    return () if verdict in (NONE, UNKNOWN) else tuple(verdict.split("|"))
