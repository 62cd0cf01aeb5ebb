"""Small logs in good order, written in every format, from which mutated files are made."""

import bz2
import gzip
import io
import lzma
import zipfile
from collections.abc import Callable, Mapping
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
import pandas as pd
import pyarrow as pa

from drillid.formats import formats
from tests.raw_logs import START, drilling, standstill

Write = Callable[[pd.DataFrame], bytes]


def logs() -> list[pd.DataFrame]:
    """Drilling, drilling with a connection, and drilling with faults, 5 to 8 s each; stamps in UTC."""
    whole = drilling(5.0)
    connected = pd.concat([drilling(5.0), standstill(3.0, START + pd.Timedelta(seconds=5), 2000.06)])
    faulty = drilling(7.0, 2).drop(index=[*range(40, 43), *range(150, 190)])
    faulty.loc[[20, 250], "RPM"] = 0.0
    faulty["HOLE"] = faulty["HOLE"].where(faulty.index % 50 == 0)
    return [log.reset_index(drop=True) for log in (whole, connected, faulty)]


def _text(log: pd.DataFrame, stamp: Callable[[pd.Timestamp], str] | None = None, **options: object) -> str:
    stamps = [_cell(value, stamp) for value in log["Time"]]
    return str(log.assign(Time=stamps).to_csv(index=False, float_format="%.6g", lineterminator="\n", **options))


def _cell(value: object, stamp: Callable[[pd.Timestamp], str] | None) -> object:
    if not isinstance(value, pd.Timestamp):
        return value
    return value.isoformat() + "Z" if stamp is None else stamp(value)


def csv(log: pd.DataFrame) -> bytes:
    """Comma-separated text with ISO stamps."""
    return _text(log).encode("utf-8", "surrogateescape")


def european_csv(log: pd.DataFrame) -> bytes:
    """Semicolons, decimal commas, day first, as offices export."""
    day_first = _text(log, lambda stamp: stamp.strftime("%d.%m.%Y %H:%M:%S.%f")[:-3], sep=";", decimal=",")
    return b"Rig;7\n\n" + day_first.encode("utf-8", "surrogateescape")


def epoch_csv(log: pd.DataFrame) -> bytes:
    """Tabs, a row of units, and milliseconds since 1970."""
    text = _text(log, lambda stamp: str(stamp.value // 1_000_000), sep="\t")
    head, _, body = text.partition("\n")
    return f"{head}\n{chr(9).join(['ms', *['-'] * (len(log.columns) - 1)])}\n{body}".encode("utf-8", "surrogateescape")


def parquet(log: pd.DataFrame) -> bytes:
    """Apache Parquet, Snappy by page."""
    buffer = io.BytesIO()
    _zoned(log).to_parquet(buffer, index=False)
    return buffer.getvalue()


def plain_parquet(log: pd.DataFrame) -> bytes:
    """The same without compression or dictionaries, so that a byte that changes is a value that changes."""
    buffer = io.BytesIO()
    _zoned(log).to_parquet(buffer, index=False, compression=None, use_dictionary=False, row_group_size=200)
    return buffer.getvalue()


def feather(log: pd.DataFrame) -> bytes:
    """Apache Feather."""
    buffer = io.BytesIO()
    _zoned(log).to_feather(buffer)
    return buffer.getvalue()


_UNITS = {"TQ": "kN.m", "SWEEP": "kN.m", "RPM": "rpm", "SET": "rpm", "HOLE": "ft", "BIT": "ft", "FLOW": "L/min"}
"""Of the columns of the logs, for formats that state them."""


def excel(log: pd.DataFrame) -> bytes:
    """An Excel workbook."""
    buffer = io.BytesIO()
    log.head(40).to_excel(buffer, index=False)
    return buffer.getvalue()


def las(log: pd.DataFrame) -> bytes:
    """LAS 2.0 against time."""
    curves = "\n".join(f" {name}.{_UNITS.get(str(name), '')} : {name}" for name in log.columns)
    body = _text(log.fillna(-999.25) if log.isna().any().any() else log, sep=" ").partition("\n")[2]
    head = (
        "~Version\n VERS. 2.0 : CWLS LAS\n WRAP. NO : one line per step\n~Well\n STRT.s 0 : start\n STOP.s 0 : stop\n"
        f" STEP.s 0 : step\n NULL. -999.25 : null\n WELL. W1 : well\n~Curve\n{curves}\n~ASCII\n"
    )
    return (head + body).encode("utf-8", "surrogateescape")


def witsml(log: pd.DataFrame) -> bytes:
    """A WITSML 1.4.1.1 log."""
    names = [str(name) for name in log.columns]
    units = [_UNITS.get(name, "") for name in names]
    info = "".join(
        f'<logCurveInfo uid="{name}"><mnemonic>{name}</mnemonic><unit>{unit}</unit>'
        f"<typeLogData>{'date time' if name == 'Time' else 'double'}</typeLogData></logCurveInfo>"
        for name, unit in zip(names, units, strict=True)
    )
    rows = "".join(f"<data>{row}</data>\n" for row in _text(log).splitlines()[1:])
    return (
        '<?xml version="1.0" encoding="UTF-8"?>\n<logs xmlns="http://www.witsml.org/schemas/1series" version="1.4.1.1">'
        '<log uidWell="w" uidWellbore="b" uid="l"><nameWell>W1</nameWell><indexType>date time</indexType>'
        f"<indexCurve>Time</indexCurve>{info}<logData><mnemonicList>{','.join(names)}</mnemonicList>"
        f"<unitList>{','.join(units)}</unitList>{rows}</logData></log></logs>"
    ).encode("utf-8", "surrogateescape")


def tdms(log: pd.DataFrame) -> bytes:
    """National Instruments TDMS."""
    from nptdms import ChannelObject, TdmsWriter

    buffer = io.BytesIO()
    with TdmsWriter(buffer) as writer:
        writer.write_segment([ChannelObject("log", str(name), _plain(log[name])) for name in log.columns])
    return buffer.getvalue()


def hdf5(log: pd.DataFrame) -> bytes:
    """HDF5, one dataset a column, stamps as text."""
    import h5py

    buffer = io.BytesIO()
    with h5py.File(buffer, "w") as file:
        for name in log.columns:
            values = _plain(log[name])
            values = values.astype("datetime64[ms]").astype(str) if values.dtype.kind == "M" else values
            file[str(name)] = values.astype("S") if values.dtype.kind in "UO" else values
    return buffer.getvalue()


def matlab(log: pd.DataFrame) -> bytes:
    """MATLAB 5, stamps as serial dates."""
    from scipy.io import savemat

    buffer = io.BytesIO()
    columns = {str(name): _plain(log[name]) for name in log.columns}
    columns = {
        name: 719_529 + values.astype("datetime64[ns]").astype(np.int64) / 86.4e12
        if values.dtype.kind == "M"
        else values
        for name, values in columns.items()
    }
    savemat(
        buffer, {name: values if values.dtype.kind != "O" else values.astype(str) for name, values in columns.items()}
    )
    return buffer.getvalue()


def netcdf(log: pd.DataFrame) -> bytes:
    """NetCDF 4."""
    import xarray as xr

    columns = {str(name): ("row", _plain(log[name])) for name in log.columns}
    with TemporaryDirectory() as folder:
        path = Path(folder) / "log.nc"
        xr.Dataset(columns).to_netcdf(path, engine="h5netcdf")
        return path.read_bytes()


def zarr(log: pd.DataFrame) -> bytes:
    """A zarr store as xarray writes them, its files in a zip archive without compression."""
    import zarr

    files = dict[str, Any]()
    store = zarr.storage.MemoryStore(files)
    group = zarr.create_group(store, zarr_format=2)
    for name in log.columns:
        values, attributes = _plain(log[name]), dict[str, Any]()
        if values.dtype.kind == "M":
            values = values.astype("datetime64[ns]").astype(np.int64)
            attributes = {"units": "nanoseconds since 1970-01-01", "calendar": "proleptic_gregorian"}
        attributes["_ARRAY_DIMENSIONS"] = ["row"]
        group.create_array(str(name), data=values, attributes=attributes)
    return archive({path: content.to_bytes() for path, content in sorted(files.items())})


def archive(files: Mapping[str, bytes], packing: int = zipfile.ZIP_STORED) -> bytes:
    """Files in a zip archive."""
    buffer = io.BytesIO()
    with zipfile.ZipFile(buffer, "w", packing) as opened:
        for name, content in files.items():
            opened.writestr(name, content)
    return buffer.getvalue()


WITS_CODES = {
    "TQ": "0118",
    "SWEEP": "0141",
    "RPM": "0120",
    "SET": "0142",
    "HOLE": "0110",
    "BIT": "0108",
    "FLOW": "0130",
}
"""Items of a WITS stream by the columns of the logs."""


def wits(log: pd.DataFrame) -> bytes:
    """Records of level 0, of the columns that have a code there."""
    columns = [name for name in log if name in WITS_CODES]
    records = []
    for row in log.to_dict("records"):
        stamp = row["Time"]
        items = [f"0105{stamp:%y%m%d}", f"0106{stamp:%H%M%S.%f}"] + [
            f"{WITS_CODES[name]}{row[name]}" for name in columns
        ]
        records.append("\r\n".join(["&&", *items, "!!", ""]))
    return "".join(records).encode("utf-8", "surrogateescape")


def lvm(log: pd.DataFrame) -> bytes:
    """A LabVIEW Measurement file of one segment, with a column of times since its start."""
    names = [str(name) for name in log.columns if name != "Time"]
    begin = log["Time"].iloc[0]
    per_channel = {
        "Samples": str(len(log)),
        "Date": f"{begin:%Y/%m/%d}",
        "Time": f"{begin:%H:%M:%S.%f}",
        "X0": "0.0",
        "Delta_X": "0.02",
    }
    lines = ["LabVIEW Measurement", "Writer_Version\t2", "Separator\tTab", "Decimal_Separator\t.", "X_Columns\tOne"]
    lines += ["***End_of_Header***", "", f"Channels\t{len(names)}"]
    lines += ["\t".join([key, *[cell] * len(names)]) for key, cell in per_channel.items()]
    lines += ["\t".join(["Y_Unit_Label", *(_UNITS.get(name, "") for name in names)])]
    lines += ["***End_of_Header***", "\t".join(["X_Value", *names, "Comment"])]
    elapsed = log.assign(Time=(log["Time"] - begin) / pd.Timedelta("1s"))
    body = _text(elapsed, sep="\t").partition("\n")[2]
    return ("\r\n".join(lines) + "\r\n" + body).encode("utf-8", "surrogateescape")


def _zoned(log: pd.DataFrame) -> pd.DataFrame:
    stamps = log["Time"]
    return log.assign(Time=stamps.dt.tz_localize("UTC")) if stamps.dtype.kind == "M" else log


def _plain(column: "pd.Series[object]") -> np.ndarray:
    values = column.to_numpy()
    return values.astype(str) if values.dtype.kind == "O" else values


_TEXTS = (csv, european_csv, epoch_csv)
_BY_READER: Mapping[str, tuple[Write, ...]] = {
    ".csv": _TEXTS,
    ".parquet": (parquet, plain_parquet),
    ".feather": (feather,),
    ".xlsx": (excel,),
    ".las": (las,),
    ".xml": (witsml,),
    ".wits": (wits,),
    ".lvm": (lvm,),
    ".tdms": (tdms,),
    ".h5": (hdf5,),
    ".mat": (hdf5, matlab),
    ".nc": (netcdf,),
    ".zarr": (zarr,),
}
"""Writers by the first ending of each reader."""
_PACKINGS: Mapping[str, Callable[[bytes], bytes]] = {
    ".gz": lambda content: gzip.compress(content, 1, mtime=0),
    ".bz2": lambda content: bz2.compress(content, 1),
    ".xz": lambda content: lzma.compress(content, preset=0),
    ".zst": lambda content: bytes(pa.compress(content, "zstd", asbytes=True)),
    ".zip": lambda content: archive({"log.csv": content}, zipfile.ZIP_DEFLATED),
}
_PACKED_TOO = (".csv", ".las", ".parquet", ".mat")
"""Endings of files that are also packed."""


def suffixes() -> tuple[str, ...]:
    """Endings of all formats, plain and packed, in alphabetical order."""
    return tuple(sorted([*formats(), *(plain + packing for plain in _PACKED_TOO for packing in _PACKINGS)]))


def writers(suffix: str) -> tuple[Write, ...]:
    """Writers of files with an ending.

    Raises
    ------
    KeyError
        If there is none; a new format needs one here.
    """
    for packing, pack in _PACKINGS.items():
        if suffix.endswith(packing):
            return tuple(_packed(write, pack) for write in writers(suffix.removesuffix(packing)))
    return _BY_READER[formats()[suffix].SUFFIXES[0]]


def _packed(write: Write, pack: Callable[[bytes], bytes]) -> Write:
    return lambda log: pack(write(log))
