"""Generated files are what the models give, and what they show is valid."""

import re
from pathlib import Path

import pytest
import yaml
from pydantic import BaseModel

from drillid.config import documents as docs
from drillid.config.described_well import DescribedFriction
from drillid.config.rig import Rig
from drillid.config.settings import Settings
from drillid.config.sheets import read_sheets
from drillid.figures.captions import FIGURES
from scripts.write_documents import commands_page
from scripts.write_gallery import page

ROOT = Path(__file__).resolve().parents[2]
DOCUMENTS = docs.documents(ROOT)


@pytest.mark.parametrize("name", DOCUMENTS)
def test_the_file_is_what_the_models_give(name: str) -> None:
    assert (ROOT / name).read_text() == DOCUMENTS[name], f"{name} is out of date: run `make docs`"


def test_the_page_of_commands_is_what_the_command_line_says() -> None:
    assert (ROOT / "docs/commands.md").read_text() == commands_page(), (
        "docs/commands.md is out of date: run `make docs`"
    )


def test_the_settings_on_the_page_on_clusters_are_valid() -> None:
    blocks = re.findall(r"```yaml\n(.*?)```", (ROOT / "docs/how-to/clusters.md").read_text(), re.DOTALL)
    found = [Settings.checked(yaml.safe_load(block), "docs/how-to/clusters.md").fleet.scheduler for block in blocks]
    assert [bool(each and each.slurm) for each in found] == [True, False]
    assert found[1] is not None
    assert found[1].kubernetes is not None


def test_the_page_on_starts_of_rotation_tells_every_key_of_friction() -> None:
    page = (ROOT / "docs/how-to/start-of-rotation.md").read_text()
    rows = [line for line in page.splitlines() if line.startswith("| `")]
    told = {key for row in rows for key in re.findall(r"`(\w+)`", row.split("|")[1])}
    assert told == set(DescribedFriction.model_fields)


def test_the_default_configuration_is_the_defaults() -> None:
    assert Settings.from_yaml(ROOT / "config/config.yaml") == Settings()


def test_the_example_of_a_rig_description_validates() -> None:
    rig = Rig.checked(yaml.safe_load(docs._EXAMPLE), "example")
    assert rig.controller is not None
    assert rig.controller.proportional == 1500
    assert rig.collars[0].outer_diameter == pytest.approx(0.1651)


@pytest.mark.parametrize("model", [Settings, Rig])
def test_every_key_is_described(model: type[BaseModel]) -> None:
    schema = model.model_json_schema()
    for name, definition in {model.__name__: schema, **schema["$defs"]}.items():
        for key, value in definition.get("properties", {}).items():
            assert value.get("description") or "$ref" in value, f"{name}.{key} lacks its sentence"


@pytest.mark.parametrize("name", ["config/demo/config.yaml", "config/shared-rigs/config.yaml"])
def test_a_configuration_of_the_repository_validates(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(ROOT)
    settings = Settings.from_yaml(Path(name))
    rigs = {path: Rig.from_yaml(path) for path in Path(settings.rigs).glob("*.yaml")}
    assert {listing.rig_file for listing in read_sheets(settings).values()} == rigs.keys()


def test_the_gallery_shows_every_figure_and_no_other() -> None:
    assert (ROOT / "docs/gallery.md").read_text() == page(), "docs/gallery.md is out of date: run `make gallery`"
    assert {path.stem for path in (ROOT / "docs/gallery").glob("*.png")} == set(FIGURES)
