"""Dimensions and runs of a study that is no grid: what is accepted, how values are written, which runs a larger sample keeps."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from sph.scene.schema import make_scene
from sph.study.dimensions import Dimension, check_names, dimension, in_order, named, readable, scene_keys, title_of, value_of
from sph.study.sampling import Sample, chosen_study, read_cases

RANGES = {"soil.cohesion": {"bounds": [5.0, 50.0], "scale": "log"}, "S_R": [0.1, 0.5]}


def sample(method: str, size: int, seed: int = 1) -> list[dict[str, str]]:
    return Sample.model_validate({"method": method, "size": size, "seed": seed, "ranges": RANGES}).points()


@pytest.mark.parametrize("method", ["sobol", "random", "latin_hypercube"])
def test_a_sample_fills_its_ranges(method: str) -> None:
    points = sample(method, 256)
    cohesion, strength = (np.array([float(point[name]) for point in points]) for name in ("soil.cohesion", "S_R"))
    assert 5.0 <= cohesion.min() < 5.5 and 45.0 < cohesion.max() <= 50.0
    assert np.median(cohesion) == pytest.approx(np.sqrt(250.0), rel=0.15), "even on a logarithmic scale"
    assert np.mean(strength) == pytest.approx(0.3, abs=0.03)
    assert max(map(len, points[0].values())) <= 10, "written shortly"
    assert points == sample(method, 256) != sample(method, 256, seed=2)


@pytest.mark.parametrize(("method", "kept"), [("sobol", True), ("random", True), ("latin_hypercube", False)])
def test_a_larger_sample_keeps_the_runs_where_the_method_says_so(method: str, kept: bool) -> None:
    assert (sample(method, 100)[:37] == sample(method, 37)) is kept


def test_every_latin_interval_has_one_value() -> None:
    strengths = sorted(float(point["S_R"]) for point in sample("latin_hypercube", 20))
    assert [int((value - 0.1) / 0.02) for value in strengths] == list(range(20))


def test_values_are_numbers_words_or_nothing() -> None:
    assert [value_of(label) for label in ("0.10", "-5", "1e-3", "+2.5E+06", "null", "cubic_spline", "nan", "1_000")] == [
        0.1, -5.0, 1e-3, 2.5e6, None, "cubic_spline", "nan", "1_000"
    ]  # fmt: skip


def test_a_reader_who_does_not_know_symbols_reads_words() -> None:
    plainly = named("S_R")._replace(plainly=True)
    assert plainly.said("0.1") == "residual strength ratio 0.1" and plainly.phrase == "residual strength ratio"
    of_clay = Dimension("layers.clay.S_R", "-", "", False, plainly=True)
    assert of_clay.symbol == "residual strength ratio of clay" and of_clay._replace(plainly=False).symbol == "S_R of clay"


def test_a_dimension_has_the_unit_and_meaning_of_its_key() -> None:
    scene = make_scene({"scheme": "paper", "name": "s", "geometry": {"shape": "slope"}, "motion": {"kind": "tapered_sine"}})
    cohesion, rate = dimension("soil.cohesion", ["20"], scene), dimension("gamma", ["1"], scene)
    assert cohesion == Dimension("soil.cohesion", "kPa", "peak cohesion, that of the solid state", False)
    assert (rate.label, dimension("motion.amplitude", ["1"], scene).label) == ("γ (s⁻¹)", "amplitude of the motion (m/s²)")
    kernel = dimension("numerics.kernel", ["cubic_spline", "wendland_c2"], scene)
    assert kernel.words and kernel.variable(False).dtype == "str" and kernel.variable(False).units == "1"
    assert cohesion.variable(True).dims == ("case",) and cohesion.variable(False).dims == ("soil.cohesion",)
    assert title_of([cohesion, rate, kernel], {"soil.cohesion": "20", "gamma": "1", "numerics.kernel": "a"}) == (
        "cohesion 20 kPa, γ 1 s⁻¹, kernel a"
    )
    assert in_order(["soil.cohesion", "amplitude", "S_R"]) == ["S_R", "amplitude", "soil.cohesion"]


def test_keys_of_all_variants_are_known() -> None:
    assert {"soil.cohesion", "motion.peak", "numerics.kernel", "coupling.fluid.max_viscosity", "probes.<name>"} <= set(scene_keys())
    check_names("grid", ["S_R", "motion.peak", "probes.A", "numerics.adaptive_step.courant"])


@pytest.mark.parametrize(
    ("names", "message"),
    [
        (["soil.cohesoin"], "grid.soil.cohesoin: there is no such key in a scene; did you mean soil.cohesion?"),
        (["gama"], "did you mean gamma?"),
        (["soil"], ""),
        (["probes."], "no such key"),
        (["S_R", "coupling.S_R"], "S_R and coupling.S_R set the same key"),
    ],
)
def test_unknown_and_double_dimensions_are_refused(names: list[str], message: str) -> None:
    if not message:
        return check_names("grid", names)  # a section can be null
    with pytest.raises(ValueError, match=message.replace(".", r"\.")):
        check_names("grid", names)
    return None


def test_cases_come_from_a_table_as_written(tmp_path: Path) -> None:
    (tmp_path / "cases.csv").write_text("S_R,soil.cohesion\n0.10, 20\n0.50,null\n")
    assert read_cases([tmp_path], "cases.csv") == [{"S_R": "0.10", "soil.cohesion": "20"}, {"S_R": "0.50", "soil.cohesion": "null"}]


@pytest.mark.parametrize(
    ("text", "message"),
    [("S_R,gamma\n0.1\n", "row 2 has 1 values for 2 dimensions"), ("S_R,S_R\n1,2\n", "appears twice"), ("", "cannot be read as a table")],
)
def test_a_bad_table_of_cases_is_refused_by_row(tmp_path: Path, text: str, message: str) -> None:
    (tmp_path / "cases.csv").write_text(text)
    with pytest.raises(ValueError, match=f"cases.csv: .*{message}"):
        read_cases([tmp_path], "cases.csv")


def test_the_runs_of_a_configuration_take_the_place_of_those_below_it() -> None:
    merged = {"study": "s", "grid": {"S_R": [1]}, "sample": {"size": 2}}
    assert chosen_study(merged, {"sample": {"size": 2}}) == {"study": "s", "sample": {"size": 2}}
    assert chosen_study(merged, {"study": "s"}) == merged
    laid = {"study": "s", "grid": {"S_R": [1], "gamma": [100], "soil.cohesion": [20]}}
    assert chosen_study(laid, {"grid": {"soil.cohesion": [20]}}) == {"study": "s", "grid": {"soil.cohesion": [20]}}


def test_a_study_of_another_scene_must_say_which_runs_it_has() -> None:
    with pytest.raises(ValueError, match=r"scene: own\.yaml: .*grid, cases, sample"):
        chosen_study({"study": "s", "scene": "own.yaml", "grid": {"S_R": [1]}}, {"study": "s", "scene": "own.yaml"})
    with pytest.raises(ValueError, match=r"study: .*own\.yaml .*name"):
        chosen_study({"study": "paper", "scene": "own.yaml", "grid": {"S_R": [1]}}, {"scene": "own.yaml", "grid": {"S_R": [1]}})


def test_a_study_of_another_scene_stands_alone() -> None:
    below = {"study": "paper", "scene": "paper.yaml", "grid": {"S_R": [1]}, "fidelities": {"draft": {}}, "claims": {"amplitude": 6.0}}
    given = {"study": "mine", "scene": "own.yaml", "grid": {"soil.cohesion": [20]}}
    assert chosen_study({**below, **given}, given) == given


@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("S_R", "S_R"),
        ("gamma", "γ"),
        ("soil.youngs_modulus", "Young's modulus"),
        ("layers.soft_clay.soil.cohesion", "cohesion of soft clay"),
        ("layers.clay.S_R", "S_R of clay"),
        ("layers.clay.region.top", "top of clay"),
        ("motion.frequency", "frequency of the motion"),
        ("motion.stochastic.seed", "seed of the synthetic motion"),
        ("coupling.softening.slip_at_peak", "slip at the peak"),
        ("layers.soft_clay.softening.slip_at_residual", "slip at the residual strength of soft clay"),
        ("numerics.kernel", "kernel"),
    ],
)
def test_names_of_keys_are_read_without_dots(name: str, words: str) -> None:
    assert readable(name) == words
