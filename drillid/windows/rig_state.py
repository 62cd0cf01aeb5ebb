"""State of the rig at each sample, from the channels that are logged."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import maximum_filter1d, median_filter, minimum_filter1d

from drillid.arrays import Array, Booleans
from drillid.config.settings import WindowsSettings
from drillid.datasets.codes import RecordFlag, RigState
from drillid.records.quality import runs

NEEDED = ("speed", "torque_sweep", "hole_depth")
"""Channels without which the state is unknown."""
_SMOOTHING_S = 2.0
"""Time of the running medians, which do not shift a change of state, s."""
_SWEEP_S = 5.0
"""A sweep is visible in any interval of this length, s."""
_ON_S = 60.0
"""A sweep lasts longer, s, and all spikes of a log together do not."""
_SWEEP_SHARE = 0.05
"""Share of the sweep's usual range below which it counts as off."""
_MOVING = 0.02
"""Axial speed above which the bit counts as moving, m/s."""
_DEEPENING_S = 60.0
"""Where neither bit depth nor weight is logged, the hole's deepening over this time on either side decides, s."""
_FLOW_SHARE = 0.1
"""Share of the usual flow below which the pumps are off."""
_WEIGHT_SHARE = 0.1
"""Share of the usual weight on bit below which the bit is off bottom; used without bit depth only."""


def rig_states(
    channels: dict[str, Array], flags: NDArray[np.uint8], rate: float, settings: WindowsSettings
) -> NDArray[np.int8]:
    """State of the rig at every sample of one log.

    Parameters
    ----------
    channels : SI channels by their names in the records, each of shape (time,); all NaN where not logged
    flags : flags of the records, shape (time,)
    rate : samples per second

    Returns
    -------
    Values of `RigState`, shape (time,)
    """
    size = flags.size
    unknown = (flags & np.uint8(RecordFlag.GAP)) > 0
    for name in NEEDED:
        unknown |= ~np.isfinite(channels[name])
    states = np.full(size, RigState.UNKNOWN, dtype=np.int8)
    if np.all(unknown):
        return states
    filled = {name: without_holes(values) for name, values in channels.items() if np.any(np.isfinite(values))}
    rotating = np.abs(_smooth(filled["speed"], rate)) * 30 / np.pi > settings.rotating_rpm
    on_bottom = _on_bottom(filled, rate, settings)
    sweep_on = _sweep_on(filled["torque_sweep"], unknown, rate)
    states[:] = RigState.OFF_BOTTOM
    if "bit_depth" in filled:
        states[_moving(filled["bit_depth"], rate)] = RigState.REAMING
    if "flow" in filled:
        states[~_above_share(filled["flow"], _FLOW_SHARE, rate)] = RigState.CONNECTION
    states[on_bottom] = RigState.DRILLING
    states[on_bottom & ~sweep_on] = RigState.SWEEP_OFF
    states[~rotating] = RigState.CONNECTION
    states[unknown] = RigState.UNKNOWN
    return states


def without_holes(values: Array) -> Array:
    """A channel with its missing samples interpolated linearly, shape (time,); it must hold at least one value."""
    missing = ~np.isfinite(values)
    if not np.any(missing):
        return values
    filled, present = values.copy(), np.flatnonzero(~missing)
    filled[missing] = np.interp(np.flatnonzero(missing), present, values[present])
    return filled


def _span(seconds: float, rate: float) -> int:
    return 2 * round(seconds * rate / 2) + 1


def _smooth(values: Array, rate: float) -> Array:
    return np.asarray(median_filter(values, _span(_SMOOTHING_S, rate), mode="nearest"))


def _on_bottom(filled: dict[str, Array], rate: float, settings: WindowsSettings) -> Booleans:
    """From the bit's distance to the bottom; without bit depth from weight; without both from the hole's deepening."""
    if "bit_depth" in filled:
        return _smooth(filled["hole_depth"] - filled["bit_depth"], rate) < settings.on_bottom_m
    if "weight_on_bit" in filled:
        return _above_share(filled["weight_on_bit"], _WEIGHT_SHARE, rate)
    size = filled["hole_depth"].size
    around = min(round(_DEEPENING_S * rate), size - 1)
    depth = np.pad(filled["hole_depth"], around, mode="edge")
    return np.asarray(depth[2 * around :] - depth[:size] > 0)


def _above_share(values: Array, share: float, rate: float) -> Booleans:
    """Where a channel exceeds a share of its 95th percentile in the log."""
    return np.asarray(_smooth(values, rate) > share * max(float(np.quantile(values, 0.95)), 0.0))


def _sweep_on(sweep: Array, unknown: Booleans, rate: float) -> Booleans:
    """Where the range of the sweep over a few seconds exceeds a share of its usual one, exact to the sample.

    The running range extends each sweep by half of those seconds at both ends; the running
    minimum reverses that, except for the samples at either end of a sweep that are close to its
    resting value. Those are recognised by their difference from it; and as a sweep starts at its
    resting value, one more sample counts as on at its start.
    """
    span = _span(_SWEEP_S, rate)
    swing = maximum_filter1d(sweep, span, mode="nearest") - minimum_filter1d(sweep, span, mode="nearest")
    near = (swing > _SWEEP_SHARE * _usual(swing, rate)) | unknown
    on = np.asarray(minimum_filter1d(near.astype(np.uint8), span, mode="constant", cval=1) > 0)
    for first, stop in runs(~on):
        off = sweep[first:stop]
        resting = off[off.size // 4 : off.size - off.size // 4]
        level = np.median(resting)
        at_rest = np.flatnonzero(np.abs(off - level) <= np.max(np.abs(resting - level)))
        on[first : first + at_rest[0]] = True
        on[first + at_rest[-1] : stop] |= stop < sweep.size
    return on


def _usual(swing: Array, rate: float) -> float:
    """Usual range of a sweep that is on: the 95th percentile in the log or, where that is at rest by the range that is
    reached for a minute, the median of what is not.
    """
    usual = float(np.quantile(swing, 0.95))
    minute = min(round(_ON_S * rate), swing.size)
    reached = float(np.partition(swing, -minute)[-minute])
    at_rest = usual <= _SWEEP_SHARE * reached
    return float(np.median(swing[swing > _SWEEP_SHARE * reached])) if at_rest and reached > 0 else usual


def _moving(bit_depth: Array, rate: float) -> Booleans:
    span = _span(_SWEEP_S, rate)
    travel = maximum_filter1d(bit_depth, span, mode="nearest") - minimum_filter1d(bit_depth, span, mode="nearest")
    return np.asarray(travel > _MOVING * _SWEEP_S)
