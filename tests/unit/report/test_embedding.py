"""Documents of charts are those that Bokeh itself would write."""

import json
import re
from typing import Any

import numpy as np
from bokeh.core.json_encoder import serialize_json
from bokeh.document import Document
from bokeh.models import ColorBar, LinearColorMapper, Range1d

from drillid.report.charts.embedding import document
from drillid.report.charts.style import new_chart, source


def charts() -> dict[str, Any]:
    """Charts with what pages have: glyphs, an image with its colour bar, tools, shared ranges, and changed lists."""
    depths, data = Range1d(0, 1), source({"x": np.arange(3.0), "y": np.arange(3.0)}, {"y": "depth"})
    first = new_chart(None, 200, title="First", y_range=depths, tools=("pan", "reset"))
    first.scatter("x", "y", source=data, legend_label="points")
    second = new_chart(None, 200, title="Second", y_range=depths, tools=("box_zoom",))
    mapper = LinearColorMapper("Viridis256", low=0.0, high=1.0)
    second.image(image=[np.eye(3, dtype=np.float32)], x=0, y=0, dw=1, dh=1, color_mapper=mapper)
    second.add_layout(ColorBar(color_mapper=mapper), "right")
    second.xaxis[0].ticker.update(desired_num_ticks=3)
    return {"first": first, "second": second}


def test_nothing_that_bokeh_would_write_is_missing() -> None:
    drawn, held = charts(), Document()
    found = document(drawn, drawn, "c")
    for chart in drawn.values():
        held.add_root(chart)
    expected = serialize_json(held.to_json(deferred=False))
    identifiers = dict.fromkeys(re.findall(r'"id":"(p\d+)"', expected))
    for number, name in enumerate(identifiers):
        expected = expected.replace(f'"{name}"', f'"c{number}"')
    assert json.loads(found)["document"] == json.loads(expected)
    assert '"First"' in found
