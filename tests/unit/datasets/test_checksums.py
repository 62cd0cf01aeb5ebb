"""A chunk that is missing or has changed is noticed when it is read, and damage is never taken over."""

from pathlib import Path

import numpy as np
import pytest
import xarray as xr

from drillid.datasets.checked_store import CheckedStore
from drillid.datasets.checksums import SUFFIX, check, stamps, write_checksums
from drillid.datasets.store import write_store
from drillid.errors import DamageError


@pytest.fixture
def store(tmp_path: Path) -> Path:
    """Two chunks of numbers, and one of nothing that zarr does not store."""
    path = tmp_path / "numbers.zarr"
    values = np.concatenate([np.arange(4.0), np.arange(4.0) + 10, np.full(4, np.nan)])
    dataset = xr.Dataset({"a": ("x", values)})
    dataset["a"].encoding = {"chunks": (4,), "_FillValue": np.nan}
    write_store(dataset, path)
    write_checksums(path, path.with_suffix(SUFFIX))
    return path


def read(store: Path, place: slice) -> list[float]:
    dataset = xr.open_zarr(CheckedStore(store, "fits"), chunks=None)
    return list(dataset["a"][place].values)


def chunk(store: Path, number: int) -> Path:
    return store / "a" / "c" / str(number)


def test_what_is_sound_is_read(store: Path) -> None:
    assert read(store, slice(0, 2)) == [0.0, 1.0]
    assert np.isnan(read(store, slice(8, 12))).all()
    check(store, "fits")


@pytest.mark.parametrize("number", [0, 1])
def test_a_missing_chunk_is_damage_and_no_fill_value(store: Path, number: int) -> None:
    chunk(store, number).unlink()
    with pytest.raises(DamageError, match=rf"a/c/{number}: is missing\. The next run makes it again"):
        read(store, slice(None))
    with pytest.raises(DamageError, match="is missing"):
        check(store, "fits")


@pytest.mark.parametrize("name", ["a/c/1", "zarr.json", "a/zarr.json"])
def test_a_flipped_bit_is_damage(store: Path, name: str) -> None:
    content = bytearray((store / name).read_bytes())
    content[len(content) // 2] ^= 1
    (store / name).write_bytes(bytes(content))
    with pytest.raises(DamageError, match=rf"{name}: has changed since it was written") as error:
        check(store, "fits")
    assert error.value.stage == "fits"
    if name != "a/zarr.json":  # which the metadata at the top hold as well
        with pytest.raises(DamageError):
            read(store, slice(None))


@pytest.mark.parametrize("content", ["", "[]", "{"])
def test_damaged_checksums_are_damage(store: Path, content: str) -> None:
    store.with_suffix(SUFFIX).write_text(content)
    with pytest.raises(DamageError, match="is damaged"):
        read(store, slice(None))


def test_damage_done_before_a_series_is_continued_is_not_taken_for_right(store: Path) -> None:
    """Bits that change on a disk leave size and time of the file as they were."""
    sums = store.with_suffix(SUFFIX)
    content = bytearray(chunk(store, 0).read_bytes())
    content[-1] ^= 1
    chunk(store, 0).write_bytes(bytes(content))
    untouched = stamps(store)
    chunk(store, 1).write_bytes(b"continued")
    write_checksums(store, sums, sums, untouched)
    with pytest.raises(DamageError, match="a/c/0: has changed"):
        check(store, "fits")
