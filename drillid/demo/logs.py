"""Log files of a demo rig: columns, units and resolution, file format and recording faults."""

import datetime
import gzip
import io
import zoneinfo
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from drillid.arrays import Floats
from drillid.config.rig import CHANNEL_UNITS, Channel
from drillid.errors import LogError
from drillid.units import to_si_factor

Stamps = NDArray[np.datetime64]


@dataclass(frozen=True)
class LogColumn:
    """One column of the log: header, channel, unit and decimals."""

    header: str
    channel: Channel
    unit: str
    decimals: int


@dataclass(frozen=True)
class Faults:
    """Recording faults, in each file."""

    jitter: float = 0.0
    """s, root mean square error of the time stamps."""
    dropped_share: float = 0.0
    """Share of rows that are lost individually."""
    speed_spikes: int = 0
    """Samples at which the speed reads zero while the string turns."""
    gap: float = 0.0
    """s, length of one gap in the middle of the drilled time."""


@dataclass(frozen=True)
class LogWriter:
    """Log format of one rig, and its faults."""

    time_header: str
    columns: tuple[LogColumn, ...]
    zone: str | None = None
    """Time zone of stamps that are written without one; None for UTC stamps marked as such."""
    faults: Faults = Faults()

    def write(
        self,
        path: Path,
        time: Floats,
        channels: Mapping[str, Floats],
        drilling_s: float,
        generator: np.random.Generator,
    ) -> None:
        """Write one log; the file's name gives its start as ..._YYYYmmddTHHMM, in UTC.

        Parameters
        ----------
        time : (rows,) s since the start
        channels : (rows,) each, SI units
        drilling_s : s, drilled time at the start of the log, where the faults occur
        """
        stamps, values = self._with_faults(time, channels, drilling_s, generator)
        times = np.datetime64(_start(path), "us") + np.rint(stamps * 1e3).astype("timedelta64[ms]")
        columns: dict[str, Floats] = {}
        for column in self.columns:
            factor = to_si_factor(column.unit, CHANNEL_UNITS[column.channel])
            # The sum turns −0.0 into 0.0, as no rig logs a signed zero.
            columns[column.header] = np.round(values[column.channel] / factor, column.decimals) + 0.0
        path.parent.mkdir(parents=True, exist_ok=True)
        if path.name.endswith(".parquet"):
            self._write_parquet(path, times, columns)
        else:
            self._write_csv(path, times, columns)

    def _with_faults(
        self, time: Floats, channels: Mapping[str, Floats], drilling_s: float, generator: np.random.Generator
    ) -> tuple[Floats, dict[str, Floats]]:
        faults = self.faults
        interval = time[1] - time[0]
        values = dict(channels)
        if faults.speed_spikes:
            where = generator.choice(np.flatnonzero(time < drilling_s), faults.speed_spikes, replace=False)
            values["speed"] = values["speed"].copy()
            values["speed"][where] = 0.0
        kept = generator.random(time.size) >= faults.dropped_share
        middle = drilling_s / 2
        kept &= (time < middle - faults.gap / 2) | (time >= middle + faults.gap / 2)
        error = np.clip(faults.jitter * generator.standard_normal(time.size), -0.4 * interval, 0.4 * interval)
        return (time + error)[kept], {name: series[kept] for name, series in values.items()}

    def _write_parquet(self, path: Path, times: Stamps, columns: dict[str, Floats]) -> None:
        import pyarrow as pa
        from pyarrow import parquet

        stamps = pa.array(times).cast(pa.timestamp("us", tz="UTC"))
        parquet.write_table(pa.table({self.time_header: stamps, **columns}), path)

    def _write_csv(self, path: Path, times: Stamps, columns: dict[str, Floats]) -> None:
        import pyarrow as pa
        from pyarrow import csv

        table = pa.table({self.time_header: self._formatted(times), **columns})
        buffer = io.BytesIO()
        buffer.write((",".join(table.column_names) + "\n").encode())
        csv.write_csv(table, buffer, csv.WriteOptions(include_header=False, quoting_style="none"))
        # A time stamp in the gzip header would make equal logs differ.
        content = gzip.compress(buffer.getvalue(), mtime=0) if path.suffix == ".gz" else buffer.getvalue()
        path.write_bytes(content)

    def _formatted(self, times: Stamps) -> NDArray[np.str_]:
        if self.zone is None:
            return np.strings.add(np.datetime_as_string(times, unit="ms"), "Z")
        start = times[0].item().replace(tzinfo=datetime.UTC)
        offset = np.timedelta64(start.astimezone(zoneinfo.ZoneInfo(self.zone)).utcoffset())
        return np.strings.replace(np.datetime_as_string(times + offset, unit="ms"), "T", " ")


def _start(path: Path) -> datetime.datetime:
    stem = path.name.partition(".")[0]
    try:
        return datetime.datetime.strptime(stem.rpartition("_")[2], "%Y%m%dT%H%M")
    except ValueError as error:
        raise LogError(
            str(path), "the name of a demo log must end in its start", "Name it like D01_20250601T0600.csv"
        ) from error
