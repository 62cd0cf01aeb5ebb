"""Everything identified in a well, indexed by depth, and the fleet's table of it."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import pandas as pd
import xarray as xr
from numpy.typing import NDArray

from drillid.arrays import Floats
from drillid.datasets.codes import RigState
from drillid.datasets.reuse import completed, row_keys
from drillid.datasets.store import Problem, WellFolders, windows_place
from drillid.depth.responses import RESPONSES, identified_models, identified_responses
from drillid.depth.speed_control import VARIABLES, speed_control, tuned_rows
from drillid.discrepancy.products.extended_model import identified_window_models
from drillid.fits.datasheet import stored_controllers
from drillid.physics.parameters import PARAMETERS
from drillid.windows.channels import sample_rate

if TYPE_CHECKING:
    from drillid.config.listing import Well
    from drillid.config.settings import Settings
    from drillid.discrepancy.catalogue import WindowModel


_BLOCK = 1_000_000
"""Number of samples of the states in memory at once."""
_JOINT_ENDS = {"": "value", "_lower": "lower", "_upper": "upper"}
"""Endings of the variables from the joint fit, and the variables of its dataset."""


def _unstable(dataset: xr.Dataset) -> list[Problem]:
    """A row for the windows that have a model but no step response."""
    modelled = np.isfinite(dataset["bit_mobility_controlled"].values).all(axis=1)
    placed = dataset.rename(depth="hole_depth")
    return [
        Problem(
            f"{windows_place(placed, rows)}, {name}",
            "the identified system is unstable, so that its step response grows without limit",
            "See the verdict on the window: a cause that feeds vibration exceeds all damping there",
        )
        for name in ("bit_step_stiff", "bit_step_controlled")
        if (rows := np.flatnonzero(modelled & np.isnan(dataset[name].values).any(axis=1)).tolist())
    ]


def parameter_variables(fits: xr.Dataset) -> dict[str, tuple[str, Floats]]:
    """A variable for each parameter and its standard error, along depth."""
    named = {name: fits.sel(parameter=name) for name in PARAMETERS}
    values = {name: ("depth", row["value"].values) for name, row in named.items()}
    errors = {f"{name}_error": ("depth", row["standard_error"].values) for name, row in named.items()}
    return values | errors | {f"{name}_at_bound": ("depth", row["at_bound"].values) for name, row in named.items()}


def joint_variables(joint: xr.Dataset) -> dict[str, tuple[str, Floats]]:
    """A variable for each parameter from all windows together, with the ends of its 95 % band, along depth."""
    return {
        f"{name}_joint{suffix}": ("depth", joint[variable].sel(parameter=name).values)
        for name in PARAMETERS
        for suffix, variable in _JOINT_ENDS.items()
    }


def parameters_for_settings(fits: xr.Dataset, joint: xr.Dataset) -> Floats:
    """Parameters from all windows together, (window, 8), or from the window alone where those do not give all eight.

    Settings tuned to these change with depth as the string does, and not with the noise of single windows.
    """
    together = joint["value"].values
    return np.asarray(np.where(np.isnan(together).any(axis=1, keepdims=True), fits["value"].values, together))


def time_in_states(states: xr.Dataset, windows: xr.Dataset) -> Floats:
    """Time in each state of the rig from the previous window's end to each window's end, s, shape (window, state)."""
    ends, total = (windows["first_sample"] + windows["samples"]).values, len(RigState)
    counted = np.zeros(ends.size * total, dtype=int)
    for begin in range(0, int(ends[-1]) if ends.size else 0, _BLOCK):
        part = states["rig_state"][begin : min(begin + _BLOCK, int(ends[-1]))].values
        window = np.searchsorted(ends, np.arange(begin, begin + part.size), side="right")
        counted += np.bincount(total * window + part, minlength=counted.size)
    return counted.reshape(-1, total) / sample_rate(states)


def process(well: Well, folders: WellFolders, settings: Settings) -> list[Problem]:
    """The depth dataset and the parameter table of a well."""
    fits, mobility = folders.read("fits", "fits").load(), folders.read("mobility", "mobility").load()
    windows = folders.read("windows", "windows").load()
    discrepancy = folders.read("discrepancy", "discrepancy").load()
    examination, frequency = folders.read("discrepancy", "examination").load(), mobility["frequency"].values
    extended = identified_window_models(examination)
    controllers, bit_depth = stored_controllers(fits), windows["bit_depth"].values
    accepted, depths = fits["accepted"].values.astype(bool), fits["hole_depth"].values
    tuned, weight = tuned_rows(depths, accepted, settings.depth.tuning_interval_m), windows["weight_on_bit"].values
    joint = folders.read("fits", "joint").load()
    # none where no settings are sought
    steady = np.where(tuned[:, None], parameters_for_settings(fits, joint), np.nan)

    def models(rows: list[int], parameters: Floats) -> list[WindowModel | None]:
        named = {place: extended[row] for place, row in enumerate(rows) if row in extended}
        return identified_models(well.rig, [controllers[row] for row in rows], parameters[rows], bit_depth[rows], named)

    def make(rows: list[int]) -> xr.Dataset:
        own = models(rows, fits["value"].values)
        responses = identified_responses(own, frequency, settings.depth)
        drilled_by = [model if accepted[row] else None for row, model in zip(rows, own, strict=True)]
        sought = [model if tuned[row] else None for row, model in zip(rows, models(rows, steady), strict=True)]
        controlled = speed_control(drilled_by, sought, weight[rows], settings.depth)
        return responses.assign({name: ("depth", values) for name, values in controlled.items()})

    # the models of windows in which a cause is named are those of their sets
    of_sets = examination["key"].values
    sets = [str(of_sets[number]) for number in examination["window_set"].values.tolist()] if of_sets.size else []
    own = (fits["key"].values, bit_depth, weight, tuned, steady)
    contents = [
        (*content, sets[row] if row in extended else "")
        for row, content in enumerate(zip(*(values.tolist() for values in own), strict=True))
    ]
    earlier = folders.earlier("depth", "depth")
    earlier = None if earlier is None else earlier.reset_coords()[[*RESPONSES, *VARIABLES, "key"]]
    responses = completed(earlier, row_keys(folders.basis, contents, frequency.tolist()), "depth", make)
    copied = {
        **{name: mobility[name] for name in ("command_mobility", "command_mobility_variance", "coherence", "gate")},
        **{name: fits[name] for name in ("chi2_per_dof", "accepted")},
        **{name: discrepancy[name] for name in ("damping_pull", "inertia_pull", "flagged", "verdict")},
    }
    dataset = responses.assign(
        {name: (("depth", *variable.dims[1:]), variable.values) for name, variable in copied.items()}
        | parameter_variables(fits)
        | joint_variables(joint)
        | {"state_time": (("depth", "state"), time_in_states(folders.read("windows", "states"), windows))}
    ).assign_coords(
        {name: ("depth", fits[name].values) for name in ("window", "start", "end")}
        | {
            "frequency": frequency,
            "depth": fits["hole_depth"].values,
            "state": [state.name.lower() for state in RigState],
        }
    )
    folders.write("depth", "depth", dataset)
    folders.write_table("depth", "parameters", parameter_table(dataset, fits["reason"].values))
    return _unstable(dataset)


def parameter_table(depth: xr.Dataset, reasons: NDArray[np.str_]) -> pd.DataFrame:
    """Parameters with errors, and verdicts, one row per window; units in the column names."""
    columns = {"window": depth["window"].values, "start": depth["start"].values, "depth [m]": depth["depth"].values}
    for name, (unit, _) in PARAMETERS.items():
        columns[f"{name} [{unit}]"] = depth[name].values
        columns[f"{name}_error [{unit}]"] = depth[f"{name}_error"].values
        columns[f"{name}_at_bound"] = depth[f"{name}_at_bound"].values
        columns |= {f"{name}_joint{end} [{unit}]": depth[f"{name}_joint{end}"].values for end in _JOINT_ENDS}
    verdicts = ("chi2_per_dof", "accepted", "damping_pull", "inertia_pull", "flagged", "verdict")
    return pd.DataFrame(columns | {name: depth[name].values for name in verdicts} | {"reason": reasons})
