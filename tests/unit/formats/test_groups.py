"""Logs whose channels lie in groups of netCDF, HDF5 and zarr: chosen, found, or asked for by their names."""

from collections.abc import Callable
from pathlib import Path

import h5py
import numpy as np
import pandas as pd
import pytest
import xarray as xr

from drillid.errors import LogError
from drillid.formats import first_stamp, headers, read_log
from drillid.formats.description import Dialect

STAMPS = pd.date_range("2025-03-03T06:00", periods=50, freq="20ms").as_unit("ns")
SPEED = np.linspace(119, 121, 50)


def dataset(later: str = "0s", **channels: np.ndarray) -> xr.Dataset:
    times = STAMPS + pd.Timedelta(later)
    return xr.Dataset({name: ("time", values) for name, values in channels.items()}, {"time": times})


def write_netcdf(groups: dict[str, xr.Dataset], path: Path) -> None:
    xr.DataTree.from_dict({f"/{group}": found for group, found in groups.items()}).to_netcdf(path, engine="h5netcdf")


def write_zarr(groups: dict[str, xr.Dataset], path: Path) -> None:
    xr.DataTree.from_dict({f"/{group}": found for group, found in groups.items()}).to_zarr(path, consolidated=False)


def write_hdf5(groups: dict[str, xr.Dataset], path: Path) -> None:
    with h5py.File(path, "w") as file:
        for group, found in groups.items():
            for name, variable in found.variables.items():
                values = variable.values
                if values.dtype.kind == "M":
                    values = values.astype("datetime64[ns]").astype(np.int64) / 1e9
                file[f"{group}/{name}"] = values


def write_workbook(groups: dict[str, xr.Dataset], path: Path) -> None:
    with pd.ExcelWriter(path) as book:
        for group, found in groups.items():
            found.to_dataframe().reset_index().to_excel(book, sheet_name=group, index=False)


every_format = pytest.mark.parametrize(
    ("suffix", "write"), [(".nc", write_netcdf), (".zarr", write_zarr), (".h5", write_hdf5)]
)
Writer = Callable[[dict[str, xr.Dataset], Path], None]


@every_format
def test_channels_in_the_only_group_that_holds_them_are_found(suffix: str, write: Writer, tmp_path: Path) -> None:
    path = tmp_path / f"log{suffix}"
    write({"well/rig": dataset(RPM=SPEED, TORQUE=SPEED / 7), "well/mud": dataset(FLOW=SPEED, SPP=SPEED)}, path)
    found = read_log(path, None, ["RPM", "TORQUE"])
    np.testing.assert_array_equal(found.pop("RPM"), SPEED)
    np.testing.assert_array_equal(found.pop("TORQUE"), SPEED / 7)
    assert (found.stamps == STAMPS.to_numpy()).all()
    assert {header.table for header in headers(path)} == {"well/rig", "well/mud"}


@every_format
def test_of_several_groups_with_the_channels_one_must_be_stated(suffix: str, write: Writer, tmp_path: Path) -> None:
    path = tmp_path / f"log{suffix}"
    write({"fast": dataset(RPM=SPEED, TORQUE=SPEED), "slow": dataset(RPM=2 * SPEED, TORQUE=SPEED)}, path)
    with pytest.raises(LogError, match=r"'fast', 'slow' all hold the columns") as raised:
        read_log(path, None, ["RPM", "TORQUE"])
    assert "file.table" in raised.value.remedy
    for group, factor in (("fast", 1), ("slow", 2)):
        found = read_log(path, None, ["RPM", "TORQUE"], dialect=Dialect(table=group))
        np.testing.assert_array_equal(found.pop("RPM"), factor * SPEED)
    with pytest.raises(LogError, match="has no table 'other'; its tables are 'fast', 'slow'"):
        read_log(path, None, ["RPM"], dialect=Dialect(table="other"))


@pytest.mark.parametrize(
    ("suffix", "write"),
    [(".nc", write_netcdf), (".zarr", write_zarr), (".h5", write_hdf5), (".xlsx", write_workbook)],
)
def test_tables_of_the_same_columns_that_continue_one_another_are_one(
    suffix: str, write: Writer, tmp_path: Path
) -> None:
    path = tmp_path / f"log{suffix}"
    parts = {"log 2": dataset("1s", RPM=2 * SPEED, TORQUE=SPEED), "log 1": dataset(RPM=SPEED, TORQUE=SPEED)}
    write(parts, path)
    found = read_log(path, None, ["RPM", "TORQUE"])
    order = np.argsort(found.stamps)
    np.testing.assert_allclose(found.pop("RPM")[order], np.append(SPEED, 2 * SPEED), rtol=1e-12)
    off = (found.stamps[order] - np.append(STAMPS, STAMPS + pd.Timedelta("1s"))) / np.timedelta64(1, "ns")
    assert np.max(np.abs(off)) < 2000
    assert any("2 tables" in what and "are read as one" in what for what, _ in found.notes)
    assert abs(first_stamp(path, None, columns=["RPM"]) - np.datetime64("2025-03-03T06:00")) < np.timedelta64(2, "us")
    alone = read_log(path, None, ["RPM"], dialect=Dialect(table="log 1"))
    np.testing.assert_allclose(alone.pop("RPM"), SPEED, rtol=1e-12)


def test_tables_of_the_same_columns_in_other_units_are_not_one(tmp_path: Path) -> None:
    path = tmp_path / "log.nc"
    other = dataset("1s", TORQUE=SPEED)
    other["TORQUE"].attrs["units"] = "ft.lbf"
    write_netcdf({"log 1": dataset(TORQUE=SPEED), "log 2": other}, path)
    with pytest.raises(LogError, match=r"'log 1', 'log 2' all hold the columns 'TORQUE'"):
        read_log(path, None, ["TORQUE"])


def test_a_wrong_cell_in_one_of_several_sheets_is_named(tmp_path: Path) -> None:
    path = tmp_path / "log.xlsx"
    wrong = np.where(SPEED > 120.9, "1x", SPEED)
    write_workbook({"log 1": dataset(RPM=SPEED), "log 2": dataset("1s", RPM=wrong)}, path)
    with pytest.raises(LogError, match=r"'log 1 \+ log 2', column 'RPM', row 98: '1x' is not a number"):
        read_log(path, None, ["RPM"]).pop("RPM")


@pytest.mark.parametrize(("suffix", "write"), [(".nc", write_netcdf), (".zarr", write_zarr)])
def test_channels_share_the_times_of_the_group_above(suffix: str, write: Writer, tmp_path: Path) -> None:
    path = tmp_path / f"log{suffix}"
    write({"": dataset(), "rig": dataset(RPM=SPEED, TORQUE=SPEED).drop_vars("time")}, path)
    found = read_log(path, None, ["RPM"])
    np.testing.assert_array_equal(found.pop("RPM"), SPEED)
    assert (found.stamps == STAMPS.to_numpy()).all()


def test_a_missing_chunk_of_a_group_is_damage(tmp_path: Path) -> None:
    path = tmp_path / "log.zarr"
    write_zarr({"rig": dataset(RPM=SPEED, TORQUE=SPEED)}, path)
    (path / "rig/RPM/c/0").unlink()
    with pytest.raises(LogError, match="chunks of 'RPM' are missing"):
        read_log(path, None, ["RPM"])
