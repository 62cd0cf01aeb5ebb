"""A small fleet with its report: a flagged well, one of a single window, one without windows, one that failed."""

from dataclasses import dataclass
from pathlib import Path

import pandas as pd
import pytest
import yaml

from drillid.config.settings import Settings
from drillid.config.sheets import read_sheets
from drillid.datasets.registry import PROBLEM_COLUMNS
from drillid.datasets.store import WellFolders
from drillid.datasets.tables import write_table
from drillid.report.content import Identified, identified
from drillid.report.page import write_report
from tests.synthetic_well import RIG, make_well

COUNTS = {"W1": 10, "W2": 1, "W3": 0}
WELLS = [*COUNTS, "W4"]
ATTACK = "<script>alert(1)</script>"
PROBLEMS = [
    ("W1", "records", "log_1.csv", "3 spikes replaced", "Look at the recorder"),
    *(("W2", "fits", f"window {name} <1500 m", f"reason & name {name}", "See it") for name in "abcdefghi"),
    *(("W2", "mobility", f"stack {number}", f"windows {number} disagree", "See them") for number in range(5)),
    ("W3", "windows", "well W3", "no window was found", "See its segments.csv for the reasons"),
    ("W4", "records", "bad.csv, row 7", f"{ATTACK} is not a number", "Correct the row"),
]
"""Rows of problems.csv."""


@dataclass(frozen=True)
class Fleet:
    """Settings and results of a fleet with its report."""

    settings: Settings
    results: Path
    wells: list[str]

    def page(self, well: str = "") -> str:
        """The page of a well, or of the fleet."""
        path = self.results / f"report/{well}.html" if well else self.results / "report.html"
        return path.read_text(encoding="utf-8")

    def write(self) -> None:
        """Write the report again."""
        write_report(self.settings, self.results, self.wells)


@pytest.fixture(scope="session")
def fleet(tmp_path_factory: pytest.TempPathFactory) -> Fleet:
    """The fleet; read only."""
    root = tmp_path_factory.mktemp("fleet")
    settings = Settings.checked(
        {
            **{name: str(root / f"{name}.tsv") for name in ("wells", "logs")},
            **{name: str(root / name) for name in ("rigs", "results")},
            "report": {"title": "Fleet of <two> & more"},
        },
        "test",
    )
    (root / "rigs").mkdir()
    (root / "rigs/rig.yaml").write_text(yaml.safe_dump(RIG, allow_unicode=True))
    rows = [f"{well}\trig\tWell {number} <b>bold</b>" for number, well in enumerate(WELLS)]
    (root / "wells.tsv").write_text("\n".join(["well\trig\tdescription", *rows]))
    (root / "logs.tsv").write_text("\n".join(["well\tlog", *(f"{well}\t{well}.csv" for well in WELLS)]))
    results = root / "results"
    for name, count in COUNTS.items():
        make_well(results, name, count)
    write_table(pd.DataFrame(PROBLEMS, columns=list(PROBLEM_COLUMNS)), results / "problems.csv")
    made = Fleet(settings, results, WELLS)
    made.write()
    return made


@pytest.fixture(scope="session")
def found(fleet: Fleet) -> Identified:
    """What was identified in the flagged well."""
    return identified(WellFolders(fleet.results, "W1"), read_sheets(fleet.settings)["W1"].load().rig)
