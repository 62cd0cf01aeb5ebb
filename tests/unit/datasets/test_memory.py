"""Datasets that are read once."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from drillid.datasets.checked_store import CheckedStore
from drillid.datasets.memory import WellReadOnce
from drillid.datasets.registry import DATASETS
from drillid.datasets.store import WellFolders


def test_each_file_is_read_once_however_often_a_dataset_is_asked_for(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    WellFolders(tmp_path, "W1").write("windows", "windows", DATASETS["windows"].empty())
    read, get = list[str](), CheckedStore.get

    async def noted(store: CheckedStore, key: str, *options: Any, **named: Any) -> Any:
        read.append(key)
        return await get(store, key, *options, **named)

    monkeypatch.setattr(CheckedStore, "get", noted)
    folders = WellReadOnce(tmp_path, "W1")
    first = folders.read("windows", "windows").load()
    before = list(read)
    assert before
    np.testing.assert_array_equal(folders.read("windows", "windows")["start"].values, first["start"].values)
    assert read == before
