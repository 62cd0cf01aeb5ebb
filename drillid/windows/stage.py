"""Records → state of the rig, segments, and windows of steady drilling with the sweep on."""

from __future__ import annotations

import itertools
from collections.abc import Iterator
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np
import xarray as xr
from scipy.ndimage import uniform_filter1d

from drillid.arrays import Array
from drillid.datasets.codes import RecordFlag, RigState
from drillid.datasets.measured import WINDOWS
from drillid.datasets.store import Problem, WellFolders
from drillid.windows.channels import log_bounds, sample_rate
from drillid.windows.rig_state import NEEDED, rig_states, without_holes
from drillid.windows.segments import (
    Segment,
    cut,
    joined,
    reason_of,
    segments,
    segments_table,
    steady_parts,
    window_starts,
)

if TYPE_CHECKING:
    from drillid.config.settings import Settings, WindowsSettings
    from drillid.config.sheets import Well


_STATE_CHANNELS = (*NEEDED, "bit_depth", "weight_on_bit", "flow")
_REMAINDER, _REPAIRED, _USED = range(3)
_STEADY_S = 60.0
"""Where no set point is logged, it is replaced by the mean speed over this time, s."""


def process(well: Well, folders: WellFolders, settings: Settings) -> list[Problem]:
    """Write states, windows and segments of a well."""
    records = folders.read("records", "records")
    rate = sample_rate(records)
    parts: list[Segment] = []
    with folders.appending("windows", "states") as append:
        for first, stop in log_bounds(records):
            part = records[[*_STATE_CHANNELS, "flags"]].isel(time=slice(first, stop)).load()
            channels = {name: part[name].values for name in _STATE_CHANNELS}
            states = rig_states(channels, part["flags"].values, rate, settings.windows)
            append(xr.Dataset({"rig_state": ("time", states)}, coords={"time": part["time"]}))
            parts += segments(part, states, rate, first)
    rows: list[Segment] = []
    windows: list[dict[str, Any]] = []
    for segment in joined(parts, rate):
        if segment.state is RigState.DRILLING and not segment.stuck:
            for part_row, starts in _windows_of(segment, records, rate, settings.windows):
                rows.append(part_row)
                windows += [_window(records, start, rate, settings.windows) for start in starts]
        else:
            rows.append(replace(segment, reason=reason_of(segment)))
    folders.write("windows", "windows", _windows_dataset(windows))
    folders.write_table("windows", "segments", segments_table(well.name, rows))
    if windows:
        return []
    return [
        Problem(
            f"well {well.name}",
            "no window of steady drilling with the sweep on was found",
            "See its segments.csv for the reasons",
        )
    ]


def _windows_of(
    segment: Segment, records: xr.Dataset, rate: float, settings: WindowsSettings
) -> Iterator[tuple[Segment, list[int]]]:
    """Parts of one segment of drilling, each with the first samples of its windows."""
    part = (
        records[["speed_set", "speed", "hole_depth", "flags", "time"]]
        .isel(time=slice(segment.first, segment.stop))
        .load()
    )
    set_point = part["speed_set"].values.astype(float)
    if np.any(np.isfinite(set_point)):
        set_point = without_holes(set_point)
    else:
        set_point = uniform_filter1d(
            without_holes(part["speed"].values.astype(float)), round(_STEADY_S * rate), mode="nearest"
        )
    repaired = (part["flags"].values & np.uint8(RecordFlag.INTERPOLATED | RecordFlag.SPIKE)) > 0
    length = round(settings.length_s * rate)
    parts = steady_parts(set_point, settings.steady_rpm * np.pi / 30)
    for low, high in parts:
        starts = low + window_starts(high - low, length, settings.overlap)
        good = [int(start) for start in starts if np.mean(repaired[start : start + length]) <= settings.flagged_share]
        label = np.full(high - low, _REMAINDER)
        for chosen, value in ((starts, _REPAIRED), (good, _USED)):
            for start in chosen:
                label[start - low : start - low + length] = value
        edges = [0, *(np.flatnonzero(np.diff(label)) + 1).tolist(), high - low]
        for first, stop in ((low + first, low + stop) for first, stop in itertools.pairwise(edges)):
            kind = int(label[first - low])
            inside = [segment.first + start for start in good if kind == _USED and first <= start < stop]
            reason = _reason(kind, (stop - first) / rate, float(np.mean(repaired[first:stop])), settings)
            if kind == _REMAINDER and len(parts) > 1:
                reason += "; the set point of the speed changed"
            yield cut(segment, part, first, stop, rate, len(inside), reason), inside


def _reason(label: int, seconds: float, share: float, settings: WindowsSettings) -> str:
    if label == _REMAINDER:
        return f"too short: {seconds:.1f} s of {settings.length_s:.1f} s"
    if label == _REPAIRED:
        return f"{100 * share:.1f} % of it interpolated or replaced, of {100 * settings.flagged_share:.1f} % allowed"
    return ""


def _window(records: xr.Dataset, first: int, rate: float, settings: WindowsSettings) -> dict[str, Any]:
    """Variables of one window, by the names of the WINDOWS schema."""
    samples = round(settings.length_s * rate)
    names = [
        "hole_depth",
        "bit_depth",
        "speed",
        "torque_command",
        "weight_on_bit",
        "flow",
        "torque_sweep",
        "flags",
        "time",
    ]
    part = records[names].isel(time=slice(first, first + samples)).load()
    repaired = (part["flags"].values & np.uint8(RecordFlag.INTERPOLATED | RecordFlag.SPIKE)) > 0
    depth, time = part["hole_depth"].values.astype(float), part["time"].values
    bit_depth = _mean(part["bit_depth"].values)
    return {
        "hole_depth": _mean(depth),
        "start": time[0],
        "end": time[-1] + np.timedelta64(round(1e9 / rate), "ns"),
        "depth_from": depth[0],
        "depth_to": depth[-1],
        # the bit is on bottom in a window, so where its depth is not logged it is that of the hole
        "bit_depth": bit_depth if np.isfinite(bit_depth) else _mean(depth),
        "speed": _mean(part["speed"].values),
        "torque": _mean(part["torque_command"].values),
        "weight_on_bit": _mean(part["weight_on_bit"].values),
        "flow": _mean(part["flow"].values),
        "sweep_amplitude": float(np.std(part["torque_sweep"].values.astype(float))),
        "flagged_share": float(np.mean(repaired)),
        "first_sample": first,
        "samples": samples,
    }


def _mean(values: Array) -> float:
    """Mean of the samples that are present; NaN without any."""
    present = values[np.isfinite(values)]
    return float(np.mean(present, dtype=float)) if present.size else np.nan


def _windows_dataset(windows: list[dict[str, Any]]) -> xr.Dataset:
    windows = sorted(windows, key=lambda window: window["first_sample"])
    columns = {
        name: ("window", np.array([window[name] for window in windows], dtype=declared.dtype))
        for name, declared in WINDOWS.variables.items()
        if name != "window"
    }
    return xr.Dataset(columns, coords={"window": np.arange(len(windows))})
