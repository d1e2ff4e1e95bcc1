"""The prediction of costs against the runs of the cost-accuracy study and against itself; no clock is read."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from small_scenes import SceneBuilder

from sph.experiments.variants.advice import shipped_table
from sph.scene.schema import Scene, load_scene
from sph.solver.checkpoint import run_to_file
from sph.solver.particles import place_particles
from sph.stability.extrapolation import at_spacing
from sph.stability.standing import FailureRule, static_scene
from sph.storage import trajectory
from sph.study.cost import COMPILER, TRIALS, TRIALS_NEAR, TRIALS_STRONGER, cost, needs, search_cost

ROOT = Path(__file__).resolve().parents[2]


@pytest.fixture(scope="module")
def measured_runs() -> list[tuple[Any, Scene]]:
    """Timed rows of the shipped table, with their scenes."""
    table = shipped_table()
    assert table is not None
    rows = table[table["timed"] == 1].itertuples()
    return [(row, load_scene(ROOT / "config" / "scenes" / "paper.yaml", json.loads(str(row.settings)))) for row in rows]


def test_the_measured_costs_are_met(measured_runs: list[tuple[Any, Scene]]) -> None:
    """Runs of 0.4 s to 2,640 s, as they were measured, some beside other work: what the module says of itself."""
    ratios = np.array([cost(scene).seconds / row.wall_time for row, scene in measured_runs])
    lower, first, median, third, upper = np.quantile(ratios, [0.1, 0.25, 0.5, 0.75, 0.9])
    assert len(ratios) > 50
    assert lower > 0.8 and 0.95 < first < median < third < 1.07 and upper < 1.12 and 0.97 < median < 1.03
    assert ratios.min() > 0.5 and ratios.max() < 1.3


def test_sizes_and_steps_of_the_measured_runs(measured_runs: list[tuple[Any, Scene]]) -> None:
    for row, scene in measured_runs:
        found = cost(scene)
        assert found.particles == row.particles
        if scene.early_stop is None:
            balanced = scene.gravity.initial_stress != "none"  # by a step before the first
            assert 0.95 < found.steps / row.steps < 1.25 if scene.numerics.adaptive_step else found.steps + balanced == row.steps, (
                row.variant
            )


def test_parts_add_up(small_slope: SceneBuilder) -> None:
    scene = small_slope({})
    whole, gravity, rest = cost(scene), cost(scene, until=1.0), cost(scene, since=1.0)
    assert gravity.steps + rest.steps == whole.steps == 3000
    assert gravity.seconds + rest.seconds == pytest.approx(whole.seconds)
    assert gravity.disk < rest.disk == whole.disk and gravity.memory < whole.memory
    assert whole.particles == place_particles(scene).x.size


def test_what_costs_more(small_slope: SceneBuilder) -> None:
    scene = small_slope({})
    for changes in ({"numerics.spacing": 2.5}, {"numerics.smoothing_ratio": 3.0}, {"numerics.time_step": 5e-4}, {"duration": 5.0}):
        assert cost(small_slope(changes)).seconds > cost(scene).seconds, changes
    assert cost(small_slope({"numerics.gradient_tolerance": 0.0})).seconds > 1.3 * cost(scene).seconds
    assert cost(small_slope({"outputs.frame_interval": 0.01})).disk > 5 * cost(scene).disk
    adaptive = {"numerics.adaptive_step": {"courant": 0.8}, "numerics.time_step": 0.01}
    calm: dict[str, Any] = {"coupling": {"gamma": 0.0, "solid_after_failure": "elastic_plastic"}} | adaptive
    assert cost(small_slope(calm)).steps < cost(small_slope(adaptive)).steps
    layer = {"region": {"kind": "depth", "top": 5.0}, "soil": {}}
    kept, lost = (small_slope(calm | {"layers": {"deep": layer | {"gamma": gamma}}}) for gamma in (0.0, 1.0))
    assert cost(kept).steps < cost(lost).steps == cost(small_slope(adaptive)).steps, "a layer alone may become debris"


@pytest.mark.long
def test_a_file_is_about_as_large_as_predicted(small_slope: SceneBuilder, tmp_path: Path) -> None:
    scene = small_slope({"numerics.spacing": 2.5, "numerics.time_step": 2e-3, "outputs.frame_interval": 0.05})
    result = run_to_file(scene, tmp_path / "run.nc", say=lambda line: None)
    assert result.trajectory.sizes["frame"] == 61 and trajectory.read(tmp_path / "run.nc").attrs["status"] == "complete"
    found = cost(scene)
    assert 0.6 < found.disk * 2**20 / (tmp_path / "run.nc").stat().st_size < 1.6
    assert result.trajectory.attrs["particle_steps"] == found.particles * found.steps


def test_a_search_is_many_static_tests(small_slope: SceneBuilder) -> None:
    scene = small_slope({"numerics.spacing": 2.0})
    one = cost(static_scene(scene, FailureRule(), acceleration=1.0))
    alone = search_cost(scene, extrapolates=False)
    assert alone.steps == TRIALS * one.steps and alone.seconds == TRIALS * one.seconds


def test_a_search_at_two_spacings_costs_about_as_much_as_one_at_the_fine_one_alone(small_slope: SceneBuilder) -> None:
    """The coarse tests are cheap, and the fine search begins near its end."""
    scene = small_slope({"numerics.spacing": 1.25, "numerics.gradient_tolerance": 0.1})
    rule = FailureRule()
    coarse, fine = (cost(static_scene(at_spacing(scene, spacing), rule, acceleration=1.0)) for spacing in (2.5, 1.25))
    both = search_cost(scene)
    assert both.seconds == pytest.approx((TRIALS + TRIALS_STRONGER) * coarse.seconds + TRIALS_NEAR * fine.seconds)
    assert both.seconds < 1.5 * search_cost(scene, extrapolates=False).seconds and both.memory == 2 * fine.memory


def test_a_search_of_a_slope_without_one_is_as_the_scene(small_slope: SceneBuilder) -> None:
    coarse = small_slope({})
    assert search_cost(coarse) == cost(coarse), "too coarse for the rule of failure: there is no search"


def test_what_a_job_asks_for(small_slope: SceneBuilder) -> None:
    data = small_slope({})
    first, second = needs(data), needs(data, attempt=2)
    assert first.mem_mb >= COMPILER and first.runtime >= 5
    assert second.mem_mb == pytest.approx(2 * first.mem_mb, abs=1) and second.runtime == pytest.approx(2 * first.runtime, abs=1)
    large = small_slope({"numerics.spacing": 0.2, "numerics.time_step": 5e-5, "outputs.frame_interval": 0.05})
    gravity, end, search = (needs(large, what) for what in ("gravity", "end", "yield_acceleration"))
    assert first.runtime < gravity.runtime < end.runtime < search.runtime and first.mem_mb < gravity.mem_mb < end.mem_mb
