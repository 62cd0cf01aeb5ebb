"""What files of arrays state beside them: units, scales, missing values, starts and rates."""

import json
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pandas as pd
import pyarrow as pa
import pytest
from pyarrow import feather, parquet
from scipy.io import savemat

from drillid.errors import LogError
from drillid.formats import headers, read_log

STAMPS = pd.date_range("2025-03-03T06:00", periods=50, freq="20ms").as_unit("ns")
NS = STAMPS.to_numpy().astype(np.int64)
SECONDS = np.arange(50) * 0.02
SPEED = np.linspace(119, 121, 50)
TORQUE = np.linspace(-1, 13, 50)
NAMES, UNITS = ["Time", "RPM", "TQ"], ["ns", "rpm", "kft.lbf"]
RECORDS = np.rec.fromarrays([NS, SPEED, TORQUE], names=NAMES)


def hdf5(path: Path, **attributes: dict[str, Any]) -> Path:
    """A file with the times and two channels; attributes by the names of the arrays, `file` for those of the file."""
    with h5py.File(path, "w") as file:
        for name, values in (("Time", NS), ("RPM", SPEED), ("TQ", TORQUE)):
            own = attributes.get(name, {})
            file[name] = own.get("values", values)
            file[name].attrs.update({key: value for key, value in own.items() if key != "values"})
        file.attrs.update(attributes.get("file", {}))
    return path


def test_packed_numbers_of_hdf5_are_scaled(tmp_path: Path) -> None:
    stored = np.round((TORQUE - 2) / 1e-3).astype(np.int16)
    stored[3] = -32768
    packed = {"values": stored, "scale_factor": 1e-3, "add_offset": np.array([2.0]), "_FillValue": np.int16(-32768)}
    found = read_log(hdf5(tmp_path / "log.h5", TQ=packed), None, ["RPM", "TQ"])
    np.testing.assert_allclose(found.pop("TQ"), np.where(np.arange(50) == 3, np.nan, TORQUE), atol=6e-4)
    np.testing.assert_array_equal(found.pop("RPM"), SPEED)
    assert (found.stamps == STAMPS.to_numpy()).all()


@pytest.mark.parametrize("scale", ["0.001", [1.0, 2.0], np.nan])
def test_a_scale_that_is_not_one_number_is_refused(scale: Any, tmp_path: Path) -> None:
    path = hdf5(tmp_path / "log.h5", TQ={"scale_factor": scale})
    with pytest.raises(LogError, match="as 'scale_factor' of '/TQ', which is not one number"):
        read_log(path, None, ["TQ"])


def test_the_missing_value_of_one_array_is_that_of_no_other(tmp_path: Path) -> None:
    stopped = np.where(np.arange(50) < 9, 0.0, SPEED)
    path = hdf5(tmp_path / "log.h5", RPM={"values": stopped}, TQ={"values": stopped, "_FillValue": 0.0})
    found = read_log(path, None, ["RPM", "TQ"])
    np.testing.assert_array_equal(found.pop("RPM"), stopped)
    np.testing.assert_array_equal(found.pop("TQ"), np.where(stopped == 0, np.nan, stopped))


@pytest.mark.parametrize(("key", "start"), [("start_time", "2025-03-03 07:00:00"), ("StartTime", "2025-03-03T06:00Z")])
def test_a_start_without_zone_is_of_the_rigs_clock(key: str, start: str, tmp_path: Path) -> None:
    path = hdf5(tmp_path / "log.h5", Time={"values": SECONDS, "units": "s"}, file={key: start})
    found = read_log(path, None, ["RPM"], zone="Europe/Oslo")
    assert (found.stamps == STAMPS.to_numpy()).all()


def test_seconds_since_a_time_without_zone_are_utc_by_convention(tmp_path: Path) -> None:
    path = hdf5(tmp_path / "log.h5", Time={"values": SECONDS, "units": "seconds since 2025-03-03 06:00:00"})
    assert (read_log(path, None, ["RPM"], zone="Europe/Oslo").stamps == STAMPS.to_numpy()).all()


@pytest.mark.parametrize(
    "times",
    [{"units": "ns"}, {"values": NS / 86400e9 + 25569}, {"values": NS / 86400e9 + 719529, "units": "days"}],
)
def test_times_that_are_dates_do_not_count_from_the_start_of_the_log(times: dict[str, Any], tmp_path: Path) -> None:
    path = hdf5(tmp_path / "log.h5", Time=times, file={"start": "2025-03-03"})
    off = (read_log(path, None, ["RPM"]).stamps - STAMPS.to_numpy()) / np.timedelta64(1, "us")
    assert np.max(np.abs(off)) < 20


def test_days_since_a_time_count_from_it_whatever_their_size(tmp_path: Path) -> None:
    times = {"values": NS / 86400e9 + 25567, "units": "days since 1900-01-01"}
    path = hdf5(tmp_path / "log.h5", Time=times)
    off = (read_log(path, None, ["RPM"]).stamps - STAMPS.to_numpy()) / np.timedelta64(1, "us")
    assert np.max(np.abs(off)) < 20


def test_a_group_of_channels_that_is_named_like_units_holds_none(tmp_path: Path) -> None:
    path = tmp_path / "log.h5"
    with h5py.File(path, "w") as file:
        for name, values in zip(NAMES, (NS, SPEED, (TORQUE * 1e9).astype(np.int64)), strict=True):
            file[f"Unit/{name}"] = values
    assert headers(path)[0].units == {}


def test_an_array_of_records_may_state_a_start(tmp_path: Path) -> None:
    path = tmp_path / "log.h5"
    with h5py.File(path, "w") as file:
        file["log"] = np.rec.fromarrays([SECONDS, SPEED], names=["Time", "RPM"])
        file["log"].attrs["Start_Time"] = "2025-03-03T06:00:00Z"
    assert (read_log(path, None, ["RPM"]).stamps == STAMPS.to_numpy()).all()


@pytest.mark.parametrize("stated", [np.array(UNITS, dtype="S8"), json.dumps(dict(zip(NAMES, UNITS, strict=True)))])
def test_records_and_matrices_of_hdf5_have_units_stated_once(stated: Any, tmp_path: Path) -> None:
    with h5py.File(tmp_path / "records.h5", "w") as file:
        file["log"] = RECORDS
        file["log"].attrs["units"] = stated
    with h5py.File(tmp_path / "matrix.h5", "w") as file:
        file["log"] = np.column_stack([NS, SPEED, TORQUE])
        file["log"].attrs.update({"Columns": NAMES, "units": stated})
    for name in ("records.h5", "matrix.h5"):
        (header,) = headers(tmp_path / name)
        assert header.units == dict(zip(NAMES, UNITS, strict=True))
        assert header.notes == ()
        assert read_log(tmp_path / name, None, ["TQ"]).units == {"TQ": "kft.lbf"}


def test_units_that_are_not_one_for_each_column_are_told(tmp_path: Path) -> None:
    with h5py.File(tmp_path / "log.h5", "w") as file:
        file["log"] = RECORDS
        file["log"].attrs["units"] = UNITS[1:]
    found = read_log(tmp_path / "log.h5", None, ["TQ"])
    assert found.units == {}
    assert any("not one for each of its 3 columns and are not read" in what for what, _ in found.notes)


def test_a_structure_of_units_beside_arrays_of_matlab_7_3_is_read(tmp_path: Path) -> None:
    with h5py.File(tmp_path / "log.mat", "w") as file:
        for name, unit, values in zip(NAMES, UNITS, (NS, SPEED, TORQUE), strict=True):
            file[f"log/{name}"] = values[None, :]
            file[f"units/{name}"] = np.array([[ord(sign)] for sign in unit], dtype=np.uint16)
            file[f"units/{name}"].attrs["MATLAB_class"] = np.bytes_("char")
    (header,) = headers(tmp_path / "log.mat")
    assert header.units == dict(zip(NAMES, UNITS, strict=True))


def test_a_cell_array_of_units_beside_a_matrix_of_matlab_is_read(tmp_path: Path) -> None:
    matrix = np.column_stack([NS / 1e9, SPEED, TORQUE])
    cells = {"names": np.array(NAMES, dtype=object), "Units": np.array(["s", *UNITS[1:]], dtype=object)}
    savemat(tmp_path / "log.mat", {"log": {"data": matrix, **cells}})
    assert read_log(tmp_path / "log.mat", None, ["RPM", "TQ"]).units == {"RPM": "rpm", "TQ": "kft.lbf"}


@pytest.mark.parametrize("width", [1, 2])
def test_a_structure_with_time_of_simulink_is_read(width: int, tmp_path: Path) -> None:
    values = np.column_stack([SPEED, TORQUE])[:, :width]
    kinds = [("values", object), ("label", object), ("dimensions", object)]
    signals = np.array([(values, "RPM", width), (TORQUE[:, None], "TQ", 1)], dtype=kinds)
    savemat(tmp_path / "log.mat", {"out": {"time": NS[:, None] / 1e9, "signals": signals}})
    found = read_log(tmp_path / "log.mat", None, ["RPM", "TQ"])
    np.testing.assert_array_equal(found.pop("RPM"), SPEED)
    np.testing.assert_array_equal(found.pop("TQ"), TORQUE)
    np.testing.assert_allclose((found.stamps - STAMPS.to_numpy()).astype(float), 0, atol=1e3)
    assert ("RPM:2" in headers(tmp_path / "log.mat")[0].columns) == (width == 2)


@pytest.mark.parametrize("sampling", [{"Fs": 50.0}, {"dt": 0.02}, {"Sample_Rate": 50}])
def test_a_rate_and_a_start_beside_arrays_of_matlab_make_times(sampling: dict[str, float], tmp_path: Path) -> None:
    path = tmp_path / "log.mat"
    savemat(path, {"RPM": SPEED[:, None], "TQ": TORQUE[:, None], **sampling, "t0": "2025-03-03 07:00:00"})
    found = read_log(path, None, ["RPM", "TQ"], zone="Europe/Oslo")
    assert (found.stamps == STAMPS.to_numpy()).all()
    assert any("they are made of 50 rows a second" in what for what, _ in found.notes)
    savemat(path, {"RPM": SPEED[:, None], "TQ": TORQUE[:, None], **sampling})
    with pytest.raises(LogError, match=r"column 'Time', row 1: .*state their start as time\.start"):
        read_log(path, None, ["RPM"])


@pytest.mark.parametrize("suffix", [".parquet", ".feather"])
@pytest.mark.parametrize("stated", [{"RPM": "rpm", "TQ": "kft.lbf"}, ["", "rpm", "kft.lbf"]])
def test_units_in_the_metadata_of_a_parquet_or_feather_file_are_read(stated: Any, suffix: str, tmp_path: Path) -> None:
    table = pa.table({"Time": STAMPS, "RPM": SPEED, "TQ": TORQUE}).replace_schema_metadata(
        {"units": json.dumps(stated)}
    )
    (parquet.write_table if suffix == ".parquet" else feather.write_feather)(table, tmp_path / f"log{suffix}")
    assert read_log(tmp_path / f"log{suffix}", None, ["RPM", "TQ"]).units == {"RPM": "rpm", "TQ": "kft.lbf"}
