"""Workbooks that a disk or share does not deliver, as opposed to damaged ones."""

import errno
import os
import stat
import zipfile
from pathlib import Path
from typing import Any

import pandas as pd
import pytest

from drillid.errors import LogError, is_of_machine
from drillid.formats import Header, read_log
from drillid.formats.description import Dialect
from drillid.formats.readers import excel


@pytest.fixture
def workbook(tmp_path: Path) -> Path:
    path = tmp_path / "log.xlsx"
    stamps = pd.date_range("2025-03-03T06:00:00", periods=20, freq="1s")
    pd.DataFrame({"Time": stamps, "RPM": range(20)}).to_excel(path, index=False)
    assert read_log(path, None, ["RPM"]).stamps.size == 20
    os.utime(path, (0, 0))
    return path


def refused(path: Path) -> LogError:
    with pytest.raises(LogError) as told:
        read_log(path, None, ["RPM"])
    return told.value


def test_a_workbook_that_cannot_be_opened_is_not_damaged(workbook: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    headers = excel.headers

    def out_of_reach(path: Path, dialect: Dialect) -> list[Header]:
        path.unlink()
        os.mknod(path, stat.S_IFSOCK | 0o600)
        return headers(path, dialect)

    monkeypatch.setattr(excel, "headers", out_of_reach)
    error = refused(workbook)
    assert is_of_machine(error)
    assert error.remedy.endswith("the next run tries again")


def test_a_workbook_whose_end_cannot_be_read_is_not_damaged(workbook: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def unreadable(*_: Any) -> None:
        raise OSError(errno.EIO, os.strerror(errno.EIO))

    monkeypatch.setattr(zipfile, "_EndRecData", unreadable)
    assert is_of_machine(refused(workbook))


def test_a_workbook_of_which_a_part_cannot_be_read_is_not_damaged() -> None:
    calamine = pytest.importorskip("python_calamine")
    with pytest.raises(OSError, match="Stale file handle") as told, excel._damage():
        raise calamine.ZipError(f"i/o error: Stale file handle (os error {errno.ESTALE})")
    assert is_of_machine(told.value)


def test_a_workbook_that_is_cut_short_is_damaged(workbook: Path) -> None:
    workbook.write_bytes(workbook.read_bytes()[:-100])
    error = refused(workbook)
    assert not is_of_machine(error)
    assert "damaged" in error.remedy
