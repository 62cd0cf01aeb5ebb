"""Small made-up rig logs for the tests of formats, records and windows."""

from pathlib import Path

import numpy as np
import pandas as pd

from drillid.config.rig import Rig

RATE = 50.0
START = pd.Timestamp("2025-03-03T06:00:00")
RIG = Rig.checked(
    {
        "name": "made up",
        "channels": {
            "torque_command": {"column": "TQ", "unit": "kN m"},
            "torque_sweep": {"column": "SWEEP", "unit": "kN m"},
            "speed": {"column": "RPM", "unit": "rpm"},
            "speed_set": {"column": "SET", "unit": "rpm"},
            "hole_depth": {"column": "HOLE", "unit": "ft"},
            "bit_depth": {"column": "BIT", "unit": "ft"},
            "flow": {"column": "FLOW", "unit": "L/min"},
        },
    },
    "made-up rig",
)


def sweep_at(seconds: np.ndarray) -> np.ndarray:
    """Three sweeps at once, repeated every 40 s, N m; continuous but for its kinks at each repeat."""
    phase = np.mod(seconds, 40.0)
    total = np.zeros_like(phase)
    for low, ratio in ((0.1, 4.0), (0.4, 4.0), (1.6, 2.5)):
        slope = np.log(ratio) / 40.0
        total += 300.0 * np.sin(2 * np.pi * low / slope * np.expm1(slope * phase))
    return np.asarray(total)


def drilling(seconds: float, seed: int = 1, depth: float = 2000.0, start: pd.Timestamp = START) -> pd.DataFrame:
    """An undamaged log of steady drilling in the units of `RIG`, its stamps in column Time."""
    at = np.arange(round(seconds * RATE)) / RATE
    noise = np.random.default_rng(seed)
    sweep = sweep_at(at + (start - START).total_seconds())
    rough = np.convolve(noise.normal(size=at.size + 24), np.hanning(25) / 3, "valid")
    hole = depth + at * 0.012
    return pd.DataFrame(
        {
            "Time": start + pd.to_timedelta(np.round(at * 1e9), unit="ns"),
            "TQ": 7.0 + sweep / 1e3 - 0.1 * rough,
            "SWEEP": sweep / 1e3,
            "RPM": 120.0 + 2.0 * rough + sweep * 2e-3 + noise.normal(0, 0.02, at.size),
            "SET": 120.0,
            "HOLE": hole / 0.3048,
            "BIT": hole / 0.3048,
            "FLOW": 2700.0,
        }
    )


def standstill(seconds: float, start: pd.Timestamp, depth: float) -> pd.DataFrame:
    """A connection: nothing turns or flows, the bit is lifted."""
    log = drilling(seconds, depth=depth, start=start)
    log[["TQ", "SWEEP", "RPM", "SET", "FLOW"]] = 0.0
    log["HOLE"] = depth / 0.3048
    log["BIT"] = (depth - np.minimum(12.0, 0.3 * np.arange(len(log)) / RATE)) / 0.3048
    return log


def save(log: pd.DataFrame, path: Path) -> Path:
    """Write a log in the format that its name asks for, stamps as UTC."""
    stamped = log.assign(Time=log["Time"].dt.tz_localize("UTC"))
    if path.suffix == ".parquet":
        stamped.to_parquet(path, index=False)
    else:
        stamped.assign(Time=stamped["Time"].map(lambda stamp: stamp.isoformat())).to_csv(path, index=False)
    return path
