"""What a stage says it reads is what its code reads: a key that forgets something would keep stale results."""

import ast
import functools
import re
from pathlib import Path
from typing import Any

import pytest

from drillid.config.rig import Rig
from drillid.config.settings import CommonCausesSettings, Settings
from drillid.datasets.store import WellFolders
from drillid.fleet.provenance import PACKAGE, closure
from drillid.fleet.stages import STAGES, Stage

RULES = PACKAGE.parent / "workflow/rules"
INFRASTRUCTURE = ("drillid.config", "drillid.datasets", "drillid.errors", "drillid.units")
"""Contracts that all stages share; they read nothing themselves."""


@functools.cache
def sources(stage: Stage) -> tuple[ast.Module, ...]:
    """Syntax trees of the modules that belong to the stage."""
    other_stages = {other.module for other in STAGES.values()} - {stage.module}
    modules = [name for name in sorted(closure(stage.module) - other_stages) if not name.startswith(INFRASTRUCTURE)]
    files = [PACKAGE.joinpath(*name.split(".")[1:]).with_suffix(".py") for name in modules]
    return tuple(map(parsed, filter(Path.is_file, files)))


@functools.cache
def parsed(file: Path) -> ast.Module:
    return ast.parse(file.read_text())


def attributes(stage: Stage, owner: str) -> set[str]:
    """Names read as `<owner>.name` or `<something>.<owner>.name`."""
    found = set()
    for node in (node for tree in sources(stage) for node in ast.walk(tree) if isinstance(node, ast.Attribute)):
        last = node.value.attr if isinstance(node.value, ast.Attribute) else getattr(node.value, "id", "")
        if last == owner:
            found.add(node.attr)
    return found


def datasets(stage: Stage) -> set[tuple[str, str]]:
    """Pairs of texts given to `folders.read` anywhere in the stage's modules."""
    found = set()
    for node in (node for tree in sources(stage) for node in ast.walk(tree) if isinstance(node, ast.Call)):
        named = [argument.value for argument in node.args if isinstance(argument, ast.Constant)]
        if isinstance(node.func, ast.Attribute) and node.func.attr == "read" and len(named) == 2:
            found.add((str(named[0]), str(named[1])))
    return {(name, dataset) for name, dataset in found if name != stage.name}


@pytest.mark.parametrize("stage", STAGES.values(), ids=list(STAGES))
def test_a_stage_declares_the_settings_that_it_reads(stage: Stage) -> None:
    # where results lie changes none of them
    read = attributes(stage, "settings") & (set(Settings.model_fields) - {"results"})
    assert read <= set(stage.sections), f"{stage.name} reads {read}: name them in drillid/fleet/stages.py"


@pytest.mark.parametrize("stage", STAGES.values(), ids=list(STAGES))
def test_a_stage_declares_the_parts_of_the_rig_that_it_reads(stage: Stage) -> None:
    read = attributes(stage, "rig") & {*Rig.model_fields, "collars_at"}
    read = {"collars" if name == "collars_at" else name for name in read}
    assert read <= set(stage.rig), f"{stage.name} reads {read} of the rig: name them in drillid/fleet/stages.py"


@pytest.mark.parametrize("stage", STAGES.values(), ids=list(STAGES))
def test_a_stage_declares_the_datasets_that_it_reads(stage: Stage) -> None:
    assert sources(stage), f"{stage.module} has no source"
    assert datasets(stage) <= set(stage.reads), f"{stage.name}: name every dataset in drillid/fleet/stages.py"


@pytest.mark.parametrize("stage", STAGES.values(), ids=list(STAGES))
def test_the_rule_waits_for_the_manifests_of_the_stages_that_it_reads(stage: Stage) -> None:
    rule = (RULES / f"{stage.name}.smk").read_text().partition(f"rule {stage.name}:")[2]
    waits, _, makes = rule.partition("output:")
    assert re.findall(r'(\w+)="<results>/(\w+)/{batch}.json"', waits) == [(name, name) for name in stage.upstream]
    # where it reads no stage it reads logs; beside these, a dry run gives it what says that its manifest is out of date
    assert waits.count("=") == max(len(stage.upstream), 1) + 1
    assert f'again=again("{stage.name}/{{batch}}.json"),' in waits
    assert makes.split()[0] == f'manifest="<results>/{stage.name}/{{batch}}.json",'


def test_settings_and_parts_of_the_rig_that_a_stage_reads_are_found_by_the_check() -> None:
    assert "fits" in attributes(STAGES["fits"], "settings")
    assert {"controller", "pipe", "top_drive_inertia"} <= attributes(STAGES["fits"], "rig")


def test_judging_common_causes_examines_again_and_their_error_rate_does_not() -> None:
    def taken(**chosen: Any) -> Any:
        settings = Settings(common_causes=CommonCausesSettings(**chosen))
        return settings.model_dump(mode="json", include=STAGES["discrepancy"].sections)

    assert taken(enabled=True) != taken() == taken(error_rate=0.01)
    assert set(taken()) == {"spectra", "mobility", "fits", "discrepancy", "common_causes"}


def test_a_dataset_that_a_stage_reads_is_found_by_the_check(tmp_path: Path) -> None:
    assert ("records", "records") in datasets(STAGES["spectra"])
    assert not WellFolders(tmp_path, "W1").has("records", "records")
