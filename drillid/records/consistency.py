"""Statistics of a log's channels by which physics and practice judge them; plausibility.py holds their bounds."""

from __future__ import annotations

import functools
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from drillid.arrays import Array, Booleans, Floats, Integers

_TURNING = 1.0
"""Speed above which the string turns, rad/s; 10 rpm."""
_LEAST_S = 60
"""Least time for anything to be judged, s."""
_BLOCK_S, _MOST_BLOCKS = 20.0, 50
"""Length of the blocks in which sweep and speed are compared, s, and their largest number, spread over the log."""
_UNSTEADY = 10.0
"""Ratio of the speed's variance in a block to that of usual ones, above which its mean changed there."""
_RESPONSE_S = 300.0
"""Least time with the sweep on for the response of the speed to be judged, s."""
_LAGS_S = 0.4
"""Largest delay of the speed behind the sweep that is tried, s; drives respond within a tenth of a second."""
_RATE_S = 60
"""Time over which the hole's deepening is measured, s."""
_DEEPER_M = 0.05
"""Deepening in that time above which the bit is drilling, m; 3 m/h."""
_PAUSE_S = 60.0
"""Least gap in the log in which a connection may lie, s."""


@dataclass(frozen=True)
class Measure:
    """A statistic and, where it belongs to one moment, the second of `Samples.seconds` at which it was found."""

    value: float
    second: int | None = None


@dataclass(frozen=True)
class Samples:
    """One log's channels in order of time, as the statistics use them.

    channels : SI units, NaN where missing, shape (row,) in the file's order
    rows : rows in order of time
    time : s since `start`, shape (row,)
    start : UTC
    rate : samples per second
    """

    channels: Mapping[str, Array]
    rows: Integers
    time: Floats
    start: np.datetime64
    rate: float

    def moment(self, measure: Measure) -> str:
        """When a statistic was found, for messages."""
        if measure.second is None:
            return ""
        passed = np.timedelta64(round(1e3 * float(self.time[self.seconds[measure.second]])), "ms")
        return f"at {self.start.astype('datetime64[ms]') + passed}"

    @functools.cached_property
    def seconds(self) -> Integers:
        """Positions in `rows` about one second apart, shape (second,)."""
        return np.arange(0, self.rows.size, max(1, round(self.rate)))

    def slow(self, name: str) -> Floats:
        """A channel about once a second, shape (second,)."""
        return np.asarray(self.channels[name][self.rows[self.seconds]], dtype=float)

    @functools.cached_property
    def turning(self) -> Booleans:
        """Whether the string turns, shape (second,)."""
        return np.asarray(np.abs(self.slow("speed")) > _TURNING)

    @functools.cached_property
    def deepening(self) -> Floats:
        """Increase of hole depth in the following minute, where the string turns; NaN elsewhere, shape (second,)."""
        depth, time = self.slow("hole_depth"), self.time[self.seconds]
        ahead = max(1, round(_RATE_S * self.rate / max(1, round(self.rate))))
        change = np.full(depth.size, np.nan)
        if depth.size > ahead:
            whole = (
                (np.abs(time[ahead:] - time[:-ahead] - _RATE_S) < 2.0) & self.turning[:-ahead] & self.turning[ahead:]
            )
            change[:-ahead][whole] = (depth[ahead:] - depth[:-ahead])[whole]
        return change

    @functools.cached_property
    def sweeping(self) -> Floats:
        """Sweep, speed and torque command in blocks of steady rotation with the sweep on, shape (3, block, sample).

        The mean of each block is subtracted. The command is NaN where it is not logged.
        """
        length = round(_BLOCK_S * self.rate)
        starts = np.arange(0, self.rows.size - length + 1, max(length, 1)) if length >= 8 else np.zeros(0, int)
        whole = self.time[starts + length - 1] - self.time[starts] < 1.01 * _BLOCK_S
        chosen = starts[whole][:: max(1, int(np.sum(whole)) // _MOST_BLOCKS)]
        blocks = []
        for start in chosen:
            rows = self.rows[start : start + length]
            fast = np.array([self._fast(name, rows) for name in ("torque_sweep", "speed", "torque_command")])
            if np.all(np.isfinite(fast[:2])) and np.ptp(fast[0]) > 0 and np.all(np.abs(fast[1]) > _TURNING):
                blocks.append(fast - fast.mean(axis=1, keepdims=True))
        if not blocks:
            return np.zeros((3, 0, length))
        moving = np.var([block[1] for block in blocks], axis=1)
        steady = np.array(blocks)[moving <= _UNSTEADY * np.median(moving)]
        return np.asarray(steady.transpose(1, 0, 2))

    def _fast(self, name: str, rows: Integers) -> Floats:
        return (
            np.asarray(self.channels[name][rows], dtype=float) if name in self.channels else np.full(rows.size, np.nan)
        )


def usable_frequency(samples: Samples) -> Measure:
    """Highest identifiable frequency at the sample rate, Hz: 0.8 of half that rate, for the recorder's filter."""
    return Measure(0.4 * samples.rate)


def level(samples: Samples, name: str) -> Measure | None:
    """Median magnitude of a channel, its zeros left out, while the string turns."""
    return _median(np.abs(samples.slow(name)), samples.turning & (samples.slow(name) != 0))


def drilling_level(samples: Samples, name: str) -> Measure | None:
    """The same while the hole deepens."""
    return _median(np.abs(samples.slow(name)), samples.deepening > _DEEPER_M)


def sweep_size(samples: Samples) -> Measure | None:
    """Root mean square of the sweep while it is on, N m."""
    sweep = samples.sweeping[0]
    return Measure(float(np.sqrt(np.mean(sweep**2)))) if sweep.size else None


def bit_below_hole(samples: Samples) -> Measure | None:
    """Median distance of the bit below the bottom of the hole while the string turns, m."""
    return _median(samples.slow("bit_depth") - samples.slow("hole_depth"), samples.turning)


def bit_above_bottom(samples: Samples) -> Measure | None:
    """Median distance of the bit above the bottom while the hole deepens, m."""
    return _median(samples.slow("hole_depth") - samples.slow("bit_depth"), samples.deepening > _DEEPER_M)


def hole_shrinks(samples: Samples) -> Measure | None:
    """Largest depth of the hole so far less its present depth, m."""
    depth, known = _known(samples, "hole_depth")
    if depth.size == 0:
        return None
    lost = np.maximum.accumulate(depth) - depth
    return Measure(float(lost.max()), int(known[np.argmax(lost)]))


def hole_jumps(samples: Samples) -> Measure | None:
    """Largest increase of hole depth from one second to the next, m."""
    depth, known = _known(samples, "hole_depth")
    if depth.size < 2:
        return None
    near = np.diff(samples.time[samples.seconds[known]]) < 2 * max(1.0, 1 / samples.rate)
    rise = np.where(near, np.diff(depth), 0.0)
    return Measure(float(rise.max()), int(known[1 + np.argmax(rise)]))


def drilling_rate(samples: Samples) -> Measure | None:
    """Median rate of penetration while the hole deepens, m/h."""
    rate = samples.deepening * 3600 / _RATE_S
    return _median(rate, samples.deepening > _DEEPER_M)


def drilled_at_once(samples: Samples) -> Measure | None:
    """Largest deepening of the hole between two stops of the rotation or of the log, m."""
    depth, known = _known(samples, "hole_depth")
    if depth.size == 0:
        return None
    stopped = ~samples.turning[known] | (np.diff(samples.time[samples.seconds[known]], prepend=0.0) > _PAUSE_S)
    stand = np.cumsum(stopped)
    low = np.full(int(stand[-1]) + 1, np.inf)
    high = -low
    np.minimum.at(low, stand[~stopped], depth[~stopped])
    np.maximum.at(high, stand[~stopped], depth[~stopped])
    length = np.where(np.isfinite(low), high - low, 0.0)
    return Measure(float(length.max()))


def speed_over_set_point(samples: Samples) -> Measure | None:
    """Median speed over its set point while both are not zero."""
    speed, target = samples.slow("speed"), samples.slow("speed_set")
    both = samples.turning & (np.abs(target) > 0)
    ratio = np.divide(speed, target, out=np.full(speed.size, np.nan), where=both)
    return _median(np.abs(ratio), both)


def power_of_drive(samples: Samples) -> Measure | None:
    """Share of the time in which the drive turns the string less that in which the string turns the drive."""
    power = samples.slow("torque_command") * samples.slow("speed")
    known = samples.turning & np.isfinite(power)
    return Measure(float(np.mean(np.sign(power[known])))) if np.sum(known) >= _LEAST_S else None


def sweep_in_command(samples: Samples) -> Measure | None:
    """Change of the torque command per change of the sweep that it contains, from sample to sample; 1 if all is well.

    From one sample to the next the control has hardly responded yet. None where other changes of the command dominate.
    """
    gain, correlation = _command_gain(samples)
    return Measure(gain) if correlation > 0.8 else None


def sweep_in_command_closely(samples: Samples) -> Measure | None:
    """The same where nothing but the sweep moves the command, so that the gain is exact."""
    gain, correlation = _command_gain(samples)
    return Measure(gain) if correlation > 0.98 else None


def apparent_inertia(samples: Samples) -> Measure | None:
    """Sweep per acceleration of the speed at the delay at which they agree best, kg m²; None where they do not."""
    sweep, speed = samples.sweeping[:2]
    if sweep.size < _RESPONSE_S * samples.rate:
        return None
    change = np.diff(speed, axis=1) * samples.rate
    correlation = _correlations(sweep[:, 1:], change, samples.rate)
    best = int(np.argmax(np.abs(correlation)))
    if abs(correlation[best]) < 0.2:
        return None
    slope = abs(correlation[best]) * float(np.std(change) / np.std(sweep))
    return Measure(1 / slope)


def response_size(samples: Samples) -> Measure | None:
    """Largest correlation of speed and sweep, either sign, over the delays that occur."""
    correlation = _speed_correlations(samples)
    return None if correlation is None else Measure(float(np.max(np.abs(correlation))))


def response_sign(samples: Samples) -> Measure | None:
    """Largest plus most negative correlation of speed and sweep, over the larger, −2 to 2; None where both are small.

    Below −1 the speed moves against the sweep at all delays; about 0 the sweep is too narrow to tell.
    """
    correlation = _speed_correlations(samples)
    if correlation is None or np.max(np.abs(correlation)) < 0.1:
        return None
    return Measure(float((correlation.max() + correlation.min()) / np.max(np.abs(correlation))))


def _speed_correlations(samples: Samples) -> Floats | None:
    sweep, speed = samples.sweeping[:2]
    if sweep.size < _RESPONSE_S * samples.rate or not np.any(speed):
        return None
    return _correlations(sweep, speed, samples.rate)


def _command_gain(samples: Samples) -> tuple[float, float]:
    """Slope and correlation of the command's changes on those of the sweep, at the lag at which they agree best."""
    known = np.all(np.isfinite(samples.sweeping[2]), axis=1)
    if np.sum(known) * _BLOCK_S < _LEAST_S:
        return np.nan, 0.0
    sweep, command = (np.diff(samples.sweeping[channel][known], axis=1) for channel in (0, 2))
    if not np.any(sweep) or not np.any(command):
        return np.nan, 0.0
    ahead = _correlations(sweep, command, samples.rate)
    behind = _correlations(command, sweep, samples.rate)
    correlation = float(max(ahead.max(), behind.max()))
    return correlation * float(np.std(command) / np.std(sweep)), correlation


def _correlations(first: Floats, second: Floats, rate: float) -> Floats:
    """Correlations of two signals in blocks, shape (block, sample), the second up to 0.4 s later, shape (lag,)."""
    lags = np.arange(round(_LAGS_S * rate) + 1)
    lags = lags[lags < first.shape[1] // 2]
    scale = float(np.sqrt(np.mean(first**2) * np.mean(second**2)))
    size = first.shape[1]
    products = [float(np.mean(first[:, : size - lag] * second[:, lag:])) for lag in lags]
    return np.array(products) / (scale or 1.0)


def _median(values: Floats, where: Booleans) -> Measure | None:
    chosen = values[where & np.isfinite(values)]
    return Measure(float(np.median(chosen))) if chosen.size >= _LEAST_S else None


def _known(samples: Samples, name: str) -> tuple[Floats, NDArray[np.int64]]:
    """Values of a channel once a second, and their positions among the seconds."""
    values = samples.slow(name)
    known = np.flatnonzero(np.isfinite(values))
    return values[known], known
