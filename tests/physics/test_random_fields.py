"""Random fields of strength: statistics of what is realised against the model, what a field depends on, and what the solver makes of it."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from comparison import same_bits
from scipy import stats

from sph.checks.messages import words
from sph.checks.scene import findings, uncertain_rows
from sph.command.check import check, draw
from sph.scene.schema import Scene
from sph.scene.uncertain import RandomField, Uncertain
from sph.solver.particles import peak_strength, place_particles
from sph.solver.physics.material import material_of
from sph.solver.run import run
from sph.solver.simulation import Simulation
from sph.stability.standing import divided_strength, weakened
from sph.storage import trajectory

SEEDS = 100
ERRORS = 4.0
"""Standard errors by which a statistic of the realised fields may miss that of the model."""
LENGTHS = {"horizontal_length": 10.0, "vertical_length": 2.0}
LAGS = [(0.0, 0.0), (5.0, 0.0), (10.0, 0.0), (0.0, 1.0), (0.0, 3.0), (6.0, -1.2)]
BASES = np.array([(100.0 * column, 20.0 * row) for column in range(6) for row in range(6)])
"""Places ten correlation lengths apart: what is found at them is independent."""
C: dict[str, Any] = {"of": "soil.cohesion", "kind": "lognormal", "mean": 150.0, "cov": 0.3, "field": {"model": "exponential", **LENGTHS}}
PHI = {"of": "soil.friction_angle", "kind": "normal", "mean": 20.0, "sd": 2.0, "lower": 5.0, "upper": 35.0, "field": C["field"]}


def varied(**changes: Any) -> dict[str, Any]:
    return {"seed": 1, "variables": {"c": C | changes}}


def standard_normal(scores: np.ndarray) -> None:
    count = scores.size
    assert abs(scores.mean()) < ERRORS / np.sqrt(count)
    assert abs(scores.var() - 1.0) < ERRORS * np.sqrt(2.0 / count)
    assert stats.kstest(scores, "norm").pvalue > 1e-3


@pytest.mark.parametrize("model", ["exponential", "gaussian"])
def test_mean_variance_and_correlation_over_seeds_are_those_of_the_model(model: Any) -> None:
    field = RandomField(model=model, **LENGTHS)
    x, y = (BASES[:, None, :] + np.array(LAGS)).reshape(-1, 2).T
    scores = np.array([field.scores(seed, x, y) for seed in range(SEEDS)]).reshape(-1, len(LAGS)).T
    standard_normal(scores[0])
    for (dx, dy), there in zip(LAGS, scores, strict=True):
        distance = np.hypot(dx / 10.0, dy / 2.0)
        wanted = np.exp(-distance if model == "exponential" else -(distance**2))
        found = np.corrcoef(scores[0], there)[0, 1]
        assert abs(found - wanted) <= ERRORS * (1.0 - wanted**2) / np.sqrt(there.size) + 1e-12, (dx, dy)


def test_an_interval_from_independent_places_covers_the_mean_as_often_as_it_says() -> None:
    field = RandomField(**LENGTHS)
    blocks = np.array([field.scores(seed, *BASES.T) for seed in range(2 * SEEDS)])
    half = stats.t.ppf(0.975, len(BASES) - 1) * blocks.std(axis=1, ddof=1) / np.sqrt(len(BASES))
    covered = int(np.count_nonzero(np.abs(blocks.mean(axis=1)) < half))
    low, high = stats.binom.interval(0.999, len(blocks), 0.95)
    assert low <= covered <= high


def test_two_fields_of_strength_are_correlated_place_by_place() -> None:
    section = {"seed": 0, "variables": {"c": C, "phi": PHI}, "correlations": [{"between": ["c", "phi"], "value": -0.5}]}
    settings = Uncertain.model_validate(section)
    found = [settings.model_copy(update={"seed": seed}).ratios(*BASES.T) for seed in range(SEEDS)]
    c, phi = (np.concatenate([each[name] for each in found]) for name in ("soil.cohesion", "soil.friction_angle"))
    assert abs(c.mean() - 1.0) < ERRORS * 0.3 / np.sqrt(c.size) and abs(phi.mean() - 1.0) < ERRORS * 0.1 / np.sqrt(c.size)
    assert abs(np.corrcoef(np.log(c), phi)[0, 1] + 0.5) < ERRORS * (1.0 - 0.5**2) / np.sqrt(c.size)
    shape = np.sqrt(np.log1p(0.3**2))
    standard_normal(np.log(c) / shape + 0.5 * shape)


def test_a_field_is_one_of_the_ground_whatever_the_particles(small_slope: Any) -> None:
    found: list[dict[tuple[float, float], float]] = []
    for spacing in (5.0, 5.0 / 3.0):
        scene = small_slope({"uncertain": varied(field={"model": "gaussian", **LENGTHS}), "numerics.spacing": spacing})
        particles = place_particles(scene)
        soil = zip(particles.x.round(6), particles.y.round(6), peak_strength(scene, particles)[0], strict=True)
        found.append({(x, y): c for x, y, c in list(soil)[: particles.n_soil]})
    shared = found[0].keys() & found[1].keys()
    coarse, fine = (np.array([each[place] for place in shared]) for each in found)
    assert len(shared) > 50 and np.ptp(coarse) > 0.5 * coarse.mean()
    # The ground is looked up a ten-thousandth of a spacing beside the particle, of a correlation length of 2 m.
    np.testing.assert_allclose(fine, coarse, rtol=0.01)


def test_particles_have_the_strength_of_their_place_in_both_states(small_slope: Any) -> None:
    layers = {"clay": {"region": {"kind": "depth", "bottom": 8.0}, "soil": {"friction_angle": 5.0}, "S_R": 0.5}}
    section = {"seed": 1, "variables": {"c": C | {"of": "layers.clay.soil.cohesion"}}}
    scene = small_slope({"layers": layers, "uncertain": section, "coupling.S_R": 0.1})
    simulation = Simulation(scene)
    terms, particles = simulation.terms, simulation.particles
    cohesion, friction = peak_strength(scene, particles)
    clay = particles.layer == 1
    assert np.ptp(cohesion[clay]) > 1e4 and not np.ptp(cohesion[~clay]) and set(friction[clay]) == {np.radians(5.0)}
    for i in range(0, particles.x.size, 7):
        found, ratio = material_of(terms.layers, terms.soil, i), 0.5 if clay[i] else 0.1
        for state, kept in ((found.solid, 1.0), (found.fluid, ratio)):
            assert state.cohesion_term == pytest.approx(kept * cohesion[i] * np.cos(kept * friction[i]), rel=1e-12)
            assert state.sine == pytest.approx(np.sin(kept * friction[i]), rel=1e-12)
    for changed, factor in ((divided_strength(scene, 2.0), 0.5), (weakened(scene, 0.1), np.where(clay, 0.5, 0.1))):
        np.testing.assert_allclose(peak_strength(changed, particles)[0], factor * cohesion, rtol=1e-12)


@pytest.mark.long
def test_a_field_without_variance_changes_nothing_but_the_rounding(small_slope: Any) -> None:
    """A field is compiled with a table of one row a particle, so its sums may be rounded otherwise, as the processor has it; the
    difference grows as debris is stirred."""
    scenes = [small_slope({"uncertain": varied(cov=0.0)}), small_slope({})]
    flat_strength, plain_strength = (peak_strength(scene, place_particles(scene)) for scene in scenes)
    np.testing.assert_array_equal(flat_strength, plain_strength)
    flat, plain = (run(scene).trajectory for scene in scenes)
    assert plain["failed_fraction"][-1] > 0.3
    for name in ("x", "y", "stress_xx", "density", "t_f"):
        np.testing.assert_allclose(flat[name].values[:8], plain[name].values[:8], rtol=1e-5, atol=1e-6)


@pytest.mark.long
def test_a_run_that_goes_on_keeps_its_field_and_another_seed_is_another_slope(small_slope: Any, tmp_path: Path) -> None:
    scene = small_slope({"uncertain": varied()})
    whole, pre_failure = run(scene), run(scene, until="first_failure")
    trajectory.write(tmp_path / "pre_failure.nc", pre_failure.trajectory, pre_failure.restart)
    same_bits(run(scene, restart=tmp_path / "pre_failure.nc"), whole)
    other = small_slope({"uncertain": varied() | {"seed": 2}})
    assert not np.array_equal(run(other).trajectory["displacement_x"], whole.trajectory["displacement_x"])
    with pytest.raises(ValueError, match=r"uncertain\.seed: 1 .*2"):
        run(other, restart=tmp_path / "pre_failure.nc")


def test_summary_finding_and_map_of_a_field(small_slope: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    # Without the search for slip surfaces, which sums the field at 120 of them: 47 s.
    monkeypatch.setattr("sph.command.check.found_equilibrium", lambda scene: None)
    scene: Scene = small_slope({"uncertain": varied()})
    particles = place_particles(scene)
    cohesion = peak_strength(scene, particles)[0, : particles.n_soil] / 1e3
    [(label, text)] = uncertain_rows(scene, particles)
    assert label == "drawn c" and f"{cohesion.min():.4g} to {cohesion.max():.4g}, mean {cohesion.mean():.4g}" in text
    assert "exponential over 10 by 2 m" in text
    [found] = [each for each in findings(scene, particles) if each.code == "short-correlation"]
    assert found.counts and "2 m" in words(found).measured and f"{2 * scene.numerics.smoothing_length:.3g} m" in words(found).wanted
    longer = small_slope({"uncertain": varied(field={"horizontal_length": 50.0, "vertical_length": 2 * scene.numerics.smoothing_length})})
    assert "short-correlation" not in {each.code for each in findings(longer)}
    _, shown, scale = draw([check(scene)]).axes
    assert scale.get_xlabel() == "peak cohesion (kPa)" and shown.get_aspect() == 1.0
    assert scale.get_xlim() == pytest.approx((cohesion.min(), cohesion.max()))


WIDTH = 103.43375672974065
"""Of the paper's slope, m."""
REFUSED = [
    ({"uncertain": varied(of="soil.density")}, ["uncertain.variables.c", "field: soil.density", "soil.cohesion"]),
    ({"uncertain": varied(kind="normal")}, ["uncertain.variables.c", "lower", "at least 0"]),
    ({"uncertain": varied(of="soil.friction_angle", mean=20.0)}, ["uncertain.variables.c", "upper", "50 degrees"]),
    ({"uncertain": varied(field={"horizontal_length": 5.0, "vertical_length": 0.0})}, ["field.vertical_length", "greater than 0"]),
    ({"uncertain": varied(), "walls.sides": "periodic", "numerics.spacing": WIDTH / 20}, ["walls.sides: periodic", "soil.cohesion"]),
    (
        {"uncertain": {"seed": 1, "variables": {"phi": PHI}}, "soil.dilation_angle": 8.0},
        ["soil.friction_angle", "dilation angle, 8", "lower"],
    ),
    (
        {
            "uncertain": {
                "seed": 1,
                "variables": {"c": C, "phi": {**PHI, "field": None}},
                "correlations": [{"between": ["c", "phi"], "value": -0.5}],
            }
        },
        ["correlations.0.between", "same field"],
    ),
]


@pytest.mark.parametrize(("overrides", "words"), REFUSED)
def test_a_field_that_makes_no_sense_is_refused(small_slope: Any, overrides: dict[str, Any], words: list[str]) -> None:
    with pytest.raises(ValueError) as error:
        small_slope(overrides)
    assert all(word in str(error.value) for word in words), error.value
