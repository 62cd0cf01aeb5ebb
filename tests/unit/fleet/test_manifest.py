"""What a job leaves: keys that are damaged are none, and a failure holds until its causes change."""

import json
from pathlib import Path

import pytest

from drillid.fleet.manifest import KEY, marks, out_of_date, stored, stored_key, write_manifest


@pytest.mark.parametrize("content", [b"", b"[1, 2]", b"{}", b'{"key": 5}', b"\xff\xfe", b"{" * 2000])
def test_a_damaged_key_is_no_key(tmp_path: Path, content: bytes) -> None:
    (tmp_path / KEY).write_bytes(content)
    assert stored(tmp_path) == {}
    assert stored_key(tmp_path) == ""


@pytest.mark.parametrize("content", [b"", b"[]", b"5", b"\xff", b'{"W1": 3}'])
def test_a_damaged_manifest_does_not_hold(tmp_path: Path, content: bytes) -> None:
    (tmp_path / "W1.json").write_bytes(content)
    assert out_of_date(tmp_path / "W1.json", ["W1"], lambda _: "")


def test_a_mark_is_a_new_file_whose_name_says_what_is_out_of_date(tmp_path: Path) -> None:
    results = tmp_path / "results"
    out = {results / "fits/W1.json": "W1 not finished", results / "report.html": "page of W1 missing"}
    found = marks(out, tmp_path)
    assert found == {
        f"{results}/fits/W1.json": f"{tmp_path}/fits: W1 not finished",
        f"{results}/report.html": f"{tmp_path}/report: page of W1 missing",
    }
    assert all(Path(mark).is_file() for mark in found.values())
    assert not results.exists()


def test_a_failure_holds_until_its_causes_change(tmp_path: Path) -> None:
    (tmp_path / "W1").mkdir()
    (tmp_path / "W1" / KEY).write_text(json.dumps({"key": "a", "failed_on": "wrong rig description"}))
    write_manifest(tmp_path / "W1.json", ["W1"])
    assert not out_of_date(tmp_path / "W1.json", ["W1"], lambda _: "wrong rig description")
    assert out_of_date(tmp_path / "W1.json", ["W1"], lambda _: "corrected rig description")
