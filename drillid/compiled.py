"""Compiled functions that are kept on disk between processes.

numba recompiles a function when its own file changes, but not when it calls into another file that has changed,
nor when a constant from there has. So the simulator's functions, which are spread over files, are kept in a
folder named after all of them.
"""

import hashlib
from collections.abc import Callable
from pathlib import Path
from typing import Any, TypeVar

import numba

Function = TypeVar("Function", bound=Callable[..., Any])

_CONFIG: Any = numba.config
_PACKAGE = Path(__file__).parent


def _folder() -> str:
    content = b"".join(path.read_bytes() for path in sorted(_PACKAGE.glob("simulate_*.py")))
    base = Path(_CONFIG.CACHE_DIR) if _CONFIG.CACHE_DIR else _PACKAGE / "__pycache__"
    return str(base / f"simulate-{hashlib.sha256(content).hexdigest()[:16]}")


_FOLDER = _folder()


def compiled(function: Function) -> Function:
    """Compile a function of the simulator, with products and sums contracted where the processor can."""
    given = _CONFIG.CACHE_DIR
    _CONFIG.CACHE_DIR = _FOLDER
    try:
        result: Any = numba.njit(cache=True, fastmath={"contract"})(function)
    finally:
        _CONFIG.CACHE_DIR = given
    kept: Function = result
    return kept
