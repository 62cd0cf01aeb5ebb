"""Small depth tracks for the fleet's page, as SVG."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from markupsafe import Markup

from drillid.arrays import Floats

WIDTH, HEIGHT = 64, 72
_BAR, _GAP = 8, 4
_MOST_POINTS = 60
_LEAST_HEIGHT = 2.0
"""Pixels of the shortest mark."""


def depth_track(depth: Floats, value: Floats, marks: Sequence[tuple[float, float, str]], words: str) -> Markup:
    """Windows as a bar, marked intervals on it, and one parameter beside it, against depth downwards.

    Parameters
    ----------
    depth, value : of the windows, in order of depth, shape (window,); values are not negative
    marks : from and to, m, and urgency, which colours them
    words : for readers who do not see it
    """
    known = np.isfinite(depth) & np.isfinite(value)
    ends = [*depth[known].tolist(), *(end for *mark, _ in marks for end in mark if np.isfinite(end))]
    if not ends:
        return Markup("")
    top, span = min(ends), max(max(ends) - min(ends), 1e-9)

    def down(place: float) -> float:
        return float(round(1 + (HEIGHT - 2) * (place - top) / span, 1))

    shapes = [Markup('<rect class="windows" x="0" y="1" width="{}" height="{}"/>').format(_BAR, HEIGHT - 2)]
    for begin, end, level in marks:
        if np.isfinite(begin):
            height = max(down(end) - down(begin), _LEAST_HEIGHT)
            shape = Markup('<rect class="mark {}" x="0" y="{}" width="{}" height="{:.1f}"/>')
            shapes.append(shape.format(level, down(begin), WIDTH, height))
    if known.sum() > 1:
        shapes.append(_line(depth[known], value[known], down))
    head = Markup('<svg class="track" viewBox="0 0 {} {}" width="{}" height="{}" role="img" aria-label="{}">').format(
        WIDTH, HEIGHT, WIDTH, HEIGHT, words
    )
    return head + Markup("").join(shapes) + Markup("</svg>")


def _line(depth: Floats, value: Floats, down: object) -> Markup:
    chosen = np.unique(np.linspace(0, depth.size - 1, min(depth.size, _MOST_POINTS)).round().astype(int))
    # from zero, and what is usual no further than half-way: scatter about one level is no trend
    end = max(np.percentile(value, 98), 2 * np.median(value), 1e-12)
    across = np.clip(value[chosen] / end, 0, 1) * (WIDTH - _BAR - 2 * _GAP) + _BAR + _GAP
    assert callable(down)
    points = " ".join(f"{x:.0f},{down(y):.0f}" for x, y in zip(across.tolist(), depth[chosen].tolist(), strict=True))
    return Markup('<polyline class="curve" points="{}"/>').format(points)
