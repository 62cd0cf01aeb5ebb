"""Figures of small synthetic wells: all are written, hold the right data, and say what they show."""

import contextlib
import gc
import shutil
import weakref
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import matplotlib
import numpy as np
import pytest
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.collections import QuadMesh
from matplotlib.colors import to_rgba
from matplotlib.figure import Figure
from PIL import Image

from drillid.arrays import Floats
from drillid.config.listing import Well
from drillid.config.settings import FiguresSettings, Settings
from drillid.datasets.codes import Gate
from drillid.datasets.examined import EXAMINATIONS
from drillid.datasets.store import WellFolders
from drillid.discrepancy.rules import DISTINCT
from drillid.discrepancy.stage import _failed_tests
from drillid.errors import SettingsError
from drillid.figures import stage as figures
from drillid.figures.captions import DISPLAYED_PARAMETERS, FIGURES, RPM_PER_KILONEWTON_METRE
from drillid.figures.data import STAND_M, DepthCells, WellResults, drilled_length, successive_windows
from drillid.figures.layout import FORMATS, save
from drillid.figures.style import FLAGGED, STYLE, depth_image, well_marks
from drillid.figures.tracks import parameters
from drillid.figures.verdicts import set_title
from drillid.figures.windows import degrees
from drillid.physics.parameters import PARAMETERS
from tests.synthetic_well import FIRST_DEPTH, WINDOW_HEIGHT, windows_of
from tests.unit.figures.conftest import COUNTS

SETTINGS = Settings(figures=FiguresSettings(dpi=50))
DRAWINGS = figures.drawings()
OF_SETS = {"verdicts", "evidence", "distinguishability", "model_residuals", "held_out", "reflectogram"}
"""Figures of what the discovery engine examined."""


@pytest.fixture(autouse=True)
def _style() -> Iterator[None]:
    with matplotlib.rc_context(STYLE):
        yield


def test_every_figure_has_its_words_in_the_order_of_the_report() -> None:
    assert list(DRAWINGS) == list(FIGURES)


def image(axis: Axes) -> QuadMesh:
    return next(child for child in axis.collections if isinstance(child, QuadMesh))


def bars(axis: Axes) -> list[Floats]:
    """Ends of the lines of each path with gaps, (line, end, x and y)."""
    paths = [np.asarray(line.get_xydata()) for line in axis.lines]
    return [
        path.reshape(-1, 3, 2)[:, :2]
        for path in paths
        if len(path) and len(path) % 3 == 0 and np.isnan(path[2::3]).any(axis=1).all()
    ]


def panels(figure: Figure) -> list[Axes]:
    """Axes that are no colour bars."""
    return [axis for axis in figure.axes if axis.get_label() != "<colorbar>"]


def panel(figure: Figure, name: str) -> Axes:
    """The track of a parameter."""
    return next(axis for axis in figure.axes if axis.get_xlabel().startswith(DISPLAYED_PARAMETERS[name].name))


def test_every_declared_figure_is_written_and_leaves_memory(wells: tuple[Path, dict[str, Well]]) -> None:
    """Those of many windows are compared with stored images."""
    results, made = wells
    drawn: list[weakref.ref[Figure]] = []
    draw = figures.draw
    # what the collector has not come to yet must not be kept for good by the next well
    with pytest.MonkeyPatch.context() as patch, contextlib.ExitStack() as after:
        gc.disable()
        after.callback(gc.enable)
        patch.setattr(figures, "draw", lambda *what: drawn.append(weakref.ref(figure := draw(*what))) or figure)
        for name in ("one", "gap"):
            assert figures.process(made[name], WellFolders(results, name), SETTINGS) == []
            written = {path.name for path in (results / "figures" / name).iterdir()} - {"memo.txt"}
            assert written == {f"{figure}.png" for figure in FIGURES}
    gc.collect()
    assert len(drawn) == 2 * len(FIGURES)
    assert all(figure() is None for figure in drawn)


def test_a_well_without_windows_has_no_figures(wells: tuple[Path, dict[str, Well]]) -> None:
    results, made = wells
    assert figures.process(made["none"], WellFolders(results, "none"), SETTINGS) == []
    assert not list((results / "figures").glob("none/*.png"))


def test_a_well_that_failed_before_its_windows_has_no_figures(tmp_path: Path, many: WellResults) -> None:
    assert figures.process(Well("lost", many.rig, ()), WellFolders(tmp_path, "lost"), SETTINGS) == []


@pytest.mark.parametrize("suffix", FORMATS)
def test_the_same_results_give_the_same_file(many: WellResults, tmp_path: Path, suffix: str) -> None:
    paths = [tmp_path / f"again_{number}.{suffix}" for number in range(2)]
    for path in paths:
        save(figures.draw(many, "residuals"), path, 50)
    assert paths[0].read_bytes() == paths[1].read_bytes()
    signs = {"png": b"\x89PNG", "svg": b"<?xml", "pdf": b"%PDF"}
    assert paths[0].read_bytes().startswith(signs[suffix])


def test_a_figure_for_a_publication_has_no_heading_and_panels_of_the_same_size(
    many: WellResults, tmp_path: Path
) -> None:
    full, bare = tmp_path / "full.png", tmp_path / "bare.png"
    figure = figures.draw(many, "anomaly")
    save(figure, full, 50)
    panel = figure.axes[0].get_window_extent()
    save(figure, bare, 50, heading=False)
    assert figure.axes[0].get_window_extent().size == pytest.approx(panel.size)
    assert not figure.texts
    with Image.open(bare) as without, Image.open(full) as entire:
        assert without.height < entire.height - 10
    with pytest.raises(SettingsError, match="png, svg, pdf"):
        save(figure, tmp_path / "figure.xyz", 50)


def test_every_format_that_is_asked_for_is_written(many: WellResults, tmp_path: Path) -> None:
    folders = WellFolders(tmp_path, "many")
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(figures, "drawings", lambda: {"anomaly": DRAWINGS["anomaly"]})
        patch.setattr(WellResults, "load", staticmethod(lambda *_: many))
        patch.setattr(WellFolders, "has", lambda *_: True)
        patch.setattr(WellFolders, "read", lambda *_: many.windows)
        settings = Settings(figures=FiguresSettings(dpi=50, formats=("svg", "png")))
        figures.process(Well("many", many.rig, ()), folders, settings)
    assert {path.stem for path in folders.stage("figures").iterdir()} == {"anomaly", "memo"}
    assert {path.suffix for path in folders.stage("figures").glob("anomaly.*")} == {".svg", ".png"}


def test_figures_of_which_nothing_has_changed_are_kept(many: WellResults, tmp_path: Path) -> None:
    folders = WellFolders(tmp_path, "many")
    settings = Settings(figures=FiguresSettings(dpi=50))
    names = ("anomaly", "spectrograms", "command_mobility_fitted", "reflectogram")
    drawn: list[str] = []

    def again(results: WellResults) -> list[str]:
        """Figures that are drawn where all of them lie aside."""
        shutil.rmtree(folders.aside("figures"), ignore_errors=True)
        if folders.stage("figures").exists():
            folders.aside("figures").parent.mkdir(exist_ok=True)
            folders.stage("figures").rename(folders.aside("figures"))
        drawn.clear()
        with pytest.MonkeyPatch.context() as patch:
            patch.setattr(figures, "drawings", lambda: dict.fromkeys(names))
            patch.setattr(figures, "draw", lambda shown, name: drawn.append(name) or DRAWINGS[name](shown))
            patch.setattr(WellResults, "load", staticmethod(lambda *_: results))
            patch.setattr(WellFolders, "has", lambda *_: True)
            patch.setattr(WellFolders, "read", lambda *_: many.windows)
            figures.process(Well("many", many.rig, ()), folders, settings)
        assert {path.stem for path in folders.stage("figures").glob("*.png")} == set(names)
        return list(drawn)

    assert again(many) == list(names)
    assert again(many) == ["anomaly"]
    joint = many.depth.assign(kappa_joint=many.depth["kappa_joint"] + 1.0)
    assert again(replace(many, depth=joint)) == ["anomaly"]
    fitted = many.depth.assign(command_mobility_fitted=2 * many.depth["command_mobility_fitted"])
    assert again(replace(many, depth=fitted)) == ["anomaly", "spectrograms", "command_mobility_fitted"]
    assert again(replace(many, depth=fitted)) == ["anomaly"]
    (folders.stage("figures") / "reflectogram.png").write_bytes(b"damaged")
    assert again(replace(many, depth=fitted)) == ["anomaly", "reflectogram"]


def test_the_window_that_is_shown_stays_as_a_long_well_grows(many: WellResults) -> None:
    rows = [replace(many, windows=windows_of(count)).middle for count in (1, 2, 7, 10, 372, 383, 384)]
    assert rows == [0, 1, 3, 5, 160, 160, 192]


@pytest.mark.parametrize("name", list(FIGURES))
def test_every_axis_has_a_unit_and_depth_runs_downwards(many: WellResults, name: str) -> None:
    figure = DRAWINGS[name](many)
    labels = [axis.get_xlabel() for axis in panels(figure)] + [axis.get_ylabel() for axis in figure.axes]
    assert any(labels)
    assert [label for label in labels if label and "[" not in label and not label.startswith("dB re")] == []
    for axis in figure.axes:
        if axis.get_ylabel() == "Measured depth [m]":
            bottom, top = axis.get_ylim()
            assert bottom > top
            assert top <= FIRST_DEPTH < FIRST_DEPTH + WINDOW_HEIGHT * COUNTS["many"] <= bottom
    assert any(FIGURES[name].title in text.get_text() and "many" in text.get_text() for text in figure.texts)


def test_the_caption_states_the_engine_s_distance_of_indistinguishable_causes() -> None:
    assert f"below {float(DISTINCT):.1f} the two are indistinguishable" in FIGURES["distinguishability"].caption


@pytest.mark.parametrize("name", list(FIGURES))
def test_figures_of_a_well_without_an_accepted_fit_and_without_a_stack(many: WellResults, name: str) -> None:
    nothing = {"value": np.nan, "standard_error": np.nan, "chi2_per_dof": np.nan, "fit_p_value": np.nan}
    fits = many.fits.assign({key: many.fits[key] * value for key, value in nothing.items()})
    fits = fits.assign(accepted=xr.zeros_like(fits["accepted"]))
    fitted = [key for key in many.depth if str(key).startswith(("bit_", "command_mobility_fitted"))]
    depth = many.depth.assign({key: many.depth[key] * np.nan for key in fitted})
    depth = depth.assign(accepted=xr.zeros_like(depth["accepted"]))
    discrepancy = many.discrepancy.copy()
    for key in set(discrepancy.data_vars) - {"flagged", "verdict", "key"}:
        discrepancy[key] = discrepancy[key] * np.nan
    empty = many.intervals.iloc[:0]
    stackless = {"stacks": many.stacks.isel(stack=[]), "stack_fits": many.stack_fits.isel(stack=[])}
    unexamined = {"examination": EXAMINATIONS.empty(), "verdicts": many.verdicts.iloc[:0]}
    bare = replace(many, fits=fits, depth=depth, discrepancy=discrepancy, intervals=empty, **stackless, **unexamined)
    figure = DRAWINGS[name](bare)
    figure.canvas.draw()
    notes = " ".join(text.get_text() for axis in figure.axes for text in axis.texts)
    assert ("nothing was examined" in notes) == (name in OF_SETS)
    if name.startswith("bit_"):
        assert np.ma.getmaskarray(image(panels(figure)[0]).get_array()).all()


def test_a_set_is_titled_by_the_verdicts_that_hold_in_it(many: WellResults) -> None:
    assert (many.examination["verdict"].values == "none").all()
    assert (many.verdicts["verdict"] != "none").all()
    assert set_title(many, 0) == "1002–1028 m: regime change at 1015–1021 m, > 99 %"
    assert set_title(replace(many, verdicts=many.verdicts.iloc[:0]), 0) == "1002–1028 m"
    for probability, said in ((0.9999, "> 99 %"), (0.001, "< 1 %")):
        assert set_title(replace(many, verdicts=many.verdicts.assign(probability=probability)), 0).endswith(said)


def test_what_a_channel_did_not_test_says_so_and_has_no_bar(many: WellResults) -> None:
    axis = DRAWINGS["evidence"](many).axes[0]
    examined = many.examination.isel(set=0)
    missing = sum(int(np.isnan(examined[name].values).sum()) for name in ("log_evidence", "detection_log_evidence"))
    ports = examined.sizes["port"]
    assert [text.get_text() for text in axis.texts].count("not tested") == missing + ports
    assert len(axis.patches) == 2 * (examined.sizes["cause"] + ports) - missing - ports


def test_base_and_extended_residuals_are_both_seen(many: WellResults) -> None:
    after = many.examination["residual_after"] * 0.999
    figure = DRAWINGS["model_residuals"](replace(many, examination=many.examination.assign(residual_after=after)))
    axis = next(axis for axis in figure.axes if axis.get_title(loc="left").startswith("Mean square"))
    base, extended = (
        next(line for line in axis.lines if line.get_label() == f"{name} model") for name in ("base", "extended")
    )
    assert base.get_linewidth() > 2 * extended.get_linewidth()
    assert base.get_zorder() <= extended.get_zorder()


def test_the_line_of_the_p_values_is_where_the_stage_lists_a_problem(many: WellResults) -> None:
    accepted = many.fits["accepted"].copy()
    accepted[[0, 1]] = False
    some = replace(many, fits=many.fits.assign(accepted=accepted))
    axis = DRAWINGS["anomaly"](some).axes[3]
    (line,) = (each for each in axis.lines if to_rgba(each.get_color()) == to_rgba(FLAGGED))
    level = float(np.asarray(line.get_xdata())[0])
    tested = many.discrepancy.isel(window=accepted.values).copy(deep=True)
    for name in ("normality_p_value", "whiteness_p_value"):
        listed = []
        for factor in (0.99, 1.01):
            p_values = tested[["normality_p_value", "whiteness_p_value"]].map(np.ones_like)
            p_values[name][3] = factor * level
            listed.append(len(_failed_tests(tested.assign(p_values), many.error_rate)))
        assert listed == [1, 0]


def test_the_flagged_band_spans_the_interval(many: WellResults) -> None:
    interval = many.intervals.iloc[0]
    assert (interval.from_m, interval.to_m) == (FIRST_DEPTH + 5 * WINDOW_HEIGHT, FIRST_DEPTH + 7 * WINDOW_HEIGHT)
    for axis in parameters(many).axes:
        bands = [patch for patch in axis.patches if to_rgba(patch.get_facecolor())[:3] == to_rgba(FLAGGED)[:3]]
        (extent,) = [band.get_extents().transformed(axis.transData.inverted()) for band in bands]
        assert sorted((extent.y0, extent.y1)) == pytest.approx([interval.from_m, interval.to_m])


def test_sections_runs_and_intervals_are_labelled(many: WellResults) -> None:
    first, second, flagged = sorted(
        well_marks(many, 1000.0, 1030.0), key=lambda mark: (mark.until is not None, mark.depth)
    )
    assert first.text == '12¼" hole\n60 m collars\nOD 165 mm'
    assert not first.line
    assert (second.text, second.depth, second.line) == ('8⅜" hole', 1018.0, True)
    assert (flagged.text, flagged.until) == ("flagged\n1015–1021 m", 1021.0)


def test_parameters_are_drawn_at_their_values_in_units_that_people_say(many: WellResults) -> None:
    track = panel(parameters(many), "polar_moment")
    assert track.get_xlabel().endswith("[cm⁴]")
    drawn = np.concatenate([line.get_xdata() for line in track.lines if line.get_marker() == "o"])
    expected = 1e8 * many.fits["value"].sel(parameter="polar_moment").values
    np.testing.assert_allclose(np.sort(drawn.astype(float)), np.sort(expected))


def test_bars_are_two_standard_errors_to_either_side(many: WellResults) -> None:
    track = panel(parameters(many), "inertia_td")
    fit = many.fits.sel(parameter="inertia_td")
    # the marks of the measured intervals are lines too, at the axis' edge
    segments = next(drawn for drawn in bars(track) if len(drawn) == COUNTS["many"] and drawn[0, 0, 0] > 1000)
    half = 1.96 * fit["standard_error"].values
    np.testing.assert_allclose(segments[:, 0, 0], fit["value"].values - half)
    np.testing.assert_allclose(segments[:, 1, 0], fit["value"].values + half)


def test_a_value_at_its_bound_is_one_sided_and_a_rejected_fit_hollow(many: WellResults) -> None:
    index = list(PARAMETERS).index("damping_bha")
    fits = many.fits.copy(deep=True)
    fits["value"][0, index], fits["at_bound"][0, index] = 0.0, True
    fits["accepted"][1] = False
    track = panel(parameters(replace(many, fits=fits)), "damping_bha")
    markers = {line.get_marker(): line for line in track.lines if len(line.get_xdata()) and line.get_marker() in "<"}
    assert markers["<"].get_xdata() == pytest.approx([0.0])
    hollow = [line for line in track.lines if line.get_marker() == "o" and line.get_markerfacecolor() == "white"]
    assert [float(x) for line in hollow for x in line.get_xdata()] == [float(fits["value"][1, index])]
    at_bound = [
        start
        for drawn in bars(track)
        for start in drawn
        if start[0, 1] == float(many.windows["hole_depth"][0]) and start[1, 0] > 0
    ]
    assert any(segment[0, 0] == 0.0 for segment in at_bound)


def test_images_show_the_rows_and_omit_what_the_gate_rejected(many: WellResults) -> None:
    depth = many.depth.copy(deep=True)
    depth["gate"][3, 20:30] = Gate.TOO_INCOHERENT
    measured, fitted = panels(DRAWINGS["command_mobility_depth"](replace(many, depth=depth)))[:2]
    shown = image(measured).get_array()
    assert shown is not None
    assert np.ma.getmaskarray(shown).sum() == 10
    assert np.ma.getmaskarray(shown)[3, 20:30].all()
    np.testing.assert_allclose(shown[2], np.abs(depth["command_mobility"].values[2]))
    assert image(measured).get_clim() == image(fitted).get_clim()


@pytest.mark.parametrize("kind", ["bit_step", "bit_mobility"])
def test_stiff_and_controlled_have_the_same_colours(many: WellResults, kind: str) -> None:
    stiff, controlled = (image(panels(DRAWINGS[f"{kind}_{top}"](many))[0]) for top in ("stiff", "controlled"))
    assert stiff.get_clim() == controlled.get_clim()
    assert stiff.get_cmap().name == controlled.get_cmap().name


def test_bit_steps_are_in_rpm_per_kilonewton_metre(many: WellResults) -> None:
    shown = image(panels(DRAWINGS["bit_step_stiff"](many))[0])
    low, high = shown.get_clim()
    assert low == -high
    np.testing.assert_allclose(shown.get_array(), many.depth["bit_step_stiff"].values * RPM_PER_KILONEWTON_METRE)
    assert pytest.approx(1e3 * 60 / (2 * np.pi)) == RPM_PER_KILONEWTON_METRE


def test_depth_cells_join_stands_but_not_across_longer_gaps() -> None:
    windows = windows_of(4, gap=STAND_M + 1)
    cells = DepthCells.of(windows)
    assert cells.order.tolist() == [0, 1, 2, -1, 3]
    np.testing.assert_allclose(cells.edges, [1000, 1003, 1006, 1009, 1040, 1043])
    assert np.ma.getmaskarray(cells.image(np.ones((4, 2))))[:, 0].tolist() == [False, False, False, True, False]
    joined = DepthCells.of(windows_of(4, gap=20.0))
    assert joined.order.tolist() == [0, 1, 2, 3]
    np.testing.assert_allclose(joined.edges, [1000, 1003, 1006, 1019, 1032])


def test_depth_cells_are_in_order_of_depth_and_have_some_height() -> None:
    backwards = windows_of(300).isel(window=slice(None, None, -1))
    cells = DepthCells.of(backwards)
    assert cells.order.tolist() == list(range(299, -1, -1))
    assert (np.diff(cells.edges) > 0).all()
    still = windows_of(1)
    still["depth_to"] = still["depth_from"]
    assert np.diff(DepthCells.of(still).edges) > 0


def test_the_largest_stack_nearest_the_middle_is_shown(many: WellResults) -> None:
    stacks = xr.Dataset(coords={"first_window": ("stack", [0, 3, 7]), "last_window": ("stack", [2, 5, 8])})
    chosen = successive_windows(replace(many, stacks=stacks))
    assert (chosen.rows, chosen.stack) == ([3, 4, 5], 1)
    without = successive_windows(replace(many, stacks=stacks.isel(stack=[])))
    assert (without.rows, without.stack) == ([2, 3, 4, 5, 6, 7], None)


def test_phase_has_no_jump_at_half_a_turn() -> None:
    np.testing.assert_allclose(degrees(np.exp(1j * np.radians([80.0, -90.0, -170.0, -200.0]))), [80, -90, -170, -200])


def test_pipe_length_by_depth_is_bit_depth_less_collars(many: WellResults) -> None:
    np.testing.assert_allclose(drilled_length(many.rig, np.array([1000.0, 1010.0])), [940.0, 950.0])


@pytest.mark.parametrize("name", list(FIGURES))
def test_no_label_leaves_the_sheet_or_covers_another_panel(many: WellResults, name: str) -> None:
    figure = DRAWINGS[name](many)
    figure.canvas.draw()
    width, height = figure.get_size_inches()
    drawn = figure.get_tightbbox()
    assert drawn.x0 > 0
    assert drawn.y0 > 0
    assert drawn.x1 < width
    assert drawn.y1 < height
    renderer = figure.canvas.get_renderer()
    for axis in figure.axes:
        label = axis.yaxis.get_tightbbox(renderer)
        others = [other.get_window_extent(renderer) for other in figure.axes if other is not axis]
        assert label is None or not any(label.padded(-1).overlaps(other) for other in others)


def test_of_many_points_an_image_shows_those_that_can_be_seen(many: WellResults) -> None:
    axis, points = Figure().subplots(), np.linspace(0.05, 4.0, 2000)
    rows = np.broadcast_to(points, (many.windows.sizes["window"], points.size))
    mesh = depth_image(axis, many, points, rows)
    shown = np.asarray(mesh.get_array())[0]
    assert shown.size <= 400
    assert (shown[0], shown[-1]) == (points[0], points[-1])
    # each is in its place, and neighbours are a grid's step apart or neighbours before
    edges = mesh.get_coordinates()[0, :, 0]
    assert np.all((edges[:-1] < shown) & (shown < edges[1:]))
    assert np.max(np.diff(np.log(shown)) - np.log1p((points[1] - points[0]) / shown[:-1])) < 2 * np.log(80) / 399
