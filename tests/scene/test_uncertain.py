"""Uncertain keys: statistics of the draws against the distributions, what a seed depends on, and what is refused."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from scipy import stats

from sph.checks.scene import uncertain_rows
from sph.scene.configuration import dotted, merge
from sph.scene.schema import Scene, make_scene, stored_scene
from sph.scene.uncertain import Uncertain
from sph.solver.particles import place_particles
from sph.stability.standing import divided_strength, weakened

SEEDS = 4000
ERRORS = 4.0
"""Standard errors by which a statistic of the sample may miss that of the distribution."""
C = {"of": "soil.cohesion", "kind": "lognormal", "mean": 20.0, "cov": 0.3}
PHI = {"of": "soil.friction_angle", "kind": "normal", "mean": 25.0, "sd": 2.0}
BOTH: dict[str, Any] = {"seed": 1, "variables": {"c": C, "phi": PHI}, "correlations": [{"between": ["c", "phi"], "value": -0.5}]}
SLOPE: dict[str, Any] = {"scheme": "paper", "name": "s", "geometry": {"shape": "slope"}}


def scene(uncertain: dict[str, Any], **other: Any) -> Scene:
    return make_scene(SLOPE | {"uncertain": uncertain} | other, "some.yaml")


def draws(section: dict[str, Any], seeds: int = SEEDS) -> dict[str, np.ndarray]:
    settings = Uncertain.model_validate(section)
    found = [settings.model_copy(update={"seed": seed}).values() for seed in range(seeds)]
    return {name: np.array([values[name] for values in found]) for name in found[0]}


@pytest.fixture(scope="module")
def sample() -> dict[str, np.ndarray]:
    return draws(BOTH)


def test_mean_deviation_and_shape_are_those_of_the_distributions(sample: dict[str, np.ndarray]) -> None:
    shape = np.sqrt(np.log1p(0.3**2))
    for values, wanted in (
        (sample["soil.cohesion"], stats.lognorm(shape, scale=20.0 / np.sqrt(1.0 + 0.3**2))),
        (sample["soil.friction_angle"], stats.norm(25.0, 2.0)),
    ):
        mean, variance, _, excess = (float(part) for part in wanted.stats("mvsk"))
        assert abs(values.mean() - mean) < ERRORS * np.sqrt(variance / SEEDS)
        assert abs(values.var() - variance) < ERRORS * variance * np.sqrt((excess + 2.0) / SEEDS)
        assert stats.kstest(values, wanted.cdf).pvalue > 1e-3


def test_the_correlation_is_that_of_the_scores(sample: dict[str, np.ndarray]) -> None:
    c, phi = sample["soil.cohesion"], sample["soil.friction_angle"]
    assert abs(np.corrcoef(np.log(c), phi)[0, 1] + 0.5) < ERRORS * (1.0 - 0.5**2) / np.sqrt(SEEDS)
    shape = np.sqrt(np.log1p(0.3**2))
    expected = -0.5 * shape / 0.3  # of a lognormal and a normal variable: rho s / sqrt(exp(s^2) - 1)
    assert abs(np.corrcoef(c, phi)[0, 1] - expected) < ERRORS / np.sqrt(SEEDS)


def test_three_correlations_hold_together() -> None:
    variables = {"c": C, "phi": PHI, "rho": {"of": "soil.density", "kind": "normal", "mean": 1900.0, "cov": 0.05}}
    pairs = {("c", "phi"): -0.5, ("phi", "rho"): 0.6, ("c", "rho"): 0.1}
    found = draws({"seed": 0, "variables": variables, "correlations": [{"between": pair, "value": r} for pair, r in pairs.items()]})
    scores = {name: np.log(found[v["of"]]) if v["kind"] == "lognormal" else found[v["of"]] for name, v in variables.items()}
    for (one, other), wanted in pairs.items():
        assert abs(np.corrcoef(scores[one], scores[other])[0, 1] - wanted) < ERRORS * (1.0 - wanted**2) / np.sqrt(SEEDS)


def test_an_interval_from_twenty_seeds_covers_the_mean_as_often_as_it_says(sample: dict[str, np.ndarray]) -> None:
    blocks = sample["soil.friction_angle"].reshape(-1, 20)
    half = stats.t.ppf(0.975, 19) * blocks.std(axis=1, ddof=1) / np.sqrt(20)
    covered = int(np.count_nonzero(np.abs(blocks.mean(axis=1) - 25.0) < half))
    low, high = stats.binom.interval(0.999, len(blocks), 0.95)
    assert low <= covered <= high


@pytest.mark.parametrize("kind", ["normal", "lognormal"])
def test_bounds_cut_the_distribution_off(kind: str) -> None:
    values = draws({"seed": 0, "variables": {"c": C | {"kind": kind, "lower": 15.0, "upper": 24.0}}})["soil.cohesion"]
    assert 15.0 <= values.min() < 15.05 and 23.9 < values.max() <= 24.0
    shape = np.sqrt(np.log1p(0.3**2))
    whole = stats.norm(20.0, 6.0) if kind == "normal" else stats.lognorm(shape, scale=20.0 / np.sqrt(1.0 + 0.3**2))
    low, high = whole.cdf(15.0), whole.cdf(24.0)
    assert stats.kstest(values, lambda x: (whole.cdf(x) - low) / (high - low)).pvalue > 1e-3


def test_a_draw_depends_on_its_key_and_the_seed_alone() -> None:
    both = Uncertain.model_validate(BOTH)
    turned = Uncertain.model_validate(
        {"seed": 1, "variables": {"phi": PHI, "c": C}, "correlations": [{"between": ["phi", "c"], "value": -0.5}]}
    )
    renamed = Uncertain.model_validate(
        {"seed": 1, "variables": {"a": PHI, "z": C}, "correlations": [{"between": ["a", "z"], "value": -0.5}]}
    )
    assert both.values() == turned.values() == renamed.values()
    more = Uncertain.model_validate(BOTH | {"variables": BOTH["variables"] | {"E": {**C, "of": "soil.youngs_modulus", "mean": 1e5}}})
    assert {name: more.values()[name] for name in both.values()} == both.values(), "another variable changes none"
    assert both.values() != both.model_copy(update={"seed": 2}).values()


def test_the_scene_holds_what_was_drawn() -> None:
    made = scene(BOTH, soil={"density": 1800.0})
    values = Uncertain.model_validate(BOTH).values()
    assert (made.soil.cohesion, made.soil.friction_angle) == (values["soil.cohesion"], values["soil.friction_angle"])
    assert made.soil.density == 1800.0 and made.uncertain is not None and made.uncertain.drawn == values
    label, text = uncertain_rows(made, place_particles(made))[0]
    assert label == "drawn c" and text.startswith(f"soil.cohesion = {values['soil.cohesion']:.4g} (lognormal, mean 20, cov 0.3), seed 1")
    no_deviation = scene({"seed": 5, "variables": {"c": C | {"cov": 0.0}}})
    assert no_deviation.soil == make_scene(SLOPE | {"soil": {"cohesion": 20.0}}).soil


def test_a_stored_scene_repeats_and_another_seed_draws_anew() -> None:
    made = scene(BOTH)
    assert stored_scene(made.model_dump(mode="json")) == made
    again = make_scene(merge(made.model_dump(), dotted({"uncertain.seed": 2.0})))
    assert again.soil == scene(BOTH | {"seed": 2}).soil != made.soil
    wider = make_scene(merge(made.model_dump(), dotted({"uncertain.variables.c.cov": 0.6})))
    assert wider.soil.cohesion != made.soil.cohesion and wider.soil.friction_angle == made.soil.friction_angle


def test_a_weakened_scene_keeps_its_strength_when_it_is_read_again() -> None:
    made = scene(BOTH)
    for changed in (divided_strength(made, 1.5), weakened(made, 0.25)):
        assert changed.soil.cohesion < made.soil.cohesion
        assert make_scene(changed.model_dump()).soil == changed.soil


def test_keys_of_a_layer_can_be_drawn() -> None:
    layers = {"clay": {"region": {"kind": "depth", "top": 5.0}, "soil": {"friction_angle": 0.0}}}
    made = scene({"seed": 1, "variables": {"c": C | {"of": "layers.clay.soil.cohesion"}}}, layers=layers)
    assert made.layers["clay"].soil.cohesion != made.soil.cohesion and made.layers["clay"].soil.friction_angle == 0.0


def one(**keys: Any) -> dict[str, Any]:
    return {"seed": 1, "variables": {"c": {k: v for k, v in (C | keys).items() if v is not None}}}


REFUSED = [
    (one(of="soil.cohesoin"), ["soil.cohesoin", "no such key", "cohesion"]),
    (one(of="layers.caly.soil.cohesion"), ["uncertain.variables.c.of: layers.caly.soil.cohesion", "caly"]),
    (one(of="uncertain.seed"), ["uncertain.variables.c", "uncertain.seed", "choose a key"]),
    (one(kind="beta"), ["uncertain.variables.c.kind", "lognormal"]),
    (one(cov=None), ["uncertain.variables.c", "cov, sd", "one of the two"]),
    (one(sd=3.0), ["uncertain.variables.c", "cov, sd", "one of the two"]),
    (one(mean=-1.0), ["uncertain.variables.c", "mean: -1", "positive"]),
    (one(kind="normal", mean=0.0), ["uncertain.variables.c", "cov", "write sd"]),
    (one(lower=21.0), ["uncertain.variables.c", "mean: 20", "lower: 21"]),
    (one(lower=20.0, upper=20.01), ["uncertain.variables.c", "probability", "at least 0.01"]),
    (
        one(of="soil.friction_angle", kind="normal", mean=49.9, cov=10.0, lower=49.5),
        ["soil.friction_angle", "uncertain.seed: 1 draws soil.friction_angle", "uncertain.variables.c.lower"],
    ),
    (
        {"seed": 1, "variables": {"c": C, "d": C}},
        ["uncertain", "variables.d.of: soil.cohesion is drawn by variables.c already"],
    ),
    (BOTH | {"correlations": [{"between": ["c", "psi"], "value": 0.1}]}, ["correlations.0.between", "psi", "phi"]),
    (BOTH | {"correlations": [{"between": ["c", "c"], "value": 0.1}]}, ["correlations.0.between", "itself"]),
    (BOTH | {"correlations": BOTH["correlations"] * 2}, ["correlations.1.between", "twice"]),
    (BOTH | {"correlations": [{"between": ["c", "phi"], "value": 1.0}]}, ["correlations.0.value", "less than 1"]),
    (
        {
            "seed": 1,
            "variables": {"c": C, "phi": PHI, "E": C | {"of": "soil.youngs_modulus"}},
            "correlations": [{"between": pair, "value": -0.9} for pair in (["c", "phi"], ["phi", "E"], ["c", "E"])],
        },
        ["uncertain", "correlations", "not positive definite", "choose smaller"],
    ),
    ({"variables": {"c": C}}, ["uncertain.seed", "required"]),
]


@pytest.mark.parametrize(("section", "words"), REFUSED)
def test_what_cannot_be_drawn_is_refused_by_its_key(section: dict[str, Any], words: list[str]) -> None:
    with pytest.raises(ValueError, match=r"some\.yaml") as error:
        scene(section)
    assert all(word in str(error.value) for word in words), error.value


def test_a_key_may_be_written_as_the_mean_alone() -> None:
    assert scene(one(), soil={"cohesion": 20}) == scene(one())
    with pytest.raises(ValueError, match=r"variables\.c\.of: soil\.cohesion .*20.*21\.0"):
        scene(one(), soil={"cohesion": 21.0})
