"""Compiled functions cached on disk between processes.

numba recompiles a function when its own file changes, but not when a file changes from which it uses a function or a
constant. The functions of a set of folders are therefore cached in a directory named by a hash of all their files, and
below it by module, so that every checkout with the same files finds them.

A compiled function holds copies of those that it calls, optimised together with it. numba leaves all copies of a
function visible under one name, and a process uses the one that it met first, so the last bits of a result would depend
on what was compiled or loaded before, and in which order. Here every function keeps its copies to itself.
"""

import fcntl
import hashlib
import os
from collections.abc import Callable
from pathlib import Path
from typing import Any, TypeVar

import numba
from numba.core.caching import IndexDataCacheFile, UserProvidedCacheLocator
from numba.core.codegen import CPUCodeLibrary

Function = TypeVar("Function", bound=Callable[..., Any])

_CONFIG: Any = numba.config
_PACKAGE = Path(__file__).parent
_DISPATCHERS: list[Any] = []


_FILE: Any = IndexDataCacheFile
_LOCATOR: Any = UserProvidedCacheLocator
_LIBRARY: Any = CPUCodeLibrary
_optimise: Callable[[Any], None] = _LIBRARY._optimize_final_module
_save: Callable[[Any, Any, Any], None] = _FILE.save


def _optimise_with_own_copies(library: Any) -> None:
    """Make the copies of called functions private before numba optimises and stores them."""
    for function in library._final_module.functions:
        if not function.is_declaration and function.linkage.name == "linkonce_odr":
            function.linkage = "internal"
    _optimise(library)


def _save_alone(file: Any, key: Any, data: Any) -> None:
    """Save while no other process does: two that add to an index at once would give their data the same name."""
    with Path(file._cache_path, ".lock").open("a") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        _save(file, key, data)


_LIBRARY._optimize_final_module = _optimise_with_own_copies
_FILE.save = _save_alone


class LocatorByModule(_LOCATOR):  # type: ignore[misc]
    """Where a function is cached below `numba.config.CACHE_DIR`: by its module, whereas numba uses its file's path."""

    def __init__(self, function: Callable[..., Any], file: str) -> None:
        super().__init__(function, file)
        self._folder = str(Path(_CONFIG.CACHE_DIR, function.__module__))

    def get_cache_path(self) -> str:
        """The folder."""
        return self._folder


def compiler(*folders: str, root: Path = _PACKAGE, **options: Any) -> Callable[[Function], Function]:
    """A decorator that compiles functions of some folders, which may call each other.

    Parameters
    ----------
    folders : folders of the library that hold the functions and all that these call
    root : where the folders are
    options : of `numba.njit`

    Raises
    ------
    FileNotFoundError
        If one of the folders does not exist.
    """
    cache = str(_cache(folders, root))

    def compiled_function(function: Function) -> Function:
        previous = _CONFIG.CACHE_DIR, _CONFIG.CACHE_LOCATOR_CLASSES
        _CONFIG.CACHE_DIR, _CONFIG.CACHE_LOCATOR_CLASSES = cache, f"{__name__}.{LocatorByModule.__name__}"
        try:
            result: Any = numba.njit(cache=True, **options)(function)
        finally:
            _CONFIG.CACHE_DIR, _CONFIG.CACHE_LOCATOR_CLASSES = previous
        _DISPATCHERS.append(result)
        typed: Function = result
        return typed

    return compiled_function


def is_compiled(*folders: str) -> bool:
    """Whether functions of these folders have been compiled before; if not, their first use takes minutes."""
    return any(_cache(folders, _PACKAGE).rglob("*.nbi"))


def _cache(folders: tuple[str, ...], root: Path) -> Path:
    """Where compiled functions of these folders are kept."""
    base = Path(_CONFIG.CACHE_DIR) if _CONFIG.CACHE_DIR else _writable(root / "__pycache__")
    return base / f"{'-'.join(folders)}-{_sources(folders, root)}"


def load_kernels() -> None:
    """Load the imported functions as compiled by earlier processes, for all argument types met there."""
    for dispatcher in _DISPATCHERS:
        dispatcher.targetctx.refresh()
        for key in dispatcher._cache._cache_file._load_index():
            # looked up as numba does, so that nothing is compiled here
            if key == dispatcher._cache._index_key(key[0], dispatcher.targetctx.codegen()):
                dispatcher.compile(key[0])


def _writable(folder: Path) -> Path:
    """The folder if it can be written, else one of the user's: an installed library may be read-only."""
    there = next(each for each in (folder, *folder.parents) if each.exists())
    if os.access(there, os.W_OK):
        return folder
    return Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "drillid"


def _sources(folders: tuple[str, ...], root: Path) -> str:
    """Hash of this module, which sets how functions are compiled, and of names and contents of the folders' sources."""
    content = hashlib.sha256(Path(__file__).read_bytes())
    for folder in folders:
        if not (root / folder).is_dir():
            raise FileNotFoundError(f"{root / folder} is no folder of compiled functions")
        for path in sorted((root / folder).rglob("*.py")):
            content.update(f"{path.relative_to(root)}\n".encode())
            content.update(path.read_bytes())
    return content.hexdigest()[:16]
