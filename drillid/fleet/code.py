"""Hashes of source files by what they do, regardless of comments, docstrings and layout.

Parsing a module takes as long as importing it, so hashes are cached beside the bytecode under the bytes of the source
files; a cached hash is therefore never out of date.
"""

from __future__ import annotations

import ast
import functools
import hashlib
import json
import os
import sys
from collections.abc import Sequence
from pathlib import Path

_HERE = Path(__file__).resolve()
_KEPT = 4000
"""Number of hashes kept, the latest ones; the library has a few hundred files."""


def code_hashes(files: Sequence[Path], store: Path) -> list[str]:
    """Hash of the syntax tree of each file without positions, comments and docstrings.

    Parameters
    ----------
    files : valid Python
    store : file in which hashes are cached, if it can be written

    Raises
    ------
    SyntaxError
        If a file is not valid Python.
    """
    contents = [file.read_bytes() for file in files]
    names = [hashlib.sha256(_manner() + content).hexdigest() for content in contents]
    known = _read(store)
    new = {name: tree_hash(content) for name, content in zip(names, contents, strict=True) if name not in known}
    if new and not sys.dont_write_bytecode:
        # read again, as other processes may have added theirs meanwhile
        _write(store, dict(list((_read(store) | new).items())[-_KEPT:]))
    return [known[name] if name in known else new[name] for name in names]


def tree_hash(source: bytes) -> str:
    """The same hash from a file's bytes, without the cache."""
    tree = ast.parse(ast.unparse(ast.parse(source)))
    for node in ast.walk(tree):
        body = getattr(node, "body", None)
        if isinstance(body, list):
            body[:] = [statement for statement in body if not _is_text(statement)]
    return hashlib.sha256(ast.dump(tree).encode()).hexdigest()


@functools.cache
def _manner() -> bytes:
    """What a hash depends on besides the file: Python's syntax trees and this module."""
    return sys.version.encode() + _HERE.read_bytes()


def _read(store: Path) -> dict[str, str]:
    try:
        content = json.loads(store.read_bytes())
    except (OSError, ValueError, RecursionError):
        return {}
    return content if isinstance(content, dict) else {}


def _write(store: Path, content: dict[str, str]) -> None:
    """Write it atomically; where it cannot be written, as with an installed library, every process hashes anew."""
    temporary = store.with_suffix(f".{os.getpid()}.part")
    try:
        store.parent.mkdir(parents=True, exist_ok=True)
        temporary.write_text(json.dumps(content))
        os.replace(temporary, store)
    except OSError:
        return


def _is_text(statement: ast.stmt) -> bool:
    return (
        isinstance(statement, ast.Expr)
        and isinstance(statement.value, ast.Constant)
        and isinstance(statement.value.value, str)
    )
