"""The status quo: numbers that nothing but an earlier run states are what they were.

A failure says that behaviour changed, not that it is wrong. `python -m tests.baselines.make` writes the numbers again
where the change is meant; every number that differs belongs into the message of that commit.
"""

import json

import pytest

from tests.baselines.make import FOLDER
from tests.baselines.values import BASELINES

pytestmark = pytest.mark.xdist_group("baselines")


@pytest.mark.parametrize("name", BASELINES)
def test_numbers_are_those_of_the_stored_run(name: str) -> None:
    """Fits end within their tolerances, which are far below 0.1 %; words are compared letter by letter."""
    values, data = BASELINES[name]
    if data is not None and not data.exists():
        pytest.skip(f"{data} is not there")
    stored, found = json.loads((FOLDER / f"{name}.json").read_text()), values()
    assert found.keys() == stored.keys()
    differing = {key: (stored[key], found[key]) for key in stored if found[key] != _like(stored[key])}
    assert not differing, "stored and found"


def _like(value: object) -> object:
    return pytest.approx(value, rel=1e-3) if isinstance(value, float) else value


def test_no_stored_file_is_left_behind() -> None:
    assert {path.stem for path in FOLDER.glob("*.json")} == set(BASELINES)
