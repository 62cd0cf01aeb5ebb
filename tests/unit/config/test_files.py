"""Text and YAML files: what is read, and that every fault names its line and a remedy that fits."""

from pathlib import Path

import pytest

from drillid.config import files
from drillid.config.files import parse_yaml, read_text, read_yaml
from drillid.config.rig import Rig
from drillid.errors import SettingsError
from drillid.fleet.provenance import yaml_digest

BOMB = "a: &a [x, x, x, x, x, x, x, x, x]\n" + "".join(
    f"{name}: &{name} [{', '.join(['*' + before] * 9)}]\n" for before, name in zip("abcdefgh", "bcdefghi", strict=True)
)


@pytest.mark.parametrize(
    ("text", "where", "remedy"),
    [
        ("name: x\n\tunit: y\n", "line 2, column 1", "Indent with spaces"),
        ("name Rig 7\ntime: {}\n", "line 2, column 5", "a colon and a space after the key in line 1, 'name Rig 7'"),
        ("name:Rig\ntime: {}\n", "line 2, column 5", "a colon and a space after the key in line 1, 'name:Rig'"),
        ("name: Rig: 7\n", "line 1, column 10", "Put the text with a colon in it in quotation marks"),
        ("a: 1\n  b: 2\n", "line 2, column 4", "Begin the keys of one level in the same column"),
        ("a: {x: 1 y: 2}\n", "line 1, column 11", "Separate 'key: value' pairs by commas"),
        ("a: {x: 1\nb: 2\n", "line 2, column 2", "close the brace"),
        ("a: [1, 2\nb: 2\n", "line 2, column 2", "close the bracket"),
        ("a: 'x\nb: 1\n", "line 3, column 1", "Close the quotation marks"),
        ('a: "C:\\logs"\n', "line 1, column 7", "Use single quotation marks"),
        ("a: @x\n", "line 1, column 4", "Put the text in quotation marks"),
        ("a: *x\n", "line 1, column 4", "Define its anchor before"),
        ("a:\n  b: 1\n c: 2\n", "line 3, column 2", "in the same column"),
        ("a: !!python/object/apply:os.system [ls]\n", "line 1, column 4", "Leave the tag out"),
        ("a: 1\nb: !!int x\n", "line 2", "leave out tags"),
        ("a: !!int ''\n", "line 1", "leave out tags"),
        ("a: !!bool maybe\n", "line 1", "leave out tags"),
        ("a: !!timestamp 2025-99-99\n", "line 1", "leave out tags"),
        (f"a: {'9' * 5000}\n", "line 1", "Correct it"),
        ("a: 1\n---\nb: 2\n", "line 2, column 1", "Keep one description in a file"),
        ("a: {b: 1,, c: 2}\n", "line 1, column 10", "remove a superfluous comma"),
        ("a: x\nb: \x07\n", "line 2", "Remove it"),
        ("a: 1\nb: 2\na: 3\n", "line 3", "Keep one of the two"),
        ("a: {x: 1, x: 2}\n", "line 1", "Keep one of the two"),
        ("a: 1\n7: 2\n", "line 2", "Put the text in quotation marks"),
        ("? [a]\n: 1\n", "line 1", "Put the text in quotation marks"),
        ("a: &x [*x]\n", "line 1", "without aliases"),
        ("[" * 100_000, "line 1", "Check that it is the file that was meant"),
        ("".join(" " * depth + "a:\n" for depth in range(100)), "line 41", "Check that it is the file that was meant"),
        (BOMB, "line 5", "without aliases"),
    ],
)
def test_a_fault_names_its_line_and_a_remedy_that_fits(text: str, where: str, remedy: str) -> None:
    with pytest.raises(SettingsError) as error:
        parse_yaml(text, "rig.yaml")
    assert error.value.where == f"rig.yaml, {where}"
    assert remedy in error.value.remedy


def test_faults_are_named_without_the_parser_in_c_too(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delattr(files.yaml, "CSafeLoader")
    files._loader.cache_clear()
    try:
        for text, remedy in (("a: 1\n\tb: 2\n", "Indent with spaces"), ("a: 1\na: 2\n", "Keep one of the two")):
            with pytest.raises(SettingsError) as error:
                parse_yaml(text, "rig.yaml")
            assert remedy in error.value.remedy
    finally:
        files._loader.cache_clear()


def test_a_key_that_is_there_twice_names_the_line_of_the_first() -> None:
    with pytest.raises(SettingsError, match=r"line 3: the key 'speed' is already given in line 2"):
        parse_yaml("channels:\n  speed: 1\n  speed: 2\n", "rig.yaml")


def test_values_are_those_of_the_core_schema() -> None:
    text = "a: 38e3\nb: 1e-6\nc: .5\nd: -3\ne: true\nf: no\ng: 12:30\nh: 2025-03-03\ni: ~\nj:\nk: 010\nl: 0\nm: .inf\n"
    assert parse_yaml(text, "x") == {
        "a": 38e3,
        "b": 1e-6,
        "c": 0.5,
        "d": -3,
        "e": True,
        "f": "no",
        "g": "12:30",
        "h": "2025-03-03",
        "i": None,
        "j": None,
        "k": 10,
        "l": 0,
        "m": float("inf"),
    }


def test_anchors_and_merges_are_read() -> None:
    text = "thick: &thick {od: 6 in, id: 3 in}\ncollars: [{<<: *thick, length: 9 m}, *thick]\n"
    assert parse_yaml(text, "x")["collars"] == [
        {"od": "6 in", "id": "3 in", "length": "9 m"},
        {"od": "6 in", "id": "3 in"},
    ]


def test_a_file_in_latin_1_is_named_with_line_and_remedy(tmp_path: Path) -> None:
    path = tmp_path / "rig.yaml"
    path.write_bytes("name: Rig\ntime: {column: 'Målt tid'}\n".encode("latin-1"))
    with pytest.raises(SettingsError) as error:
        Rig.from_yaml(path)
    assert error.value.where == f"{path}, line 2"
    assert "is not in UTF-8: byte 0xE5; in Latin-1 the line reads 'time: {column: 'Målt tid'}'" in error.value.what
    assert "iconv -f LATIN1 -t UTF-8" in error.value.remedy


@pytest.mark.parametrize("begin", [b"PK\x03\x04", b"\xd0\xcf\x11\xe0"])
def test_a_workbook_is_told_to_be_none_of_text(tmp_path: Path, begin: bytes) -> None:
    path = tmp_path / "logs.xlsx"
    path.write_bytes(begin + b"\xc7\x00")
    with pytest.raises(SettingsError, match=r"logs.xlsx: is a workbook or an archive, not text. Save it as text"):
        read_text(path)


@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig", "utf-16"])
def test_unicode_is_read_with_its_mark(tmp_path: Path, encoding: str) -> None:
    path = tmp_path / "rig.yaml"
    path.write_bytes("name: Målt\n".encode(encoding))
    assert read_yaml(path) == {"name": "Målt"}


def test_what_is_no_readable_file_is_named(tmp_path: Path) -> None:
    with pytest.raises(SettingsError, match="is a folder, not a file"):
        read_text(tmp_path)
    with pytest.raises(SettingsError, match="cannot be read"):
        read_text(tmp_path / "none.yaml")
    large = tmp_path / "large.yaml"
    large.write_bytes(b"x" * 1_000_001)
    with pytest.raises(SettingsError, match="has 1000001 bytes"):
        read_text(large)


def test_a_bomb_in_a_rig_description_is_no_bomb_in_its_digest(tmp_path: Path) -> None:
    path = tmp_path / "rig.yaml"
    path.write_text(BOMB)
    before = yaml_digest(path, ("i",))
    path.write_text(BOMB.replace("x, x", "x, y"))
    assert yaml_digest(path, ("i",)) != before
