"""Records → state of the rig, segments, and windows of steady drilling with the sweep on."""

from __future__ import annotations

import functools
import hashlib
import itertools
from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np
import xarray as xr
from scipy.ndimage import uniform_filter1d

from drillid.arrays import Array
from drillid.datasets.codes import RecordFlag, RigState
from drillid.datasets.measured import WINDOWS
from drillid.datasets.reuse import EarlierPieces, Memo, digest
from drillid.datasets.store import Problem, WellFolders
from drillid.windows.channels import CHANNELS, sample_rate
from drillid.windows.rig_state import NEEDED, rig_states, without_holes
from drillid.windows.segments import (
    Segment,
    cut,
    joined,
    reason_of,
    segments,
    segments_table,
    steady_parts,
    window_places,
)

if TYPE_CHECKING:
    from drillid.config.listing import Well
    from drillid.config.rig import Rig
    from drillid.config.settings import Settings, WindowsSettings


_STATE_CHANNELS = (*NEEDED, "bit_depth", "weight_on_bit", "flow")
_PLACE = ("first_sample", "samples")
_REMAINDER, _REPAIRED, _SHALLOW, _USED = range(4)
_OF_WINDOW = ["hole_depth", "bit_depth", "weight_on_bit", "flow", "standpipe_pressure", *CHANNELS, "flags", "time"]
_BLOCK = 250_000
"""Number of samples in memory at once, except for a window that is longer."""
_STEADY_S = 60.0
"""Where no set point is logged, it is replaced by the mean speed over this time, s."""


def process(well: Well, folders: WellFolders, settings: Settings) -> list[Problem]:
    """Write states, windows and segments of a well; results from logs that have not changed are reused."""
    records, logs = folders.read("records", "records"), folders.read("records", "logs").load()
    rate, memo = sample_rate(records), Memo(folders, "windows")
    parts = _log_segments(records, logs, rate, folders, memo, settings.windows)
    rows: list[Segment] = []
    windows: list[dict[str, Any]] = []
    for segment in joined(parts, rate):
        if segment.state is RigState.DRILLING and not segment.stuck:
            divide = functools.partial(_divided, segment, records, rate, well.rig, settings.windows)
            divided = memo.result(memo.key("segment", _samples_of(segment, logs), rate), divide)
            rows += [Segment.of(row, segment.first) for row in divided["rows"]]
            windows += [row | {"first_sample": segment.first + row["first_sample"]} for row in divided["windows"]]
        else:
            rows.append(replace(segment, reason=reason_of(segment, _missing(segment, records))))
    folders.write("windows", "windows", _windows_dataset(windows))
    folders.write_table("windows", "segments", segments_table(well.name, rows))
    memo.save()
    if windows:
        return []
    return [
        Problem(
            f"well {well.name}",
            "no window of steady drilling with the sweep on was found",
            "See its segments.csv for the reasons",
        )
    ]


def _missing(segment: Segment, records: xr.Dataset) -> list[str]:
    """Needed channels that a segment of unknown state lacks."""
    if segment.state is not RigState.UNKNOWN:
        return []
    part = records[list(NEEDED)].isel(time=slice(segment.first, segment.stop))
    return [name for name in NEEDED if not np.isfinite(part[name].values).all()]


def _log_segments(
    records: xr.Dataset, logs: xr.Dataset, rate: float, folders: WellFolders, memo: Memo, settings: WindowsSettings
) -> list[Segment]:
    """Write the states log by log, and return the segments of every log."""
    keys = [memo.key("log", str(key), rate) for key in logs["key"].values]
    earlier, found = EarlierPieces(folders, "windows", "states", memo, keys), list[Segment]()
    with folders.appending("windows", "states", kept=earlier.kept) as append:
        for key, first, samples in zip(keys, *(logs[name].values.tolist() for name in _PLACE), strict=True):
            if key in earlier:
                content = earlier.content(key)
                states = earlier.piece(key)
            else:
                part = records[[*_STATE_CHANNELS, "flags"]].isel(time=slice(first, first + samples)).load()
                channels = {name: part[name].values for name in _STATE_CHANNELS}
                state = rig_states(channels, part["flags"].values, rate, settings)
                states = xr.Dataset({"rig_state": ("time", state)}, coords={"time": part["time"]})
                content = [segment.content(0) for segment in segments(part, state, rate, 0)]
            if states is not None:
                append(states)
            memo.found[key] = {"first": first, "samples": samples, "content": content}
            found += [Segment.of(row, first) for row in content]
    return found


def _samples_of(segment: Segment, logs: xr.Dataset) -> list[Any]:
    """What identifies the samples of a segment: the logs that it lies in, and its ends in the first and the last."""
    first = logs["first_sample"].values
    begin, end = (int(np.searchsorted(first, sample, side="right")) - 1 for sample in (segment.first, segment.stop - 1))
    ends = [segment.first - int(first[begin]), segment.stop - int(first[end])]
    return [*map(str, logs["key"].values[begin : end + 1]), *ends]


def _divided(segment: Segment, records: xr.Dataset, rate: float, rig: Rig, settings: WindowsSettings) -> dict[str, Any]:
    """Parts and windows of a segment of drilling, their samples counted from its first."""
    rows, windows = [], []
    for row, places in _windows_of(segment, records, rate, rig, settings):
        rows.append(row.content(segment.first))
        windows += [_window(block, *place, rate) for block, place in _loaded(records, places)]
    return {
        "rows": rows,
        "windows": [row | {"first_sample": row["first_sample"] - segment.first} for row in windows],
    }


def _windows_of(
    segment: Segment, records: xr.Dataset, rate: float, rig: Rig, settings: WindowsSettings
) -> Iterator[tuple[Segment, list[tuple[int, int]]]]:
    """Parts of one segment of drilling, each with first sample and length of its windows."""
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
    depth = part["hole_depth"].values
    length = max(1, round(settings.length_s * rate))
    shortest = max(round(settings.shortest_share * length), 1)
    parts = steady_parts(set_point, settings.steady_rpm * np.pi / 30)
    for low, high in parts:
        places = [(low + start, size) for start, size in window_places(high - low, length, shortest, settings.overlap)]
        whole = [place for place in places if np.mean(repaired[place[0] : sum(place)]) <= settings.flagged_share]
        good = [place for place in whole if not _without_pipe(rig, _mean(depth[place[0] : sum(place)]))]
        label = np.full(high - low, _REMAINDER)
        for chosen, value in ((places, _REPAIRED), (whole, _SHALLOW), (good, _USED)):
            for start, size in chosen:
                label[start - low : start - low + size] = value
        edges = [0, *(np.flatnonzero(np.diff(label)) + 1).tolist(), high - low]
        for first, stop in ((low + first, low + stop) for first, stop in itertools.pairwise(edges)):
            kind = int(label[first - low])
            inside = [(segment.first + start, size) for start, size in good if kind == _USED and first <= start < stop]
            if kind == _SHALLOW:
                reason = _without_pipe(rig, _mean(depth[first:stop]))
            else:
                reason = _reason(kind, (stop - first) / rate, float(np.mean(repaired[first:stop])), settings)
            if kind == _REMAINDER and len(parts) > 1:
                reason += "; the set point of the speed changed"
            yield cut(segment, part, first, stop, rate, len(inside), reason), inside


def _without_pipe(rig: Rig, depth: float) -> str:
    """Why no string of pipe and collars is in a hole of some depth, m; empty where there is one."""
    collars = rig.collars_at(depth)
    if collars is None or collars.length < depth:
        return ""
    return f"the drill collars are stated as {collars.length:.1f} m long in a hole of {depth:.1f} m: there is no pipe"


def _reason(label: int, seconds: float, share: float, settings: WindowsSettings) -> str:
    if label == _REMAINDER:
        return f"too short: {seconds:.1f} s of the {settings.shortest_share * settings.length_s:.1f} s needed"
    if label == _REPAIRED:
        return f"{100 * share:.1f} % of it interpolated or replaced; {100 * settings.flagged_share:.1f} % is allowed"
    return ""


def _loaded(
    records: xr.Dataset, places: Sequence[tuple[int, int]]
) -> Iterator[tuple[tuple[int, xr.Dataset], tuple[int, int]]]:
    """Places of windows, each with the samples in memory that hold it, and the place of the first of these.

    Neighbouring windows are read together, as opening a file costs much more than the samples that are taken from it.
    """
    block, end = (0, records), 0
    for place in places:
        first, stop = place[0], sum(place)
        if stop > end:
            together = [sum(other) for other in places if first <= other[0] and sum(other) <= first + _BLOCK]
            end = max([stop, *together])
            block = first, records[_OF_WINDOW].isel(time=slice(first, end)).load()
        yield block, place


def _window(block: tuple[int, xr.Dataset], first: int, samples: int, rate: float) -> dict[str, Any]:
    """Variables of one window, by the names of the WINDOWS schema, from samples that hold it."""
    begin, held = block
    part = held.isel(time=slice(first - begin, first - begin + samples))
    repaired = (part["flags"].values & np.uint8(RecordFlag.INTERPOLATED | RecordFlag.SPIKE)) > 0
    depth, time = part["hole_depth"].values.astype(float), part["time"].values
    bit_depth = _mean(part["bit_depth"].values)
    start = int(time[0].astype("datetime64[ns]").astype(np.int64))
    end = int(time[-1].astype("datetime64[ns]").astype(np.int64)) + round(1e9 / rate)
    row = {
        "hole_depth": _mean(depth),
        "start": start,
        "end": end,
        "depth_from": float(depth[0]),
        "depth_to": float(depth[-1]),
        # the bit is on bottom in a window, so where its depth is not logged it is that of the hole
        "bit_depth": bit_depth if np.isfinite(bit_depth) else _mean(depth),
        "speed": _mean(part["speed"].values),
        "torque": _mean(part["torque_command"].values),
        "weight_on_bit": _mean(part["weight_on_bit"].values),
        "flow": _mean(part["flow"].values),
        "standpipe_pressure": _mean(part["standpipe_pressure"].values),
        "sweep_amplitude": float(np.std(part["torque_sweep"].values.astype(float))),
        "flagged_share": float(np.mean(repaired)),
        "samples": samples,
    }
    content = hashlib.sha256(digest([row, rate]).encode())
    for name in CHANNELS:
        content.update(part[name].values.tobytes())
    return row | {"first_sample": first, "key": content.hexdigest()[:16]}


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
