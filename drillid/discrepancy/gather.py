"""Evidence about a set of windows, from what the stages have made of a well and its rig's papers."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from drillid.discrepancy.evidence import Conditions, Evidence, Knowledge, Sign
from drillid.discrepancy.signs import WindowRecord, read_signs
from drillid.estimation import Prior
from drillid.fits import speed_controller
from drillid.physics.equipment import Controller, polar_moment
from drillid.physics.model import DELAY, INERTIA_TD, LENGTH, POLAR_MOMENT, KnownEquipment
from drillid.schema import PARAMETERS, Gate
from drillid.windows import sample_rate

if TYPE_CHECKING:
    from drillid.rig import Rig

Floats = NDArray[np.float64]

_CLOCK_ERROR = 0.002
"""s, between channels of one log whose rows were put on one grid."""


def gather_well(
    rig: Rig, records: xr.Dataset, windows: xr.Dataset, spectra: xr.Dataset, mobility: xr.Dataset, fits: xr.Dataset
) -> Evidence:
    """Evidence from the datasets of a well's stages; every dataset holds the same windows.

    Signs are read where a window has a fit. The windows must share one bottom-hole assembly.
    """
    depth = windows["bit_depth"].values
    controller = speed_controller(rig, spectra)
    knowledge = rig_knowledge(rig, controller, float(np.nanmedian(depth)))
    conditions = Conditions(
        *(
            windows[name].values.astype(float)
            for name in ("hole_depth", "bit_depth", "speed", "torque", "weight_on_bit")
        )
    )
    rate, known = sample_rate(records), known_equipment(knowledge)
    fitted = fits["value"].values
    kept = []
    for row in range(depth.size):
        first, samples = int(windows["first_sample"][row]), int(windows["samples"][row])
        sweep, speed, command = (
            np.asarray(records[name][first : first + samples].values, dtype=float)
            for name in ("torque_sweep", "speed", "torque_command")
        )
        finite = all(np.isfinite(values).all() for values in (fitted[row], sweep, speed))
        period = float(spectra["sweep_period"][row])
        kept.append(WindowRecord(sweep, speed, command, rate, period, fitted[row], known) if finite else None)
    return assembled(mobility, conditions, knowledge, fitted, all_signs(kept))


def rig_knowledge(rig: Rig, controller: Controller, bit_depth: float) -> Knowledge:
    """What the papers of a rig say with the bit at `bit_depth` (m); `controller` is theirs, or read from the log."""
    collars, pipe, inertia, delay = rig.collars_at(bit_depth), rig.pipe, rig.top_drive_inertia, rig.drive_delay
    told: dict[str, float] = {"controller_relative": rig.controller.relative if rig.controller else np.inf}
    if collars:
        told["collar_length"], told["collar_relative"] = collars.length, collars.relative
        told["collar_polar_moment"] = polar_moment(collars.outer_diameter, collars.inner_diameter)
    if delay:
        told["delay"], told["delay_error"] = delay.value, delay.tolerance
    if inertia:
        told["inertia_td"], told["inertia_td_error"] = inertia.value, inertia.relative * inertia.value
    if pipe:
        moment = polar_moment(pipe.outer_diameter, pipe.inner_diameter)
        told["polar_moment"], told["polar_moment_error"] = moment, pipe.relative * moment
        told["length_relative"] = pipe.length_relative
    return Knowledge(controller, clock_error=_CLOCK_ERROR, **told)


def known_equipment(knowledge: Knowledge) -> KnownEquipment:
    """What a fit of one window takes as given."""
    return KnownEquipment(knowledge.controller, knowledge.collar_length, knowledge.collar_polar_moment)


def prior(knowledge: Knowledge, bit_depth: float) -> Prior:
    """What a fit of one window takes from the papers, with the bit at `bit_depth` (m)."""
    length = bit_depth - knowledge.collar_length
    known = {
        LENGTH: (length, knowledge.length_relative * length),
        POLAR_MOMENT: (knowledge.polar_moment, knowledge.polar_moment_error),
        DELAY: (knowledge.delay, knowledge.delay_error),
        INERTIA_TD: (knowledge.inertia_td, knowledge.inertia_td_error),
    }
    value, error = np.full((2, len(PARAMETERS)), np.nan)
    for place, (figure, deviation) in known.items():
        if np.isfinite(deviation):
            value[place], error[place] = figure, deviation
    return Prior(value, error)


def all_signs(records: Sequence[WindowRecord | None]) -> tuple[Sign, ...]:
    """Signs of all windows that have a fit; None stands for one without."""
    read = (read_signs(record, window) for window, record in enumerate(records) if record is not None)
    return tuple(sign for signs in read for sign in signs)


def assembled(
    mobility: xr.Dataset, conditions: Conditions, knowledge: Knowledge, fitted: Floats, signs: tuple[Sign, ...]
) -> Evidence:
    """Evidence from mobilities (window, frequency) and the eight parameters of each window, (window, 8)."""
    control = mobility["control_response"].values
    logged = bool(np.isfinite(control).any())
    return Evidence(
        frequency=mobility["frequency"].values,
        mobility=mobility["command_mobility"].values,
        variance=mobility["command_mobility_variance"].values,
        degrees_of_freedom=mobility["degrees_of_freedom"].values,
        used=mobility["gate"].values == Gate.USED,
        conditions=conditions,
        knowledge=knowledge,
        fitted=fitted,
        control=control if logged else None,
        control_variance=mobility["control_response_variance"].values if logged else None,
        signs=signs,
    )
