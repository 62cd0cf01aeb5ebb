"""Hashes notice what changes results, and nothing else."""

import json
import os
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

from drillid.errors import SettingsError
from drillid.fleet import code, provenance
from drillid.fleet.code import code_hashes, tree_hash


@pytest.fixture
def package(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    files = {
        "__init__.py": "",
        "base.py": "B = 1\n",
        "late.py": "L = 1\n",
        "typed.py": "T = 1\n",
        "physics/__init__.py": "",
        "physics/line.py": "P = 1\n",
        "physics/ladder.py": "Q = 1\n",
        "formats/__init__.py": "def read(): ...\n",
        "formats/csv.py": "C = 1\n",
        "stage.py": '"""Text."""\nfrom typing import TYPE_CHECKING\n'
        "from rig.base import B\nfrom rig.physics.line import P\nfrom .formats import read\n"
        "if TYPE_CHECKING:\n    from rig.typed import T\n"
        "def work():\n    from rig import late\n    return late.L\n",
    }
    for name, text in files.items():
        path = tmp_path / "rig" / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text)
    monkeypatch.syspath_prepend(tmp_path)
    _forget()
    yield tmp_path / "rig"
    _forget()


def _forget() -> None:
    for cached in (provenance.source_hash, provenance.closure, provenance._graph):
        cached.cache_clear()


def test_the_closure_follows_imports_into_functions_and_packages(package: Path) -> None:
    assert provenance.closure("rig.stage") == {
        f"rig.{name}" for name in ("stage", "base", "late", "physics.line", "formats", "formats.csv")
    }


@pytest.mark.parametrize("name", ["stage", "base", "late", "physics/line", "formats/csv"])
def test_code_that_the_stage_uses_changes_its_hash(package: Path, name: str) -> None:
    before = provenance.source_hash("rig.stage")
    with (package / f"{name}.py").open("a") as source:
        source.write("MORE = 2\n")
    _forget()
    assert provenance.source_hash("rig.stage") != before


@pytest.mark.parametrize(
    ("name", "text"),
    [
        ("physics/ladder", "MORE = 2\n"),
        ("typed", "MORE = 2\n"),
        ("base", "# a comment\n"),
        ("base", '"""A docstring."""\n'),
    ],
)
def test_what_cannot_change_results_leaves_the_hash_alone(package: Path, name: str, text: str) -> None:
    before = provenance.source_hash("rig.stage")
    with (package / f"{name}.py").open("a") as source:
        source.write(text)
    _forget()
    assert provenance.source_hash("rig.stage") == before


def test_models_around_the_settings_leave_the_hash_alone_as_their_values_are_in_every_key() -> None:
    assert "drillid.config.settings" not in provenance.closure("drillid.spectra.stage")


def test_a_source_that_is_no_python_is_named(package: Path) -> None:
    (package / "base.py").write_text("def (:\n")
    with pytest.raises(SettingsError, match=r"base\.py"):
        provenance.source_hash("rig.stage")


def test_a_module_that_is_not_there_is_named(package: Path) -> None:
    with pytest.raises(SettingsError, match=r"rig\.nowhere"):
        provenance.source_hash("rig.nowhere")


def test_a_manifest_notices_size_and_any_change_of_time(tmp_path: Path) -> None:
    log = tmp_path / "a.csv"
    missing = provenance.file_manifest([log])
    log.write_text("1234")
    os.utime(log, (2e9, 2e9))
    first = provenance.file_manifest([log])
    os.utime(log, (1e9, 1e9))
    older = provenance.file_manifest([log])
    log.write_text("12345")
    os.utime(log, (1e9, 1e9))
    assert len({missing, first, older, provenance.file_manifest([log])}) == 4


def test_a_rig_file_counts_by_its_parts_and_not_by_its_layout(tmp_path: Path) -> None:
    path = tmp_path / "rig.yaml"
    path.write_text("time: {zone: UTC}\npipe: 1\n")
    before = provenance.yaml_digest(path, ("time",))
    path.write_text("# moved\npipe: 22\ntime:\n  zone: UTC\n")
    assert provenance.yaml_digest(path, ("time",)) == before
    path.write_text("time: {zone: CET}\n")
    changed = provenance.yaml_digest(path, ("time",))
    path.write_text("time: {zone: UTC\n")
    broken = provenance.yaml_digest(path, ("time",))
    path.unlink()
    assert len({before, changed, broken, provenance.yaml_digest(path, ("time",))}) == 4


def test_a_hash_that_is_kept_is_that_found_anew_and_a_damaged_store_is_none(tmp_path: Path) -> None:
    source, store = tmp_path / "line.py", tmp_path / "kept/code.json"
    source.write_text("P = 1\n")
    expected = [tree_hash(b"P = 1\n")]
    assert code_hashes([source], store) == expected
    if not sys.dont_write_bytecode:
        assert list(json.loads(store.read_text()).values()) == expected
    assert code_hashes([source], store) == expected
    source.write_text("P = 2\n")
    assert code_hashes([source], store) == [tree_hash(b"P = 2\n")] != expected
    store.parent.mkdir(exist_ok=True)
    store.write_text("[1, ")
    assert code_hashes([source], store) == [tree_hash(b"P = 2\n")]


def test_a_hash_that_is_kept_is_taken_without_a_syntax_tree(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sys, "dont_write_bytecode", False)
    source, store = tmp_path / "line.py", tmp_path / "code.json"
    source.write_text("P = 1\n")
    before = code_hashes([source], store)
    monkeypatch.setattr(code, "tree_hash", lambda _: pytest.fail("a syntax tree was made again"))
    assert code_hashes([source], store) == before
