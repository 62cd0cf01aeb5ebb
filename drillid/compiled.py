"""Compiled functions that are kept on disk between processes.

numba recompiles a function when its own file changes, but not when it calls into another file that has changed,
nor when a constant from there has. So each family of functions, which is spread over files, is kept in a
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


def compiler(family: str, **options: Any) -> Callable[[Function], Function]:
    """A decorator that compiles the functions of one family.

    Parameters
    ----------
    family : beginning of the names of the family's modules
    options : of `numba.njit`
    """
    content = b"".join(path.read_bytes() for path in sorted(_PACKAGE.glob(f"{family}_*.py")))
    base = Path(_CONFIG.CACHE_DIR) if _CONFIG.CACHE_DIR else _PACKAGE / "__pycache__"
    folder = str(base / f"{family}-{hashlib.sha256(content).hexdigest()[:16]}")

    def compiled_function(function: Function) -> Function:
        given = _CONFIG.CACHE_DIR
        _CONFIG.CACHE_DIR = folder
        try:
            result: Any = numba.njit(cache=True, **options)(function)
        finally:
            _CONFIG.CACHE_DIR = given
        kept: Function = result
        return kept

    return compiled_function


compiled = compiler("simulate", fastmath={"contract"})
"""Compile a function of the simulator, with products and sums contracted where the processor can."""
