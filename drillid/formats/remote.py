"""Logs elsewhere: `s3://bucket/log.parquet` and whatever else fsspec knows, as local copies."""

from __future__ import annotations

import contextlib
import re
import shutil
import tempfile
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Any

_URL = re.compile(r"^([a-z][a-z0-9+.-]+):/+([^/].*)$")
_KEPT_BYTES = 2**31
"""Local copies of a process take up to so much; the oldest are deleted first."""


def url_of(path: Path) -> str | None:
    """The URL that a path stands for, as paths hold one of its two slashes; None of a local file."""
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
        key = (url, _state(system.info(place, **_fresh(system))))
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
    OSError
        If it is not there or may not be read.
    ValueError
        If nothing reads such URLs.
    """
    url = url_of(path)
    yield path if url is None else _COPIES.of(url)


def states(paths: Iterable[Path]) -> dict[Path, str]:
    """Size and version of each remote file, empty of one that is not there; folders are listed once."""
    from fsspec.core import url_to_fs

    found: dict[Path, str] = {}
    listed: dict[str, dict[str, Any]] = {}
    for path in paths:
        url = url_of(path)
        if url is None:
            continue
        found[path] = ""
        with contextlib.suppress(OSError, ValueError):
            system, place = url_to_fs(url)
            folder = url.rpartition("/")[0]
            if folder not in listed:
                entries = system.ls(system._parent(place), detail=True, **_fresh(system))
                listed[folder] = {entry["name"]: entry for entry in entries}
            entry = listed[folder].get(place)
            found[path] = "" if entry is None else _state(entry)
    return found


def _state(entry: dict[str, Any]) -> str:
    """What changes with a file's content: its size, its tag or its time."""
    version = next((entry[key] for key in ("ETag", "etag", "md5Hash", "mtime", "LastModified") if key in entry), "")
    return f"{entry.get('size')} {version}"


def _fresh(system: Any) -> dict[str, bool]:
    """The option by which a system looks again instead of answering from memory."""
    import inspect

    return {"refresh": True} if "refresh" in inspect.signature(system.info).parameters else {}
