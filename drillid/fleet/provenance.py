"""Hashes of code and inputs, by which changes of either are noticed."""

from __future__ import annotations

import functools
import importlib.metadata
import importlib.util
import sys
from collections.abc import Iterable
from pathlib import Path
from typing import TYPE_CHECKING, Any

from drillid.config.files import read_yaml
from drillid.datasets.reuse import digest as digest
from drillid.errors import SettingsError
from drillid.fleet.code import code_hashes
from drillid.formats.remote import states

if TYPE_CHECKING:
    from grimp import ImportGraph

PACKAGE = Path(__file__).resolve().parent.parent
_WITHOUT_EFFECT = {"drillid", "drillid.config.settings"}
"""Modules that do not count: the package's version, and the models of the settings, whose values are in every key."""


def file_manifest(paths: Iterable[Path]) -> str:
    """Hash of names, sizes and modification times; any replacement of a file changes it, even a back-dated one.

    For files in a remote store, it is the hash of sizes and versions.

    Raises
    ------
    SettingsError
        If a remote store does not answer.
    """
    paths = list(paths)
    elsewhere = states(paths)
    return digest([(path.name, elsewhere[path] if path in elsewhere else _size_and_time(path)) for path in paths])


def _size_and_time(path: Path) -> tuple[int, int]:
    try:
        status = path.stat()
    except OSError:
        return (-1, -1)
    return status.st_size, status.st_mtime_ns


def yaml_digest(path: Path, keys: tuple[str, ...]) -> str:
    """Hash of the top-level `keys` of a YAML file; of its bytes if it is invalid, so that a repair is noticed."""
    content = _yaml(path, _size_and_time(path))
    return digest({key: content.get(key) for key in keys}) if isinstance(content, dict) else digest(content)


@functools.lru_cache(maxsize=1024)
def _yaml(path: Path, _: tuple[int, int]) -> Any:
    """Parsed content, read again when the file's size or time changes; its bytes in hex if it cannot be parsed."""
    try:
        return read_yaml(path)
    except SettingsError:
        return _bytes(path)


def _bytes(path: Path) -> str:
    try:
        return path.read_bytes().hex()
    except OSError:
        return "missing"


@functools.cache
def source_hash(*modules: str) -> str:
    """Hash of the code of modules and all modules of their package that they use, without comments and docstrings.

    It is computed once per process, as closures are.

    Raises
    ------
    SettingsError
        If a module does not exist or is not valid Python.
    """
    names = sorted({name for module in modules for name in closure(module)})
    store = PACKAGE / "__pycache__" / f"code-{sys.implementation.cache_tag}.json"
    return digest(dict(zip(names, code_hashes([_file(name) for name in names], store), strict=True)))


@functools.cache
def numerical_versions() -> dict[str, str]:
    """Versions of the libraries that affect the last bits of results."""
    return {name: importlib.metadata.version(name) for name in ("numba", "numpy", "pandas", "pyarrow", "scipy")}


@functools.cache
def package_hash() -> str:
    """Hash of every source file of the library as it is on disk at the first call."""
    files = sorted(PACKAGE.rglob("*.py"))
    return digest({str(path.relative_to(PACKAGE)): path.read_text() for path in files})


def template_hash() -> str:
    """Hash of the report's templates, which do not appear among the imports."""
    return digest({path.name: path.read_text() for path in sorted((PACKAGE / "report" / "templates").iterdir())})


@functools.cache
def closure(module: str) -> frozenset[str]:
    """The module and all modules of its package that it uses, found in the sources without importing them.

    A package that is imported as a whole may load any of its modules itself, so all of them count.

    Raises
    ------
    SettingsError
        If the module does not exist, or a source of its package is not valid Python.
    """
    graph = _graph(module.partition(".")[0])
    if module not in graph.modules:
        raise SettingsError(module, "is not a module of this checkout", "Restore the file from the repository")
    found: set[str] = set()
    waiting = {module}
    while waiting:
        name = waiting.pop()
        found.add(name)
        whole = graph.find_children(name) if name != module else set()
        waiting |= (graph.find_modules_directly_imported_by(name) | whole) - found - _WITHOUT_EFFECT
    return frozenset(found)


@functools.cache
def _graph(package: str) -> ImportGraph:
    """Imports among the modules of a package, except those for type checkers.

    grimp starts threads, so a process that has built a graph must not fork children that build another one.
    """
    import grimp

    try:
        return grimp.build_graph(package, exclude_type_checking_imports=True, cache_dir=None)
    except grimp.exceptions.SourceSyntaxError as error:
        raise SettingsError(
            f"{error.filename}, line {error.lineno}", f"is not valid Python ({error.text})", "Correct it"
        ) from error


def _file(module: str) -> Path:
    package, *parts = module.split(".")
    found = importlib.util.find_spec(package)
    assert found is not None
    assert found.origin is not None
    place = Path(found.origin).parent.joinpath(*parts)
    return place / "__init__.py" if place.is_dir() else place.with_suffix(".py")
