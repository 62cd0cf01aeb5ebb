"""Checksums of a dataset's or table's files, by which one that is missing or has changed is noticed when it is read.

zarr takes a missing chunk for one of fill values, and damage that its compression does not see for data. The checksums
lie beside the store or table, in `<dataset>.sums`.
"""

from __future__ import annotations

import json
import os
import zlib
from collections.abc import Mapping
from pathlib import Path

from drillid.errors import DamageError

SUFFIX = ".sums"
Stamps = Mapping[str, tuple[int, int]]


def checksum(content: bytes) -> str:
    """CRC-32 as 8 hexadecimal digits."""
    return f"{zlib.crc32(content):08x}"


def stamps(store: Path) -> dict[str, tuple[int, int]]:
    """Size and time of every file of a store, by its path in there."""
    # paths as text, as a long series has some thousand files
    files = sorted(os.path.join(folder, name) for folder, _, names in os.walk(store) for name in names)
    states = {file[len(str(store)) + 1 :]: os.stat(file) for file in files}
    return {name: (status.st_size, status.st_mtime_ns) for name, status in states.items()}


def compare(file: Path, content: bytes | None, expected: str | None, stage: str) -> None:
    """Compare the content of a store's file, None where there is none, with its checksum, None where it has none.

    Raises
    ------
    DamageError
        If it is missing or has changed.
    """
    if content is None and expected is not None:
        raise DamageError(str(file), "is missing", stage)
    if content is not None and checksum(content) != expected:
        raise DamageError(str(file), "has changed since it was written", stage)


def write_checksums(store: Path, path: Path, earlier: Path | None = None, untouched: Stamps | None = None) -> None:
    """Write the checksums of a store's files.

    Parameters
    ----------
    store : folder of the store
    path : file that is written
    earlier : checksums of the store that this one continues, so that damage done meanwhile is not taken for right
    untouched : `stamps` of that store; its files that are still as they were keep their checksums
    """
    known = _stored(earlier) if earlier is not None and earlier.exists() else {}
    files = {
        name: known[name]
        if name in known and (untouched or {}).get(name) == stamp
        else checksum((store / name).read_bytes())
        for name, stamp in stamps(store).items()
    }
    write_listing(files, path)


def write_listing(files: Mapping[str, str], path: Path) -> None:
    """Write checksums by the files' paths in their store."""
    path.write_text(json.dumps(files, indent=0) + "\n")


def read_checksums(store: Path, stage: str) -> dict[str, str]:
    """Checksums of a store's files by their paths in there; empty where none were written.

    Raises
    ------
    DamageError
        If they cannot be read.
    """
    path = store.with_suffix(SUFFIX)
    try:
        return _stored(path) if path.exists() else {}
    except ValueError as error:
        raise DamageError(str(path), "is damaged", stage) from error


def _stored(path: Path) -> dict[str, str]:
    content = json.loads(path.read_bytes())
    if not isinstance(content, dict):
        raise ValueError("no table of checksums")
    return content


def check(path: Path, stage: str) -> None:
    """Compare every file of a store, or a table, with its checksum, if one was written.

    Raises
    ------
    DamageError
        If one is missing or has changed.
    """
    folder = path.parent if path.suffix == ".csv" else path
    for name, expected in read_checksums(path, stage).items():
        file = folder / name
        compare(file, file.read_bytes() if file.is_file() else None, expected, stage)
