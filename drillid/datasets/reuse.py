"""Rows that an earlier run made from the same things, by their keys: only the others are made again.

The `key` of a row is a hash of everything that its values come from: code and settings of the stage, the part of the
rig description that it uses, and the keys of the rows or logs that it reads. So equal keys mean equal rows.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Callable, Iterator, Mapping, MutableMapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from drillid.datasets.store import WellFolders


def digest(content: Any) -> str:
    """Short hash of anything that JSON can hold, independent of the order of keys: 16 hexadecimal digits."""
    return hashlib.sha256(json.dumps(content, sort_keys=True, default=str).encode()).hexdigest()[:16]


def checksum(path: Path) -> str:
    """Short hash of a file's bytes: 16 hexadecimal digits."""
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()[:16]


def row_keys(basis: str, rows: Sequence[Any], *shared: Any) -> list[str]:
    """Keys of rows.

    Parameters
    ----------
    basis : what all rows of the stage come from; see `WellFolders.basis`
    rows : what each row comes from, such as the key of the row that it reads
    shared : what all rows come from besides
    """
    return [digest([basis, row, *shared]) for row in rows]


def completed(
    earlier: xr.Dataset | None, keys: Sequence[str], dimension: str, make: Callable[[list[int]], xr.Dataset]
) -> xr.Dataset:
    """The dataset of all rows: those that the earlier one holds are taken from there, the others are made.

    Parameters
    ----------
    earlier : with a variable `key` along the dimension; None where there is none
    keys : of all rows, in order
    dimension : name of the rows' dimension
    make : makes the dataset of some rows, by their places in `keys`

    Returns
    -------
    The rows in the order of `keys`, which are the variable `key`. What lies not along the dimension is that of the
    made rows, or of the earlier dataset where none is made.
    """
    known = {} if earlier is None else {str(key): place for place, key in enumerate(earlier["key"].values)}
    missing = [row for row, key in enumerate(keys) if key not in known]
    if earlier is None or len(missing) == len(keys):
        found = make(missing)
    else:
        held = [row for row in range(len(keys)) if keys[row] in known]
        kept = earlier.load().drop_encoding().isel({dimension: [known[keys[row]] for row in held]})
        made = make(missing) if missing else kept.isel({dimension: slice(0)})
        found = _merged(kept, made, dimension, np.argsort([*held, *missing]))
    return found.assign(key=(dimension, np.array(keys, dtype=object)))


def _merged(kept: xr.Dataset, made: xr.Dataset, dimension: str, order: Any) -> xr.Dataset:
    """Rows of both in the given order; xarray's own concatenation would compare all that lies not along them."""
    variables: dict[Any, Any] = {}
    for name, variable in made.variables.items():
        values = variable.values
        if dimension in variable.dims:
            axis = variable.dims.index(dimension)
            values = np.take(np.concatenate([kept[name].values, values], axis=axis), order, axis=axis)
        variables[name] = (variable.dims, values)
    return xr.Dataset(variables).set_coords([name for name in made.coords if name in variables])


class Entries(MutableMapping[str, Any]):
    """Values by key, each held as its JSON, so that only those that are looked up are parsed."""

    def __init__(self, texts: Mapping[str, str]) -> None:
        self.texts = dict(texts)

    def __getitem__(self, key: str) -> Any:
        return json.loads(self.texts[key])

    def __setitem__(self, key: str, value: Any) -> None:
        self.texts[key] = json.dumps(value, sort_keys=True)

    def __delitem__(self, key: str) -> None:
        del self.texts[key]

    def __contains__(self, key: object) -> bool:
        return key in self.texts

    def __iter__(self) -> Iterator[str]:
        return iter(self.texts)

    def __len__(self) -> int:
        return len(self.texts)


class Memo:
    """What a stage found out about parts of a well that is no row of a dataset, by keys as those of rows.

    Everything in it can be written as JSON, which keeps the bits of numbers.

    earlier : what an earlier run found; empty where none did with this code and these settings
    found : what this run has found or taken over
    """

    def __init__(self, folders: WellFolders, stage: str) -> None:
        self._folders, self._stage = folders, stage
        self.earlier = Entries(folders.earlier_memo(stage))
        self.found = Entries({})

    def key(self, *content: Any) -> str:
        """Key of what comes from this content, beside code, settings and rig description."""
        return digest([self._folders.basis, *content])

    def result(self, key: str, make: Callable[[], Any]) -> Any:
        """What has this key: taken over where an earlier run found it, else made."""
        if key not in self.found and not self.take_over(key):
            self.found[key] = make()
        # what is made goes through JSON as well, so that it is the same the next time
        return self.found[key]

    def take_over(self, key: str) -> bool:
        """Whether an earlier run found what has this key, which is then kept without being looked at."""
        if key not in self.earlier:
            return False
        self.found.texts[key] = self.earlier.texts[key]
        return True

    def save(self) -> None:
        """Write what was found into the stage's folder of the well."""
        self._folders.write_memo(self._stage, self.found.texts)


class EarlierPieces:
    """Pieces of a long series as an earlier run has written it, whose memo has the place of each by its key.

    kept : samples with which the earlier and the new series begin, unless others may be needed again
    """

    def __init__(self, folders: WellFolders, stage: str, name: str, memo: Memo, keys: Sequence[str]) -> None:
        self._series = folders.earlier(stage, name)
        self._known = {key: memo.earlier[key] for key in keys if key in memo.earlier} if self._series else {}
        kept, behind = 0, set(keys)
        for key in keys:
            if key not in self._known or self._known[key]["first"] != kept:
                break
            kept += self._known[key]["samples"]
            behind.remove(key)
        # pieces behind one that has changed are read from the earlier series, which is then not taken as it is
        self.kept = 0 if behind & self._known.keys() else kept

    def __contains__(self, key: str) -> bool:
        return key in self._known

    def content(self, key: str) -> Any:
        """What the memo holds of a piece."""
        return self._known[key]["content"]

    def piece(self, key: str) -> xr.Dataset | None:
        """Samples of a piece; None where they are among those that are kept."""
        first, samples = (self._known[key][name] for name in ("first", "samples"))
        if self._series is None or first + samples <= self.kept:
            return None
        return self._series.isel(time=slice(first, first + samples)).load().drop_encoding()
