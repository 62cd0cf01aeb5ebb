"""Names of wells as folders, and the folders that logs may lie in."""

from __future__ import annotations

import functools
import glob
import hashlib
import os
import re
import unicodedata
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

SAFE = r"^[A-Za-z0-9][A-Za-z0-9_.-]*$"
"""Names that are folders on every file system and need no quoting in a shell."""
_LONGEST = 80
_LETTERS = str.maketrans({"ø": "o", "Ø": "O", "æ": "ae", "Æ": "AE", "å": "a", "Å": "A", "ß": "ss", "ł": "l", "Ł": "L"})
_LIKE_A_FILE = re.compile(r"\.(?:json|part|lock)\.*$", re.IGNORECASE)
"""Ends of names that files beside the folders have."""
_REMOTE = re.compile(r"(?:s3a?|gcs|gs|az|abfss?)://(?!.*::)", re.IGNORECASE)
_OTHER_ADDRESS = re.compile(r"^[a-z0-9]+(?:::|:/)", re.IGNORECASE)


def folder_of(name: str) -> str:
    """The folder of a well: its name where that is safe, else its letters and digits.

    '34/10-A-12 H' is in '34-10-A-12-H'. It depends on the name alone. Where letters are lost, as of a name in Cyrillic,
    or the name is long, a hash of the name keeps folders of different names apart.
    """
    if re.match(SAFE, name) and _may_be_folder(name):
        return name
    plain = unicodedata.normalize("NFKD", name.translate(_LETTERS))
    kept = re.sub(r"[^A-Za-z0-9_.]+", "-", plain).strip("-._")
    lost = any(letter.isalnum() and not letter.isascii() for letter in plain)
    if kept and not lost and _may_be_folder(kept):
        return kept
    digest = hashlib.sha256(name.encode()).hexdigest()[:8]
    return f"{kept[: _LONGEST - 9].strip('-._') or 'well'}-{digest}"


def _may_be_folder(name: str) -> bool:
    return len(name) <= _LONGEST and not _LIKE_A_FILE.search(name)


def folder_apart(name: str) -> str:
    """A folder for a name that may not have its own, as that is another's."""
    return f"{folder_of(name)}-{hashlib.sha256(name.encode()).hexdigest()[:8]}"


def as_seen(folder: str) -> str:
    """The folder as file systems see it that ignore case and points at its end."""
    return folder.casefold().rstrip(".")


@dataclass(frozen=True)
class Roots:
    """Folders that the sheets' paths may lead into.

    folders : absolute, without links; or addresses
    """

    folders: tuple[str, ...]

    @classmethod
    def of(cls, paths: Iterable[str | Path]) -> Roots:
        """The roots of these paths and addresses."""
        texts = map(str, paths)
        return cls(tuple(dict.fromkeys(text if "://" in text else os.path.realpath(text) for text in texts)))

    def hold(self, path: str) -> bool:
        """Whether a path lies in one of the folders once its links are followed, or is an address of a remote store."""
        if _REMOTE.match(path):
            return True
        if _OTHER_ADDRESS.match(path):
            return ".." not in path and any(_below(path, root) for root in self.folders if "://" in root)
        resolved = without_links(path)
        return any(_below(resolved, root) for root in self.folders)


def without_links(path: str) -> str:
    """The path of a file once its links are followed, or its address without needless parts: one file, one name."""
    if _OTHER_ADDRESS.match(path):
        return os.path.normpath(path)
    folder, name = os.path.split(os.path.abspath(path))
    resolved = os.path.join(_resolved(folder), name)
    return os.path.realpath(path) if ".." in Path(path).parts or os.path.islink(resolved) else resolved


def files_of(path: str) -> list[str]:
    """The files that a pattern such as raw/*.csv stands for, sorted; the path itself where it is none or matches none.

    A file of that very name comes before the pattern, and addresses are no patterns.
    """
    if not glob.has_magic(path) or _OTHER_ADDRESS.match(path) or os.path.lexists(path):
        return [path]
    return sorted(glob.glob(path, recursive=True)) or [path]


@functools.lru_cache(maxsize=4096)
def _resolved(folder: str) -> str:
    """The folder without links; logs are many, their folders few."""
    return os.path.realpath(folder)


def _below(path: str, root: str) -> bool:
    return path == root or path.startswith(root.rstrip("/") + "/")
