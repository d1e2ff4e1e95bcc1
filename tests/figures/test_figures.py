"""Figures: that they show what they are given, to size, named and with their origin; looks are judged by eye."""

from __future__ import annotations

import itertools
from pathlib import Path
from typing import Any

import matplotlib
import numpy as np
import pandas as pd
import pytest
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.collections import EllipseCollection
from matplotlib.figure import Figure
from matplotlib.text import Text
from overprint import overprints
from synthetic import step_ramp, synthetic, translation

from sph.figures import (
    RUN_FIGURES,
    STUDY_FIGURES,
    caption,
    figure_arrangement,
    figure_displaced,
    figure_geometry,
    figure_map,
    figure_mobilised,
    figure_motion,
    figure_profiles,
    figure_study,
    plot_trajectory,
    save,
)
from sph.figures.arrangement import failed_words, motion_name
from sph.figures.before_after import figure_before_after
from sph.figures.labels import NAME
from sph.figures.profile import field_norm, layer_colours
from sph.figures.scene import Drawn, figure_scenes
from sph.figures.study import BOUNDED
from sph.figures.style import LINE_STYLES, curve_colours, metres, note_text, write_note
from sph.measures.fields import FIELDS
from sph.measures.metrics import CLASSES, UNDETERMINED
from sph.output.run import Run
from sph.scene.schema import Scene, load_scene, make_scene
from sph.solver.particles import SOIL, locate_probes, place_particles
from sph.stability.slip_search import limit_equilibrium
from sph.storage.trajectory import Status
from sph.study.dimensions import Dimension

CONFIG = Path(__file__).resolve().parents[2] / "config"

BLOCK = {"geometry": {"shape": "block", "width": 10.0, "height": 5.0}}


def axes(figure: Figure, panel: int = 0) -> Any:
    """A panel, without the loose types of matplotlib's artists."""
    return figure.axes[panel]


def circles(figure: Figure, panel: int = 0) -> list[Any]:
    """The circles of a panel: box first, soil second."""
    return [item for item in axes(figure, panel).collections if isinstance(item, EllipseCollection)]


def texts(figure: Figure) -> str:
    """Every text in a figure."""
    return "\n".join(text.get_text() for text in figure.findobj(matplotlib.text.Text))


def test_every_figure_of_a_study_has_a_caption_that_holds_for_any_dimensions() -> None:
    for draw in (RUN_FIGURES | STUDY_FIGURES).values():
        told = caption(draw)
        assert len(told) > 60 and not any(word in told for word in ("\n", "ValueError", "S_R", "γ", "gamma"))


def test_particles_are_drawn_at_their_places() -> None:
    slid = synthetic(translation(-3.0, -1.0))
    figure = figure_profiles({"a": slid})
    box, soil = circles(figure)
    is_soil = slid["kind"] == SOIL
    np.testing.assert_allclose(soil.get_offsets(), np.column_stack([slid["x"][-1][is_soil], slid["y"][-1][is_soil]]))
    np.testing.assert_allclose(soil.get_array(), slid["y0"][is_soil])
    assert len(box.get_offsets()) == 354 and box.get_facecolor()[0].tolist() == [1, 1, 1, 1]


def test_profiles_of_a_study_of_ones_own_show_how_far_the_soil_has_moved() -> None:
    runs = {"slid": synthetic(translation(-3.0, -4.0)), "stands": synthetic()}
    slid, stands = (circles(figure_displaced(runs), panel)[1].get_array() for panel in (0, 1))
    moved = runs["slid"]["y0"][runs["slid"]["kind"] == SOIL] > 10.0
    np.testing.assert_allclose(slid, np.where(moved, 5.0, 0.0), atol=1e-5)
    np.testing.assert_allclose(stands, 0.0, atol=1e-12)


def test_particles_touch_and_leave_the_gaps_of_a_lattice_free(standing: Run) -> None:
    figure = figure_profiles({"a": standing})
    figure.set_dpi(400)
    canvas = FigureCanvasAgg(figure)
    canvas.draw()
    pixels = np.asarray(canvas.buffer_rgba())

    def colour(x: float, y: float) -> list[int]:
        column, row = axes(figure).transData.transform((x, y))
        return pixels[pixels.shape[0] - 1 - round(row), round(column), :3].tolist()

    white = [255, 255, 255]
    centre, corner = colour(60.5, 5.5), colour(61.0, 6.0)
    assert corner == white and centre != white
    assert all(colour(60.5 + dx, 5.5 + dy) == centre for dx, dy in ((0.4, 0.0), (-0.4, 0.0), (0.0, 0.4), (0.0, -0.4)))
    assert colour(60.5 + 0.42, 5.5 + 0.42) == white


def test_profiles_share_the_scale_and_are_lettered(slid: Run, standing: Run) -> None:
    figure = figure_profiles({"first": slid, "second": standing}, fidelity="draft")
    norms = [circles(figure, panel)[1].norm for panel in (0, 1)]
    assert (norms[0].vmin, norms[0].vmax) == (norms[1].vmin, norms[1].vmax) == (0.0, 34.5)
    assert axes(figure).get_xlim() == axes(figure, 1).get_xlim() and axes(figure).get_ylim() == axes(figure, 1).get_ylim()
    shown = texts(figure)
    assert "(a) first" in shown and "(b) second" in shown and "initial elevation (m)" in shown
    assert "fidelity draft · scene paper · spacing 1 m · kernel support 4.6 m · fixed side walls · failed solid elastic · 15 s" in shown


def test_the_initial_surface_is_drawn(slid: Run) -> None:
    line = axes(figure_profiles({"a": slid})).lines[0]
    np.testing.assert_allclose(line.get_xydata()[[0, 1]], [(0.0, 10.0), (55.0, 10.0)])
    assert line.get_ydata()[-1] == 35.0 and line.get_xdata()[-1] == 103.0


def test_arrangement_shows_the_first_frame(slid: Run) -> None:
    figure = figure_arrangement(slid)
    soil = circles(figure)[1]
    np.testing.assert_allclose(soil.get_offsets()[:, 0], slid["x0"][slid["kind"] == SOIL])
    assert "2050 soil particles, 354 particles of the box" in texts(figure) and "A" in texts(figure).split("\n")


def test_geometry_carries_dimensions_material_and_walls(slid: Run) -> None:
    shown = texts(figure_geometry(slid))
    for text in (
        "55.0 m",
        "14.4 m",
        "34.0 m",
        "H = 25 m",
        "10 m",
        "60°",
        "1964",
        "cohesion 150 kPa, friction angle 20°; once failed 37.5 kPa, 5°",
        "fixed side wall",
        "A (crest)",
    ):
        assert text in shown
    slip = synthetic(overrides={"walls": {"sides": "free_slip", "layers": 4}})
    assert "free-slip side wall" in texts(figure_geometry(slip))


def test_geometry_of_another_shape_is_refused() -> None:
    with pytest.raises(ValueError, match="geometry.shape: 'block'"):
        figure_geometry(synthetic(overrides=BLOCK))


def test_motion_is_the_stored_one_with_its_stages(slid: Run) -> None:
    figure = figure_motion(slid)
    line = axes(figure).lines[0]
    np.testing.assert_array_equal(line.get_ydata(), slid["ground_acceleration"])
    assert np.ptp(line.get_ydata()) > 11.0
    shown = texts(figure).split("\n")
    assert {"gravity", "shaking"} <= set(shown) and "in other runs" not in texts(figure)
    assert axes(figure).get_xlim() == (0.0, slid.scene.motion.end) and slid.scene.motion.end < slid.scene.duration
    assert axes(figure_motion(slid, others="× 2 and × 3")).get_title(loc="left").endswith("(0.612 g); in other runs × 2 and × 3")
    still = texts(figure_motion(synthetic(overrides={"motion": {"kind": "none"}}))).split("\n")
    assert "shaking" not in still and "gravity" in still


def test_a_synthetic_motion_is_no_record() -> None:
    assert motion_name(load_scene(CONFIG / "scenes" / "gentle_motions.yaml")) == "synthetic motion, seed 1"
    assert motion_name(load_scene(CONFIG / "scenes" / "gentle_layered.yaml")) == "record synthetic.csv"


def test_motion_downwards_points_downwards() -> None:
    # A constant load away from the toe is negative: the axis must not be turned upside down by it.
    load = {"kind": "constant", "amplitude": -2.0, "start": 3.0, "ramp": 1.0}
    low, high = figure_motion(synthetic(overrides={"motion": load})).axes[0].get_ylim()
    assert low < -2.0 and high > 0.0


def test_geometry_of_a_slope_with_periodic_sides() -> None:
    # 55 + 25 + 35 m are whole spacings.  No side wall is drawn, and none named.
    geometry = {"shape": "slope", "slope_angle": 45.0, "crest_length": 35.0}
    periodic = synthetic(overrides={"geometry": geometry, "walls": {"sides": "periodic"}})
    assert "side wall" not in texts(figure_geometry(periodic)).replace("periodic side walls", "")


def test_profiles_without_data_are_refused() -> None:
    with pytest.raises(ValueError, match="runs"):
        figure_profiles({})


@pytest.mark.parametrize("field", FIELDS)
def test_plot_of_a_trajectory_colours_by_each_field(slid: Run, field: str) -> None:
    slid["stress_yy"][:] = -3000.0
    figure = plot_trajectory(slid, 6.2, field)
    shown = circles(figure)[1].get_array()
    frame = 12  # the last one not later than 6.2 s
    is_soil = slid["kind"] == SOIL
    np.testing.assert_allclose(shown, FIELDS[field].of(slid, frame)[is_soil])
    expected = {"initial_height": 34.5, "displacement": 1.5, "speed": 0.75, "beta": 1.0, "pressure": 1.0}
    expected |= {"layer": 0.0, "failed": 0.0, "pore_pressure_ratio": 0.0}
    angle = np.radians(20.0)
    expected["mobilised"] = 1.5 / (150.0 * np.cos(angle) + 1.5 * np.sin(angle))
    assert float(np.max(np.asarray(shown))) == pytest.approx(expected[field])
    assert "t = 6 s" in texts(figure) and "complete" in texts(figure)


def test_plot_refuses_an_unknown_field_and_a_time_outside_the_run(slid: Run) -> None:
    with pytest.raises(ValueError, match="field: 'colour'.*initial_height"):
        plot_trajectory(slid, field="colour")
    for time in (-1.0, 15.1):
        with pytest.raises(ValueError, match=f"time: {time} s"):
            plot_trajectory(slid, time)


def test_a_diverged_run_can_be_plotted(tmp_path: Path, slid: Run) -> None:
    slid.attrs["status"] = "diverged"
    slid["y"][-1, 5], slid["x"][-1, 6], slid["velocity_x"][-1, 6] = np.nan, 1e9, np.inf
    figure = plot_trajectory(slid, field="speed")
    save(figure, tmp_path / "run.png")
    assert (tmp_path / "run.png").stat().st_size > 10_000 and axes(figure).get_xlim()[1] < 120


def test_other_shapes_and_open_boxes_can_be_plotted(tmp_path: Path) -> None:
    block = synthetic(translation(-3.0), overrides={**BLOCK, "walls": {"base": "none", "sides": "none"}})
    figure = figure_profiles({"block": block})
    save(figure, tmp_path / "block.png")
    assert axes(figure).get_xlim()[0] < -2.5


def test_a_constant_field_has_a_scale(standing: Run) -> None:
    norm = field_norm({"": standing}, "speed")
    assert (norm.vmin, norm.vmax) == (0.0, 1.0)


def test_displacement_leaves_out_the_gravity_stage() -> None:
    settled = synthetic(translation(0.0, -1.0), step_ramp(0.0, 6.0))
    horizontal, vertical = settled.displacement()
    top = settled["y0"] > 10.0
    top &= settled["kind"] == SOIL
    assert vertical[top] == pytest.approx(-0.5) and not horizontal.any()


def test_files_are_whole_and_the_same_each_time(tmp_path: Path, slid: Run) -> None:
    for folder in ("one", "two"):
        save(figure_motion(slid), tmp_path / folder / "fig2.png", tmp_path / folder / "fig2.pdf")
    for name in ("fig2.png", "fig2.pdf"):
        assert (tmp_path / "one" / name).read_bytes() == (tmp_path / "two" / name).read_bytes()
    assert sorted(path.name for path in (tmp_path / "one").iterdir()) == ["fig2.pdf", "fig2.png"]


def test_drawing_leaves_matplotlibs_settings_alone(slid: Run) -> None:
    before = dict(matplotlib.rcParams)
    figure_motion(slid)
    assert dict(matplotlib.rcParams) == before


def test_a_diverged_run_says_so_in_its_figures() -> None:
    runs = {"sound": synthetic(translation(-1.0)), "broken": synthetic(translation(-2.0), status="diverged")}
    end = f"broken, diverged at {float(runs['broken']['sample_time'][-1]):.3g} s"
    profiles = texts(figure_profiles(runs))
    assert end in profiles and profiles.count("diverged") == 1


@pytest.mark.parametrize("turned", [pytest.param(False, marks=pytest.mark.long), True])
def test_a_surveyed_slope_keeps_its_coordinates(turned: bool) -> None:
    line = [[120, 440], [175, 440], [190, 465], [224, 465]]
    ground = {"shape": "ground_line", "points": [[300 - x, y] for x, y in line] if turned else line, "base": 430}
    run = synthetic(overrides={"geometry": ground | ({"downhill": "right"} if turned else {})})
    for figure in (figure_geometry(run), figure_arrangement(run), plot_trajectory(run)):
        FigureCanvasAgg(figure).draw()
        ax = axes(figure)
        assert ax.get_ylabel() == "elevation (m)"
        for axis, origin, direction in ((ax.xaxis, 180 if turned else 120, -1 if turned else 1), (ax.yaxis, 430, 1)):
            ticks = {float(label.get_text()): place for label, place in zip(axis.get_ticklabels(), axis.get_ticklocs(), strict=True)}
            assert len(ticks) >= 3
            assert all(place == pytest.approx(direction * (value - origin)) for value, place in ticks.items())
    assert {"toe", "A (crest)", "H = 25 m"} <= set(texts(figure_geometry(run)).split("\n"))


COHESION = Dimension("layers.soft_clay.soil.cohesion", "kPa", "", False)
KERNEL = Dimension("numerics.kernel", "-", "", True)
AMPLITUDE = Dimension("amplitude", "m/s2", "", False)
VALUES = {COHESION: ("3", "10", "30"), AMPLITUDE: ("1.0", "2.0", "4.0", "6.0"), KERNEL: ("wendland_c2", "cubic_spline")}


def grid_of(*dimensions: Dimension) -> pd.DataFrame:
    """Runs over a grid; the first diverged, and the displacement counts the others."""
    rows = list(itertools.product(*(VALUES[found] for found in dimensions)))
    table = pd.DataFrame(rows, columns=[found.name for found in dimensions])
    moved = np.where(np.arange(len(rows)) == 0, np.nan, np.arange(len(rows)) / 10)
    classes = [UNDETERMINED, *(CLASSES[number % 4] for number in range(1, len(rows)))]
    same = {"status": "complete", "reached_side": "", "findings": "", "at_rest": 1, "diverged": 0}
    return table.assign(**same, collapse_class=classes, displacement_magnitude=moved, runout=0.5 * moved)


def test_a_grid_is_drawn_as_curves_with_names_that_are_read() -> None:
    """Against the shaking, a curve a value of the other dimension, whatever stands first; no dotted key."""
    table = grid_of(COHESION, AMPLITUDE)
    figure = figure_study(table, [COHESION, AMPLITUDE], note="study x")
    displacement, runout = figure.axes
    assert (displacement.get_ylabel(), runout.get_ylabel()) == ("displacement of A (m)", "run-out (m)")
    assert runout.get_xlabel() == "amplitude (m/s²)"
    curves = [line for line in displacement.lines if line.get_linestyle() != "None"]
    assert [curve.get_xdata().tolist() for curve in curves] == [[1.0, 2.0, 4.0, 6.0]] * 3
    np.testing.assert_array_equal(np.concatenate([curve.get_ydata() for curve in curves]), table["displacement_magnitude"])
    legend = figure.legends[0]
    assert legend.get_title().get_text() == "cohesion of soft clay (kPa)"
    assert [text.get_text() for text in legend.get_texts()] == ["3", "10", "30"]
    assert [text.get_text() for text in figure.legends[1].get_texts()] == [*CLASSES, "diverged"]
    assert not {"^", "v"} & {line.get_marker() for line in displacement.lines} and "layers." not in texts(figure)


def test_a_map_holds_every_run_in_a_cell_of_its_own() -> None:
    table = grid_of(AMPLITUDE, COHESION, KERNEL)
    figure = figure_map(table, [AMPLITUDE, COHESION, KERNEL], note="study x")
    cells = [cell for ax in figure.axes for cell in ax.patches]
    assert len(cells) == len(table) == len({(cell.axes, cell.get_xy()) for cell in cells})
    numbers = [text.get_text() for ax in figure.axes for text in ax.texts]
    assert sorted(numbers) == sorted(map(metres, table["displacement_magnitude"].dropna()))
    assert sum(line.get_marker() == "x" for ax in figure.axes for line in ax.lines) == 1
    two = figure_map(table[table["collapse_class"].isin(CLASSES[::3])], [AMPLITUDE, COHESION, KERNEL])
    assert [text.get_text() for text in two.legends[0].get_texts()] == ["stable", "collapse"], "only what is drawn"
    assert [ax.get_title(loc="left") for ax in figure.axes] == ["kernel wendland_c2", "kernel cubic_spline"]
    assert (figure.axes[0].get_xlabel(), figure.axes[0].get_ylabel()) == ("amplitude (m/s²)", "cohesion of soft clay (kPa)")


@pytest.mark.parametrize("bound", [{"reached_side": "front back"}, {"findings": "few-particles weak-on-strong"}, {"at_rest": 0}])
def test_values_of_debris_that_met_the_box_was_braked_or_still_moves_are_marked_as_lower_bounds(bound: dict[str, Any]) -> None:
    table = grid_of(AMPLITUDE, COHESION, KERNEL)
    met = table.assign(**bound)
    numbers = [text.get_text() for ax in figure_map(met, [AMPLITUDE, COHESION, KERNEL]).axes for text in ax.texts]
    assert numbers and all(number.startswith("≥ ") for number in numbers)
    for shown, marked in ((met, True), (table.assign(reached_side="back", findings="cover-rows"), False)):
        figure = figure_study(shown, [AMPLITUDE, COHESION, KERNEL])
        assert any(line.get_marker() == BOUNDED["marker"] for ax in figure.axes for line in ax.lines) == marked
        assert any("lower bound" in text.get_text() for legend in figure.legends for text in legend.get_texts()) == marked


@pytest.mark.parametrize("draw", [figure_study, figure_map])
@pytest.mark.parametrize(
    "dimensions",
    [
        (AMPLITUDE,),
        pytest.param((KERNEL,), marks=pytest.mark.long),
        pytest.param((COHESION, AMPLITUDE), marks=pytest.mark.long),
        (COHESION, AMPLITUDE, KERNEL),
    ],
)
def test_figures_of_all_runs_take_any_dimensions(tmp_path: Path, draw: Any, dimensions: tuple[Dimension, ...]) -> None:
    table = grid_of(*dimensions)
    for rows in (table, table.iloc[[0, 1, -1]].reset_index(drop=True), table.iloc[:1]):  # a grid, a list of cases, one run
        figure = draw(rows, dimensions, note="fidelity draft · study x")
        assert not overprints(figure)
        save(figure, tmp_path / "figure.png")
    with pytest.raises(ValueError, match="no run to draw"):
        draw(table.iloc[:0], dimensions)


def test_runs_that_fail_unshaken_are_marked() -> None:
    """Their class is not the earthquake's: hollow marks and hatched cells, and words in the legend."""
    table = grid_of(COHESION, AMPLITUDE).assign(status=["complete", Status.FAILED_UNSHAKEN] + ["complete"] * 10)
    curves, cells = figure_study(table, [COHESION, AMPLITUDE]), figure_map(table, [COHESION, AMPLITUDE])
    hollow = [line for line in curves.axes[0].lines if line.get_markerfacecolor() == "white"]
    assert sum(len(line.get_xdata()) for line in hollow) == 1
    assert sum(patch.get_hatch() is not None for patch in cells.axes[0].patches) == 1
    for figure in (curves, cells):
        assert "fails without shaking" in [text.get_text() for text in figure.legends[-1].get_texts()]


def test_a_list_is_drawn_against_each_dimension() -> None:
    """Words stand side by side, wide ranges on a logarithmic axis; a metric that no run has is left out."""
    cohesion = Dimension("soil.cohesion", "kPa", "", False)
    rows = [
        (1.0, "b", "complete", "stable", 0.05, 0.0),
        (10.0, "a", "complete", "collapse", 9.0, 8.0),
        (100.0, "b", "complete", UNDETERMINED, np.nan, np.nan),
    ]
    columns = ["soil.cohesion", "numerics.kernel", "status", "collapse_class", "displacement_magnitude", "runout"]
    table = pd.DataFrame(rows, columns=columns).astype({"soil.cohesion": str}).assign(reached_side="", findings="", at_rest=1, diverged=0)
    figure = figure_study(table, [cohesion, KERNEL])
    assert [ax.get_xscale() for ax in figure.axes] == ["log", "linear", "log", "linear"]
    assert [label.get_text() for label in figure.axes[3].get_xticklabels()] == ["b", "a"]
    assert figure.axes[2].get_xlabel() == "cohesion (kPa)"
    assert [text.get_text() for text in figure.legends[0].get_texts()] == ["stable", "collapse", "diverged"]
    for ax, values in zip(figure.axes, ([0.05, 9.0], [0.05, 9.0], [0.0, 8.0], [0.0, 8.0]), strict=True):
        assert [float(line.get_ydata()[0]) for line in ax.lines[:-1]] == values and len(ax.lines) == 3
    assert len(figure_study(table.assign(runout=np.nan), [cohesion]).axes) == 1, "no run has a run-out"


LINE = [[120, 440], [175, 440], [190, 465], [224, 465]]
LAYERED = {
    "geometry": {"shape": "ground_line", "points": LINE, "base": 430},
    "layers": {
        "fill": {"region": {"kind": "depth", "bottom": 4.0}, "soil": {"cohesion": 7.0}},
        "soft_clay": {"region": {"kind": "elevation", "bottom": 434.0, "top": 437.0}, "soil": {"cohesion": 18.0}, "S_R": 0.4},
        "lens": {"region": {"kind": "polygon", "points": [[195, 445], [210, 445], [210, 450]]}, "soil": {"friction_angle": 31.0}},
    },
}


def turned_round(scene: dict[str, Any]) -> dict[str, Any]:
    """The same slope, falling to the right."""
    ground = scene["geometry"] | {"points": [[300 - x, y] for x, y in LINE], "downhill": "right"}
    lens = scene["layers"]["lens"] | {"region": {"kind": "polygon", "points": [[105, 445], [90, 445], [90, 450]]}}
    return scene | {"geometry": ground, "layers": scene["layers"] | {"lens": lens}}


@pytest.mark.parametrize("scene", [LAYERED, turned_round(LAYERED)], ids=["left", "right"])
def test_the_section_shows_every_layer_where_its_particles_are(scene: dict[str, Any]) -> None:
    run = synthetic(overrides=scene)
    figure = figure_geometry(run)
    built = run.scene
    particles, colours = place_particles(built), layer_colours(built)
    soil = particles.kind == SOIL
    places = np.column_stack([particles.x[soil] + 1e-3, particles.y[soil] + 1e-6])  # on a boundary: right of it, or above
    painted = np.zeros(len(places), int)
    for patch in axes(figure).patches:
        if patch.get_visible() and patch.get_facecolor() in colours:
            painted[patch.get_path().contains_points(places)] = colours.index(patch.get_facecolor())
    assert (painted == particles.layer[soil]).mean() > 0.98, "all but particles that straddle a boundary"
    legend = [text.get_text() for text in figure.legends[0].get_texts()]
    assert [line.partition(":")[0] for line in legend] == [
        "soil", "fill", "soft clay", "lens", "critical surface, Bishop", "critical surface, Spencer"
    ]  # fmt: skip
    assert "cohesion 7 kPa" in legend[1] and "cohesion 18 kPa" in legend[2] and "friction angle 31°" in legend[3]
    assert "once failed 7.2 kPa" in legend[2], "0.4 of 18 kPa"


def drawn(scene: Scene) -> Drawn:
    """What the drawing of a scene shows."""
    particles = place_particles(scene)
    return Drawn(scene, particles, locate_probes(scene, particles))


SECTIONS = pytest.mark.parametrize(
    "scene",
    [
        pytest.param(LAYERED, id="left"),
        pytest.param(turned_round(LAYERED), id="right", marks=pytest.mark.long),
        pytest.param({}, id="paper", marks=pytest.mark.long),
    ],
)


@SECTIONS
def test_nothing_lies_over_anything_else(scene: dict[str, Any]) -> None:
    run = synthetic(translation(-3.0), overrides=scene)
    figures = {
        "geometry": figure_geometry(run, "draft"),
        "motion": figure_motion(run, "draft"),
        "arrangement": figure_arrangement(run, "draft"),
        "mobilised": figure_mobilised(run, "draft"),
        "profiles": figure_profiles({"amplitude 4.0 m/s², cohesion of soft clay 30 kPa": run, "two": run}, "draft"),
        "run": plot_trajectory(run),
        "scene": figure_scenes([drawn(run.scene)]),
    }
    assert {name: found for name, figure in figures.items() if (found := overprints(figure))} == {}
    for name, figure in figures.items():
        sections = [ax for ax in figure.axes if ax.get_ylabel() in ("elevation (m)", "height (m)")]
        assert sections or name == "motion"
        assert all(ax.get_aspect() == 1.0 for ax in sections), name


def test_names_have_room_in_a_flat_section() -> None:
    line = {"shape": "ground_line", "points": [[0, 0], [230, 0], [300, 20], [520, 22]], "base": -5}
    run = synthetic(overrides={"title": "A long and flat hillside whose title meets its crest, where A is", "geometry": line})
    assert overprints(figure_scenes([drawn(run.scene)])) == [] == overprints(figure_geometry(run))


PLACES = {"road": "12 beyond the toe", "house_of_the_guard": "20 m beyond the toe"}


@SECTIONS
def test_places_stand_before_the_toe_with_their_names(scene: dict[str, Any]) -> None:
    run = synthetic(translation(-3.0), overrides=scene)
    toe, base = run.scene.geometry.toe
    figures = {
        "profiles": figure_displaced({"one": run, "two": run}, places=PLACES, choice="2 of 6 runs: " + "those that move far, " * 8),
        "scene": figure_scenes([drawn(run.scene)._replace(places=PLACES)]),
        "section": figure_geometry(run, places=PLACES),
        "run": plot_trajectory(run, places=PLACES),
        "before and after": figure_before_after(run, "one", PLACES),
    }
    for name, figure in figures.items():
        posts = {text.get_text(): text.xy for text in axes(figure).texts if text.get_rotation() == 90 and hasattr(text, "xy")}
        assert posts["road"][0] == pytest.approx(toe - 12.0) and posts["house of the guard"][0] == pytest.approx(toe - 20.0), name
        assert overprints(figure) == [], name
    assert posts["road"][1] <= base + 1e-9 or scene, "on the ground"


CLOSE = {"way": "2 beyond the toe", "road": "5 beyond the toe", "house": "40 beyond the toe"}


@SECTIONS
def test_names_of_places_side_by_side_keep_apart(scene: dict[str, Any]) -> None:
    """Probes behind the crest edge and at it, the toe and a place before it: no name over another one or over the ring of another."""
    run = synthetic(translation(0.0), overrides=scene)
    geometry = run.scene.geometry
    crest_x, crest_y = geometry.crest
    probes = {"A": "crest_edge", "B": "crest_edge", "track": geometry.in_survey(crest_x + 3.0, crest_y - 0.5)}
    run = synthetic(translation(0.0), overrides={**scene, "probes": probes})
    figures = {
        "section": figure_geometry(run, places=CLOSE),
        "scene": figure_scenes([drawn(run.scene)._replace(places=CLOSE)]),
        "particles": figure_arrangement(run),
        "before and after": figure_before_after(run, "one", CLOSE),
    }
    for name, figure in figures.items():
        figure.draw_without_rendering()
        section = axes(figure)
        names = {text.get_text(): text for text in section.texts if text.get_gid() == NAME}
        boxes = {word: Text.get_window_extent(text) for word, text in names.items()}
        assert {"A, B (crest)", "track", "toe", *CLOSE} <= {*names} or {"A, B", "track"} <= {*names}, name
        assert not [pair for pair in itertools.combinations(boxes, 2) if boxes[pair[0]].overlaps(boxes[pair[1]])], name
        rings = {word: section.transData.transform(text.xy) for word, text in names.items()}
        assert not [
            (word, ring) for word, ring in itertools.product(boxes, rings) if word != ring and boxes[word].contains(*rings[ring])
        ], name


def test_titles_and_legends_name_what_each_layer_keeps() -> None:
    overrides = {
        "coupling": {"S_R": 0.4},
        "layers": {"clay": {"region": {"kind": "depth", "top": 5.0}, "soil": {"residual_cohesion": 60.0}}},
    }
    overrides["layers"]["clay"]["soil"]["residual_friction_angle"] = 5.0
    overrides["soil"] = {"name": "weathered tuff", "youngs_modulus": 84.0336e3, "viscosity": 0.0}
    run = synthetic(translation(-3.0), overrides=overrides)
    own, clay, *surfaces = (text.get_text() for text in figure_geometry(run).legends[0].get_texts())
    surfaces = [words.partition(": F")[0].partition(", 0.")[0] for words in surfaces]
    assert surfaces == ["critical surface, Bishop", "critical surface, Spencer", "that of the yield acceleration"]
    assert own.startswith("weathered tuff: ") and "Young's modulus 84 MPa" in own and own.endswith("once failed 60 kPa, 8°")
    assert clay.endswith("once failed 60 kPa, 5°")
    bar = figure_displaced({"one": run}, field="layer").axes[-1]
    assert [label.get_text() for label in bar.get_yticklabels()] == ["weathered tuff", "clay"]
    assert "$S_R$ = 0.4; $c_r$ = 60 kPa, $φ_r$ = 5° in clay, γ = 100 s⁻¹" in axes(plot_trajectory(run)).get_title(loc="left")
    assert "$S_R$ = 0.25, γ = 100 s⁻¹" in axes(plot_trajectory(synthetic(translation(-3.0)))).get_title(loc="left")


def test_a_long_note_takes_more_lines_and_stays_in_the_figure() -> None:
    """Runs with either solid state of failed soil, of a long name: a line each, broken where the figure is narrower."""
    runs = {
        law: synthetic(translation(-3.0), overrides={"name": "a_slope_with_a_long_name", "coupling": {"solid_after_failure": law}})
        for law in ("elastic", "elastic_plastic")
    }
    figures = [
        figure_profiles(runs, "standard"),
        figure_motion(runs["elastic"], "standard"),
        Figure(figsize=(2.5, 2.5), layout="constrained"),
    ]
    figures[2].subplots().set_xlabel("time (s)")
    write_note(figures[2], note_text(runs["elastic"].scene))
    for figure in figures:
        canvas = FigureCanvasAgg(figure)
        canvas.draw()
        (note,) = (text for text in figure.texts if "failed solid" in text.get_text())
        box = note.get_window_extent(canvas.get_renderer())
        assert box.x0 >= 0.0 and box.x1 <= figure.bbox.x1 and box.y0 >= 0.0 and overprints(figure) == []
    assert any(text.get_text().count("\n") == 1 for text in figures[0].texts)


def test_a_slope_that_falls_to_the_right_is_drawn_so() -> None:
    figure = figure_profiles({"": synthetic(translation(-3.0), overrides=turned_round(LAYERED))})
    circle, bar = circles(figure)[1], figure.axes[-1]
    assert axes(figure).xaxis_inverted() and bar.get_ylabel() == "initial elevation (m)"
    assert circle.norm.vmin == 430.0 and circle.get_array().max() == pytest.approx(464.5)


def test_a_seam_is_drawn_where_it_is_in_the_soil_with_its_name() -> None:
    seam = {"points": [[0.0, 2.0], [10.0, 7.0]], "cohesion": 5.0, "friction_angle": 10.0}
    scene = make_scene({"scheme": "paper", "name": "block", "numerics": {"spacing": 0.5}, "seams": {"weak_clay": seam}} | BLOCK)
    figure = figure_scenes([Drawn(scene, place_particles(scene), {})])
    (line,) = [line for line in axes(figure).lines if line.get_linewidth() == 1.2]
    shown = np.isfinite(line.get_xdata())
    np.testing.assert_allclose(line.get_ydata()[shown], 2.0 + 0.5 * line.get_xdata()[shown])
    assert line.get_xdata()[shown].max() == pytest.approx(6.0, abs=0.1), "the ground lies at 5 m"
    assert "weak clay" in {text.get_text() for text in axes(figure).texts}


def test_soil_that_has_failed_but_hardly_moved_is_drawn_apart() -> None:
    """Rock that reaches its strength in the shaking is no slide."""
    slid = synthetic(translation(-3.0))
    everywhere = synthetic(translation(-3.0), failed=np.ones_like(slid["failed"]))
    first, second = circles(figure_before_after(everywhere, "one"))[:2]
    moved = np.hypot(*slid.displacement())[slid.soil] > 0.5
    assert [first.get_offsets().shape[0], second.get_offsets().shape[0]] == [moved.sum(), (~moved).sum()]
    words = [text.get_text() for text in figure_before_after(everywhere, "one").legends[0].get_texts()]
    assert "SPH: failed, and moved by more than 0.5 m" in words and "SPH (dots): reached its strength, moved less" in words
    area = float(f"{moved.sum() * slid.scene.numerics.spacing**2:.2g}")
    assert failed_words(everywhere) == (
        f"Has failed and moved by more than 0.5 m: {area:g} m² of the soil. "
        f"Has reached its strength for an instant at least, but moved by less: {100.0 * (~moved).mean():.0f} % of the soil."
    )
    assert failed_words(slid) == "", "nothing has failed"


def test_curves_survive_print() -> None:
    """In grey, too: every one stands out from the paper, and each is paler than the one before."""
    colours = np.array([colour[:3] for colour in curve_colours(len(LINE_STYLES))])
    linear = np.where(colours <= 0.03928, colours / 12.92, ((colours + 0.055) / 1.055) ** 2.4)  # WCAG 2.1, relative luminance
    luminance = linear @ (0.2126, 0.7152, 0.0722)
    assert (1.05 / (luminance + 0.05) >= 3.0).all() and (np.diff(luminance) > 0.01).all()


def test_the_soil_that_fails_is_shown_where_it_lay() -> None:
    run = synthetic(translation(-3.0))
    assert not any("SPH" in text.get_text() for text in figure_before_after(run, "one").legends[0].get_texts()), "nothing failed"
    run["failed"][-1, :40] = 1
    figure = figure_before_after(run, "one", equilibrium=limit_equilibrium(run.scene))
    shown = circles(figure)[0].get_offsets()
    np.testing.assert_allclose(shown, np.column_stack([run[axis][run.gravity_frame, :40] for axis in "xy"]))
    named = [text.get_text().partition(":")[0] for text in figure.legends[0].get_texts()]
    assert named[1:] == ["SPH (dots)", "critical surface, Bishop", "critical surface, Spencer", "that of the yield acceleration, 0.56 g"]
