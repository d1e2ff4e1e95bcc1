"""Designs and indices of the sensitivity analysis: known functions, extension, refusals."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest
import yaml
from SALib.analyze import morris as salib_morris
from scipy.stats import qmc
from small_scenes import SLOPE
from synthetic import synthetic, translation

from sph.experiments.registry import load_study
from sph.experiments.sensitivity.design import BASE, SensitivityPlan, load_sensitivity
from sph.experiments.sensitivity.elementary_effects import MORRIS, elementary_effects, influential, morris_table
from sph.experiments.sensitivity.factors import Axis, Quantity
from sph.experiments.sensitivity.figures import figure_cross_validation, figure_morris, figure_sobol, figure_tornado
from sph.experiments.sensitivity.schema import SAMPLE, SobolSettings
from sph.experiments.sensitivity.surrogate import CROSS_VALIDATION, SOBOL, TRUSTED, sobol_tables
from sph.experiments.sensitivity.tables import (
    CONFIRMED,
    TORNADO,
    confirmation_table,
    described,
    read_sample,
    sample_columns,
    sample_row,
    tornado_table,
)
from sph.measures.metrics import MetricSettings
from sph.scene.configuration import merge, read_yaml
from sph.scene.schema import make_scene
from sph.solver.particles import locate_probes, place_particles
from sph.study.runs import PlannedRun
from sph.study.tables import write_csv

ROOT = Path(__file__).resolve().parents[2]
CONFIG = read_yaml(ROOT / "config" / "config.yaml") | {"fidelity": "draft"}
SHIPPED = read_yaml(ROOT / "config" / "sensitivity.yaml")


def planned(folder: Path, changes: dict[str, Any] | None = None, check: bool = False, **study: Any) -> SensitivityPlan:
    """The shipped configuration with changes."""
    (folder / "sensitivity.yaml").write_text(yaml.safe_dump(merge(SHIPPED, changes or {}), sort_keys=False))
    return load_sensitivity("sensitivity.yaml", load_study(CONFIG | study, [ROOT]), [folder], check)


def run_of(plan: SensitivityPlan, design: str, name: str, chosen: Sequence[str] = ()) -> PlannedRun:
    return next(run for run in plan.rows(design, chosen) if run.id == f"{design}/{name}")


# ---------------------------------------------------------------- designs


def test_the_shipped_ranges_hold_valid_scenes_with_the_probe_at_the_crest(tmp_path: Path) -> None:
    plan = planned(tmp_path)
    assert len(plan.axes) == 11 and plan.fidelities == ("draft", "standard")
    for end in ("low", "high"):
        for name in ("height", "slope_angle"):
            scene = make_scene(run_of(plan, "tornado", f"{name}/{end}").scene)
            particles = place_particles(scene)
            probe = locate_probes(scene, particles)["A"]
            crest = np.array(scene.geometry.crest)
            assert np.hypot(*(np.array([particles.x[probe], particles.y[probe]]) - crest)) < scene.numerics.spacing
    # The box grows with the slope.
    tall = make_scene(run_of(plan, "tornado", "height/high").scene).geometry
    assert (tall.slope_height, tall.apron_length, tall.crest_length) == pytest.approx((30.0, 66.0, 40.8))


def test_factors_take_their_base_value_and_unit_from_the_scene(tmp_path: Path) -> None:
    axes = {axis.name: axis for axis in planned(tmp_path).axes}
    assert (axes["cohesion"].base, axes["cohesion"].unit) == (150.0, "kPa")
    assert (axes["height"].base, axes["height"].unit) == (25.0, "m") and axes["gamma"].log
    assert axes["viscosity"].value(0.5) == pytest.approx(np.sqrt(0.2 * 2e4))
    assert axes["viscosity"].share(np.array([0.2, 2e4])).tolist() == [0.0, 1.0]


def test_bounds_take_units_as_the_keys_of_a_scene_do(tmp_path: Path) -> None:
    axes = {axis.name: axis for axis in planned(tmp_path, {"factors": {"amplitude": {"bounds": ["0.2g", "800 gal"]}}}).axes}
    assert (axes["amplitude"].low, axes["amplitude"].high) == pytest.approx((1.962, 8.0))
    with pytest.raises(ValueError, match="factors.cohesion.*'0.2g'.*soil.cohesion"):
        planned(tmp_path, {"factors": {"cohesion": {"bounds": ["0.2g", 200.0]}}})


def test_more_trajectories_and_samples_keep_the_first_ones(tmp_path: Path) -> None:
    few = planned(tmp_path, {"morris": {"trajectories": 3}, "sobol": {"samples": 10}})
    more = planned(tmp_path, {"morris": {"trajectories": 5}, "sobol": {"samples": 70}})
    chosen = ["S_R", "height"]
    for design, count in (("morris", 36), ("tornado", 23), ("sobol", 10)):
        short, long = few.design(design, chosen), more.design(design, chosen)
        assert len(short) == count and list(long.items())[:count] == list(short.items())
    other = planned(tmp_path, {"seed": 2, "morris": {"trajectories": 3}, "sobol": {"samples": 10}})
    assert all(other.design(design, chosen) != few.design(design, chosen) for design in ("morris", "sobol"))


def test_sobol_moves_the_chosen_factors_alone_and_confirms_the_first_points(tmp_path: Path) -> None:
    plan = planned(tmp_path)
    points = np.array(list(plan.design("sobol", ["S_R", "height"]).values()))
    moved = [axis.name for axis, values in zip(plan.axes, points.T, strict=True) if np.ptp(values) > 0]
    assert moved == ["S_R", "height"]
    confirm = plan.design("confirm", ["S_R", "height"])
    assert list(confirm.items()) == list(plan.design("sobol", ["S_R", "height"]).items())[:6]
    for design, ratio in (("confirm", 2.3), ("sobol", 1.3)):
        assert make_scene(run_of(plan, design, "0000", ["S_R", "height"]).scene).numerics.smoothing_ratio == ratio
    assert planned(tmp_path, fidelity="standard").confirmed == 0, "the study's own fidelity confirms nothing"


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"factors": {"S_R": {"bounds": [0.5, 0.1]}}}, ["factors.S_R", "bounds", "increase"]),
        ({"factors": {"gamma": {"bounds": [0.0, 100.0]}}}, ["factors.gamma", "positive"]),
        ({"factors": {"S_R": {"bounds": [0.3, 0.5]}}}, ["factors.S_R", "0.25"]),
        ({"factors": {"cohesion": {"keys": {"soil.cohesin": 1}}}}, ["factors.cohesion", "soil.cohesin"]),
        ({"factors": {"status": {"keys": {"soil.density": 1}, "bounds": [1900, 2000]}}}, ["factors", "status", "column"]),
        ({"factors": {"height": {"keys": {"geometry.apron_length": 2.0}}}}, ["factors.height", "25, 55, 34", "proportion"]),
        ({"factors": {"gamma": {"keys": {"coupling.S_R": 1}}}}, ["factors", "two", "coupling.S_R"]),
        ({"metrics": {"run_out": {}}}, ["metrics", "run_out", "runout"]),
        ({"sobol": {"factors": ["S_R", "depth"]}}, ["sobol.factors", "depth"]),
        ({"sobol": {"points": 1000}}, ["sobol", "1000", "power of 2"]),
        ({"confirm": {"fidelity": "best"}}, ["confirm.fidelity", "best", "paper"]),
        ({"confirm": {"points": 500}}, ["confirm.points", "500"]),
        ({"morris": {"levels": 5}}, ["morris.levels"]),
    ],
)
def test_refusals_name_file_key_and_value(tmp_path: Path, changes: dict[str, Any], words: list[str]) -> None:
    with pytest.raises(ValueError) as raised:
        planned(tmp_path, changes)
    assert all(word in str(raised.value) for word in ["sensitivity.yaml", *words])


def test_ranges_with_a_scene_that_is_refused_are_refused_before_any_run(tmp_path: Path) -> None:
    two = {"factors": {name: SHIPPED["factors"][name] for name in ("S_R", "slope_angle")}, "sobol": {"samples": 16}}
    (tmp_path / "sensitivity.yaml").write_text(yaml.safe_dump(SHIPPED | two))
    load_sensitivity("sensitivity.yaml", load_study(CONFIG, [ROOT]), [tmp_path])
    steep = merge(two, {"factors": {"slope_angle": {"bounds": [50.0, 95.0]}}})
    (tmp_path / "sensitivity.yaml").write_text(yaml.safe_dump(SHIPPED | steep))
    with pytest.raises(ValueError, match="sensitivity.yaml: at .*slope_angle: .*90"):
        load_sensitivity("sensitivity.yaml", load_study(CONFIG, [ROOT]), [tmp_path])


def test_a_range_is_refused_for_a_point_inside_it(tmp_path: Path) -> None:
    """Both ends are whole multiples of the interval of the series, what lies between is not."""
    factors = {"S_R": SHIPPED["factors"]["S_R"], "duration": {"keys": {"duration": 1}, "bounds": [14.0, 16.0]}}
    (tmp_path / "sensitivity.yaml").write_text(yaml.safe_dump(SHIPPED | {"factors": factors}))
    with pytest.raises(ValueError, match="sensitivity.yaml: at .*duration: .*whole multiple"):
        load_sensitivity("sensitivity.yaml", load_study(CONFIG, [ROOT]), [tmp_path])


def test_a_probe_that_stays_where_it_is_does_not_go_with_a_slope_that_grows(tmp_path: Path) -> None:
    with pytest.raises(ValueError, match=r"factors\.height: .*probes\.A.*crest_edge"):
        planned(tmp_path, {"overrides": {"probes": {"A": [69.0, 34.0]}}})


# ---------------------------------------------------------------- whatever a scene has

LAYERED = merge(
    SLOPE,
    {
        "layers": {"clay": {"region": {"kind": "depth", "bottom": 10.0}, "soil": {"cohesion": 20.0}, "S_R": 0.2}},
        "water": {"pressure": "by_place", "level": 12.0},
        "motion": {"kind": "record", "file": "a.csv", "start": 1.0},
    },
)
RECORDS = {"levels": {"motion.file": ["a.csv", "b.csv", "c.csv"]}}
FACTORS: dict[str, Any] = {
    "c": {"keys": {"layers.clay.soil.cohesion": 1}, "bounds": [10.0, 30.0]},
    "thickness": {"keys": {"layers.clay.region.bottom": 1}, "bounds": [5.0, 15.0]},
    "water": {"keys": {"water.level": 1}, "bounds": [8.0, 16.0]},
    "spacing": {"keys": {"numerics.spacing": 1}, "bounds": [5.0, 6.0]},
    "record": RECORDS,
}


@pytest.fixture
def layered(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Callable[..., SensitivityPlan]:
    """Plans of a wet, layered slope under records, with factors of one's own."""
    monkeypatch.chdir(tmp_path)
    time = np.arange(0.0, 1.5, 0.01)
    for number, name in enumerate("abc", 1):
        table = np.column_stack([time, 2.0 * np.sin(2.0 * np.pi * number * time)])
        np.savetxt(f"{name}.csv", table, delimiter=",", header="time (s),acceleration (m/s2)", comments="")
    (tmp_path / "layered.yaml").write_text(yaml.safe_dump(LAYERED, sort_keys=False))

    def plan(factors: dict[str, Any], check: bool = False, **more: Any) -> SensitivityPlan:
        settings = {"factors": factors, "metrics": {"runout": {}}, "sobol": {"samples": 8}, "morris": {"trajectories": 2}} | more
        (tmp_path / "sensitivity.yaml").write_text(yaml.safe_dump(settings, sort_keys=False))
        study = {"study": "layered", "scene": "layered.yaml", "grid": {"S_R": ["0.1"]}, "experiments": {"sensitivity": "sensitivity.yaml"}}
        return load_sensitivity("sensitivity.yaml", load_study(study), [tmp_path], check)

    return plan


def test_layers_water_spacing_and_records_are_factors(layered: Callable[..., SensitivityPlan]) -> None:
    plan = layered(FACTORS, check=True)
    axes = {axis.name: axis for axis in plan.axes}
    assert [(axis.base, axis.unit, axis.label) for axis in plan.axes] == [
        (20.0, "kPa", "cohesion of clay"),
        (10.0, "m", "bottom of clay"),
        (12.0, "m", "level of the water"),
        (5.0, "m", "spacing"),
        (1.0, "-", "record"),
    ]
    moved = {
        name: make_scene(run_of(plan, "tornado", name).scene)
        for name in ("c/high", "thickness/low", "water/low", "spacing/high", "record/3")
    }
    assert moved["c/high"].layers["clay"].soil.cohesion == 30.0 and moved["c/high"].soil.cohesion != 30.0
    assert moved["thickness/low"].layers["clay"].region.bottom == 5.0 and moved["water/low"].water.level == 8.0  # type: ignore[union-attr]
    assert moved["spacing/high"].numerics.spacing == 6.0 and moved["record/3"].motion.file == "c.csv"  # type: ignore[union-attr]
    assert list(axes["record"].moved) == ["2", "3"] and "2: b.csv" in axes["record"].meaning
    levels = np.array(list(plan.design("sobol", ["record"]).values()))[:, 4]
    assert set(levels) == {1.0, 2.0, 3.0} and axes["record"].snapped(np.array([0.1, 0.5, 0.9])).tolist() == pytest.approx(
        [1 / 6, 0.5, 5 / 6]
    )


@pytest.mark.parametrize(
    ("factors", "words"),
    [
        ({"c": {"keys": {"layers.cley.soil.cohesion": 1}, "bounds": [1, 2]}}, ["factors.c: keys: layers.cley", "cley", "clay"]),
        ({"c": {"keys": {"layers.clay.gamma": 1}, "bounds": [1, 2]}}, ["layers.clay.gamma", "null", "must be a number"]),
        ({"c": {"keys": {"layers.clay.region.height": 1}, "bounds": [1, 2]}}, ["layers.clay.region.height", "no such key"]),
        ({"c": {"keys": {"motion.frequency": 1}, "bounds": [1, 2]}}, ["motion of the scene has no frequency", "file"]),
        ({"c": {"keys": {"water.level": 1}}}, ["factors.c", "keys with their bounds, or levels alone"]),
        ({"c": RECORDS | {"scale": "log"}}, ["factors.c", "scale: log"]),
        ({"c": {"levels": {"motion.file": ["b.csv", "c.csv"]}}}, ["factors.c: levels: b.csv, c.csv", "motion.file: a.csv"]),
        ({"c": {"levels": {"motion.fil": ["b.csv", "c.csv"]}}}, ["levels.motion.fil", "motion.file"]),
    ],
)
def test_a_factor_that_the_scene_lacks_is_refused_when_the_study_is_read(
    layered: Callable[..., SensitivityPlan], factors: dict[str, Any], words: list[str]
) -> None:
    with pytest.raises(ValueError) as raised:
        layered(factors)
    assert all(word in str(raised.value) for word in ["sensitivity.yaml", *words])
    assert "load_study" in [frame.name for frame in raised.traceback], "before the sensitivity is asked for"


def test_values_between_levels_are_not_sought(layered: Callable[..., SensitivityPlan]) -> None:
    observed = {"observed": {"runout": {"value": 3.0, "error": 1.0}}}
    with pytest.raises(ValueError, match=r"back_analysis.over: 'record' has levels"):
        layered(FACTORS, back_analysis=observed)
    assert layered(FACTORS, back_analysis=observed | {"over": ["c"]}).sought == ("c",)


def test_levels_have_effects_between_them_and_shares_of_the_variance() -> None:
    """The run-out is 3 x of a number between 0 and 1, plus 0, 5 and 2 at three levels."""
    axes, at = [unit_axes(1)[0], Axis("x1", "record", "-", 1.0, 3.0, False, 1.0, ("a.csv", "b.csv", "c.csv"))], np.array([0.0, 5.0, 2.0])

    def made(points: np.ndarray) -> pd.DataFrame:
        return sample_of(points, 3.0 * points[:, 0] + at[points[:, 1].astype(int) - 1])

    row = morris_table(
        made(np.array([[0.0, 1.0], [0.0, 3.0], [2 / 3, 3.0], [1.0, 2.0], [1 / 3, 2.0], [1 / 3, 3.0]])), axes, [METRIC], 100, 1
    )
    assert row["mu_star"].tolist() == pytest.approx([3.0, 0.5 * (2.0 + 3.0)]), "steps 1 to 3, and 2 to 3"
    table = tornado_table(made(np.array([[0.5, 1.0], [0.0, 1.0], [1.0, 1.0], [0.5, 2.0], [0.5, 3.0]])), axes, [METRIC]).set_index("factor")
    assert table.loc["x1", ["low", "high", "at_base", "at_low", "at_high", "swing"]].tolist() == [1.0, 2.0, 1.5, 1.5, 6.5, 5.0]
    assert table.loc["x1", "factor_units"] == "level"
    texts = [text.get_text() for text in figure_tornado(table.reset_index(), axes, "").axes[0].texts]
    assert {"a", "b"} <= set(texts)
    shares = space_filling(2, 64)
    points = np.column_stack([shares[:, 0], [axes[1].value(share) for share in shares[:, 1]]])
    indices, _ = sobol_tables(made(points), axes, [METRIC], SobolSettings(folds=2, draws=50, points=256), 1)
    parts = np.array([9.0 / 12.0, np.var(at)])
    np.testing.assert_allclose(indices["first"], parts / parts.sum(), atol=0.03)


# ---------------------------------------------------------------- elementary effects

METRIC = Quantity("runout", None)


def unit_axes(count: int) -> list[Axis]:
    return [Axis(f"x{i}", f"$x_{i}$", "-", 0.0, 1.0, False, 0.5) for i in range(count)]


def sample_of(shares: np.ndarray, values: np.ndarray) -> pd.DataFrame:
    """A sample as measured, with the values as run-out; NaN for diverged runs."""
    fixed = {"reason": "", "collapse_class": "minor", "still_moving": 0, "wall_time": 1.0}
    frame = pd.DataFrame(shares, columns=[f"x{i}" for i in range(shares.shape[1])])
    frame["runout"], frame["run"] = values, [f"sobol/{i:04d}" for i in range(len(values))]
    frame["status"] = np.where(np.isnan(values), "diverged", "complete")
    return frame.assign(**fixed)[[column.name for column in sample_columns(unit_axes(shares.shape[1]), [METRIC])]]


def trajectories(tmp_path: Path, count: int) -> np.ndarray:
    """Shares (count, 12, 11) of the shipped ranges."""
    plan = planned(tmp_path, {"morris": {"trajectories": count}})
    points = np.array(list(plan.design("morris").values()))
    return np.column_stack([axis.share(column) for axis, column in zip(plan.axes, points.T, strict=True)]).reshape(count, 12, 11)


def test_a_linear_function_has_its_slopes_for_effects_and_no_sigma(tmp_path: Path) -> None:
    shares, slopes = trajectories(tmp_path, 6), np.linspace(-3.0, 7.0, 11)
    effects = elementary_effects(shares, shares @ slopes)
    np.testing.assert_allclose(effects, np.tile(slopes, (6, 1)), rtol=1e-9, atol=1e-9)
    table = morris_table(sample_of(shares.reshape(-1, 11), (shares @ slopes).ravel()), unit_axes(11), [METRIC], 200, 1)
    assert list(table.columns) == [column.name for column in MORRIS]
    np.testing.assert_allclose(table["mu"], slopes, atol=1e-9)
    np.testing.assert_allclose(table[["mu_star_low", "mu_star_high"]].to_numpy(), np.abs(np.tile(slopes, (2, 1))).T, atol=1e-9)
    assert table["sigma"].max() < 1e-9 and table["share"].max() == 1.0
    assert influential(table, 0.5) == [f"x{i}" for i in range(11) if abs(slopes[i]) >= 3.5]


@pytest.mark.crosscheck
def test_statistics_are_those_of_salib(tmp_path: Path) -> None:
    shares = trajectories(tmp_path, 8)
    values = np.sin(3 * shares[..., 0]) * shares[..., 1] + shares[..., 2] ** 2
    problem = {"num_vars": 11, "names": [f"x{i}" for i in range(11)], "bounds": [[0, 1]] * 11}
    expected = salib_morris.analyze(problem, shares.reshape(-1, 11), values.ravel(), num_levels=4)
    table = morris_table(sample_of(shares.reshape(-1, 11), values.ravel()), unit_axes(11), [METRIC], 200, 1)
    for name in ("mu", "mu_star", "sigma"):
        np.testing.assert_allclose(table[name], expected[name], rtol=1e-9, atol=1e-12)
    inside = (table["mu_star_low"] <= table["mu_star"]) & (table["mu_star"] <= table["mu_star_high"])
    assert inside.all() and (table["mu_star_low"] < table["mu_star_high"])[:3].all()


def test_steps_that_touch_a_diverged_run_are_dropped_and_counted(tmp_path: Path) -> None:
    shares, slopes = trajectories(tmp_path, 4), np.arange(1.0, 12.0)
    values = shares @ slopes
    values[1, 5], values[2, 0] = np.nan, np.nan  # in the middle: two steps; at the start: one
    table = morris_table(sample_of(shares.reshape(-1, 11), values.ravel()), unit_axes(11), [METRIC], 200, 1)
    lost = np.zeros(11, int)
    for trajectory, step in ((1, 4), (1, 5), (2, 0)):
        lost[np.flatnonzero(shares[trajectory, step + 1] != shares[trajectory, step])] += 1
    assert table["dropped"].tolist() == lost.tolist() and (table["effects"] + table["dropped"] == 4).all()
    assert (table["diverged"] == 2).all() and (table["runs"] == 48).all()
    np.testing.assert_allclose(table["mu"], slopes, rtol=1e-9)


# ---------------------------------------------------------------- indices

ISHIGAMI = np.array([[0.3139, 0.4424, 0.0], [0.5576, 0.4424, 0.2437]])
"""First-order and total indices of Ishigami's function with a = 7, b = 0.1 (Ishigami and Homma 1990)."""
A = np.array([0.0, 1.0, 4.5, 9.0])


def ishigami(shares: np.ndarray) -> np.ndarray:
    x = np.pi * (2.0 * shares - 1.0)
    return np.sin(x[:, 0]) + 7.0 * np.sin(x[:, 1]) ** 2 + 0.1 * x[:, 2] ** 4 * np.sin(x[:, 0])


def g_function(shares: np.ndarray) -> np.ndarray:
    """Sobol's g-function."""
    return np.prod((np.abs(4.0 * shares - 2.0) + A) / (1.0 + A), axis=1)


def g_indices() -> tuple[np.ndarray, np.ndarray]:
    parts = 1.0 / 3.0 / (1.0 + A) ** 2
    whole = np.prod(1.0 + parts) - 1.0
    return parts / whole, parts * np.array([np.prod(np.delete(1.0 + parts, i)) for i in range(A.size)]) / whole


def space_filling(dimensions: int, count: int) -> np.ndarray:
    return qmc.Sobol(dimensions, rng=1).random(count)


@pytest.mark.long
@pytest.mark.crosscheck
@pytest.mark.parametrize(
    ("function", "exact", "count"),
    [
        pytest.param(ishigami, ISHIGAMI, 256, id="Ishigami"),
        pytest.param(g_function, g_indices(), 256, id="g-function"),
    ],
)
def test_indices_agree_with_the_exact_ones_within_their_intervals(
    function: Callable[[np.ndarray], np.ndarray], exact: Sequence[np.ndarray], count: int
) -> None:
    shares = space_filling(len(exact[0]), count)
    values = function(shares)
    values[[3, 70]] = np.nan  # two diverged runs
    table, validation = sobol_tables(sample_of(shares, values), unit_axes(shares.shape[1]), [METRIC], SobolSettings(folds=4), 1)
    assert list(table.columns) == [column.name for column in SOBOL] and (table["verdict"] == TRUSTED).all()
    assert (table["diverged"] == 2).all() and (table["runs"] == count).all() and len(validation) == count - 2
    for name, known in zip(("first", "total"), exact, strict=True):
        np.testing.assert_allclose(table[name], known, atol=0.05)
        assert (table[f"{name}_low"] <= known).all() and (known <= table[f"{name}_high"]).all()
        assert (table[f"{name}_high"] - table[f"{name}_low"] < 0.25).all(), "the intervals are wide enough to say nothing"
    assert {"sobol/0003", "sobol/0070"}.isdisjoint(validation["run"])
    computed, predicted = validation["computed"], validation["predicted"]
    q2 = 1.0 - ((computed - predicted) ** 2).mean() / computed.var(ddof=0)
    assert table["q2"].iloc[0] == pytest.approx(q2) and q2 > 0.9


def test_a_surrogate_that_predicts_nothing_is_not_trusted() -> None:
    shares = space_filling(3, 64)
    noise = np.random.default_rng(1).standard_normal(64)
    table, validation = sobol_tables(sample_of(shares, noise), unit_axes(3), [METRIC], SobolSettings(folds=4, draws=50, points=64), 1)
    assert table["q2"].max() < 0.5 and (table["verdict"] == "not to be trusted: Q² below 0.8").all()
    pictures = [figure_sobol(table, unit_axes(3), "note"), figure_cross_validation(validation, table, "note")]
    for picture in pictures:
        assert any("not to be trusted" in text.get_text() for ax in picture.axes for text in ax.texts)
    same, none = sobol_tables(sample_of(shares, np.ones(64)), unit_axes(3), [METRIC], SobolSettings(), 1)
    assert same["verdict"].str.contains("same value").all() and same["first"].isna().all() and none.empty
    with pytest.raises(ValueError, match=r"runout: 5 runs .* sobol\.folds: 8"):
        sobol_tables(sample_of(shares[:5], noise[:5]), unit_axes(3), [METRIC], SobolSettings(), 1)


# ---------------------------------------------------------------- tables and figures


def test_logarithms_keep_zero_and_units() -> None:
    quantity = Quantity("displacement_magnitude", 0.01)
    assert quantity.of(np.array([0.0, 0.99])).tolist() == [-2.0, 0.0] and np.isnan(quantity.of(np.array([np.nan])))
    assert quantity.text == "log10(displacement_magnitude + 0.01 m)" and quantity.unit == "decade"
    assert METRIC.text == "runout" and METRIC.unit == "m"


def test_a_sample_reads_back_with_its_diverged_runs(tmp_path: Path) -> None:
    axes, quantities = unit_axes(2), [METRIC, Quantity("failed_fraction", None)]
    columns = sample_columns(axes, quantities)
    runs = [synthetic(translation(-3.0)), synthetic(translation(-5.0), status="diverged")]
    rows = [sample_row(f"tornado/{i}", (0.1, 0.2), run, columns, MetricSettings()) for i, run in enumerate(runs)]
    frame = pd.DataFrame(rows)
    write_csv(frame, tmp_path / "sample.csv")
    pd.testing.assert_frame_equal(read_sample(tmp_path / "sample.csv", axes, quantities), frame)
    assert described(frame.assign(still_moving=0)) == "2 runs, 1 of which diverged and are left out"
    assert described(frame.assign(still_moving=[1, 0])).endswith(", 1 still moving at the end: at least so far")
    assert frame["status"].tolist() == ["complete", "diverged"] and frame["runout"].tolist()[0] == pytest.approx(3.0)
    assert np.isnan(frame["runout"].iloc[1]) and frame[["x0", "x1"]].to_numpy().tolist() == [[0.1, 0.2]] * 2
    assert [column.name for column in columns][: len(SAMPLE)] == [column.name for column in SAMPLE]


def test_the_tornado_has_both_ends_and_counts_what_diverged(tmp_path: Path) -> None:
    axes = unit_axes(2)
    shares = np.array([[0.5, 0.5], [0.0, 0.5], [1.0, 0.5], [0.5, 0.0], [0.5, 1.0]])
    table = tornado_table(sample_of(shares, np.array([3.0, 1.0, 4.0, np.nan, 9.0])), axes, [METRIC])
    assert list(table.columns) == [column.name for column in TORNADO]
    assert table["swing"].iloc[0] == 3.0 and table["diverged"].tolist() == [0, 1] and np.isnan(table["swing"].iloc[1])
    assert table[["at_base", "at_low", "at_high"]].iloc[0].tolist() == [3.0, 1.0, 4.0] and BASE in planned(tmp_path).design("tornado")
    ax = figure_tornado(table, axes, "5 runs").axes[0]
    assert [label.get_text().partition("\n")[0] for label in ax.get_yticklabels()] == [r"\$x_1\$", r"\$x_0\$"]
    assert any(len(line.get_xdata()) == 1 and line.get_marker() == "x" for line in ax.lines), "the diverged run is marked"
    assert ax.figure.legends[0].get_texts()[-1].get_text() == "diverged"
    with pytest.raises(ValueError, match="no row"):
        figure_tornado(table.iloc[:0], axes, "")


def test_confirmation_pairs_the_first_points() -> None:
    sample = sample_of(space_filling(2, 8), np.arange(8.0))
    table = confirmation_table(sample, sample.iloc[:3].assign(runout=[2.0, 0.0, np.nan]), [METRIC], ("draft", "standard"))
    assert list(table.columns) == [column.name for column in CONFIRMED] and table["value"].tolist() == [0.0, 1.0, 2.0]
    assert table["difference"].tolist()[:2] == [-2.0, 1.0] and table["relative_difference"].iloc[0] == -1.0
    assert table[["difference", "relative_difference"]].isna().to_numpy().tolist() == [[False, False], [False, True], [True, True]]


def test_figures_show_every_factor(tmp_path: Path) -> None:
    shares = trajectories(tmp_path, 4)
    table = morris_table(sample_of(shares.reshape(-1, 11), (shares @ np.arange(11.0)).ravel()), unit_axes(11), [METRIC], 200, 1)
    figure = figure_morris(table, unit_axes(11), ["x10"], "48 runs, none of which diverged")
    assert len(figure.legends[0].get_texts()) == 11 and "none of which diverged" in figure.get_supxlabel()
    full = [line for line in figure.axes[0].lines if line.get_marker() not in ("None", "") and line.get_markerfacecolor() != "white"]
    assert len(full) == 1
    values = ishigami(space_filling(3, 64))
    indices, validation = sobol_tables(
        sample_of(space_filling(3, 64), values), unit_axes(3), [METRIC], SobolSettings(folds=2, draws=50, points=64, least_q2=0.0), 1
    )
    assert list(validation.columns) == [column.name for column in CROSS_VALIDATION]
    bars = figure_sobol(indices, unit_axes(3), "note").axes[0].patches
    assert len(bars) == 6 and {round(bar.get_width(), 6) for bar in bars} == {round(v, 6) for n in ("first", "total") for v in indices[n]}
