"""The study's configuration: what is accepted, and what a refusal says."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
import yaml

from sph.experiments.paper import figures
from sph.experiments.paper.design import AnyStudy, PaperStudy, paper_study
from sph.experiments.registry import load_study
from sph.figures import RUN_FIGURES
from sph.figures.profile import moving_farthest
from sph.page.paper import PAPER_SECTIONS, sections_of
from sph.scene.configuration import merge, read_yaml, validated
from sph.scene.schema import make_scene
from sph.solver.restart import check_restart
from sph.stability.record import SLOPE_LIMITS
from sph.study.plan import Plan
from sph.study.runs import PlannedRun
from sph.study.sampling import chosen_study

ROOT = Path(__file__).resolve().parents[2]
GOOD: dict[str, Any] = yaml.safe_load((ROOT / "config" / "config.yaml").read_text(encoding="utf-8"))


def plan(overrides: dict[str, Any]) -> Plan:
    return load_study(merge(GOOD, overrides), [ROOT])


def paper(overrides: dict[str, Any]) -> PaperStudy:
    """The shipped study with some keys changed."""
    return paper_study(plan(overrides).study, "this test")


def test_the_shipped_study_covers_the_papers_cases() -> None:
    points = plan({}).study.points
    assert {"0.10", "0.25", "0.35", "0.50"} <= set(points["S_R"])
    assert {float(g) for g in points["gamma"]} == {1.0, 100.0}
    assert len({float(a) for a in points["amplitude"]} - {6.0}) >= 2 and "6.0" in set(points["amplitude"])
    assert {"draft", "standard", "paper"} <= set(plan({}).study.fidelities)


@pytest.mark.parametrize(
    "runs",
    [
        {"grid": {"amplitude": ["0.2g", "4.0", "600 gal"]}},
        {"cases": [{"motion.amplitude": value} for value in ("0.2g", "4.0", "6 m/s2")]},
        {"sample": {"size": 3, "ranges": {"amplitude": ["0.2g", "600 gal"]}}},
    ],
    ids=lambda runs: next(iter(runs)),
)
def test_accelerations_of_a_study_have_units(runs: dict[str, Any]) -> None:
    made = load_study(chosen_study(merge(GOOD, runs), runs), [ROOT])
    if "sample" in runs:
        assert made.study.sample is not None and made.study.sample.ranges["amplitude"].bounds == (1.962, 6.0)
    else:
        assert list(made.study.points.iloc[:, 0]) == ["1.962", "4.0", "6"]
    for name in made.study.runs:
        assert 1.962 <= make_scene(made.shared.runs[name].scene).motion.amplitude <= 6.0  # type: ignore[union-attr]


@pytest.mark.parametrize("path", sorted((ROOT / "config" / "studies").glob("*.yaml")), ids=lambda path: path.stem)
def test_the_shipped_studies_of_other_slopes_stand(path: Path) -> None:
    data = chosen_study(merge(GOOD, read_yaml(path)), read_yaml(path))
    for fidelity in read_yaml(path).get("fidelities", [data["fidelity"]]):
        chosen = load_study({**data, "fidelity": fidelity}, [ROOT])
        assert len(chosen.study.runs) >= 6 and chosen.study.study == path.stem


def test_a_file_of_an_experiment_is_named_below_one_key_or_found_by_the_experiments_name() -> None:
    study = plan({"experiments": {"assumptions": "mine.yaml"}}).study
    assert study.file_of("assumptions") == "mine.yaml" and study.file_of("resolution") == "config/resolution.yaml"


def test_labels_stay_as_written_and_become_numbers_in_the_scene() -> None:
    chosen = plan({"grid": {"S_R": ["0.10", 0.25, "0.350", 0.5]}, "figures": {"strengths": [0.1]}})
    assert chosen.study.grid is not None and chosen.study.grid["S_R"] == ("0.10", "0.25", "0.350", "0.5")
    assert chosen.built(S_R="0.10", gamma="1", amplitude="4.0").coupling.S_R == 0.1
    assert [point["S_R"] for _, point in paper_study(chosen.study, "this").figure_runs(4)] == ["0.10"]


def test_stages_do_not_depend_on_what_they_are_shared_by() -> None:
    one, other = plan({"grid": {"S_R": ["0.10", "0.25", "0.35", "0.50"]}}), plan({"grid": {"S_R": ["0.10", "0.25", "0.35", "0.50", "0.7"]}})
    assert one.scene() == other.scene()
    assert one.scene(amplitude="4.0") == other.scene(amplitude="4.0") != one.scene(amplitude="6.0")


def test_a_fidelity_lays_its_keys_over_the_scene() -> None:
    assert plan({"fidelity": "draft"}).built().numerics.smoothing_ratio == 1.3
    assert plan({}).built().numerics.smoothing_ratio == 2.3


def test_figure_7_shows_the_strength_of_the_text_and_of_the_caption() -> None:
    runs = list(paper({}).figure_runs(7))
    assert [(point["S_R"], point["gamma"]) for _, point in runs] == [("0.25", "100"), ("0.25", "1"), ("0.35", "100"), ("0.35", "1")]
    titles = [title for number in (4, 5, 6, 7) for both, _ in paper({}).figure_runs(number) for title in both]
    assert any("S_R = 0.25" in title for title in titles) and not any("$" in title for title in titles), "figures set the subscript"


@pytest.mark.parametrize(
    ("overrides", "wanted"),
    [
        (
            {"fidelities": {"draft": {"coupling": {"initial_state": "fluid"}}}, "fidelity": "draft"},
            ("coupling.initial_state", "fluid", "solid"),
        ),
        ({"fidelity": "best"}, ("fidelity", "best", "draft, standard, paper, fine")),
        ({"grid": {"S_R": []}}, ("grid.S_R", "at least 1")),
        ({"design": "0.25g"}, ("design: 0.25 g (2.453 m/s2)", "must be one of the amplitudes of the runs", "2 m/s2 (0.204 g)")),
        ({"grid": {"S_R": ["0.1", "0.10"]}}, ("grid", "S_R", "the same value twice")),
        ({"grid": {"gamma": ["fast"]}}, ("gamma = fast", "coupling.gamma", "valid number")),
        ({"grid": {"gamma": ["-1"]}}, ("gamma = -1", "coupling.gamma", "greater than or equal to 0")),
        ({"grid": {"depth": ["1"]}}, ("grid.depth", "no such key in a scene")),
        ({"grid": {"S_R": ["0.10", "0.25", "0.35", "0.50", "1.5"]}}, ("S_R = 1.5", "coupling.S_R", "less than or equal to 1")),
        ({"grid": {"S_R": ["0.10"]}, "figures": {"strengths": ["0.25"]}}, ("grid.S_R", "0.25", "figure")),
        ({"claims": {"amplitude": 5.0}}, ("claims.amplitude", "5.0", "grid.amplitude", "claims: null")),
        ({"fidelities": {"fine": {"numerics": {"spacng": 0.5}}}}, ("fidelity fine", "numerics.spacng", "no such key")),
        ({"metrics": {"link_length": 0}}, ("metrics.link_length", "0")),
        ({"study": "../elsewhere"}, ("study", "../elsewhere")),
        ({"fidelities": {"../x": {}}}, ("fidelities", "../x")),
        ({"scene": "config/scenes/absent.yaml"}, ("scene", "absent.yaml")),
        ({"extra": 1}, ("extra", "no such key")),
        ({"title": "Mine"}, ("title", "is a key of the scene", "write it in the scene file")),
    ],
)
def test_refusals_name_key_and_value(overrides: dict[str, Any], wanted: tuple[str, ...]) -> None:
    with pytest.raises(ValueError) as error:
        plan(overrides)
    for text in wanted:
        assert text in str(error.value)


def test_a_fidelity_is_checked_over_the_scene_and_not_over_the_chosen_fidelity() -> None:
    """An interval of 0.1 ms suits the scene's own time step and not that of the draft."""
    dense = {"fidelities": {"dense": {"outputs": {"series_interval": 1e-4}}}}
    assert plan(dense | {"fidelity": "draft"}).built().outputs.series_interval == 0.01
    assert plan(dense | {"fidelity": "dense"}).built().outputs.series_interval == 1e-4


# ---------------------------------------------------------------- any dimensions


def free(**runs: Any) -> Plan:
    """The shipped scene with other runs than the shipped grid."""
    return load_study({name: value for name, value in GOOD.items() if name != "grid"} | runs, [ROOT])


def test_a_grid_over_any_keys() -> None:
    chosen = free(grid={"numerics.kernel": ["wendland_c2", "cubic_spline"], "soil.cohesion": [150, "20"], "S_R": ["0.10", "0.5"]})
    assert list(chosen.study.runs)[:3] == [
        "S_R-0.10_numerics.kernel-wendland_c2_soil.cohesion-20",
        "S_R-0.10_numerics.kernel-wendland_c2_soil.cohesion-150",
        "S_R-0.10_numerics.kernel-cubic_spline_soil.cohesion-20",
    ], "numbers increase, words stay in their order"
    scene = chosen.built(**chosen.study.runs["S_R-0.5_numerics.kernel-wendland_c2_soil.cohesion-20"])
    assert (scene.coupling.S_R, scene.soil.cohesion, scene.numerics.kernel) == (0.5, 20.0, "wendland_c2")
    assert [axis.dtype for axis in chosen.layout.axes] == ["f8", "str", "f8"]
    assert list(chosen.study.figure_files) == [*RUN_FIGURES] == ["section", "motion", "particles", "mobilised", "profiles"]


def ids(runs: list[PlannedRun]) -> list[str]:
    return [run.id for run in runs]


def test_stages_hold_what_acts_in_them_and_nothing_else() -> None:
    chosen = free(grid={"S_R": [0.1, 0.5], "gamma": [1, 100], "amplitude": [2, 6], "motion.frequency": [1, 2], "soil.cohesion": [20, 150]})
    assert len(chosen.study.runs) == 32
    gravities, pre_failures = chosen.shared.gravities, chosen.shared.pre_failures
    assert ids(gravities) == ["gravity_soil.cohesion-20", "gravity_soil.cohesion-150"]
    assert len(pre_failures) == 8 and pre_failures[0].id == "pre_failure_amplitude-2_motion.frequency-1_soil.cohesion-20"
    run = chosen.shared.runs["S_R-0.5_gamma-1_amplitude-6_motion.frequency-2_soil.cohesion-150"]
    gravity, pre_failure = chosen.shared.gravity_of(run.id), next(stage for stage in pre_failures if stage.file == run.parent)
    assert pre_failure.parent == gravity.file and [row.until for row in (gravity, pre_failure, run)] == [
        "gravity",
        "first_failure",
        "end",
    ]
    stage = make_scene(gravity.scene)
    assert (stage.soil.cohesion, stage.coupling.S_R, stage.motion.amplitude) == (150.0, 0.25, 6.0)


def test_a_limit_is_searched_of_the_slope_that_its_name_ends_with() -> None:
    chosen = free(grid={"amplitude": [2, 6], "soil.cohesion": [20, 150]})
    for limit in SLOPE_LIMITS:
        searches = chosen.shared.searches(limit)
        assert [search.file for search in searches] == [f"{chosen.folder}/stages/{limit}_soil.cohesion-{c}.nc" for c in (20, 150)]
        assert [search.scene for search in searches] == [stage.scene for stage in chosen.shared.gravities]
        assert {(search.by, search.extrapolates) for search in searches} == {(limit, True)}
    assert [search.id for search in chosen.searches.values()] == 2 * [f"yield_acceleration_soil.cohesion-{c}" for c in (20, 150)]
    assert {run.by for run in chosen.jobs} == {"simulation", "yield_acceleration"}, "the factor of safety only where it is asked for"


def test_searches_are_switched_by_one_key() -> None:
    for searches in ("quick", "none"):
        chosen = free(grid={"amplitude": [2, 6]}, searches=searches)
        assert chosen.searches == {} and {run.by for run in chosen.jobs} == {"simulation"}
        with pytest.raises(ValueError, match=f"yield_acceleration: each .*searches: {searches}.*searches: full"):
            free(grid={"amplitude": [2, 6]}, searches=searches, yield_acceleration="each")
    with pytest.raises(ValueError, match="searches: .*'full', 'quick' or 'none'.*'fast'"):
        free(grid={"amplitude": [2, 6]}, searches="fast")


UNCERTAIN = {
    "uncertain": {"seed": 1, "variables": {"c": {"of": "soil.cohesion", "kind": "lognormal", "mean": 120.0, "cov": 0.2}}},
    "soil": {"cohesion": 120.0},
}


def uncertain(grid: dict[str, Any], scene: dict[str, Any] | None = None, **more: Any) -> Plan:
    """A study of the shipped scene with an uncertain cohesion."""
    return free(grid=grid, fidelity="own", fidelities={"own": UNCERTAIN if scene is None else scene}, **more)


def test_draws_of_uncertain_soil_share_the_search_of_the_mean_soil() -> None:
    shared = uncertain({"uncertain.seed": [1, 2, 3], "uncertain.variables.c.cov": [0.1, 0.3], "soil.friction_angle": [20, 25]}).shared
    assert len(shared.gravities) == 12
    searches = shared.searches("yield_acceleration")
    assert [search.id for search in searches] == [f"yield_acceleration_of_mean_soil.friction_angle-{angle}" for angle in (20, 25)]
    for search, angle in zip(searches, (20, 25), strict=True):
        soil = search.scene["soil"]
        assert (soil["cohesion"], soil["friction_angle"], "uncertain" in search.scene) == (120.0, angle, False)
        assert make_scene(search.scene).uncertain is None
    assert {search.id for search in shared if search.by == "yield_acceleration"} == {search.id for search in searches}
    assert {shared.search_of(name).id for name in shared.runs} == {search.id for search in searches}
    assert len(shared.searches("factor_of_safety")) == 12, "each draw has a factor of its own"


def test_each_draw_is_searched_where_that_is_asked_for_or_there_is_one() -> None:
    each = uncertain({"uncertain.seed": [1, 2, 3], "amplitude": [2, 6]}, yield_acceleration="each")
    assert {search.id for search in each.searches.values()} == {f"yield_acceleration_uncertain.seed-{seed}" for seed in (1, 2, 3)}
    one = uncertain({"amplitude": [2, 6]})
    assert {search.id for search in one.searches.values()} == {"yield_acceleration"}
    assert all(search.scene["uncertain"]["seed"] == 1 for search in one.searches.values())
    means = uncertain({"uncertain.variables.c.mean": [110, 120]}, {"uncertain": UNCERTAIN["uncertain"]})
    assert len({search.id for search in means.searches.values()}) == 2, "another mean is another slope"


def test_many_draws_of_one_slope_have_a_yield_acceleration() -> None:
    seeds = {"uncertain.seed": list(range(1, 41))}
    many = uncertain(seeds)
    assert len(many.searches) == 40 and len({search.file for search in many.searches.values()}) == 1
    assert uncertain(seeds, yield_acceleration="each").searches == {}


@pytest.mark.parametrize(
    "key",
    [
        "S_R", "gamma", "coupling.fluid_tension_limit", "amplitude", "motion.decay_start", "duration", "soil.viscosity", "walls.layers",
        "numerics.time_step", "outputs.frame_interval", "gravity.damping", "damping.ratio", "geometry.slope_angle",
    ],
)  # fmt: skip
def test_the_solver_accepts_every_stage_that_is_shared(key: str) -> None:
    """By the comparison that it makes itself: of a gravity stage at its end, of a pre-failure run in which nothing failed until then."""
    values = {"walls.layers": [2, 3], "duration": [12, 15], "numerics.time_step": ["1e-4", "5e-5"], "geometry.slope_angle": [50, 60]}
    values |= {"motion.decay_start": [8, 9], "outputs.frame_interval": [0.25, 0.5], "gravity.damping": [10, 20]}
    chosen = free(grid={key: values.get(key, ["0.1", "0.2"]), "S_R" if key != "S_R" else "gamma": ["0.3", "0.4"]})
    rows = {row.file: row for row in chosen.shared}
    for run in chosen.shared.runs.values():
        pre_failure = rows[str(run.parent)]
        gravity = rows[str(pre_failure.parent)]
        scenes = [make_scene(row.scene) for row in (gravity, pre_failure, run)]
        check_restart(scenes[0], scenes[1], scenes[0].gravity.duration, False, gravity.id)
        check_restart(scenes[1], scenes[2], scenes[1].duration, False, pre_failure.id)


def test_a_stage_that_does_not_stand_alone_is_not_shared() -> None:
    """A gravity stage of 4 s ends after the shaking of the scene file has begun."""
    cases = [{"gravity.duration": 4, "motion.start": 4, "motion.decay_start": 10, "motion.end": 11, "S_R": S_R} for S_R in (0.1, 0.5)]
    chosen = free(cases=cases)
    assert ids(chosen.shared.gravities) == ["gravity_case-000001", "gravity_case-000002"]
    assert ids(chosen.shared.pre_failures) == ["pre_failure_case-000001"]
    assert make_scene(chosen.shared.gravities[1].scene).coupling.S_R == 0.5


def test_cases_and_samples_are_numbered_and_share_stages() -> None:
    cases = [{"S_R": "0.10", "soil.cohesion": "20"}, {"S_R": "0.50", "soil.cohesion": 20}, {"soil.cohesion": 150, "S_R": "0.50"}]
    chosen = free(cases=cases)
    assert chosen.study.runs["case-000002"] == {"S_R": "0.50", "soil.cohesion": "20"}
    assert ids(chosen.shared.gravities) == ["gravity_case-000001", "gravity_case-000003"]
    assert chosen.shared.gravity_of("case-000002").id == "gravity_case-000001"
    assert chosen.shared.runs["case-000002"].parent == f"{chosen.folder}/stages/pre_failure_case-000001.nc"
    few, more = (free(sample={"size": size, "ranges": {"soil.cohesion": [5, 50], "S_R": [0.1, 0.5]}}) for size in (5, 9))
    assert list(more.study.runs.items())[:5] == list(few.study.runs.items()), "a larger sample keeps its runs"


def test_cases_from_a_file(tmp_path: Path) -> None:
    (tmp_path / "mine.csv").write_text("S_R,numerics.kernel\n0.10,cubic_spline\n0.5,wendland_c2\n")
    data = {name: value for name, value in GOOD.items() if name != "grid"} | {"cases": "mine.csv"}
    chosen = load_study(data, [tmp_path, ROOT])
    assert [point["numerics.kernel"] for point in chosen.study.runs.values()] == ["cubic_spline", "wendland_c2"]


def test_a_dimension_set_to_null_is_none() -> None:
    chosen = plan({"grid": {"gamma": None, "amplitude": None, "soil.cohesion": [20]}})
    assert chosen.study.names == ["S_R", "soil.cohesion"]


def test_names_that_would_be_too_long_are_numbers() -> None:
    keys = (
        "geometry.slope_height",
        "geometry.base_depth",
        "geometry.apron_length",
        "geometry.crest_length",
        "gravity.damping",
        "gravity.duration",
    )
    chosen = free(grid={key: [1, 2] for key in keys})
    assert len(chosen.study.runs) == 64 and "case-000064" in chosen.study.runs and chosen.layout.named and chosen.layout.labels
    assert max(map(len, ids(chosen.shared.gravities))) < 40


def test_names_of_files_lead_nowhere() -> None:
    """A record of another folder is a value like any other; the name of its run is one of a file."""
    files = ["a.csv", "records/../../b.csv"]
    study = validated(AnyStudy, {**GOOD, "grid": {"motion.file": files}}, "config")
    assert list(study.runs) == ["motion.file-a.csv", "motion.file-records~..~..~b.csv"]


def test_large_studies_are_measured_in_parts() -> None:
    chosen = free(sample={"size": 1201, "method": "random", "ranges": {"S_R": [0.1, 0.5]}})
    assert chosen.parts == ["0001", "0002", "0003"] and [len(chosen.part(part)) for part in chosen.parts] == [500, 500, 201]
    shown = chosen.study.page_runs
    assert len(shown) <= 200 and {"case-000001", "case-001201"} <= set(shown)


def test_profiles_are_those_of_the_strongest_shaking_of_the_scene_as_it_is() -> None:
    records, drained = ["a.csv", "b.csv"], {"drained": {"soil": {"cohesion": 60}}}
    for more, wanted in (
        ({}, ["amplitude-9_a", "amplitude-9_b", "amplitude-1_b", "amplitude-1_a"]),  # all there are
        ({"alternatives": drained}, [f"amplitude-9_{which}" for which in ("a_base", "b_base", "a_drained", "b_drained")]),
        ({"figures": {"runs": ["amplitude-1_motion.file-b.csv"]}}, ["amplitude-1_b"]),
    ):
        study = validated(AnyStudy, {**GOOD, "grid": {"amplitude": [1, 9], "motion.file": records}, **more}, "config")
        short = [name.replace("motion.file-", "").replace(".csv", "").replace("alternative-", "") for name in study.profile_runs]
        assert short == wanted
    many = validated(AnyStudy, {**GOOD, "grid": {"amplitude": list(range(1, 21))}}, "config")
    assert many.profile_runs == ["amplitude-20", "amplitude-19", "amplitude-10", "amplitude-1"]


def test_the_figure_of_profiles_says_which_of_how_many_runs_it_shows() -> None:
    drained, more = {"drained": {"soil": {"cohesion": 60}}, "steep": {"soil": {"cohesion": 50}}}, {"gamma": [1, 100]}
    some = plan({"claims": None, "grid": {"S_R": [0.1], "amplitude": [1, 9], **more}, "alternatives": drained}).profile_choice
    assert [len(group) for group in some["groups"]] == [2, 2, 2] and some["size"] == 6
    assert some["of"] + some["rule"] == (
        "the 6 runs with the strongest shaking, amplitude 9 m/s² (0.917 g): of each alternative first the one in which A moves farthest"
    )
    one = {"drained": {"soil": {"cohesion": 60}}}
    with_weaker = plan({"claims": None, "grid": {"S_R": [0.1], "amplitude": [1, 5, 9], "gamma": [1]}, "alternatives": one}).profile_choice
    assert with_weaker["rule"] == ": evenly through the study", "one run of each alternative"
    both = plan({"claims": None, "grid": {"S_R": [0.1, 0.2], "amplitude": [1, 9], "gamma": [1]}}).profile_choice
    assert [len(group) for group in both["groups"]] == [2, 1, 1]
    assert both["of"] + both["rule"] == "4 runs: first the one in which A moves farthest in the strongest shaking"
    names = [name for name, *_ in some["groups"]]
    moved = dict(zip([path for group in some["groups"] for path in group], [3.0, 4.0, 2.0, 1.0, 5.0, 0.5], strict=True))
    (base, other), (first, _), (last, _) = some["groups"]
    assert names == [base, first, last] and moving_farthest(some["groups"], moved.__getitem__, 4) == [base, other, first, last]
    assert moving_farthest(some["groups"], moved.__getitem__, 3) == [other, first, last]
    amplitudes = plan({"claims": None, "grid": {"S_R": [0.1], "gamma": [1], "amplitude": list(range(1, 21))}})
    assert amplitudes.profile_choice["of"] + amplitudes.profile_choice["rule"] == "20 runs: evenly through the study"


def test_the_figure_of_the_motion_says_how_other_runs_are_shaken() -> None:
    for grid, wanted in (
        ({"amplitude": [2, 4, 6]}, "× 2 and × 3"),
        ({"amplitude": [2, 4, 6, 8, 9]}, "× 2 to × 4.5"),
        ({"amplitude": [4]}, ""),
        ({"amplitude": [2, 4], "motion.frequency": [1, 2]}, "× 2, also frequency of the motion 2 Hz"),
    ):
        assert plan({"claims": None, "grid": {"S_R": [0.1], "gamma": [1], **grid}}).other_shakings == wanted


@pytest.mark.parametrize(
    ("runs", "wanted"),
    [
        ({}, ("one of grid, cases, sample", "found none")),
        ({"grid": {"S_R": [0.1]}, "cases": [{"S_R": 0.1}]}, ("one of grid, cases, sample", "grid and cases")),
        ({"grid": {"soil.cohesoin": [1]}}, ("grid.soil.cohesoin", "did you mean soil.cohesion?")),
        ({"grid": {"soil.cohesion": [20, -1]}}, ("soil.cohesion = -1", "greater than or equal to 0")),
        ({"grid": {"numerics.kernel": ["cubic"]}}, ("numerics.kernel = cubic", "'cubic_spline' or 'wendland_c2'", "cubic")),
        ({"grid": {"soil.cohesion": [20, "20.0"]}}, ("grid.soil.cohesion", "the same value twice")),
        ({"grid": {"soil.cohesion": ["../b"]}}, ("grid.soil.cohesion", "../b")),
        ({"grid": {"soil.cohesion": [True]}}, ("grid.soil.cohesion", "not values of any key")),
        ({"grid": {}}, ("grid", "at least 1")),
        ({"grid": {"S_R": [0.1, 0.2], "soil.cohesion": list(range(1, 60_001))}}, ("the grid has 120,000 points", "100,000")),
        ({"cases": [{"S_R": 0.1}, {"gamma": 1}]}, ("cases: case 2 sets gamma, the first S_R",)),
        ({"cases": [{"S_R": "0.1"}, {"S_R": "0.10"}]}, ("case-000001 and case-000002 are the same run", "S_R = 0.10")),
        ({"cases": "absent.csv"}, ("cases", "absent.csv")),
        ({"sample": {"size": 4, "ranges": {"S_R": [0.5, 0.1]}}}, ("sample.ranges.S_R", "must increase")),
        ({"sample": {"size": 4, "ranges": {"S_R": {"bounds": [0.0, 0.1], "scale": "log"}}}}, ("sample.ranges.S_R", "positive")),
        ({"sample": {"size": 4, "ranges": {"S_R": [0.1, 3.0]}}}, ("S_R = ", "less than or equal to 1")),
        ({"sample": {"size": 0, "ranges": {"S_R": [0.1, 0.3]}}}, ("sample.size", "0")),
        ({"grid": {"S_R": [0.1, 0.5]}, "figures": {"runs": ["S_R-0.2"]}}, ("figures.runs", "S_R-0.2", "S_R-0.1")),
    ],
)  # fmt: skip
def test_refusals_of_free_studies_name_key_and_value(runs: dict[str, Any], wanted: tuple[str, ...]) -> None:
    with pytest.raises(ValueError) as error:
        free(**runs)
    for text in wanted:
        assert text in str(error.value)


def test_what_needs_the_papers_dimensions_says_so() -> None:
    chosen = free(grid={"S_R": [0.1], "soil.cohesion": [20, 150]})
    with pytest.raises(ValueError, match=r"S_R, gamma, amplitude; study 'paper' .*S_R, soil.cohesion"):
        paper_study(chosen.study, "the claims")


def test_the_claims_of_the_paper_are_asked_for() -> None:
    other = load_study({name: value for name, value in GOOD.items() if name != "claims"}, [ROOT]).study
    assert type(other) is AnyStudy and other.is_grid_over(["S_R", "gamma", "amplitude"])
    with pytest.raises(ValueError, match=r"key claims in study 'paper'"):
        paper_study(other, "the claims")


def test_an_experiment_on_a_scene_of_ones_own_is_configured_by_ones_own_file(tmp_path: Path) -> None:
    own = {**read_yaml(ROOT / "config" / "studies" / "gentle_layered.yaml")}
    chosen = load_study(own, [ROOT])
    for name in ("trigger", "sensitivity"):
        with pytest.raises(ValueError, match=rf"experiments\.{name}: study 'gentle_layered'"):
            chosen.experiment_file(name)
    mine = {**own, "experiments": {"trigger": "mine.yaml"}}
    with pytest.raises(ValueError, match=r"experiments\.trigger: no file 'mine\.yaml'"):
        load_study(mine, [ROOT])
    intensity = {"dimension": "amplitude", "lowest": 0.5, "highest": 5.0, "cells": 3}
    search = {"fidelity": "coarse", "cases": {"as it is": {}}, "intensity": intensity, "tolerance": 0.1, "classes": ["collapse"], "at": {}}
    (tmp_path / "mine.yaml").write_text(yaml.safe_dump(search), encoding="utf-8")
    assert load_study(mine, [tmp_path, ROOT]).experiment_file("trigger") == "mine.yaml"
    assert plan({}).experiment_file("trigger") == "config/trigger.yaml"


def test_the_keys_of_the_paper_are_read_and_left_alone_in_other_studies() -> None:
    """They stand in the configuration that a study is laid over."""
    keys = {"claims": {"amplitude": 5.0}, "figures": {"strengths": ["0.9"]}}
    chosen = free(grid={"S_R": [0.1], "soil.cohesion": [20, 150]}, **keys).study
    assert type(chosen) is AnyStudy and list(chosen.figure_files)[-1] == "profiles"
    with pytest.raises(ValueError, match="claims.amplitude"):
        free(grid={"S_R": [0.1]}, claims={"amplitude": -1.0})


def test_figures_of_all_runs_are_left_out_where_runs_do_not_differ() -> None:
    for grid, missing in (
        ({"S_R": [0.1], "soil.cohesion": [20]}, ["study", "map"]),
        ({"S_R": [0.1], "soil.cohesion": [20, 30]}, ["map"]),
        ({"S_R": [0.1, 0.2], "soil.cohesion": [20, 30]}, []),
    ):
        study = (chosen := free(grid=grid)).study
        (section,) = (section for section in sections_of(chosen) if section.title == "Figures")
        assert (
            list(study.left_out)
            == missing
            == [name for name in ("study", "map") if f"{{fidelity}}/figures/{name}.png" not in section.figures]
        )


def test_every_figure_of_the_paper_has_its_runs() -> None:
    shown = paper({}).figure_files
    assert list(shown) == list(figures.FIGURES)
    assert shown["fig1"] == shown["fig2"] == shown["fig3"] == ["S_R-0.10_gamma-100_amplitude-6.0"] == shown["fig4"][:1]
    assert [len(shown[f"fig{number}"]) for number in range(4, 8)] == [3, 2, 3, 4]


def test_figures_of_the_paper_whose_runs_are_not_in_the_grid_are_left_out_and_named() -> None:
    chosen = plan({"grid": {"S_R": ["0.25", "0.50"], "gamma": ["100", "1"], "amplitude": ["6.0"]}})
    assert list(chosen.study.figure_files) == ["fig1", "fig2", "fig3", "fig5"]
    assert chosen.study.figure_files["fig1"] == chosen.study.figure_files["fig5"][:1] == ["S_R-0.25_gamma-100_amplitude-6.0"]
    assert {name: reason.split(" is ")[0] for name, reason in chosen.study.left_out.items()} == {
        "fig4": "grid.S_R: 0.10",
        "fig6": "grid.S_R: 0.10",
        "fig7": "grid.S_R: 0.35",
    }
    results, example = (
        next(section for section in sections_of(chosen) if section.title == title)
        for title in ("The paper's results", "The paper's example")
    )
    assert all(f"Figure {number} is left out (grid.S_R: " in results.text for number in (4, 6, 7))
    assert (len(results.figures), len(example.figures)) == (1, 3)
    with pytest.raises(ValueError, match="fig4: grid.S_R: 0.10"):
        chosen.figure_runs("fig4")
    whole = plan({})
    assert not whole.study.left_out and sections_of(whole) == PAPER_SECTIONS


def test_what_figures_are_asked_for_by_their_keys_must_be_in_the_grid() -> None:
    with pytest.raises(ValueError, match="grid.S_R: 0.9 .*the grid has"):
        plan({"figures": {"strengths": ["0.9"]}})
