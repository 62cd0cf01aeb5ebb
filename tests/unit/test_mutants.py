"""The list of deliberate faults does not rot: their texts and tests are there, and every room has one."""

import ast
from pathlib import Path

import pytest

from drillid.fleet import stages
from tests.mutants.fault import Fault
from tests.mutants.faults import FAULTS

ROOT = Path(stages.__file__).parents[2]
WITHOUT = {"compiled", "arrays", "errors", "statistics", "__main__", "__init__"}
"""Modules beside the rooms that need none."""


def ids(fault: Fault) -> str:
    return f"{fault.room}: {fault.why}"


@pytest.mark.parametrize("fault", FAULTS, ids=ids)
def test_the_text_of_a_fault_occurs_once_and_is_changed(fault: Fault) -> None:
    assert (ROOT / fault.file).read_text().count(fault.original) == 1, f"{fault.original!r} in {fault.file}"
    assert fault.mutated != fault.original


@pytest.mark.parametrize("fault", FAULTS, ids=ids)
def test_a_faulty_module_is_still_python(fault: Fault) -> None:
    ast.parse((ROOT / fault.file).read_text().replace(fault.original, fault.mutated))


@pytest.mark.parametrize("fault", FAULTS, ids=ids)
def test_the_tests_that_must_find_it_are_there(fault: Fault) -> None:
    for test in fault.tests:
        file, _, name = test.partition("::")
        assert (ROOT / file).is_file(), file
        if name:
            assert f"def {name}(" in (ROOT / file).read_text(), test


def test_every_room_has_a_fault() -> None:
    rooms = {path.stem if path.is_file() else path.name for path in (ROOT / "drillid").iterdir()}
    covered = {fault.file.removeprefix("drillid/").partition("/")[0].removesuffix(".py") for fault in FAULTS}
    assert rooms - covered - WITHOUT - {"__pycache__"} == set()
    assert len(FAULTS) >= 30
