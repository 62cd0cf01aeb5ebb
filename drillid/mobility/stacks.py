"""Command mobility of successive windows averaged where they agree."""

from __future__ import annotations

import functools
from typing import TYPE_CHECKING

import numpy as np
import xarray as xr

from drillid.datasets.codes import Gate
from drillid.datasets.memory import WellInMemory
from drillid.datasets.reuse import Memo, completed
from drillid.datasets.store import Problem, window_place
from drillid.statistics import sharing, sum_of_ratios_probability

if TYPE_CHECKING:
    from drillid.config.settings import MobilitySettings


def stack_windows(
    mobility: xr.Dataset, settings: MobilitySettings, memo: Memo | None = None, earlier: xr.Dataset | None = None
) -> tuple[xr.Dataset, list[Problem]]:
    """Stacks of successive windows that share no sample, each weighted by its variance.

    A stack grows window by window as long as all of its windows agree within their variances and
    the depth changes little; where the next one disagrees, the stack ends and a problem is
    recorded. The error rate is shared among the possible tests of one stack.

    Parameters
    ----------
    mobility : of all windows, with their keys where there is a memo
    memo : earlier findings about windows; None where nothing is kept
    earlier : stacks of an earlier run; those of the same windows are reused
    """
    stacks: list[tuple[list[int], float]] = []
    problems: list[Problem] = []
    bound = settings.agreement_error_rate / (settings.stack_windows - 1)
    content = mobility["key"].values.tolist() if memo else list(range(mobility.sizes["window"]))
    memo = memo or Memo(WellInMemory(), "mobility")
    gates, depth = mobility["gate"].values, mobility["hole_depth"].values
    rows = [row for row in _without_overlap(mobility) if (gates[row] == Gate.USED).any()]
    while len(rows) > 1:
        members, p_value = rows[:1], 1.0
        for row in rows[1 : settings.stack_windows]:
            if abs(depth[row] - depth[members[0]]) > settings.stack_depth_share * depth[row]:
                break
            joint = [*members, row]
            test = functools.partial(_agreement_of, mobility, joint)
            agreement = memo.result(memo.key("agreement", [content[each] for each in joint]), test)
            if not agreement >= bound:
                problems.append(_disagreement(mobility, members, row, agreement))
                break
            members, p_value = [*members, row], agreement
        if len(members) > 1:
            stacks.append((members, p_value))
        rows = rows[len(members) :]
    if not stacks:
        return _no_stacks(mobility), problems

    def make(missing: list[int]) -> xr.Dataset:
        made = [_stack(mobility.isel(window=members), p_value) for members, p_value in (stacks[row] for row in missing)]
        return xr.concat(made, "stack", coords="minimal", compat="override", join="exact")

    keys = [memo.key("stack", [content[row] for row in members]) for members, _ in stacks]
    made = completed(earlier, keys, "stack", make)
    numbers = mobility["window"].values
    return made.assign_coords(
        stack=np.arange(len(stacks)),
        frequency=mobility["frequency"],
        first_window=("stack", [int(numbers[members[0]]) for members, _ in stacks]),
        last_window=("stack", [int(numbers[members[-1]]) for members, _ in stacks]),
    ), problems


def _agreement_of(mobility: xr.Dataset, rows: list[int]) -> float:
    return agreement_p_value(mobility.isel(window=rows))


def _without_overlap(mobility: xr.Dataset) -> list[int]:
    """Rows of windows that begin after the previous one has ended."""
    chosen: list[int] = []
    for row, start in enumerate(mobility["start"].values):
        if not chosen or start >= mobility["end"].values[chosen[-1]]:
            chosen.append(row)
    return chosen


def agreement_p_value(windows: xr.Dataset) -> float:
    """p-value of the disagreement between windows (window, frequency) under one common mobility.

    Welch's test of equal means with estimated variances (1951) at each frequency, summed over them.
    """
    used = (windows["gate"] == Gate.USED).values.all(axis=0)
    if not used.any():
        return float("nan")
    mobility = windows["command_mobility"].values[:, used]
    variance = windows["command_mobility_variance"].values[:, used]
    freedom = windows["degrees_of_freedom"].values[:, used]
    weight = 1 / variance
    mean = np.sum(mobility * weight, axis=0) / np.sum(weight, axis=0)
    total = np.sum(np.abs(mobility - mean) ** 2 * weight, axis=0)
    contrasts = weight.shape[0] - 1
    spread = np.sum((1 - weight / weight.sum(axis=0)) ** 2 / (2 * freedom), axis=0)
    inflation = 1 + 2 * (contrasts - 1) / (contrasts * (contrasts + 2)) * spread
    pooled = contrasts * (contrasts + 2) / (6 * spread)
    shared = sharing(freedom, windows["averages"].values[:, used]).mean(axis=0) * contrasts
    return sum_of_ratios_probability(
        float(np.sum(total / inflation)), np.tile(pooled, contrasts), np.tile(shared, contrasts), fitted=0.0
    )


def _stack(windows: xr.Dataset, p_value: float) -> xr.Dataset:
    """Mean weighted by the estimated variances, whose errors are part of its variance (Meier 1953); its degrees of
    freedom by Satterthwaite (1946), Biometrics Bulletin 2, 110–114.
    """
    used = windows["gate"] == Gate.USED
    weight = xr.where(used, 1 / windows["command_mobility_variance"], 0.0)
    total = weight.sum("window")
    any_used = total > 0
    share = weight / total.where(any_used)
    mobility = (share * windows["command_mobility"]).sum("window").where(any_used)
    inflation = 1 + (2 * share * (1 - share) / windows["degrees_of_freedom"]).sum("window")
    variance = inflation / total.where(any_used)
    lines = _pooled(share, windows["averages"] - 1)
    signal = np.abs(mobility) ** 2 / variance
    stack = xr.Dataset(
        {
            "command_mobility": mobility,
            "command_mobility_variance": variance,
            "averages": (lines + 1).where(any_used, 0.0),
            "degrees_of_freedom": _pooled(share, windows["degrees_of_freedom"]).where(any_used, 0.0),
            "coherence": (signal / (signal + lines)).where(any_used, 0.0),
            "coherence_minimum": windows["coherence_minimum"].mean("window"),
            "coherence_maximum": windows["coherence_maximum"].mean("window"),
            "gate": xr.where(any_used, np.int8(Gate.USED), windows["gate"].max("window")),
            "agreement_p_value": p_value,
            "windows": windows.sizes["window"],
        }
    )
    return stack.expand_dims("stack").assign_coords(hole_depth=("stack", [float(windows["hole_depth"].mean())]))


def _pooled(share: xr.DataArray, freedom: xr.DataArray) -> xr.DataArray:
    """Degrees of freedom of the mean of windows with these shares: their sum where the shares follow them."""
    return 1 / (share**2 / freedom).sum("window")


def _disagreement(mobility: xr.Dataset, members: list[int], row: int, p_value: float) -> Problem:
    names = [str(int(mobility["window"][member])) for member in members]
    others = f"windows {names[0]} to {names[-1]}" if len(names) > 1 else f"window {names[0]}"
    where = window_place(mobility, row)
    if np.isnan(p_value):
        what = f"shares no frequency that passes the gate with {others}; they are not stacked"
        return Problem(where, what, "Look at the coherence of these windows")
    return Problem(
        where,
        f"does not agree with {others} (p-value {p_value:.2g}), so they are not stacked",
        "None needed: the string changed between them; see the parameters against depth",
    )


def _no_stacks(mobility: xr.Dataset) -> xr.Dataset:
    none = _stack(mobility.isel(window=[0]), 1.0).isel(stack=slice(0, 0))
    return none.assign_coords({name: ("stack", []) for name in ("stack", "first_window", "last_window", "key")})
