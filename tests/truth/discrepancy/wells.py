"""Wells of the small rig through the stages, and evidence from windows of any rig."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from drillid.arrays import Floats
from drillid.config.listing import Well
from drillid.config.rig import Rig
from drillid.config.settings import Settings
from drillid.datasets.store import WellFolders
from drillid.discrepancy.evidence import Evidence, OperatingPoints
from drillid.discrepancy.gather import Series, gather
from drillid.fits.datasheet import DataSheet, data_sheet
from tests.simulated import RATE, RIG, SHALLOW, SPEED, WINDOW_S, Processed, Truth, write_records

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


def windows_of(stands: Sequence[dict[str, Floats]], length_s: float = WINDOW_S) -> list[Series]:
    """The windows that fill stands."""
    samples = round(length_s * RATE)
    return [
        Series(*(stand[name][first : first + samples] for name in ("torque_sweep", "speed", "torque_command")))
        for stand in stands
        for first in range(0, stand["speed"].size, samples)
    ]


def evidence_of(
    truth: Truth,
    stands: Sequence[dict[str, Floats]],
    sheet: Rig | DataSheet = DESCRIBED,
    length_s: float = WINDOW_S,
) -> Evidence:
    """Evidence from the windows that fill stands, without detections."""
    windows = windows_of(stands, length_s)
    depth, same = np.full(len(windows), truth.bit_depth), np.ones(len(windows))
    points = OperatingPoints(depth, depth, SPEED * same, truth.bit_torque * same, np.nan * same)
    if isinstance(sheet, Rig):
        sheet = data_sheet(sheet, truth.top_drive.controller, truth.bit_depth)
    return gather(windows, RATE, points, sheet, Settings(), detecting=False)
