"""Snakemake is led to those plugins that can be imported here."""

from pathlib import Path

import pytest

from drillid.fleet import installation
from drillid.fleet.installation import plugin_folders

ROOT = Path(__file__).resolve().parents[3]


@pytest.mark.parametrize(("spec", "names"), [(object(), ["progress", "kubernetes"]), (None, ["progress"])])
def test_the_plugin_for_kubernetes_is_left_out_where_the_one_that_it_changes_is_not_installed(
    spec: object, names: list[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(ROOT)
    monkeypatch.setattr(installation, "find_spec", lambda name: spec)
    folders = plugin_folders()
    assert [folder.name for folder in folders] == names
    assert all(list(folder.glob("snakemake_*_plugin_*/__init__.py")) for folder in folders)
