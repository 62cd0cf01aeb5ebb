"""What took long to compute, kept in files, which are never there in part."""

import json
import os
import pickle
from collections.abc import Callable
from pathlib import Path
from typing import Any, TypeVar

Kept = TypeVar("Kept")


def pickled(path: Path, make: Callable[[], Kept]) -> Kept:
    """What the file holds, or what is made and put into it."""
    if path.is_file():
        found: Kept = pickle.loads(path.read_bytes())
        return found
    made = make()
    write(path, pickle.dumps(made))
    return made


def as_json(path: Path, make: Callable[[], Any]) -> Any:
    """What the file holds, or what is made and put into it: numbers, texts, lists and dictionaries by names."""
    if not path.is_file():
        write(path, json.dumps(make()).encode())
    return json.loads(path.read_text())


def write(path: Path, content: bytes) -> None:
    """Write a file whole, under another name first, with the folders above it."""
    path.parent.mkdir(parents=True, exist_ok=True)
    # two processes may make the same
    unfinished = path.with_suffix(f".{os.getpid()}.part")
    unfinished.write_bytes(content)
    unfinished.replace(path)
