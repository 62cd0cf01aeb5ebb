"""How wells are laid out in jobs."""

from pathlib import Path

import pytest

from drillid.config.settings import FleetSettings, Settings
from drillid.config.sheets import Listing
from drillid.fleet.plan import Plan


def plan(folder: Path, processes: int, **sizes: int) -> Plan:
    """One well a log of that many MB, 'name_csv' being the file 'name.csv'; the last well's log is missing."""
    wells = {}
    for name, size in sizes.items():
        path = folder / name.replace("_", ".")
        with path.open("wb") as log:
            log.truncate(size * 1_000_000)
        wells[name] = Listing(name, folder / "toy.yaml", (path, folder / "missing.csv"))
    return Plan(Settings(fleet=FleetSettings(processes=processes)), wells)


@pytest.mark.parametrize(
    ("sizes", "memory"),
    [({}, 1000), ({"a_csv": 100, "b_csv": 50}, 2200), ({"a_csv.gz": 100}, 7000), ({"a_parquet": 100}, 7000)],
)
def test_memory_goes_with_the_largest_log_and_its_format(tmp_path: Path, sizes: dict[str, int], memory: int) -> None:
    found = plan(tmp_path, 1, small_csv=0, **sizes)
    assert found.memory_mb(tuple(found.wells)) == memory
    several = plan(tmp_path, 3, small_csv=0, **sizes)
    assert several.memory_mb(tuple(several.wells)) == memory * several.threads(tuple(several.wells))
