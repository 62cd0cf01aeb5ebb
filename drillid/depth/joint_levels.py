"""The joint fit of a well in brief, and where it has moved since."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np

from drillid.datasets.store import WellFolders
from drillid.physics.parameters import PARAMETERS

_APART_M = 100.0
"""Length of the depth intervals, over which parameters hardly change; one window is kept of each."""
_DIGITS = 6
_LEAST = 10.0 ** (1 - _DIGITS)
"""Least half-width assumed for a band, relative to the value: as much as rounding changes."""

Levels = Mapping[str, Mapping[str, Any]]
"""By depth interval: the `depth` of its window, and the value and 95 % band of each parameter; None where unknown."""


def joint_levels(folders: WellFolders) -> dict[str, dict[str, Any]]:
    """Levels of the first window of each depth interval, which remains the first as a well grows."""
    if not folders.has("fits", "joint"):
        return {}
    joint = folders.read("fits", "joint", ("value", "lower", "upper", "parameter", "hole_depth")).load()
    depth = joint["hole_depth"].values
    pieces, rows = np.unique(np.nan_to_num(depth // _APART_M, nan=-1.0), return_index=True)
    bands = np.stack([joint[name].values for name in ("value", "lower", "upper")], axis=-1)
    names = joint["parameter"].values.tolist()
    return {
        f"{piece:.0f}": {"depth": _rounded(depth[row])}
        | {name: list(map(_rounded, band)) for name, band in zip(names, bands[row].tolist(), strict=True)}
        for piece, row in zip(pieces.tolist(), rows.tolist(), strict=True)
    }


def _rounded(value: float) -> float | None:
    return float(f"{value:.{_DIGITS}g}") if np.isfinite(value) else None


def moved_levels(old: Levels, new: Levels) -> Iterator[dict[str, Any]]:
    """Parameters that lie outside their earlier band, at which depths, and the largest move."""
    both = [piece for piece in new if piece in old]
    for name, (unit, meaning) in PARAMETERS.items():
        moves = {piece: _move(name, old[piece], new[piece]) for piece in both}
        moved = [piece for piece in both if moves[piece] > 1.0]
        if not moved:
            continue
        most = max(moved, key=moves.__getitem__)
        depths = [new[piece]["depth"] for piece in moved if new[piece]["depth"] is not None]
        yield {
            "change": "changed_joint_fit",
            "stage": "fits",
            "from_m": min(depths, default=""),
            "to_m": max(depths, default=""),
            "before": f"{meaning} {_words(old[most][name], unit)}",
            "now": _words(new[most][name], unit),
        }


def _move(name: str, old: Mapping[str, Any], new: Mapping[str, Any]) -> float:
    """Change of a parameter relative to the part of the earlier band on that side; above one it lies outside."""
    (value, low, high), now, depths = old[name], new[name][0], (old["depth"], new["depth"])
    if None in (value, low, high, now):
        return 0.0
    change = now - value
    if name == "length" and None not in depths:
        # the window may be another one in the same interval
        change -= depths[1] - depths[0]
    reach = high - value if change > 0 else value - low
    return abs(change) / max(reach, _LEAST * max(abs(value), abs(now))) if change else 0.0


def _words(band: list[Any], unit: str) -> str:
    value, low, high = band
    return f"{value:.4g} {unit}" + ("" if None in (low, high) else f" ({low:.4g} to {high:.4g})")
