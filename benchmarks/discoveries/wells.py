"""The shared wells' verdicts, as the workflow's discrepancy stage wrote them (`make rigs`)."""

from math import isfinite
from pathlib import Path

import pandas as pd

from benchmarks.discoveries.rows import Discovery, Part
from drillid.discrepancy.sets import read_verdicts

LOGS = Path(__file__).parents[3] / "shared" / "data" / "rig-logs"
RESULTS = Path("results/shared-rigs")


def well_rows(verdicts: pd.DataFrame) -> tuple[Discovery, ...]:
    """One row a verdict of a well."""
    return tuple(_row(pd.Series(one)) for one in verdicts.to_dict("records"))


def _row(verdict: pd.Series) -> Discovery:
    windows = int(verdict["held_out_windows"])
    size, gain = (
        tuple(float(verdict[name + end]) for end in ("", "_low", "_high")) for name in ("size", "predictive_gain")
    )
    has_gain = isfinite(gain[0])
    return Discovery(
        verdict["well"],
        verdict["verdict"],
        float(verdict["probability"]),
        verdict["evidence"],
        family=verdict["family"],
        cause=verdict["cause"],
        from_m=float(verdict["from_m"]),
        to_m=float(verdict["to_m"]),
        location_m=float(verdict["location_m"]),
        size=(size[0], size[1], size[2]),
        unit=verdict["unit"],
        gain=(gain[0], gain[1], gain[2]),
        gain_unit="log score a window" if has_gain else "",
        held_out=(f"{windows} windows in turn" if windows else "every other frequency") if has_gain else "",
        what_would_separate=verdict["what_would_separate"],
    )


def discover(folder: Path, results: Path = RESULTS) -> Part:
    """Rows of the wells and their figure."""
    path = results / "verdicts.csv"
    if not path.is_file():
        reason = f"the wells' logs are not at {LOGS}" if not LOGS.is_dir() else f"there is no {path}: run `make rigs`"
        return Part(absent=reason)
    from benchmarks.discoveries.figures import draw_wells

    rows = well_rows(read_verdicts(path))
    drawn = folder / "wells.png"
    draw_wells(rows, drawn)
    return Part(rows, (drawn,))
