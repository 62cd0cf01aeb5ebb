"""Charts of a well: columns of a map lie at their frequencies and times, tracks hold each window's value."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
import xarray as xr
from bokeh.models import HoverTool, HStrip, Image, Segment

from drillid.config.sheets import read_sheets
from drillid.datasets.store import WellFolders
from drillid.figures.data import WellResults
from drillid.report.charts import well_data
from drillid.report.charts.log_plot import log_plot
from drillid.report.charts.maps import map_charts, map_source
from drillid.report.charts.style import depth_range
from tests.unit.report.conftest import Fleet


def loaded(fleet: Fleet) -> WellResults:
    """Results of the first well."""
    return WellResults.load(read_sheets(fleet.settings)["W1"].load(), WellFolders(fleet.results, "W1"), 0.05)


def test_a_residual_is_shown_at_its_frequency_and_none_from_above_the_band(fleet: Fleet) -> None:
    results = loaded(fleet)
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
    results = loaded(fleet)
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
    results = loaded(fleet)
    log = log_plot(results, (), depth_range(1000.0, 1030.0))
    drawn = [each.glyph for track, _, _ in log.chart.children for each in track.renderers]
    upright = [glyph for glyph in drawn if isinstance(glyph, Segment) and glyph.x0 == glyph.x1 == "weight"]
    assert [(glyph.y0, glyph.y1) for glyph in upright] == [("cell_top", "cell_bottom")]


def track_of(results: WellResults, column: str) -> Any:
    """The track of the log plot whose points are a column."""
    log = log_plot(results, (), depth_range(1000.0, 1030.0))
    tracks = (track for track, _, _ in log.chart.children)
    return next(track for track in tracks if any(getattr(each.glyph, "x", None) == column for each in track.renderers))


@pytest.mark.parametrize("stands_out", [True, False])
def test_a_flagged_window_lies_within_its_track(fleet: Fleet, stands_out: bool) -> None:
    results = loaded(fleet)
    fits, flagged = results.fits.copy(deep=True), results.discrepancy["flagged"].copy(deep=True)
    fits["value"].loc[{"parameter": "damping_bha"}][0] = 1e4
    fits["accepted"][:] = True
    flagged[:] = False
    flagged[0] = stands_out
    shown = replace(results, fits=fits, discrepancy=results.discrepancy.assign(flagged=flagged))
    across = track_of(shown, "damping_bha").x_range
    assert (across.start < 1e4 < across.end) == stands_out


def test_a_well_without_an_accepted_fit_shows_the_others_values(fleet: Fleet) -> None:
    results = loaded(fleet)
    fits = results.fits.assign(accepted=xr.zeros_like(results.fits["accepted"]))
    joint = results.joint.assign({name: results.joint[name] * np.nan for name in ("value", "lower", "upper")})
    across = track_of(replace(results, fits=fits, joint=joint), "kappa").x_range
    middle = float(np.nanmedian(results.fits["value"].sel(parameter="kappa")))
    assert across.start < middle < across.end


@pytest.mark.parametrize("never", [True, False])
def test_windows_in_which_no_speed_is_stable_are_hatched(fleet: Fleet, never: bool) -> None:
    results = loaded(fleet)
    lowest = xr.full_like(results.depth["lowest_stable_speed"], np.inf if never else 5.0)
    track = track_of(replace(results, depth=results.depth.assign(lowest_stable_speed=lowest)), "rotation")
    strips = [each.glyph.hatch_pattern for each in track.renderers if isinstance(each.glyph, HStrip)]
    assert ("x" in strips) == never
    words = [str(tip.tooltips) for tip in track.tools if isinstance(tip, HoverTool)]
    assert any("Lowest stable speed" in each for each in words)


def test_the_first_value_that_a_map_tells_is_its_own(fleet: Fleet) -> None:
    results = loaded(fleet)
    maps = well_data.maps(results)
    rows = map_source(results, maps)
    for name, chart in map_charts(results, maps, rows, depth_range(1000.0, 1030.0)).items():
        (tip,) = (each for each in chart.tools if isinstance(each, HoverTool))
        assert f"@{name}" in str(tip.tooltips)
        assert name in rows.data
