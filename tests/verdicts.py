"""A verdict of the discovery engine with all its figures."""

from drillid.discrepancy import Verdict

LAG = Verdict(
    "drive_lag",
    "drive",
    0.997,
    1800.0,
    1950.0,
    cause="drive_lag",
    size=0.0494,
    size_low=0.0489,
    size_high=0.0499,
    unit="s",
    predictive_gain=339.2,
    predictive_gain_low=309.6,
    predictive_gain_high=368.2,
    held_out_windows=12,
    evidence_nats=4070.0,
    what_would_separate="a sweep to higher frequency",
)
