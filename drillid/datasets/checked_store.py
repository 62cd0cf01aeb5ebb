"""Stores whose files are compared with their checksums as they are read; apart, as zarr is imported late."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from zarr.storage import LocalStore, WrapperStore

from drillid.datasets.checksums import compare, read_checksums


class CheckedStore(WrapperStore[LocalStore]):
    """A store to read, every file of which must have its checksum; without checksums it is read as it is.

    Parameters
    ----------
    path : folder of the store
    stage : stage that wrote it

    Raises
    ------
    DamageError
        If there is no store, or when a file is read that is missing or has changed.
    """

    def __init__(self, path: Path, stage: str) -> None:
        super().__init__(LocalStore(path, read_only=True))
        self.path, self.stage = path, stage
        self.sums = read_checksums(path, stage)

    async def get(self, key: str, prototype: Any, byte_range: Any = None) -> Any:
        """The content of a file, or nothing where the store never had it."""
        if byte_range is not None:
            found = await super().get(key, prototype, byte_range)
            if self.sums and found is None:
                # of a part of a file only whether it is there can be told
                compare(self.path / key, None, self.sums.get(key), self.stage)
            return found
        # read here, as a thread for every small file takes longer than reading it
        file = self.path / key
        content = file.read_bytes() if file.is_file() else None
        if self.sums:
            compare(file, content, self.sums.get(key), self.stage)
        return None if content is None else prototype.buffer.from_bytes(content)

    def _with_store(self, store: LocalStore) -> CheckedStore:
        return CheckedStore(self.path, self.stage)
