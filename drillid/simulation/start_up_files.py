"""Files of a simulated start of rotation: surveys, top-drive speeds, time series."""

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from drillid.arrays import Floats
from drillid.errors import LogError, SettingsError, writing
from drillid.physics.soft_string import Survey
from drillid.simulation.start_up import RATE, STATISTICS_DELAY, StartUp
from drillid.simulation.start_up_fit import MeasuredStartUp
from drillid.units import RPM

if TYPE_CHECKING:
    import pandas as pd


COLUMNS = ("t_s", "td_rpm", "torque_knm", "bit_rpm", "bit_rpm_now")
"""Columns of a written simulation; `bit_rpm` as recorded, `bit_rpm_now` of the bit itself."""
LONGEST_INTERVAL = 0.1
"""s between samples of a prescribed top-drive speed; start-up has transients of a few tenths of a second."""
_REST_BEFORE = 1.0
_STANDSTILL = 3.0 * RPM


def read_table(path: Path, columns: tuple[str, ...]) -> "pd.DataFrame":
    """Numbers of a CSV file that has the given columns.

    Raises
    ------
    LogError
        If the file is missing, is not a CSV file, lacks a column or holds text in one.
    """
    import pandas as pd

    try:
        table = pd.read_csv(path)
    except (OSError, ValueError) as error:
        raise LogError(str(path), f"it cannot be read: {error}", "Give a CSV file with a header") from error
    missing = [name for name in columns if name not in table]
    if missing or table.empty:
        raise LogError(str(path), f"columns {missing} are missing or there is no row", f"Give {', '.join(columns)}")
    text = [name for name in columns if not pd.api.types.is_numeric_dtype(table[name])]
    if text:
        raise LogError(str(path), f"columns {text} are not numbers", "Write plain decimal numbers")
    return table


def read_survey(path: Path) -> Survey:
    """Survey from a CSV file with the columns depth_m, inclination_deg and, optionally, azimuth_deg.

    Raises
    ------
    LogError
        If the file cannot be read, lacks a column, or its stations do not form a survey.
    """
    table = read_table(path, ("depth_m", "inclination_deg"))
    if "azimuth_deg" in table:
        table = read_table(path, ("depth_m", "inclination_deg", "azimuth_deg"))
    azimuth = table["azimuth_deg"].to_numpy(float) if "azimuth_deg" in table else 0.0
    try:
        return Survey.from_degrees(table["depth_m"].to_numpy(float), table["inclination_deg"].to_numpy(float), azimuth)
    except SettingsError as error:
        raise LogError(str(path), error.what, error.remedy) from error


def read_top_speed(path: Path) -> tuple[float, Floats]:
    """First time (s) and speed of the top drive, (samples,) rad/s at RATE, from a CSV file.

    It has the columns t_s and td_rpm_measured; other rates are interpolated.

    Raises
    ------
    LogError
        If a value is missing, time does not increase or its steps are too coarse, or the top drive already turns.
    """
    table = read_table(path, ("t_s", "td_rpm_measured"))
    time, speed = table["t_s"].to_numpy(float), table["td_rpm_measured"].to_numpy(float) * RPM
    steps = np.diff(time)
    if not (np.all(np.isfinite(time)) and np.all(np.isfinite(speed))):
        raise LogError(str(path), "a time or a speed is missing", "Fill or cut the gap")
    if steps.size == 0 or steps.min() <= 0 or steps.max() > LONGEST_INTERVAL + 1e-9:
        raise LogError(
            str(path),
            f"its times do not rise in steps of at most {LONGEST_INTERVAL} s",
            "Give t_s in seconds, best at 100 Hz",
        )
    if abs(speed[0]) > _STANDSTILL:
        raise LogError(
            str(path),
            f"the top drive turns at {speed[0] / RPM:.1f} rpm at the first sample",
            "Begin before the start of rotation",
        )
    regular = np.arange(time[0], time[-1] + 0.5 / RATE, 1 / RATE)
    return float(time[0]), np.asarray(np.interp(regular, time, speed), dtype=float)


def read_start_up(path: Path) -> MeasuredStartUp:
    """A measured start of rotation from a CSV file with the columns of `read_top_speed` and torque_knm_measured.

    The least and greatest speed of the bit in each half second, bit_rpm_min_measured and bit_rpm_max_measured, may be
    missing.

    Raises
    ------
    LogError
        As `read_top_speed`, and if a torque is missing.
    """
    first, speed = read_top_speed(path)
    table = read_table(path, ("t_s", "torque_knm_measured"))
    regular = first + np.arange(speed.size) / RATE

    def series(name: str, unit: float) -> Floats:
        if name not in table:
            return np.full(speed.size, np.nan)
        return np.asarray(unit * np.interp(regular, table["t_s"], table[name].to_numpy(float)), dtype=float)

    torque = series("torque_knm_measured", 1e3)
    if not np.all(np.isfinite(torque)):
        raise LogError(str(path), "a torque is missing", "Fill or cut the gap")
    return MeasuredStartUp(speed, torque, series("bit_rpm_min_measured", RPM), series("bit_rpm_max_measured", RPM))


def ramped_speed(rpm: float, ramp: float, duration: float) -> Floats:
    """Smooth ramp from rest to `rpm` within `ramp` s, starting after 1 s, (samples,) rad/s at RATE."""
    time = np.arange(round(duration * RATE) + 1) / RATE
    share = np.clip((time - _REST_BEFORE) / ramp, 0.0, 1.0)
    return np.asarray(rpm * RPM * share**2 * (3 - 2 * share), dtype=float)


def write_start_up(result: StartUp, top_speed: Floats, path: Path, first_time: float = 0.0) -> None:
    """Write COLUMNS at RATE to a CSV file; t_s of the first sample is `first_time`, s."""
    import pandas as pd

    speeds = (top_speed[: result.time.size] / RPM, result.torque / 1e3, result.recorded_bit_speed() / RPM)
    series = (first_time + result.time, *speeds, result.bit_speed / RPM)
    with writing(path, "--output", LogError):
        pd.DataFrame(dict(zip(COLUMNS, series, strict=True))).to_csv(path, index=False, float_format="%.4f")


def summary(result: StartUp, depth: float) -> str:
    """Text: greatest torque of a simulation, and range of torque and bit speed over its last third."""
    last = slice(result.time.size * 2 // 3, None)
    torque, bit = result.torque / 1e3, result.bit_speed[last] / RPM
    moving = np.flatnonzero(result.bit_speed > _STANDSTILL)
    start = f"turns from {result.time[moving[0]]:.1f} s on" if moving.size else "never turns"
    return (
        f"bit at {depth:g} m: {start}; greatest torque {torque.max():.1f} kN m\n"
        f"last third: torque {torque[last].mean():.1f} kN m on the mean, {torque[last].min():.1f} to "
        f"{torque[last].max():.1f}; bit {bit.min():.0f} to {bit.max():.0f} rpm, at rest {np.mean(bit < 1):.0%} of it\n"
        f"bit_rpm in the file is {STATISTICS_DELAY} s late, as half-second statistics stamped at their end"
    )
