"""What the fleet's page tells of what was learnt in its wells."""

from pathlib import Path
from typing import Any

from drillid.datasets.tables import read_table
from drillid.discrepancy.learning.fleet import LEARNT
from drillid.report.quantities import QUANTITIES


def learnt_rows(results: Path) -> list[dict[str, Any]]:
    """Well, depths and sentence of each set of windows in which something was learnt."""
    path = Path(results) / LEARNT
    if not path.exists():
        return []
    table = read_table(path, dtype={"well": str, "sentence": str}, keep_default_na=False)
    return [
        {
            "well": row["well"],
            "depths": str(QUANTITIES["depth"].text(float(row["from_m"]), float(row["to_m"]))),
            "sentence": row["sentence"],
        }
        for row in table.to_dict("records")
    ]
