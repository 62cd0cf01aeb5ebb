"""Remote logs: `s3://bucket/log.parquet` and whatever else fsspec supports, as local copies."""

from __future__ import annotations

import contextlib
import functools
import hashlib
import re
import shutil
import tempfile
import time
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Any

from drillid.errors import SettingsError
from drillid.formats.description import Unusable
from drillid.formats.places import first_line

_URL = re.compile(r"^([a-z][a-z0-9+.-]+):/+([^/].*)$")
_KEPT_BYTES = 2**31
"""Largest total size of a process's local copies; the oldest are deleted first."""
_KEPT_S = 60.0
"""How long the listing of a folder is kept."""


def url_of(path: Path) -> str | None:
    """The URL that a path stands for, as paths keep one of its two slashes; None for a local file."""
    match = _URL.match(str(path))
    return None if match is None else f"{match[1]}://{match[2]}"


class _Copies:
    """Local copies of remote files, for as long as this process lives."""

    def __init__(self) -> None:
        self.folder: Path | None = None
        self.files: dict[tuple[str, str], Path] = {}

    def of(self, url: str) -> Path:
        """A copy of the file as it is now."""
        from fsspec.core import url_to_fs

        system, place = url_to_fs(url)
        key = (url, _state(system, system.info(place, **_fresh(system))))
        if key not in self.files:
            self._make_room()
            target = self._next_folder() / Path(place).name
            if system.isdir(place):
                system.get(place.rstrip("/") + "/", str(target) + "/", recursive=True)
            else:
                system.get_file(place, str(target))
            self.files[key] = target
        return self.files[key]

    def _next_folder(self) -> Path:
        from multiprocessing.util import Finalize

        if self.folder is None or not self.folder.exists():
            self.folder = Path(tempfile.mkdtemp(prefix="drillid-"))
            # atexit does not run in forked children
            Finalize(None, shutil.rmtree, args=(self.folder, True), exitpriority=1)
        return Path(tempfile.mkdtemp(dir=self.folder))

    def _make_room(self) -> None:
        while self.files and sum(file.stat().st_size for file in self.files.values()) > _KEPT_BYTES:
            oldest = next(iter(self.files))
            shutil.rmtree(self.files.pop(oldest).parent, ignore_errors=True)


_COPIES = _Copies()


@contextlib.contextmanager
def local_file(path: Path) -> Iterator[Path]:
    """The file, or a copy of the one at its URL.

    Raises
    ------
    FileNotFoundError, PermissionError
        If it is not there or may not be read.
    Unusable
        If nothing here reads such URLs.
    ConnectionError
        If the store does not answer.
    """
    url = url_of(path)
    yield path if url is None else _copy_of(url)


def _copy_of(url: str) -> Path:
    try:
        return _COPIES.of(url)
    except (FileNotFoundError, PermissionError):
        raise
    except (ImportError, ValueError) as error:
        remedy = "Install what fsspec needs for such addresses, or copy the log to a folder"
        raise Unusable(f"cannot be fetched ({first_line(error)})", remedy) from error
    except Exception as error:  # each store has errors of its own
        raise ConnectionError(f"{url} cannot be fetched: {first_line(error)}") from error


def states(paths: Iterable[Path]) -> dict[Path, str]:
    """Size and version of each remote file; empty for one that is not there or may not be read.

    A folder, such as a zarr store, has the size of all its files and a version that is made from theirs. Folders are
    listed once a minute: a file that changes in between is seen to have changed at the next listing.

    Raises
    ------
    SettingsError
        If a store does not answer.
    """
    found: dict[Path, str] = {}
    for path in paths:
        url = url_of(path)
        if url is not None:
            found[path] = _state_at(url.rstrip("/"), int(time.monotonic() / _KEPT_S))
    return found


def size_of(state: str) -> int:
    """Size of a file by its state, bytes; 0 where it is not known."""
    size = state.partition(" ")[0]
    return int(size) if size.isdigit() else 0


@functools.lru_cache(maxsize=65536)
def _state_at(url: str, minute: int) -> str:
    from fsspec.core import url_to_fs

    folder, _, name = url.rpartition("/")
    entry = _listing(folder, minute).get(name)
    if entry is None:
        return ""
    with _answering(folder):
        return _state(url_to_fs(folder)[0], entry)


@functools.lru_cache(maxsize=1024)
def _listing(folder: str, _: int) -> dict[str, dict[str, Any]]:
    """Files and folders of a remote folder by their names."""
    from fsspec.core import url_to_fs

    try:
        with _answering(folder):
            system, place = url_to_fs(folder)
            entries = system.ls(place, detail=True, **_fresh(system))
    except (FileNotFoundError, PermissionError, ImportError, ValueError):
        return {}
    return {entry["name"].rstrip("/").rpartition("/")[2]: entry for entry in entries}


@contextlib.contextmanager
def _answering(place: str) -> Iterator[None]:
    """Turn the many errors of stores that do not answer into ours; what is not there or not allowed stays as it is."""
    try:
        yield
    except (FileNotFoundError, PermissionError, ImportError, ValueError):
        raise
    except Exception as error:  # each store has errors of its own
        remedy = "Check the network and the credentials, then run again"
        raise SettingsError(place, f"does not respond ({first_line(error)})", remedy) from error


def _state(system: Any, entry: dict[str, Any]) -> str:
    """What changes with a file's content: its size, its tag or its time; for a folder, with that of any file in it."""
    if entry.get("type") == "directory":
        system.invalidate_cache(entry["name"])
        files = system.find(entry["name"], detail=True)
        lines = "".join(f"{name} {_version(files[name])}\n" for name in sorted(files))
        size = sum(file.get("size") or 0 for file in files.values())
        return f"{size} {hashlib.sha256(lines.encode()).hexdigest()}"
    return _version(entry)


def _version(entry: dict[str, Any]) -> str:
    version = next((entry[key] for key in ("ETag", "etag", "md5Hash", "mtime", "LastModified") if key in entry), "")
    return f"{entry.get('size')} {version}"


def _fresh(system: Any) -> dict[str, bool]:
    """The option that makes a file system look again instead of answering from memory."""
    import inspect

    return {"refresh": True} if "refresh" in inspect.signature(system.info).parameters else {}
