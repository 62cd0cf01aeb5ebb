"""Wells of the small rig, through the stages."""

from collections.abc import Sequence
from pathlib import Path

from drillid.arrays import Floats
from drillid.config.listing import Well
from drillid.config.rig import Rig
from drillid.config.settings import Settings
from drillid.datasets.store import WellFolders
from tests.simulated import RIG, SHALLOW, Processed, write_records

DESCRIBED = Rig.checked(
    RIG.model_dump(exclude_none=True)
    | {
        "drive_delay": {"value": "28 ms", "tolerance": "5 ms"},
        "top_drive_inertia": {"value": "450 kg m^2", "relative": "5 %"},
        "pipe": {"outer_diameter": "88.9 mm", "inner_diameter": "70.2 mm"},
    },
    "small rig with data sheets",
)
"""The small rig with drive and pipe on its data sheets."""


def processed_well(results: Path, stands: Sequence[dict[str, Floats]], *stages: str) -> Processed:
    """Stands of a rig with data sheets, from their spectra through further stages."""
    folders = WellFolders(results, "well")
    write_records(folders, stands, SHALLOW.bit_depth)
    well = Processed(Well("well", DESCRIBED, ()), folders, Settings(), {})
    for stage in ("spectra", "mobility", "fits", *stages):
        well.problems[stage] = well.run(stage)
    return well
