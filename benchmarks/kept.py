"""What took long to compute, kept in files, which are never there in part."""

import os
import pickle
from collections.abc import Callable
from pathlib import Path
from typing import TypeVar

Kept = TypeVar("Kept")


def pickled(path: Path, make: Callable[[], Kept]) -> Kept:
    """What the file holds, or what is made and put into it."""
    if path.is_file():
        found: Kept = pickle.loads(path.read_bytes())
        return found
    made = make()
    write(path, pickle.dumps(made))
    return made


def write(path: Path, content: bytes) -> None:
    """Write a file whole, under another name first, with the folders above it."""
    path.parent.mkdir(parents=True, exist_ok=True)
    # two processes may make the same
    unfinished = path.with_suffix(f".{os.getpid()}.part")
    unfinished.write_bytes(content)
    unfinished.replace(path)
