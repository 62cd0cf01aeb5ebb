"""Records → state of the rig, stretches, and windows of steady drilling with the sweep on."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np
import pandas as pd
import xarray as xr
from numpy.typing import NDArray
from scipy.ndimage import uniform_filter1d

from drillid.quality import runs
from drillid.schema import RecordFlag, RigState
from drillid.states import NEEDED, rig_states, without_holes
from drillid.store import Problem, WellFolders

if TYPE_CHECKING:
    from drillid.config import Settings, WindowsSettings
    from drillid.sheets import Well

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]

STRETCH_COLUMNS = ("well", "state", "start", "end", "from_m", "to_m", "duration_s", "windows", "reason")
"""Columns of stretches.csv: one row for every stretch of the recorded time."""

_STATE_CHANNELS = (*NEEDED, "bit_depth", "weight_on_bit", "flow")
_REGULAR = 1.1
"""Intervals between samples above which time is missing."""
_BLOCK = 1_000_000
_STEADY_S = 60.0
"""Where no set point is logged, the mean speed over this time stands for it, s."""
_REASONS = {
    RigState.CONNECTION: "connection",
    RigState.OFF_BOTTOM: "off bottom",
    RigState.REAMING: "reaming",
    RigState.SWEEP_OFF: "sweep off",
}


@dataclass(frozen=True)
class Stretch:
    """Samples `first` to `stop` (exclusive) of the records: one state, no missing time.

    start, end : times of the first sample and of one interval after the last, ns since 1970 UTC
    from_m, to_m : hole depth at the first and the last sample, m
    """

    state: RigState
    stuck: bool
    gap: bool
    first: int
    stop: int
    start: int
    end: int
    from_m: float
    to_m: float
    windows: int = 0
    reason: str = ""

    @property
    def duration(self) -> float:
        """Duration, s."""
        return (self.end - self.start) * 1e-9


def process(well: Well, folders: WellFolders, settings: Settings) -> list[Problem]:
    """Write states, windows and stretches of a well."""
    records = folders.read("records", "records")
    rate = sample_rate(records)
    found: list[Stretch] = []
    with folders.appending("windows", "states") as append:
        for first, stop in log_bounds(records):
            part = records[[*_STATE_CHANNELS, "flags"]].isel(time=slice(first, stop)).load()
            channels = {name: part[name].values.astype(float) for name in _STATE_CHANNELS}
            states = rig_states(channels, part["flags"].values, rate, settings.windows)
            append(xr.Dataset({"rig_state": ("time", states)}, coords={"time": part["time"]}))
            found += stretches(part, states, rate, first)
    rows: list[Stretch] = []
    windows: list[dict[str, Any]] = []
    for stretch in joined(found, rate):
        if stretch.state is RigState.DRILLING and not stretch.stuck:
            for part_row, starts in _windows_of(stretch, records, rate, settings.windows):
                rows.append(part_row)
                windows += [_window(records, start, rate, settings.windows) for start in starts]
        else:
            rows.append(replace(stretch, reason=_reason(stretch)))
    folders.write("windows", "windows", _windows_dataset(windows))
    stretches_table(well.name, rows).to_csv(folders.stage("windows") / "stretches.csv", index=False)
    if windows:
        return []
    return [
        Problem(
            f"well {well.name}",
            "no window of steady drilling with the sweep on was found",
            "See its stretches.csv for the reasons",
        )
    ]


def sample_rate(records: xr.Dataset) -> float:
    """Samples per second of the records."""
    first = records["time"][:2].values.astype("datetime64[ns]").astype(np.int64)
    return float(1e9 / (first[1] - first[0]))


def log_bounds(records: xr.Dataset) -> Iterator[tuple[int, int]]:
    """First and last-plus-one sample of each log, in order; read block by block."""
    size, begin, current = records.sizes["time"], 0, None
    for block in range(0, size, _BLOCK):
        numbers = records["log"][block : block + _BLOCK].values
        previous = numbers[0] if current is None else current
        for change in (np.flatnonzero(np.diff(numbers, prepend=previous)) + block).tolist():
            yield begin, change
            begin = change
        current = numbers[-1]
    yield begin, size


def stretches(part: xr.Dataset, states: NDArray[np.int8], rate: float, offset: int) -> list[Stretch]:
    """Cut one log where state, time or the flags of stuck sensors break.

    Parameters
    ----------
    part : records of the log
    states : state of each sample, shape (time,)
    rate : samples per second
    offset : number of the log's first sample in the records
    """
    time = part["time"].values.astype("datetime64[ns]").astype(np.int64)
    flags, depth = part["flags"].values, part["hole_depth"].values
    stuck, gap = ((flags & np.uint8(flag)) > 0 for flag in (RecordFlag.STUCK, RecordFlag.GAP))
    kind = states.astype(np.int64) * 4 + 2 * stuck + (gap & (states == RigState.UNKNOWN))
    breaks = np.flatnonzero((np.diff(kind) != 0) | (np.diff(time) * 1e-9 * rate > _REGULAR)) + 1
    edges = [0, *breaks.tolist(), time.size]
    interval = round(1e9 / rate)
    return [
        Stretch(
            RigState(int(states[first])),
            bool(stuck[first]),
            bool(gap[first]),
            offset + first,
            offset + stop,
            int(time[first]),
            int(time[stop - 1]) + interval,
            float(depth[first]),
            float(depth[stop - 1]),
        )
        for first, stop in zip(edges[:-1], edges[1:], strict=True)
    ]


def joined(found: list[Stretch], rate: float) -> list[Stretch]:
    """Stretches of one kind that follow each other without missing time, as where one log goes on in the next, made one."""
    result: list[Stretch] = []
    for stretch in found:
        last = result[-1] if result else None
        same = last is not None and (last.state, last.stuck, last.gap) == (stretch.state, stretch.stuck, stretch.gap)
        if last is not None and same and abs(stretch.start - last.end) * 1e-9 * rate < _REGULAR - 1:
            result[-1] = replace(last, stop=stretch.stop, end=stretch.end, to_m=stretch.to_m)
        else:
            result.append(stretch)
    return result


def steady_parts(set_point: Floats, largest: float) -> list[tuple[int, int]]:
    """Cut a stretch so that the set point varies by no more than `largest` in each part; bounds of the parts."""
    parts, first = [], 0
    while first < set_point.size:
        rest = set_point[first:]
        over = np.maximum.accumulate(rest) - np.minimum.accumulate(rest) > largest
        stop = first + int(np.argmax(over)) if over[-1] else set_point.size
        parts.append((first, stop))
        first = stop
    return parts


def window_starts(samples: int, length: int, overlap: float) -> Integers:
    """First samples of as many windows as fit, the last one ending with the stretch: what is left over lies at its start."""
    if samples < length:
        return np.zeros(0, dtype=np.int64)
    hop = max(1, round(length * (1 - overlap)))
    count = (samples - length) // hop + 1
    return samples - length - hop * np.arange(count - 1, -1, -1, dtype=np.int64)


def _windows_of(
    stretch: Stretch, records: xr.Dataset, rate: float, settings: WindowsSettings
) -> Iterator[tuple[Stretch, list[int]]]:
    """Rows of one stretch of drilling, each with the first samples of its windows."""
    part = (
        records[["speed_set", "speed", "hole_depth", "flags", "time"]]
        .isel(time=slice(stretch.first, stretch.stop))
        .load()
    )
    set_point = part["speed_set"].values.astype(float)
    if np.any(np.isfinite(set_point)):
        set_point = without_holes(set_point)
    else:
        set_point = uniform_filter1d(
            without_holes(part["speed"].values.astype(float)), round(_STEADY_S * rate), mode="nearest"
        )
    touched = (part["flags"].values & np.uint8(RecordFlag.INTERPOLATED | RecordFlag.SPIKE)) > 0
    length = round(settings.length_s * rate)
    parts = steady_parts(set_point, settings.steady_rpm * np.pi / 30)
    for low, high in parts:
        cause = "; the set point of the speed changed" if len(parts) > 1 else ""
        starts = low + window_starts(high - low, length, settings.overlap)
        share = np.array([np.mean(touched[start : start + length]) for start in starts])
        good = starts[share <= settings.flagged_share] if starts.size else starts
        label = np.zeros(high - low, dtype=np.int8)
        for chosen, value in ((starts, 1), (good, 2)):
            for start in chosen:
                label[start - low : start - low + length] = value
        for value in (0, 1, 2):
            for first, stop in (runs(label == value) + low).tolist():
                inside = [int(start) + stretch.first for start in good if first <= start < stop and value == 2]
                reason = _leftover_reason(
                    value, (stop - first) / rate, float(np.mean(touched[first:stop])), settings
                ) + (cause if value == 0 else "")
                yield _cut(stretch, part, first, stop, rate, len(inside), reason), inside


def _leftover_reason(label: int, seconds: float, share: float, settings: WindowsSettings) -> str:
    if label == 0:
        return f"too short: {seconds:.1f} s of {settings.length_s:.1f} s"
    if label == 1:
        return f"{100 * share:.1f} % of its samples interpolated or replaced, of {100 * settings.flagged_share:.1f} % allowed"
    return ""


def _cut(stretch: Stretch, part: xr.Dataset, first: int, stop: int, rate: float, windows: int, reason: str) -> Stretch:
    """Samples `first` to `stop` of a stretch as a stretch of their own."""
    time, depth = part["time"].values.astype("datetime64[ns]").astype(np.int64), part["hole_depth"].values
    return replace(
        stretch,
        first=stretch.first + first,
        stop=stretch.first + stop,
        start=int(time[first]),
        end=int(time[stop - 1]) + round(1e9 / rate),
        from_m=float(depth[first]),
        to_m=float(depth[stop - 1]),
        windows=windows,
        reason=reason,
    )


def _reason(stretch: Stretch) -> str:
    if stretch.state is RigState.DRILLING:
        return "a sensor is stuck"
    if stretch.state is RigState.UNKNOWN:
        return (
            f"gap of {stretch.duration:.1f} s"
            if stretch.gap
            else f"no {', '.join(NEEDED)} for {stretch.duration:.1f} s"
        )
    return _REASONS[stretch.state]


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
    touched = (part["flags"].values & np.uint8(RecordFlag.INTERPOLATED | RecordFlag.SPIKE)) > 0
    depth, time = part["hole_depth"].values.astype(float), part["time"].values
    return {
        "hole_depth": _mean(depth),
        "start": time[0],
        "end": time[-1] + np.timedelta64(round(1e9 / rate), "ns"),
        "depth_from": depth[0],
        "depth_to": depth[-1],
        "bit_depth": _mean(part["bit_depth"].values),
        "speed": _mean(part["speed"].values),
        "torque": _mean(part["torque_command"].values),
        "weight_on_bit": _mean(part["weight_on_bit"].values),
        "flow": _mean(part["flow"].values),
        "sweep_amplitude": float(np.std(part["torque_sweep"].values.astype(float))),
        "flagged_share": float(np.mean(touched)),
        "first_sample": first,
        "samples": samples,
    }


def _mean(values: NDArray[Any]) -> float:
    """Mean of the samples that are there; NaN where there is none."""
    known = values[np.isfinite(values)]
    return float(np.mean(known, dtype=float)) if known.size else np.nan


def _windows_dataset(windows: list[dict[str, Any]]) -> xr.Dataset:
    from drillid.schema import WINDOWS

    windows = sorted(windows, key=lambda window: window["first_sample"])
    columns = {
        name: ("window", np.array([window[name] for window in windows], dtype=declared.dtype))
        for name, declared in WINDOWS.variables.items()
        if name != "window"
    }
    return xr.Dataset(columns, coords={"window": np.arange(len(windows))})


def stretches_table(well: str, rows: list[Stretch]) -> pd.DataFrame:
    """Stretches in order of time, in the columns of stretches.csv."""
    table = [
        (
            well,
            row.state.name.lower(),
            *(pd.Timestamp(moment).isoformat(timespec="milliseconds") for moment in (row.start, row.end)),
            round(row.from_m, 3),
            round(row.to_m, 3),
            round(row.duration, 3),
            row.windows,
            row.reason,
        )
        for row in sorted(rows, key=lambda row: row.first)
    ]
    return pd.DataFrame(table, columns=list(STRETCH_COLUMNS))
