"""The field well's measured start of rotation, and the misfit of a simulation."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from drillid.arrays import Floats
from drillid.errors import LogError
from drillid.simulation.start_up import RATE
from drillid.simulation.start_up_files import read_table
from drillid.units import RPM


@dataclass(frozen=True, eq=False)
class FieldLog:
    """The measured start of rotation, (samples,) at RATE, with the authors' own simulation of it."""

    top_speed: Floats
    """rad/s."""
    torque: Floats
    """N m."""
    bit_slowest: Floats
    """rad/s, least in each half second; NaN before the sensor's first statistics."""
    bit_fastest: Floats
    """rad/s, greatest in each half second."""
    authors_torque: Floats
    """N m."""
    authors_bit_speed: Floats
    """rad/s."""


def read_field_log(path: Path) -> FieldLog:
    """The digitised log of well B.

    Raises
    ------
    LogError
        If the file lacks a column or is not sampled at RATE.
    """
    measured = ("td_rpm_measured", "torque_knm_measured", "bit_rpm_min_measured", "bit_rpm_max_measured")
    names = (*measured, "torque_knm_model", "bit_rpm_model")
    table = read_table(path, ("t_s", *names))
    if not np.allclose(table["t_s"], np.arange(len(table)) / RATE, atol=1e-6):
        raise LogError(str(path), "it is not sampled at 100 Hz from 0 s", "Give the digitised log")
    units = (RPM, 1e3, RPM, RPM, 1e3, RPM)
    return FieldLog(*(table[name].to_numpy(float) * unit for name, unit in zip(names, units, strict=True)))


@dataclass(frozen=True)
class Misfit:
    """Deviations of a simulation from the log over an interval of time."""

    torque_rms: float
    """kN m."""
    bit_rms: float
    """rpm, of the bit speed from the middle of the half-second extremes, as in the authors' 41.8 rpm."""
    extremes_rms: float
    """rpm, of the simulated half-second extremes from the measured ones, both together."""


def misfit(log: FieldLog, torque: Floats, bit_speed: Floats, first: float = 0.0, last: float = 45.0) -> Misfit:
    """Misfit of a simulation between two times, s, over the measured samples."""
    from scipy.ndimage import maximum_filter1d, minimum_filter1d

    span = slice(round(first * RATE), min(round(last * RATE) + 1, torque.size))
    width = round(RATE / 2)
    middle = (log.bit_slowest + log.bit_fastest) / 2
    slowest, fastest = minimum_filter1d(bit_speed, width), maximum_filter1d(bit_speed, width)
    size = torque.size
    extremes = np.concatenate([(slowest - log.bit_slowest[:size])[span], (fastest - log.bit_fastest[:size])[span]])
    return Misfit(
        _rms((torque - log.torque[:size])[span]) / 1e3,
        _rms((bit_speed - middle[:size])[span]) / RPM,
        _rms(extremes) / RPM,
    )


def _rms(values: Floats) -> float:
    return float(np.sqrt(np.nanmean(values**2)))
