"""Charts of a well: columns of a map lie at their frequencies and times, tracks hold each window's value."""

from dataclasses import replace

import numpy as np
import pytest
from bokeh.models import Image, Segment

from drillid.config.sheets import read_sheets
from drillid.datasets.store import WellFolders
from drillid.figures.data import WellResults
from drillid.report.charts import well_data
from drillid.report.charts.log_plot import log_plot
from drillid.report.charts.maps import map_charts, map_source
from drillid.report.charts.style import depth_range
from tests.unit.report.conftest import Fleet


def test_a_residual_is_shown_at_its_frequency_and_none_from_above_the_band(fleet: Fleet) -> None:
    results = WellResults.load(read_sheets(fleet.settings)["W1"].load(), WellFolders(fleet.results, "W1"), 0.05)
    frequency, grid = results.depth["frequency"].values, well_data.maps(results).frequency
    residual = np.ones((results.windows.sizes["window"], frequency.size), dtype=complex)
    # the grid is coarser than the frequencies there
    for column in (47, 75, 110, frequency.size - 2):
        peak = residual.copy()
        peak[:, column] = 100.0
        examined = results.examination.assign(residual_before=(("window", "frequency"), peak))
        shown = well_data.maps(replace(results, examination=examined)).images["residual_before"][0]
        assert np.argmax(shown) == np.abs(np.log(grid / frequency[column])).argmin()
    peak = np.where(frequency > frequency[103], 100.0, residual)
    examined = results.examination.assign(residual_before=(("window", "frequency"), peak))
    below = replace(results, examination=examined)
    vars(below)["band"] = (0.05, float(frequency[100]))
    assert well_data.maps(below).images["residual_before"].max() < 1.0


@pytest.mark.parametrize("name", ["fitted", "bit_controlled", "step_stiff"])
def test_columns_of_a_map_lie_at_their_frequencies_and_times(fleet: Fleet, name: str) -> None:
    results = WellResults.load(read_sheets(fleet.settings)["W1"].load(), WellFolders(fleet.results, "W1"), 0.05)
    maps = well_data.maps(results)
    chart = map_charts(results, maps, map_source(results, maps), depth_range(1000.0, 1030.0))[name]
    (image,) = (each.glyph for each in chart.renderers if isinstance(each.glyph, Image))
    # the browser stretches a row evenly over the screen, along which frequencies are logarithmic
    points = maps.lag if name.startswith("step") else np.log(maps.frequency)
    ends = np.array([image.x, image.x + image.dw])
    left, right = ends if name.startswith("step") else np.log(ends)
    centres = left + (np.arange(points.size) + 0.5) / points.size * (right - left)
    assert centres == pytest.approx(points, abs=1e-9)


def test_what_the_rig_did_is_drawn_over_the_depths_of_its_window(fleet: Fleet) -> None:
    results = WellResults.load(read_sheets(fleet.settings)["W1"].load(), WellFolders(fleet.results, "W1"), 0.05)
    log = log_plot(results, (), depth_range(1000.0, 1030.0))
    drawn = [each.glyph for track, _, _ in log.chart.children for each in track.renderers]
    upright = [glyph for glyph in drawn if isinstance(glyph, Segment) and glyph.x0 == glyph.x1 == "weight"]
    assert [(glyph.y0, glyph.y1) for glyph in upright] == [("cell_top", "cell_bottom")]
