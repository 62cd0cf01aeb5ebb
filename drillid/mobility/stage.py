"""Cross spectra → command mobility, its variance, the coherence gate, and stacks of windows (paper, figure 7)."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import xarray as xr

from drillid.datasets.codes import Gate
from drillid.datasets.measured import WINDOW_COORDINATES
from drillid.datasets.reuse import Memo, completed, row_keys
from drillid.datasets.store import Problem, WellFolders, window_place
from drillid.mobility.gate import gated_mobility
from drillid.mobility.responses import channel_offsets, closed_loop_responses
from drillid.mobility.stacks import stack_windows

if TYPE_CHECKING:
    from drillid.config.listing import Well
    from drillid.config.settings import Settings


def process(well: Well, folders: WellFolders, settings: Settings) -> list[Problem]:
    """Command mobilities of all windows of a well, and their stacks."""
    spectra = folders.read("spectra", "spectra").drop_dims(["spectrogram_time", "spectrogram_frequency"]).load()

    def make(rows: list[int]) -> xr.Dataset:
        chosen = spectra.isel(window=rows)
        mobility = gated_mobility(chosen, settings.mobility)
        return mobility.merge(closed_loop_responses(chosen)).merge(channel_offsets(chosen))

    keys, memo = row_keys(folders.basis, spectra["key"].values.tolist()), Memo(folders, "mobility")
    mobility = completed(folders.earlier("mobility", "mobility"), keys, "window", make)
    mobility = mobility.assign_coords({name: spectra[name] for name in (*WINDOW_COORDINATES, "frequency")})
    folders.write("mobility", "mobility", mobility)
    stacks, problems = stack_windows(mobility, settings.mobility, memo, folders.earlier("mobility", "stacks"))
    folders.write("mobility", "stacks", stacks)
    memo.save()
    return [*_unusable_windows(mobility), *problems]


def _unusable_windows(mobility: xr.Dataset) -> list[Problem]:
    used = (mobility["gate"] == Gate.USED).sum("frequency").values
    return [
        Problem(
            window_place(mobility, row),
            "no frequency passes the coherence gate",
            "Raise the sweep's amplitude or check the speed and sweep channels",
        )
        for row in np.flatnonzero(used == 0).tolist()
    ]
