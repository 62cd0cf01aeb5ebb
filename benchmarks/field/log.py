"""The field well's measured start of rotation."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from drillid.arrays import Floats
from drillid.errors import LogError
from drillid.simulation.start_up import RATE
from drillid.simulation.start_up_files import read_table
from drillid.simulation.start_up_fit import MeasuredStartUp
from drillid.units import RPM


@dataclass(frozen=True, eq=False)
class FieldLog(MeasuredStartUp):
    """The measured start of rotation, (samples,) at RATE, with the authors' own simulation of it."""

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
