"""What a release states of itself agrees in all places."""

import tomllib
from pathlib import Path

import yaml

import drillid

ROOT = Path(__file__).parents[2]


def test_version_and_licence_are_the_same_everywhere() -> None:
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    citation = yaml.safe_load((ROOT / "CITATION.cff").read_text())
    assert project["version"] == citation["version"] == drillid.__version__
    assert project["license"] == citation["license"]
    assert (ROOT / "LICENSE").read_text().startswith(f"{project['license']} License")
    assert f"## {project['version']}" in (ROOT / "CHANGELOG.md").read_text()
