"""The same log written in every format that the library reads, by the formats' own libraries."""

import bz2
import gzip
import lzma
import shutil
import warnings
import zipfile
from collections.abc import Callable
from pathlib import Path
from typing import Any
from xml.sax.saxutils import escape

import h5py
import numpy as np
import pandas as pd
import pyarrow as pa
import xarray as xr
from nptdms import ChannelObject, TdmsWriter
from scipy.io import savemat

TIME = "Time"


def stamped(log: pd.DataFrame) -> pd.DataFrame:
    """The log with its times as ISO text."""
    return log.assign(**{TIME: [stamp if isinstance(stamp, str) else stamp.isoformat() for stamp in log[TIME]]})


def text_of(log: pd.DataFrame, **options: Any) -> str:
    """The log as delimited text."""
    return stamped(log).to_csv(index=False, **options)


def write_csv(log: pd.DataFrame, path: Path) -> None:
    """Plain text with commas."""
    path.write_text(text_of(log))


def write_las(log: pd.DataFrame, path: Path, delimiter: str = ",", units: dict[str, str] | None = None) -> None:
    """LAS 2.0 with commas, as cells may be empty or hold spaces."""
    curves = "".join(f" {name.replace(' ', '_')}.{(units or {}).get(name, '')} : {name}\n" for name in log)
    named = {"COMMA": ",", "SPACE": " ", "TAB": "\t"}
    head = (
        "~Version Information\n VERS. 2.0 : CWLS LOG ASCII STANDARD - VERSION 2.0\n WRAP. NO : One line per time step\n"
        f" DLM. {next(word for word, sign in named.items() if sign == delimiter)} : delimiter\n"
        "~Well Information\n STRT. 0 : first\n STOP. 0 : last\n STEP. 0 : irregular\n NULL. -999.25 : missing\n"
        f"~Curve Information\n{curves}~A\n"
    )
    path.write_text(head + text_of(log, sep=delimiter, header=False, na_rep="" if delimiter == "," else "-999.25"))


def write_witsml(log: pd.DataFrame, path: Path, units: dict[str, str] | None = None) -> None:
    """A WITSML 1.4.1.1 document with one log."""
    curves = "".join(
        f'<logCurveInfo uid="{escape(name)}"><mnemonic>{escape(name)}</mnemonic>'
        f"<unit>{(units or {}).get(name, 'unitless')}</unit><typeLogData>double</typeLogData></logCurveInfo>"
        for name in log
    )
    rows = text_of(log, header=False).splitlines() if len(log) else []
    data = "\n".join(f"<data>{escape(row)}</data>" for row in rows)
    path.write_text(
        '<?xml version="1.0" encoding="UTF-8"?>\n<logs xmlns="http://www.witsml.org/schemas/1series" version="1.4.1.1">'
        '<log uidWell="w" uidWellbore="b" uid="l"><nameWell>W</nameWell><nameWellbore>B</nameWellbore><name>time</name>'
        f"<indexType>date time</indexType><indexCurve>{TIME}</indexCurve><nullValue>-999.25</nullValue>{curves}"
        f"<logData><mnemonicList>{escape(','.join(log))}</mnemonicList>{data}</logData></log></logs>"
    )


def write_parquet(log: pd.DataFrame, path: Path) -> None:
    """Apache Parquet, times as such."""
    log.to_parquet(path, index=False)


def write_feather(log: pd.DataFrame, path: Path) -> None:
    """Apache Feather, times as such."""
    log.reset_index(drop=True).to_feather(path)


def write_excel(log: pd.DataFrame, path: Path) -> None:
    """A workbook, times as text where they have a zone, which cells of workbooks cannot hold."""
    stamped(log).to_excel(path, index=False)


def write_tdms(log: pd.DataFrame, path: Path) -> None:
    """TDMS, times as text."""
    with TdmsWriter(path) as writer:
        for name, values in _arrays(log).items():
            writer.write_segment([ChannelObject("log", name, values)])


def write_hdf5(log: pd.DataFrame, path: Path) -> None:
    """HDF5 with a data set for each column, times as text."""
    with h5py.File(path, "w") as file:
        for name, values in _arrays(log).items():
            if values.dtype.kind == "U":
                file.create_dataset(name, data=values.astype(object), dtype=h5py.string_dtype())
            else:
                file[name] = values


def write_matlab(log: pd.DataFrame, path: Path) -> None:
    """A MATLAB file of version 5 with a structure, times as a cell array of text."""
    arrays = {
        name: values.astype(object) if values.dtype.kind == "U" else values for name, values in _arrays(log).items()
    }
    savemat(path, {"log": {name.replace(" ", "_"): values for name, values in arrays.items()}}, oned_as="column")


def write_netcdf(log: pd.DataFrame, path: Path) -> None:
    """NetCDF 4, times as text."""
    _dataset(log).to_netcdf(path, engine="h5netcdf")


def write_zarr(log: pd.DataFrame, path: Path) -> None:
    """A zarr store, times as text."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        _dataset(log).to_zarr(path, mode="w", zarr_format=2)


WRITERS: dict[str, Callable[[pd.DataFrame, Path], None]] = {
    ".csv": write_csv,
    ".feather": write_feather,
    ".h5": write_hdf5,
    ".las": write_las,
    ".mat": write_matlab,
    ".nc": write_netcdf,
    ".parquet": write_parquet,
    ".tdms": write_tdms,
    ".xlsx": write_excel,
    ".xml": write_witsml,
    ".zarr": write_zarr,
}
"""Writers by the first ending of each format."""
TRUE_TIMES = (".parquet", ".feather")
"""Formats that are written here with times and not with text."""
WITHOUT_SPACES = (".las", ".mat")
"""Formats whose names of columns hold no spaces."""


def _zipped(content: bytes, path: Path) -> bytes:
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr(path.name.removesuffix(".zip"), content)
    return path.read_bytes()


PACKERS: dict[str, Callable[[bytes, Path], bytes]] = {
    ".gz": lambda content, _: gzip.compress(content),
    ".bz2": lambda content, _: bz2.compress(content),
    ".xz": lambda content, _: lzma.compress(content),
    ".zst": lambda content, _: pa.Codec("zstd").compress(content, asbytes=True),
    ".zip": _zipped,
}


def write(log: pd.DataFrame, path: Path) -> Path:
    """Write a log in the format, and packed in the way, that the path's name asks for."""
    packing = path.suffix if path.suffix in PACKERS else ""
    plain = path.with_name(path.name.removesuffix(packing))
    suffix = plain.suffix
    if plain.is_dir():
        shutil.rmtree(plain)
    WRITERS[suffix](log, plain)
    if packing:
        content = plain.read_bytes()
        plain.unlink()
        path.write_bytes(PACKERS[packing](content, path))
    return path


def _arrays(log: pd.DataFrame) -> dict[str, np.ndarray]:
    texts = stamped(log)
    return {
        name: texts[name].to_numpy()
        if pd.api.types.is_numeric_dtype(texts[name].dtype)
        else np.array(texts[name].tolist(), dtype=str)
        for name in texts
    }


def _dataset(log: pd.DataFrame) -> xr.Dataset:
    return xr.Dataset({name: ("row", values) for name, values in _arrays(log).items()})
