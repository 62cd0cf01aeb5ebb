"""Compiled functions are kept on disk, and compiled again whenever a source that they may use changes."""

import shutil
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import pytest
from numba.core.caching import IndexDataCacheFile

from drillid import compiled
from drillid.compiled import compiler

INNER = """
from drillid.compiled import compiler
from pathlib import Path

compiled = compiler("kernels", root=Path(__file__).parents[1])


@compiled
def inner():
    return {value}
"""
OUTER = """
from kernels.{name} import compiled, inner


@compiled
def outer():
    return inner()
"""


@pytest.fixture
def kernels(tmp_path: Path) -> Path:
    folder = tmp_path / "kernels"
    folder.mkdir()
    (folder / "__init__.py").write_text("")
    (folder / "first.py").write_text(INNER.format(value=1))
    (folder / "outer.py").write_text(OUTER.format(name="first"))
    return folder


def called(folder: Path, cache: str = "kept") -> int:
    """What the outer function gives in a process of its own, with the compiled code that is on disk."""
    code = "from kernels.outer import outer; print(outer())"
    root, library = folder.parent, str(Path(__file__).parents[2])
    # bytecode is told by size and whole second of its source, which a test changes sooner
    environment = {"PYTHONPATH": f"{root}:{library}", "NUMBA_CACHE_DIR": str(root / cache), "PATH": ""}
    environment["PYTHONDONTWRITEBYTECODE"] = "1"
    done = subprocess.run([sys.executable, "-c", code], env=environment, capture_output=True, text=True, check=True)
    return int(done.stdout)


def kept(folder: Path) -> set[str]:
    """Folders of compiled code."""
    return {path.name for path in (folder.parent / "kept").iterdir()}


def files(folder: Path) -> dict[Path, int]:
    """Files of compiled code with the times at which they were written."""
    found = (path for path in (folder.parent / "kept").rglob("*") if path.is_file())
    return {path: path.stat().st_mtime_ns for path in found}


def test_code_that_did_not_change_is_compiled_once(kernels: Path) -> None:
    assert (called(kernels), called(kernels)) == (1, 1)
    assert len(kept(kernels)) == 1


def test_another_checkout_of_the_same_code_finds_what_is_compiled(kernels: Path) -> None:
    called(kernels)
    copy = kernels.parent / "elsewhere" / "kernels"
    shutil.copytree(kernels, copy)
    before = files(kernels)
    assert called(copy, "../kept") == 1
    assert files(kernels) == before


def test_a_changed_kernel_is_not_called_as_it_was(kernels: Path) -> None:
    assert called(kernels) == 1
    (kernels / "first.py").write_text(INNER.format(value=2))
    assert called(kernels) == 2


def test_a_renamed_kernel_is_not_called_as_it_was(kernels: Path) -> None:
    assert called(kernels) == 1
    before = kept(kernels)
    (kernels / "first.py").rename(kernels / "second.py")
    (kernels / "outer.py").write_text(OUTER.format(name="second"))
    (kernels / "second.py").write_text(INNER.format(value=3))
    assert called(kernels) == 3
    assert kept(kernels) - before


def test_a_kernel_that_only_moves_counts_as_changed(kernels: Path) -> None:
    called(kernels)
    before = kept(kernels)
    (kernels / "more").mkdir()
    (kernels / "outer.py").rename(kernels / "more" / "outer.py")
    (kernels / "more" / "outer.py").rename(kernels / "outer.py")
    (kernels / "empty.py").write_text("")
    called(kernels)
    assert kept(kernels) - before


def test_what_is_compiled_at_once_is_kept_side_by_side(tmp_path: Path) -> None:
    def save(types: int) -> None:
        IndexDataCacheFile(str(tmp_path), "kernel", "as it is").save(types, f"code for {types}")

    with ThreadPoolExecutor(8) as pool:
        list(pool.map(save, range(100)))
    file = IndexDataCacheFile(str(tmp_path), "kernel", "as it is")
    assert [file.load(types) for types in range(100)] == [f"code for {types}" for types in range(100)]


def test_a_folder_that_is_not_there_is_named(tmp_path: Path) -> None:
    with pytest.raises(FileNotFoundError, match="nowhere"):
        compiler("nowhere", root=tmp_path)


def test_kernels_of_a_library_that_cannot_be_written_are_kept_with_the_user(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    library, own = tmp_path / "library", tmp_path / "cache"
    library.mkdir()
    monkeypatch.setenv("XDG_CACHE_HOME", str(own))
    assert compiled._writable(library / "__pycache__") == library / "__pycache__"
    monkeypatch.setattr(compiled.os, "access", lambda path, _: not Path(path).is_relative_to(library))
    assert compiled._writable(library / "__pycache__") == own / "drillid"
