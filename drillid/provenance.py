"""Hashes of code and inputs, so that results notice when either changes."""

import ast
import functools
import hashlib
import json
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Any

from drillid.errors import SettingsError

PACKAGE = Path(__file__).resolve().parent
_WITHOUT_EFFECT = {"drillid", "drillid.config"}
"""The package's version, and the models around the settings: the settings' values are in every key themselves."""


def digest(content: Any) -> str:
    """Short hash of anything that JSON can hold, independent of the order of keys."""
    return hashlib.sha256(json.dumps(content, sort_keys=True, default=str).encode()).hexdigest()[:16]


def file_manifest(paths: Iterable[Path]) -> str:
    """Hash of names, sizes and modification times; any replacement of a file changes it, a back-dated one too."""
    return digest([(path.name, *_size_and_time(path)) for path in paths])


def _size_and_time(path: Path) -> tuple[int, int]:
    try:
        status = path.stat()
    except OSError:
        return (-1, -1)
    return status.st_size, status.st_mtime_ns


def yaml_digest(path: Path, keys: tuple[str, ...]) -> str:
    """Hash of the top-level `keys` of a YAML file; of its bytes where it is not valid, so that a repair is noticed."""
    content = _yaml(path, _size_and_time(path))
    return digest({key: content.get(key) for key in keys}) if isinstance(content, dict) else digest(content)


@functools.lru_cache(maxsize=1024)
def _yaml(path: Path, _: tuple[int, int]) -> Any:
    """Parsed content, read again when size or time of the file change; its bytes in hex where that fails."""
    import yaml

    try:
        text = path.read_bytes()
    except OSError:
        return "missing"
    try:
        return yaml.safe_load(text)
    except yaml.YAMLError:
        return text.hex()


def source_hash(*modules: str) -> str:
    """Hash of the code of modules and of all drillid modules that they use; comments and docstrings do not count.

    Raises
    ------
    SettingsError
        If a module does not exist or is not valid Python.
    """
    return digest({name: _code(name) for module in modules for name in closure(module)})


@functools.cache
def package_hash() -> str:
    """Hash of every source file of the package as it is on disk at the first call."""
    files = sorted(PACKAGE.rglob("*.py"))
    return digest({str(path.relative_to(PACKAGE)): path.read_text() for path in files})


def template_hash() -> str:
    """Hash of the package's templates, which no import shows."""
    return digest({path.name: path.read_text() for path in sorted((PACKAGE / "templates").glob("*"))})


@functools.cache
def closure(module: str) -> frozenset[str]:
    """The module and all drillid modules it uses, found in the sources without importing them."""
    found: set[str] = set()
    waiting = [module]
    while waiting:
        name = waiting.pop()
        if name not in found:
            found.add(name)
            waiting.extend({name.rpartition(".")[0], *direct_imports(name)} - _WITHOUT_EFFECT)
    return frozenset(found)


@functools.cache
def direct_imports(module: str) -> frozenset[str]:
    """The drillid modules that a module imports anywhere but under `if TYPE_CHECKING:`."""
    names: set[str] = set()
    for node in _statements(_tree(module)):
        if isinstance(node, ast.Import):
            names.update(name for alias in node.names for name in _with_contents(alias.name))
        elif isinstance(node, ast.ImportFrom):
            base = _absolute(module, node)
            for alias in node.names:
                submodule = f"{base}.{alias.name}"
                names.update([base, submodule] if _file(submodule) else _with_contents(base))
    return frozenset(name for name in names if name.split(".")[0] == "drillid" and _file(name))


def _statements(tree: ast.AST) -> Iterator[ast.AST]:
    for node in ast.iter_child_nodes(tree):
        if isinstance(node, ast.If) and "TYPE_CHECKING" in ast.dump(node.test):
            continue
        yield node
        yield from _statements(node)


def _absolute(module: str, node: ast.ImportFrom) -> str:
    if not node.level:
        return node.module or ""
    path = _file(module)
    inside = module.split(".") if path and path.name == "__init__.py" else module.split(".")[:-1]
    base = inside[: len(inside) - node.level + 1]
    return ".".join([*base, node.module] if node.module else base)


def _with_contents(name: str) -> list[str]:
    """A package imported as a whole may look its modules up by itself, so all of them count."""
    path = _file(name)
    if path is None or path.name != "__init__.py" or name == "drillid":
        return [name]
    return [name, *(f"{name}.{module.stem}" for module in path.parent.glob("*.py") if module.stem != "__init__")]


def _file(module: str) -> Path | None:
    place = PACKAGE.joinpath(*module.split(".")[1:])
    candidates = (place.with_suffix(".py"), place / "__init__.py") if place != PACKAGE else (place / "__init__.py",)
    return next((path for path in candidates if path.is_file()), None)


@functools.cache
def _tree(module: str) -> ast.Module:
    path = _file(module)
    if path is None:
        raise SettingsError(module, "is no module of this checkout", "Restore the file from the repository")
    try:
        return ast.parse(path.read_text())
    except SyntaxError as error:
        raise SettingsError(
            f"{path}, line {error.lineno}", f"is not valid Python ({error.msg})", "Correct it"
        ) from error


@functools.cache
def _code(module: str) -> str:
    """The syntax tree without positions, comments and docstrings."""
    tree = ast.parse(ast.unparse(_tree(module)))
    for node in ast.walk(tree):
        body = getattr(node, "body", None)
        if isinstance(body, list):
            body[:] = [statement for statement in body if not _is_text(statement)]
    return ast.dump(tree)


def _is_text(statement: ast.stmt) -> bool:
    return (
        isinstance(statement, ast.Expr)
        and isinstance(statement.value, ast.Constant)
        and isinstance(statement.value.value, str)
    )
