"""The field well's start of rotation: its description, fitted to the first 28 s, on the time after them."""

import numpy as np
from rich.console import Console

from benchmarks.field.log import read_field_log
from benchmarks.field.start_up import DATA, FITTED_S
from benchmarks.field.transfer import MODELS, SEEN_S, table
from benchmarks.parts import Measurement
from benchmarks.result import Result


def measure(console: Console) -> Measurement:
    """Misfit on held-out time, where the measurement is at hand."""
    if not DATA.is_file():
        console.print(f"the field log is not at {DATA}: nothing is measured")
        return Measurement()
    log = read_field_log(DATA)
    console.print(table(log))
    ((torque, bit),) = list(MODELS.values())[-1].misfits(log, [(SEEN_S, FITTED_S)])
    return Measurement(
        [
            Result(
                "field_torque_rms_knm", "torque of the field start on held-out time, kN m", float(torque), -np.inf, 3.0
            ),
            Result("field_bit_rms_rpm", "its bit speed, rpm", float(bit), -np.inf, 30.0),
        ]
    )
