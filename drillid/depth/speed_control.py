"""How steadily the identified system drills: its stability against stick-slip, and settings of the speed control."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from drillid.arrays import Booleans, Floats
from drillid.control.stick_slip import critical_slope, lowest_stable_speed
from drillid.control.tuning import first_sample, tune
from drillid.errors import EstimationError, UnstableControlError
from drillid.physics.nonlinear import Cutting, Weakening
from drillid.units import RPM

if TYPE_CHECKING:
    from drillid.config.settings import DepthSettings
    from drillid.discrepancy.catalogue import WindowModel
    from drillid.physics.equipment import DrillingSystem


VARIABLES = (
    *("critical_slope", "critical_frequency", "lowest_stable_speed"),
    *("present_proportional", "present_integral"),
    *("tuned_proportional", "tuned_integral", "tuned_vibration"),
)


def speed_control(
    models: Sequence[WindowModel | None], joint: Sequence[WindowModel | None], weight: Floats, settings: DepthSettings
) -> dict[str, Floats]:
    """The VARIABLES of the depth dataset, each (depth,); NaN where they are not sought, and without a model.

    Parameters
    ----------
    models : of each depth; None without an accepted fit
    joint : models of all windows together, which differ less from depth to depth than the noise of single windows, for
        the settings; None where none are sought; see `tuned_rows`
    weight : shape (depth,), N on the bit; NaN where it is not logged
    """
    rock = Cutting(settings.bit_torque_slow_m, settings.bit_torque_fast_m, Weakening(settings.bit_torque_rpm * RPM))
    values = {name: np.full(weight.size, np.nan) for name in VARIABLES}
    for row, (own, shared) in enumerate(zip(models, joint, strict=True)):
        found: dict[str, float] = {}
        if own is not None:
            system = first_sample(own.continuous_system)
            found |= _stability(system, rock, float(weight[row])) | _present(system)
        if shared is not None:
            system = first_sample(shared.continuous_system)
            found |= _present(system) | _settings(system)
        for name, value in found.items():
            values[name][row] = value
    return values


def tuned_rows(depth: Floats, accepted: Booleans, interval_m: float) -> Booleans:
    """The last accepted window of every interval of depth, shape (depth,), as settings change slowly with depth."""
    rows = np.flatnonzero(accepted)[::-1]
    last = np.zeros(depth.size, dtype=bool)
    last[rows[np.unique(np.floor(depth[rows] / interval_m), return_index=True)[1]]] = True
    return last


def _stability(system: DrillingSystem, rock: Cutting, weight: float) -> dict[str, float]:
    """Critical fall of torque, and the speed below which the rock's law falls faster; infinite where it always does.

    Under a control that is unstable without the rock no speed is stable, and no fall of torque is the critical one.
    """
    try:
        slope, frequency = critical_slope(system)
    except UnstableControlError:
        return {"lowest_stable_speed": np.inf}
    except EstimationError:
        # no fall of torque destabilises it, or it lies at the limit of stability
        return {}
    stability = {"critical_slope": slope, "critical_frequency": frequency}
    if slope < 0:
        # the bit feeds vibration by itself, whatever the weight on it
        stability["lowest_stable_speed"] = np.inf
    elif np.isfinite(weight) and weight > 0:
        try:
            stability["lowest_stable_speed"] = lowest_stable_speed(rock, weight, slope)
        except EstimationError:
            stability["lowest_stable_speed"] = np.inf
    return stability


def _present(system: DrillingSystem) -> dict[str, float]:
    """Gains of the model, with what is named of the speed control."""
    controller = system.top_drive.controller
    return {"present_proportional": controller.proportional, "present_integral": controller.integral}


def _settings(system: DrillingSystem) -> dict[str, float]:
    """Gains of proportional and integral control with the least peak of the bit's mobility."""
    try:
        tuning = tune(system)
    except EstimationError:
        return {}
    controller = tuning.controller
    return {
        "tuned_proportional": controller.proportional,
        "tuned_integral": controller.integral,
        "tuned_vibration": tuning.value / tuning.present,
    }
