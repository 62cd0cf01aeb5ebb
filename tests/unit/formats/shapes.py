"""One simulated log in the shapes in which rigs and offices export it, each with the description a user would write."""

from __future__ import annotations

import io
import zipfile
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pandas as pd
import pyarrow as pa
from nptdms import ChannelObject, GroupObject, RootObject, TdmsWriter
from scipy.io import savemat

from tests.raw_logs import START
from tests.unit.formats.las_and_witsml import (
    las_3,
    las_date_and_time,
    las_iso,
    las_wrapped,
    witsml_1311,
    witsml_1411,
    witsml_lists_only,
)
from tests.unit.formats.numbers import NUMBERS, UNITS, iso, since_1970

CHANNELS = {
    "torque_command": {"column": "TQ", "unit": "kN m"},
    "torque_sweep": {"column": "SWEEP", "unit": "kN m"},
    "speed": {"column": "RPM", "unit": "rpm"},
    "speed_set": {"column": "SET", "unit": "rpm"},
    "hole_depth": {"column": "HOLE", "unit": "m"},
    "bit_depth": {"column": "BIT", "unit": "m"},
    "flow": {"column": "FLOW", "unit": "L/min"},
}
WITHOUT_UNITS = {name: {"column": column["column"]} for name, column in CHANNELS.items()}


@dataclass(frozen=True)
class Shape:
    """A shape of the log.

    write : writes it into a folder and returns its files
    description : keys of the rig description beside the name; the channels with their units where it has none
    start : of the log, UTC
    told : what the problem rows must say
    """

    write: Callable[[pd.DataFrame, Path], list[Path]]
    description: dict[str, Any] = field(default_factory=dict)
    start: pd.Timestamp = START
    told: tuple[str, ...] = ()


def _text(
    name: str, stamps: Callable[[pd.DataFrame], Any], encoding: str = "utf-8", head: str = "", **form: Any
) -> Any:
    """A writer of delimited text with times in some form."""

    def write(log: pd.DataFrame, folder: Path) -> list[Path]:
        columns = form.pop("columns", {}) if "columns" in form else {}
        text = log.assign(Time=stamps(log)).rename(columns=columns).to_csv(index=False, **form)
        (folder / name).write_bytes((head + text).encode(encoding))
        return [folder / name]

    return write


def _form(written: str, cut: int = 3) -> Callable[[pd.DataFrame], Any]:
    """Written times; `cut` digits of the microseconds are left out."""
    return lambda log: log["Time"].dt.strftime(written).str[: -cut or None]


def _am_pm(log: pd.DataFrame) -> Any:
    return log["Time"].dt.strftime("%m/%d/%Y %I:%M:%S.%f").str[:-3] + log["Time"].dt.strftime(" %p")


def _local(zone: str, written: str) -> Callable[[pd.DataFrame], Any]:
    def stamps(log: pd.DataFrame) -> Any:
        return log["Time"].dt.tz_localize("UTC").dt.tz_convert(zone).dt.strftime(written).str[:-3]

    return stamps


def _mat_5(log: pd.DataFrame, folder: Path) -> list[Path]:
    datenum = 719529 + since_1970(log) / 86400
    columns = {name: log[name].to_numpy()[:, None] for name in NUMBERS}
    savemat(folder / "log.mat", {"rig": "Rig 7", "data": {"Time": datenum[:, None], **columns, "units": UNITS}})
    return [folder / "log.mat"]


def _mat_channels(log: pd.DataFrame, folder: Path) -> list[Path]:
    """An array of structures, one a channel."""
    columns = {"Time": since_1970(log), **log[NUMBERS].to_dict("series")}
    channels = [(name, np.asarray(values, dtype=float), UNITS.get(name, "s")) for name, values in columns.items()]
    kinds = [("Name", "O"), ("Data", "O"), ("Unit", "O")]
    savemat(folder / "log.mat", {"channels": np.array(channels, dtype=kinds)})
    return [folder / "log.mat"]


def _mat_matrix(log: pd.DataFrame, folder: Path) -> list[Path]:
    """A matrix as importdata makes it."""
    matrix = np.column_stack([719529 + since_1970(log) / 86400, log[NUMBERS]])
    names = np.array(["Time", *NUMBERS], dtype=object)
    savemat(folder / "log.mat", {"log": {"data": matrix, "colheaders": names}})
    return [folder / "log.mat"]


def _mat_73(log: pd.DataFrame, folder: Path) -> list[Path]:
    path = folder / "log.mat"
    with h5py.File(path, "w", userblock_size=512) as file:
        group = file.create_group("log")
        for name, values in {"Time": since_1970(log), **log[NUMBERS].to_dict("series")}.items():
            item = group.create_dataset(name, data=np.asarray(values, dtype=float)[None, :])
            item.attrs["MATLAB_class"] = np.bytes_("double")
    with path.open("r+b") as content:
        content.write(
            b"MATLAB 7.3 MAT-file, Platform: GLNXA64, Created on: Mon Mar  3 06:00:00 2025".ljust(124) + b"\x00\x02IM"
        )
    return [path]


def _hdf5(log: pd.DataFrame, folder: Path) -> list[Path]:
    """Groups of one run, units in attributes, a group of other length beside."""
    with h5py.File(folder / "log.h5", "w") as file:
        run = file.create_group("well/run 1")
        run["Time"] = (since_1970(log) * 1e6).round().astype(np.int64)
        for name in NUMBERS:
            run[name] = log[name].to_numpy(dtype=np.float32 if name == "FLOW" else float)
            run[name].attrs["units"] = UNITS[name]
        file.create_group("well/survey")["MD"] = np.arange(9.0)
        file["well/survey"]["INC"] = np.arange(9.0)
    return [folder / "log.h5"]


def _tdms(log: pd.DataFrame, folder: Path) -> list[Path]:
    """Waveforms: no column of times, but a start and an interval."""
    start = log["Time"].iloc[0].to_datetime64()
    with TdmsWriter(folder / "log.tdms") as writer:
        objects: list[Any] = [RootObject({"name": "log"}), GroupObject("Rig", {})]
        for name in NUMBERS:
            properties = {
                "wf_start_time": start,
                "wf_increment": 0.02,
                "wf_start_offset": 0.0,
                "unit_string": UNITS[name],
            }
            objects.append(ChannelObject("Rig", name, log[name].to_numpy(dtype=float), properties))
        writer.write_segment(objects)
    return [folder / "log.tdms"]


def _excel(log: pd.DataFrame, folder: Path) -> list[Path]:
    """A US office's workbook: a cover sheet, titles above the names, units below, true dates in the cells."""
    head = pd.DataFrame([["Rig 7 - time log"], ["Exported 3/3/2025"]])
    names = pd.DataFrame([list(log), ["", *UNITS.values()]])
    with pd.ExcelWriter(folder / "log.xlsx") as book:
        pd.DataFrame([["Rig 7", "confidential"]]).to_excel(book, sheet_name="Cover", index=False, header=False)
        head.to_excel(book, sheet_name="Data", index=False, header=False)
        names.to_excel(book, sheet_name="Data", index=False, header=False, startrow=3)
        log.to_excel(book, sheet_name="Data", index=False, header=False, startrow=5)
    return [folder / "log.xlsx"]


def _excel_serial(log: pd.DataFrame, folder: Path) -> list[Path]:
    log.assign(Time=25569 + since_1970(log) / 86400).to_excel(folder / "log.xlsx", index=False)
    return [folder / "log.xlsx"]


def _packed(log: pd.DataFrame, folder: Path) -> list[Path]:
    buffer = io.BytesIO()
    with zipfile.ZipFile(buffer, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("export/Rig 7.csv", log.assign(Time=iso(log)).to_csv(index=False))
    (folder / "log.zip").write_bytes(buffer.getvalue())
    return [folder / "log.zip"]


def _zst(log: pd.DataFrame, folder: Path) -> list[Path]:
    text = log.assign(Time=iso(log)).to_csv(index=False).encode()
    (folder / "log.csv.zst").write_bytes(pa.Codec("zstd").compress(text, asbytes=True))
    return [folder / "log.csv.zst"]


def _feather(log: pd.DataFrame, folder: Path) -> list[Path]:
    log.to_feather(folder / "log.feather")
    return [folder / "log.feather"]


def _thousands(log: pd.DataFrame, folder: Path) -> list[Path]:
    written = log.assign(Time=iso(log), HOLE=[f"{value:,.4f}" for value in log["HOLE"]])
    written.assign(FLOW=[f"{value:,.1f}" for value in log["FLOW"]]).to_csv(folder / "log.csv", index=False)
    return [folder / "log.csv"]


def _split(log: pd.DataFrame, folder: Path) -> list[Path]:
    stamps = log["Time"].dt
    apart = log.assign(Time=stamps.strftime("%H:%M:%S.%f").str[:-3])
    apart.insert(0, "Date", stamps.strftime("%d.%m.%Y"))
    apart.to_csv(folder / "log.csv", index=False)
    return [folder / "log.csv"]


def _by_form(log: pd.DataFrame, folder: Path) -> list[Path]:
    """Date and time under their forms, as an electronic drilling recorder exports them."""
    times = log["Time"].dt
    apart = {"YYYY/MM/DD": times.strftime("%Y/%m/%d"), "HH:MM:SS": times.strftime("%H:%M:%S.%f")}
    pd.DataFrame(apart).join(log[NUMBERS]).to_csv(folder / "log.csv", index=False)
    return [folder / "log.csv"]


def _units_row(log: pd.DataFrame, folder: Path) -> list[Path]:
    rows = log.assign(Time=iso(log)).to_csv(index=False, header=False)
    (folder / "log.csv").write_text(f"{','.join(log)}\n(),{','.join(f'({unit})' for unit in UNITS.values())}\n{rows}")
    return [folder / "log.csv"]


def _two_lines(log: pd.DataFrame, folder: Path) -> list[Path]:
    """'Depth' of hole and bit, 'Torque' of sweep and command: only the line above tells which."""
    rows = log.assign(Time=iso(log)).to_csv(index=False, header=False)
    upper, lower = (",".join(["", *parts]) for parts in zip(*map(str.split, _TWO_NAMES.values()), strict=True))
    units = ",".join(["", *(UNITS[name] for name in _TWO_NAMES)])
    (folder / "log.csv").write_text(f"{upper}\nTime{lower}\n{units}\n{rows}")
    return [folder / "log.csv"]


def _printed(log: pd.DataFrame, folder: Path) -> list[Path]:
    """Pages with a header each, totals without a time and remarks at the end."""
    names, *rows = log.assign(Time=iso(log)).to_csv(index=False).splitlines()
    between = [names, "Page 2 of 2", "," * names.count(",")]
    end = ["", "Total,12.5,,3", '"End of file, 1500 rows"', ""]
    (folder / "log.csv").write_text("\n".join([names, *rows[:10], *between, *rows[10:], *end]))
    return [folder / "log.csv"]


def _totalled(log: pd.DataFrame, folder: Path) -> list[Path]:
    names = pd.DataFrame([list(log)])
    with pd.ExcelWriter(folder / "log.xlsx") as book:
        for part, top in ((names, 0), (log[:10], 1), (names, 11), (log[10:], 12), (_TOTAL, 12 + len(log))):
            part.to_excel(book, index=False, header=False, startrow=top)
    return [folder / "log.xlsx"]


def _cut(log: pd.DataFrame, folder: Path) -> list[Path]:
    """A log that is copied while the recorder writes it."""
    text = log.assign(Time=iso(log)).to_csv(index=False)
    (folder / "log.csv").write_text(text + "2025-03-03T06:00:59.98Z,1.2")
    return [folder / "log.csv"]


def _slow_depth(log: pd.DataFrame, folder: Path) -> list[Path]:
    fast = log[["Time", "TQ", "SWEEP", "RPM", "SET"]]
    fast.assign(Time=iso(fast)).to_csv(folder / "fast.csv", index=False)
    slow = log.iloc[::50][["Time", "HOLE", "BIT", "FLOW"]]
    last = log.iloc[[-1]][["Time", "HOLE", "BIT", "FLOW"]]
    slow = pd.concat([slow, last])
    slow.assign(Time=iso(slow)).to_csv(folder / "fast_depth.csv", index=False)
    return [folder / "fast.csv", folder / "fast_depth.csv"]


_TOTAL = pd.DataFrame([["Total", None, 3.5]])
_TWO_NAMES = {"TQ": "Command Torque", "SWEEP": "Sweep Torque", "RPM": "Actual Speed", "SET": "Set Speed"}
_TWO_NAMES |= {"HOLE": "Hole Depth", "BIT": "Bit Depth", "FLOW": "Flow In"}
_TWO_LINES = {name: {"column": _TWO_NAMES[column["column"]]} for name, column in CHANNELS.items()}
_GERMAN = {"time": {"zone": "Europe/Berlin", "format": "day first"}}
_WITS = {"TQ": "TQA", "RPM": "RPMA", "HOLE": "DMEA", "BIT": "DBTM", "FLOW": "MFIA"}
_WITS_NAMES = {name: f"{_WITS.get(name, name)} ({unit})" for name, unit in UNITS.items()}

SHAPES: dict[str, Shape] = {
    "comma": Shape(_text("log.csv", iso)),
    "LAS": Shape(las_iso, {"channels": WITHOUT_UNITS}),
    "LAS wrapped, seconds": Shape(las_wrapped, {"time": {"start": "2025-03-03T06:00:00Z"}, "channels": WITHOUT_UNITS}),
    "LAS with date and time apart": Shape(las_date_and_time, {"channels": WITHOUT_UNITS}),
    "LAS 3.0": Shape(las_3, {"channels": WITHOUT_UNITS}),
    "WITSML 1.3.1.1": Shape(witsml_1311, {"channels": WITHOUT_UNITS}),
    "WITSML 1.4.1.1": Shape(witsml_1411, {"channels": WITHOUT_UNITS}),
    "WITSML of a gateway": Shape(witsml_lists_only, {"channels": WITHOUT_UNITS}),
    "MAT 5, datenum": Shape(_mat_5, {"channels": WITHOUT_UNITS}, told=("days of MATLAB",)),
    "MAT 5, a structure a channel": Shape(_mat_channels, {"channels": WITHOUT_UNITS}, told=("read as s since 1970",)),
    "MAT 5, matrix": Shape(_mat_matrix, told=("days of MATLAB",)),
    "MAT 7.3, epoch": Shape(_mat_73, told=("read as s since 1970",)),
    "HDF5 groups": Shape(_hdf5, {"channels": WITHOUT_UNITS}, told=("read as us since 1970",)),
    "TDMS waveforms": Shape(_tdms, {"channels": WITHOUT_UNITS}),
    "workbook": Shape(
        _excel, {"channels": WITHOUT_UNITS}, told=("taken from line 4 and the units are taken from line 5",)
    ),
    "workbook, serial dates": Shape(_excel_serial, told=("days of a workbook",)),
    "zip": Shape(_packed),
    "zst": Shape(_zst),
    "feather": Shape(_feather),
    "tab": Shape(_text("log.txt", iso, sep="\t")),
    "semicolon": Shape(_text("log.csv", iso, sep=";")),
    "German office": Shape(
        _text(
            "log.csv",
            _local("Europe/Berlin", "%d.%m.%Y %H:%M:%S,%f"),
            "cp1252",
            "Bohrgerät 7\r\n\r\n",
            sep=";",
            decimal=",",
        ),
        _GERMAN,
        told=("taken from line 3", "decimal comma"),
    ),
    "Norwegian office": Shape(
        _text("log.csv", _local("Europe/Oslo", "%d.%m.%Y %H.%M.%S.%f"), "utf-16", sep="\t", decimal=","),
        {"time": {"zone": "Europe/Oslo"}},
        START + pd.Timedelta(days=1),
        told=("decimal comma", "day first, as dates with points are"),
    ),
    "thousands": Shape(_thousands, told=("',' in numbers such as",)),
    "day first": Shape(
        _text("log.csv", _form("%d/%m/%Y %H:%M:%S.%f")),
        start=START + pd.Timedelta(days=21),
        told=("read as day first",),
    ),
    "month first, AM and PM": Shape(_text("log.csv", _am_pm), {"time": {"format": "month first"}}),
    "epoch in s": Shape(_text("log.csv", since_1970), told=("read as s since 1970",)),
    "epoch in ms": Shape(
        _text("log.csv", lambda log: (since_1970(log) * 1e3).round().astype(np.int64)), told=("ms since",)
    ),
    "epoch in us": Shape(
        _text("log.csv", lambda log: (since_1970(log) * 1e6).round().astype(np.int64)), told=("us since",)
    ),
    "epoch in ns": Shape(
        _text("log.csv", lambda log: log["Time"].astype("datetime64[ns]").astype(np.int64)), told=("ns since",)
    ),
    "seconds from a start": Shape(
        _text("log.csv", lambda log: (since_1970(log) - since_1970(log)[0]).round(3)),
        {"time": {"start": "2025-03-03T07:00:00", "zone": "Europe/Oslo"}},
    ),
    "serial dates": Shape(_text("log.csv", lambda log: 25569 + since_1970(log) / 86400), {"time": {"unit": "excel"}}),
    "split date and time": Shape(_split, told=("dates are taken from column 'Date'",)),
    "columns named by their forms": Shape(_by_form, told=("dates are taken from column 'YYYY/MM/DD'",)),
    "units in a row": Shape(_units_row, {"channels": WITHOUT_UNITS}, told=("units are taken from line 2",)),
    "junk header": Shape(
        _text("log.csv", iso, head="Well: 34/10-A-12 H, Rig 7\nExported: 2025-03-04, by nobody, at all\n***\n\n"),
        told=("names of the columns are taken from line 5",),
    ),
    "names on two lines": Shape(_two_lines, {"channels": _TWO_LINES}, told=("from the lines 1 and 2",)),
    "header, total and remarks among the data": Shape(
        _printed,
        told=(
            "line 12 is not a row of data and is left out: 'Time, TQ",
            "line 13 is not a row of data and is left out: 'Page 2 of",
            "left out: 'Total, 12.5, 3'",
            "left out: 'End of file, 1500 rows'",
        ),
    ),
    "workbook with total": Shape(
        _totalled, told=("row 12 is not a row of data and is left out: 'Time,", "'Total, 3.5'")
    ),
    "cut in its last line": Shape(_cut, told=("is not a row of data and is left out: '2025-03-03T06:00:",)),
    "reversed": Shape(lambda log, folder: _text("log.csv", iso)(log.iloc[::-1], folder), told=("out of order",)),
    "shuffled": Shape(
        lambda log, folder: _text("log.csv", iso)(log.sample(frac=1, random_state=1), folder), told=("out of order",)
    ),
    "local zone, clocks set back": Shape(
        _text("log.csv", _local("Europe/Oslo", "%Y-%m-%d %H:%M:%S.%f")),
        {"time": {"zone": "Europe/Oslo"}},
        pd.Timestamp("2025-10-26T00:59:45"),
    ),
    "WITS mnemonics": Shape(
        _text("log.csv", iso, columns=_WITS_NAMES),
        {"channels": {"torque_sweep": {"column": "SWEEP"}, "speed_set": {"column": "SET"}}},
        told=("its mnemonic in WITS",),
    ),
    "slow depth apart": Shape(_slow_depth, told=("hole_depth, bit_depth, flow taken from fast_depth.csv at 1 Hz",)),
}
