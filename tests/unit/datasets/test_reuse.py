"""Rows that an earlier dataset holds are taken from there, the others made, and the order is that of the keys."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
import xarray as xr

from drillid.datasets.reuse import Memo, checksum, completed, digest, row_keys
from drillid.datasets.store import WellFolders
from drillid.fleet.aside import set_aside
from drillid.fleet.manifest import KEY


def made(*rows: int) -> xr.Dataset:
    """A dataset of rows along `window`, of which one variable has its rows along the second axis."""
    values = np.array(rows, dtype=float)
    return xr.Dataset(
        {
            "value": ("window", values),
            "row": (("frequency", "window"), np.stack([values, -values])),
            "reason": ("window", np.array([f"row {row}" for row in rows], dtype=object)),
            "common": ("frequency", [1.0, 2.0]),
        },
        {"frequency": [0.1, 0.2], "start": ("window", values.astype("datetime64[s]").astype("datetime64[ns]"))},
    )


def keys(*rows: int) -> list[str]:
    return row_keys("basis", rows, "shared")


def whole(*rows: int) -> xr.Dataset:
    return completed(None, keys(*rows), "window", lambda places: made(*(rows[place] for place in places)))


@pytest.mark.parametrize(
    ("before", "now", "missing"),
    [
        ((1, 2), (1, 2, 3), [2]),
        ((1, 2, 3), (1, 3), []),
        ((1, 2, 3), (3, 1), []),
        ((1, 2), (0, 1, 5, 2), [0, 2]),
        ((1, 2), (3, 4), [0, 1]),
        ((1, 2), (), []),
        ((), (1,), [0]),
    ],
)
def test_only_rows_without_an_equal_key_are_made(
    before: tuple[int, ...], now: tuple[int, ...], missing: list[int], tmp_path: Path
) -> None:
    whole(*before).to_zarr(tmp_path / "before.zarr", consolidated=False)
    asked: list[int] = []

    def make(places: list[int]) -> xr.Dataset:
        asked.extend(places)
        return made(*(now[place] for place in places))

    earlier = xr.open_zarr(tmp_path / "before.zarr", chunks=None, consolidated=False)
    found = completed(earlier, keys(*now), "window", make)
    assert asked == missing
    xr.testing.assert_identical(found, whole(*now))
    assert not any(variable.encoding for variable in found.variables.values())


def test_a_key_changes_with_everything_that_it_stands_for() -> None:
    found = [row_keys("a", ["x"]), row_keys("b", ["x"]), row_keys("a", ["y"]), row_keys("a", ["x"], 1.0)]
    assert len({key for [key] in found}) == 4
    assert row_keys("a", ["x"]) == row_keys("a", ["x"])
    assert digest({"a": 1, "b": 2}) == digest({"b": 2, "a": 1})
    assert digest(0.1) != digest(np.nextafter(0.1, 1))


def test_a_checksum_is_of_the_bytes_alone(tmp_path: Path) -> None:
    first, second = tmp_path / "a", tmp_path / "b"
    first.write_bytes(b"samples")
    second.write_bytes(b"samples")
    assert checksum(first) == checksum(second)
    second.write_bytes(b"sample.")
    assert checksum(first) != checksum(second)


def saved(tmp_path: Path) -> WellFolders:
    """A stage's folder, set aside, whose memo holds two entries."""
    folders = WellFolders(tmp_path, "W1", "basis")
    memo = Memo(folders, "windows")
    for name, value in (("a", {"x": [0.1, float("nan")], "b": "å\n"}), ("c", 3)):
        memo.found[memo.key(name)] = value
    memo.save()
    (folders.stage("windows") / KEY).write_text('{"key": "1", "status": "done", "basis": "basis"}')
    set_aside(folders, "windows")
    return folders


def test_a_memo_makes_only_what_no_earlier_run_found(tmp_path: Path) -> None:
    folders, made = saved(tmp_path), list[str]()
    memo = Memo(folders, "windows")
    found = [memo.result(memo.key(name), lambda name=name: made.append(name) or name) for name in "acd"]
    assert (found[0]["b"], found[1:], made) == ("å\n", [3, "d"], ["d"])
    assert found[0]["x"][0] == 0.1
    assert np.isnan(found[0]["x"][1])


def test_what_is_taken_over_is_written_as_it_was(tmp_path: Path) -> None:
    folders = saved(tmp_path)
    before = (folders.aside("windows") / "memo.txt").read_bytes()
    memo = Memo(folders, "windows")
    assert [memo.take_over(memo.key(name)) for name in "acd"] == [True, True, False]
    memo.save()
    assert (folders.stage("windows") / "memo.txt").read_bytes() == before


@pytest.mark.parametrize(
    "damage", [lambda content: content[:-5], lambda content: content.replace(b" 3", b" 4"), lambda content: b""]
)
def test_a_damaged_memo_counts_as_none(damage: Callable[[bytes], bytes], tmp_path: Path) -> None:
    path = saved(tmp_path).aside("windows") / "memo.txt"
    path.write_bytes(damage(path.read_bytes()))
    assert not Memo(WellFolders(tmp_path, "W1", "basis"), "windows").earlier
