"""Small synthetic wells whose figures are drawn."""

from pathlib import Path

import pytest

from drillid.config.listing import Well
from drillid.datasets.store import WellFolders
from drillid.figures.data import WellResults
from tests.synthetic_well import SETTINGS, make_well

COUNTS = {"many": 10, "one": 1, "gap": 4, "none": 0}


@pytest.fixture(scope="session")
def wells(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, dict[str, Well]]:
    """Results and wells, by name; read only but for the figures."""
    results = tmp_path_factory.mktemp("results")
    return results, {name: make_well(results, name, COUNTS[name], gap=80 * (name == "gap")) for name in COUNTS}


@pytest.fixture(scope="session")
def many(wells: tuple[Path, dict[str, Well]]) -> WellResults:
    """The well of ten windows, two of which are flagged."""
    results, made = wells
    return WellResults.load(made["many"], WellFolders(results, "many"), SETTINGS.discrepancy.error_rate)
