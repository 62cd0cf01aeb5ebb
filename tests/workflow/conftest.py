"""A checkout with toy stages for every test of the workflow."""

import shutil
from pathlib import Path

import pytest

from tests.once import made_once
from tests.workflow.toys import Checkout, new_checkout


@pytest.fixture
def checkout(tmp_path: Path) -> Checkout:
    """The copied workflow with toy stages, a rig description 'toy' and no wells yet."""
    return new_checkout(tmp_path)


@pytest.fixture(scope="session")
def _finished_once(tmp_path_factory: pytest.TempPathFactory) -> Checkout:
    def make(folder: Path) -> Checkout:
        found = new_checkout(folder)
        found.sheets({"W1": ["a.csv", "b.csv"], "W-2": ["c.csv"]})
        found.run()
        return found

    return made_once(tmp_path_factory, "finished", make)


@pytest.fixture
def finished(_finished_once: Checkout, tmp_path: Path) -> Checkout:
    """A checkout whose two wells, W1 and W-2, went through every stage."""
    shutil.copytree(_finished_once.root, tmp_path / "checkout")
    return Checkout(tmp_path / "checkout")
