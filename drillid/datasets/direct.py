"""zarr without threads: files and chunks are handled where they are called for; apart, as zarr is imported late.

zarr hands every file and every chunk to a thread, which takes longer than a small one itself.
"""

from __future__ import annotations

import contextlib
from collections.abc import Iterator
from typing import Any

import zarr
from zarr.codecs import BloscCodec, ZstdCodec
from zarr.registry import register_codec
from zarr.storage import LocalStore


class _Direct:
    """A codec whose chunks are handled at once."""

    _decode_sync: Any
    _encode_sync: Any

    async def _decode_single(self, chunk_bytes: Any, chunk_spec: Any) -> Any:
        return self._decode_sync(chunk_bytes, chunk_spec)

    async def _encode_single(self, chunk_bytes: Any, chunk_spec: Any) -> Any:
        return self._encode_sync(chunk_bytes, chunk_spec)


class DirectZstd(_Direct, ZstdCodec):
    """zstd, as zarr writes it by default."""


class DirectBlosc(_Direct, BloscCodec):
    """Blosc, for long series."""


class DirectStore(LocalStore):
    """A folder of a store that nobody reads before it has its final name."""

    async def get(self, key: str, prototype: Any = None, byte_range: Any = None) -> Any:
        """The content of a file, or nothing where there is none."""
        if byte_range is not None or prototype is None:
            return await super().get(key, prototype, byte_range)
        file = self.root / key
        return prototype.buffer.from_bytes(file.read_bytes()) if file.is_file() else None

    async def set(self, key: str, value: Any) -> None:
        """Write a file."""
        file = self.root / key
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_bytes(value.as_buffer_like())

    async def exists(self, key: str) -> bool:
        """Whether there is such a file."""
        return (self.root / key).is_file()


_CODECS = {"zstd": DirectZstd, "blosc": DirectBlosc}


@contextlib.contextmanager
def without_threads() -> Iterator[None]:
    """Arrays that are opened or created meanwhile are read and written without threads, then and later."""
    for name, codec in _CODECS.items():
        register_codec(name, codec)
    with zarr.config.set({f"codecs.{name}": f"{__name__}.{codec.__name__}" for name, codec in _CODECS.items()}):
        yield
