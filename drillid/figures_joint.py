"""What all windows together say of a parameter: its track and 95 % band against depth, broken where it jumps."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from drillid.figures_style import CHANGE, JOINT

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from drillid.figures_data import WellResults

Floats = NDArray[np.float64]


def joint_band(results: WellResults, name: str, shift: Floats | float, factor: float) -> Floats:
    """Lower end, value and upper end as drawn, shape (3, window)."""
    fit = results.joint.sel(parameter=name)
    return np.stack([(fit[end].values - shift) * factor for end in ("lower", "value", "upper")])


def draw_joint(axis: Axes, results: WellResults, name: str, band: Floats) -> None:
    """The band and the value, and a line at each depth where the parameter jumps."""
    depth = results.windows["hole_depth"].values
    order = np.argsort(depth, kind="stable")
    jumps = results.joint["change_parameter"].values == name
    changes = np.sort(results.joint["change_depth"].values[jumps])
    piece = np.searchsorted(changes, depth[order])
    for number in range(changes.size + 1):
        members = order[piece == number]
        if not members.size or not np.isfinite(band[:, members]).all():
            continue
        before, behind = changes[max(number - 1, 0) : number], changes[number : number + 1]
        reach = np.concatenate([before, depth[members], behind])
        lower, value, upper = (np.pad(row[members], (before.size, behind.size), mode="edge") for row in band)
        axis.fill_betweenx(reach, lower, upper, color=JOINT, alpha=0.32, linewidth=0, zorder=2.2)
        axis.plot(value, reach, color=JOINT, linewidth=2.0, zorder=3.5)
    for change in changes:
        axis.axhline(change, color=CHANGE, linewidth=1.1, zorder=2.1)
