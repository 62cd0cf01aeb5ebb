"""Readers of a process of their own: whatever happens there is an error here, and the next file is read."""

import os
from pathlib import Path

import pytest

from drillid.errors import LogError, is_of_machine
from drillid.formats import Dialect, formats, read_log
from drillid.formats import apart as module
from drillid.formats.apart import Apart, apart
from drillid.formats.description import Unusable
from tests import fragile_reader

READER = apart(fragile_reader)


@pytest.fixture
def _hasty(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(module, "_CPU_S", 0.1)
    monkeypatch.setattr(module, "_PATIENCE", 50.0)


def file(tmp_path: Path, text: str) -> Path:
    path = tmp_path / "log.fragile"
    path.write_text(text)
    return path


def process_of(path: Path) -> int:
    return int(READER.read_columns(path, READER.headers(path, Dialect())[0], ["a"], []).column("a")[0].as_py())


@pytest.mark.usefixtures("_hasty")
@pytest.mark.parametrize(
    ("text", "error", "message"),
    [
        ("segfault", ValueError, "the library that reads it crashed by SIGSEGV"),
        ("abort", ValueError, "the library that reads it crashed by SIGABRT"),
        ("loop", ValueError, "takes more than 0 s of processor time"),
        ("sleep", ValueError, "did not end within 5 s"),
        ("memory", ValueError, "takes more than 2000 MB of memory"),
        ("killed", MemoryError, "was killed, probably out of memory"),
        ("unusable", Unusable, "is a picture"),
        ("share", OSError, "Stale file handle"),
        ("bug", ValueError, "a fault of the reader"),
    ],
)
def test_an_end_of_the_process_is_an_error_and_the_next_file_is_read(
    text: str, error: type[Exception], message: str, tmp_path: Path
) -> None:
    with pytest.raises(error, match=message):
        READER.headers(file(tmp_path, text), Dialect())
    assert process_of(file(tmp_path, "sound")) != os.getpid()


def broken_call(reader: Apart) -> None:
    """Call a function of the package with what it cannot work on."""
    module._PROCESS.call(reader.module, "by_length", Path(__file__))


def test_a_fault_of_a_reader_is_no_fault_of_the_file() -> None:
    broken = Apart("drillid.formats.arrow_tables", ())
    with pytest.raises(RuntimeError, match=r"Traceback[\s\S]*arrow_tables"):
        broken_call(broken)


def test_one_process_serves_all_files_and_a_forked_child_has_its_own(tmp_path: Path) -> None:
    path = file(tmp_path, "sound")
    assert process_of(path) == process_of(path)
    reading, writing = os.pipe()
    mine = process_of(path)
    child = os.fork()
    if child == 0:
        os.write(writing, str(process_of(path)).encode())
        os._exit(0)
    os.waitpid(child, 0)
    assert int(os.read(reading, 20)) != mine
    assert process_of(path) == mine


def test_files_of_c_libraries_without_checks_of_their_own_are_read_there() -> None:
    assert {suffix for suffix, reader in formats().items() if isinstance(reader, Apart)} == {
        *(
            ".feather",
            ".arrow",
            ".ipc",
            ".arrows",
            ".h5",
            ".hdf5",
            ".hdf",
            ".he5",
            ".mat",
            ".nc",
            ".nc4",
            ".cdf",
            ".netcdf",
        )
    }


def test_a_fault_of_the_share_is_told_from_damage(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(formats(), ".fragile", READER)
    with pytest.raises(LogError, match=r"Stale file handle\)\. Check the disk or share .* tries again") as told:
        read_log(file(tmp_path, "share"), None, ["a"])
    assert is_of_machine(told.value)
    with pytest.raises(LogError) as told:
        read_log(file(tmp_path, "segfault"), None, ["a"])
    assert not is_of_machine(told.value)


def test_a_crash_fails_the_log_alone(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(formats(), ".fragile", READER)
    with pytest.raises(LogError, match=r"log\.fragile: cannot be read \(the library that reads it crashed by SIGSEGV"):
        read_log(file(tmp_path, "segfault"), None, ["a"])
