"""Options of general scenes: refused with key and value where they make no sense, compiled only where wanted, right at the start."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from small_scenes import TWO_BODIES

from sph.scene.configuration import dotted, flat, merge
from sph.scene.schema import Scene, load_scene, make_scene, stored_scene
from sph.scene.scheme import RESOLVED
from sph.scene.walls import KINDS
from sph.solver.initial_state import initial_state
from sph.solver.particles import place_particles
from sph.solver.physics.coupling import cauchy_stress
from sph.solver.simulation import Simulation
from sph.solver.state import FAILED, HELD, UNARMED
from sph.solver.terms import KEYS, active_terms, make_terms, wanted_terms

BOX: dict[str, Any] = {
    "scheme": "paper",
    "name": "box",
    "duration": 2.0,
    "geometry": {"shape": "block", "width": 6.0, "height": 4.0},
    "walls": {"layers": 3},
    "gravity": {"ramp": 0.5, "duration": 1.0},
    "damping": None,
    "coupling": {"solid_after_failure": "elastic_plastic"},
    "numerics": {
        "spacing": 0.5,
        "smoothing_ratio": 1.3,
        "time_step": 1e-4,
        "artificial_viscosity": None,
        "short_range_repulsion": None,
    },
}
"""A scene without a single optional term; fixed walls are none."""
SLIP = {"walls.base": "free_slip"}
ABSORBING = {"walls.base": "absorbing"}
VELOCITY = {"along": "y", "position": [0.0, 1.0, 4.0], "x": [0.0, 2.0, -1.0], "y": [1.0, 1.0, 0.0]}
POLYGON, RING = TWO_BODIES["bodies"]
RECORD = {"kind": "record", "start": 1.0, "vertical": {}, "data": {"interval": 0.1, "x": [0.0, 1.0, -1.0], "y": [0.5, 0.5, 0.0]}}


def box(overrides: dict[str, Any]) -> Scene:
    return make_scene(merge(BOX, dotted(overrides)), "some.yaml")


def bodies(*changed: dict[str, Any], **box_keys: Any) -> dict[str, Any]:
    return {"geometry": TWO_BODIES | {"bodies": list(changed) or [POLYGON, RING]} | box_keys}


BAD = [
    # override, and the words its error must hold: key as written, value, what is allowed
    (bodies(width=-1.0), ["geometry.width: ", "-1.0", "greater than 0"]),
    (bodies({}), ["geometry.bodies.0", "kind"]),
    ({"geometry": TWO_BODIES | {"bodies": []}}, ["geometry.bodies: ", "at least 1", "[]"]),
    (bodies({"kind": "cone"}), ["geometry.bodies.0.kind: ", "cone", "polygon", "ring"]),
    (bodies(POLYGON | {"points": [[0, 0], [1, 1]]}), ["geometry.bodies.0.points: ", "at least 3", "[[0, 0], [1, 1]]"]),
    (bodies(RING, POLYGON | {"points": [[0, 0], [1, "a"], [2, 2]]}), ["geometry.bodies.1.points.1.1: ", "'a'", "number"]),
    (bodies(POLYGON, RING | {"outer_radius": 0}), ["geometry.bodies.1.outer_radius: ", "found 0", "greater than 0"]),
    (bodies(RING | {"inner_radius": 1.5}), ["geometry.bodies.0: ", "inner_radius: 1.5", "outer_radius: 1.5", "smaller"]),
    (bodies(RING | {"colour": 1}), ["geometry.bodies.0.colour: ", "no such key"]),
    (bodies({"kind": "ring", "centre": [0, 0]}), ["geometry.bodies.0.outer_radius: ", "required"]),
    ({"walls.top": "wet"}, ["walls.top: ", "wet", "fixed", "free_slip", "none"]),
    ({"walls.top": "periodic"}, ["walls.top: ", "periodic"]),
    (SLIP | {"walls.layers": 1}, ["walls.layers: 1", "needs 2", "1.3 m"]),
    ({"walls.top": "free_slip", "walls.layers": 1}, ["walls.layers: 1", "needs 2"]),
    (SLIP | {"walls.friction": {"base": -0.1}}, ["walls.friction.base: ", "-0.1", "greater than or equal to 0"]),
    ({"walls.friction": {"base": 0.3}}, ["walls.friction.base: 0.3", "free_slip"]),
    (SLIP | {"walls.friction": {"sides": 0.4}}, ["walls.friction.sides: 0.4", "free_slip"]),
    ({"walls.sides": "periodic", "walls.friction": {"sides": 0.4}}, ["walls.friction.sides: 0.4", "free_slip"]),
    ({"walls.bedrock": {"density": 2e3, "s_wave_speed": 1e3, "p_wave_speed": 2e3}}, ["walls.bedrock: ", "walls.base: absorbing", "fixed"]),
    (ABSORBING | {"walls.bedrock": {"density": 2e3}}, ["walls.bedrock.s_wave_speed: ", "required"]),
    (
        ABSORBING | {"walls.bedrock": {"density": 2e3, "s_wave_speed": 1e3, "p_wave_speed": 1.1e3}},
        ["walls.bedrock: ", "p_wave_speed: 1100.0 m/s", "s_wave_speed: 1000.0 m/s"],
    ),
    (ABSORBING | {"walls.layers": 1}, ["walls.layers: 1", "walls.base: absorbing", "needs 2"]),
    (ABSORBING | {"walls.top": "fixed"}, ["walls.top: fixed", "walls.base: absorbing", "none"]),
    (ABSORBING | {"prescribed_velocity_gradient": {"xy": 0.1}}, ["prescribed_velocity_gradient: ", "walls.base: absorbing"]),
    (
        {"walls.sides": "absorbing", "motion": {"kind": "constant", "amplitude": 1.0, "start": 1.0, "ramp": 0.0}},
        ["motion.kind: constant", "walls.sides: absorbing"],
    ),
    ({"walls.sides": "absorbing", "walls.base": "none"}, ["walls.base: none", "walls.sides: absorbing", "contact or absorbing"]),
    ({"walls.sides": "absorbing", "walls.base": "free_slip", "walls.layers": 2}, ["walls.base: free_slip", "walls.sides: absorbing"]),
    ({"walls.sides": "absorbing", "coupling.initial_state": "fluid"}, ["coupling.initial_state: fluid", "walls.sides: absorbing"]),
    ({"walls.sides": "periodic", "geometry.width": 6.1}, ["geometry.width: 6.1 m", "multiple", "numerics.spacing (0.5 m)"]),
    ({"walls.sides": "periodic", "geometry.width": 2.5}, ["geometry.width: 2.5 m", "twice the kernel's reach", "2.9 m"]),
    ({"gravity.inclination": 90.5}, ["gravity.inclination: ", "90.5", "less than or equal to 90"]),
    (
        {"gravity.inclination": 10.0, "gravity.ramp": 0.0, "gravity.initial_stress": "geostatic"},
        ["gravity.inclination: 10.0", "geostatic"],
    ),
    ({"gravity.initial_stress": {"pressure": 1e9}}, ["gravity.initial_stress.pressure: ", "1000000000.0", "less than or equal to 1000000"]),
    ({"gravity.initial_stress": {"presure": 1}}, ["gravity.initial_stress.presure: ", "no such key"]),
    ({"gravity.initial_stress": "wet"}, ["gravity.initial_stress: ", "'wet'", "none", "geostatic"]),
    ({"coupling.initial_state": "gas"}, ["coupling.initial_state: ", "gas", "solid", "fluid"]),
    ({"initial_velocity": VELOCITY | {"along": "z"}}, ["initial_velocity.along: ", "'z'"]),
    ({"initial_velocity": VELOCITY | {"x": [1.0]}}, ["initial_velocity: x: 1 velocities for 3 places"]),
    ({"initial_velocity": VELOCITY | {"y": [1.0] * 4}}, ["initial_velocity: y: 4 velocities for 3 places"]),
    ({"initial_velocity": VELOCITY | {"position": [0.0, 1.0, 1.0]}}, ["initial_velocity: position", "[0.0, 1.0, 1.0]", "increase"]),
    ({"initial_velocity": VELOCITY | {"position": [], "x": [], "y": []}}, ["initial_velocity.position: ", "at least 1", "[]"]),
    ({"prescribed_velocity_gradient": {"xx": 1e5}}, ["prescribed_velocity_gradient.xx: ", "100000", "less than or equal to 10000"]),
    ({"prescribed_velocity_gradient": {"zz": 1.0}}, ["prescribed_velocity_gradient.zz: ", "no such key"]),
    ({"numerics.artificial_stress": {"factor": 0.0}}, ["numerics.artificial_stress.factor: ", "0.0", "greater than 0"]),
    ({"numerics.artificial_stress": {"exponent": 0.5}}, ["numerics.artificial_stress.exponent: ", "0.5", "greater than or equal to 1"]),
    ({"motion": {"kind": "ricker", "amplitude": 1.0, "frequency": 0.0, "peak": 1.5}}, ["motion.frequency: ", "0.0", "greater than 0"]),
    ({"motion": {"kind": "ricker", "amplitude": 1.0, "frequency": 3.0, "peak": 1.4}}, ["motion.peak", "0.9 s", "gravity.duration: 1.0 s"]),
    ({"motion": {"kind": "constant", "amplitude": 1.0, "start": 0.9, "ramp": 0.5}}, ["motion.start: 0.9 s", "gravity.duration: 1.0 s"]),
    ({"motion": {"kind": "constant", "amplitude": 1.0, "start": 1.0}}, ["motion.ramp: ", "required"]),
]


@pytest.mark.parametrize(("overrides", "words"), BAD, ids=lambda v: ",".join(v) if isinstance(v, dict) else v[0])
def test_bad_input_is_named(overrides: dict[str, Any], words: list[str]) -> None:
    with pytest.raises(ValueError) as raised:
        box(overrides)
    message = str(raised.value)
    for word in ["some.yaml", *words]:
        assert word in message, f"{word!r} is missing in: {message}"


def test_one_bad_corner_is_one_line() -> None:
    # No line about a list that is 'too short' only because its bad item does not count, none with a name the user did not write.
    with pytest.raises(ValueError) as raised:
        box(bodies(POLYGON | {"points": [[0, 0], [1, "a"], [2, 2]]}))
    assert len(str(raised.value).splitlines()) == 1
    with pytest.raises(ValueError) as raised:
        box({"gravity.initial_stress": "wet"})
    assert all(line.startswith("some.yaml: gravity.initial_stress: ") for line in str(raised.value).splitlines())


@given(frequency=st.integers(1, 40), duration=st.integers(1, 300))
def test_a_wavelet_may_start_when_the_gravity_stage_ends(frequency: int, duration: int) -> None:
    # 'at least 1.5 / frequency after the gravity stage': exactly that is allowed, whatever the rounding of the sum.
    end = duration / 100
    motion = {"kind": "ricker", "amplitude": 1.0, "frequency": frequency, "peak": end + 1.5 / frequency}
    scene = box({"duration": 4.0, "gravity.ramp": 0.0, "gravity.duration": end, "motion": motion})
    assert scene.motion.kind == "ricker"


EVERYTHING = SLIP | {
    "geometry": TWO_BODIES,
    "walls.top": "free_slip",
    "walls.sides": "periodic",
    "walls.friction": {"base": 0.3},
    "gravity.inclination": -12.5,
    "gravity.initial_stress": {"pressure": 50.0},
    "coupling.initial_state": "fluid",
    "initial_velocity": VELOCITY,
    "prescribed_velocity_gradient": {"xy": 0.1},
    "numerics.artificial_stress": {},
    "motion": {"kind": "ricker", "amplitude": 1.0, "frequency": 3.0, "peak": 1.5},
}


def test_a_scene_with_every_option_survives_json() -> None:
    # A trajectory holds its scene as JSON; a restart compares with it.
    scene = box(EVERYTHING)
    assert Scene.model_validate_json(scene.model_dump_json()) == scene
    assert make_scene(json.loads(scene.model_dump_json())) == scene


# ---------------------------------------------------------------- terms

TERM_OPTIONS = {
    "free_slip": [SLIP, {"walls.top": "free_slip"}, {"walls.sides": "free_slip"}],
    "wall_friction": [{"walls.friction": {}}],
    "periodic": [{"walls.sides": "periodic"}],
    "artificial_stress": [{"numerics.artificial_stress": {}}],
    "prescribed_motion": [{"prescribed_velocity_gradient": {}}],
    "layers": [{"layers": {"cover": {"region": {"kind": "depth"}}}}],
    "absorbing_walls": [ABSORBING, ABSORBING | {"walls.bedrock": {"density": 2e3, "s_wave_speed": 1e3, "p_wave_speed": 2e3}}],
    "absorbing_walls free_field": [{"walls.sides": "absorbing"}, ABSORBING | {"walls.sides": "absorbing"}],
    "absorbing_walls free_field no_slip": [{"walls.sides": "absorbing", "walls.base": "no_slip"}],
}
FREE = [
    {},
    {"walls.top": "fixed"},
    {"walls.base": "none", "walls.sides": "none"},
    {"gravity.inclination": 30.0},
    {"gravity.initial_stress": {"pressure": 10.0}},
    {"coupling.initial_state": "fluid"},
    {"initial_velocity": VELOCITY},
    {"motion": {"kind": "constant", "amplitude": 1.0, "start": 1.0, "ramp": 0.0}},
    {"motion": {"kind": "velocity_pulse", "amplitude": 1.0, "frequency": 2.0, "start": 1.0}},
    {"motion": RECORD},
    {"geometry": TWO_BODIES},
]
"""Options that are no term of the solver's loops."""


@pytest.mark.parametrize(
    ("name", "overrides"),
    [("", o) for o in FREE] + [(name, o) for name, all_of in TERM_OPTIONS.items() for o in all_of],
    ids=lambda v: ",".join(v) if isinstance(v, dict) else v or "none",
)
def test_a_term_is_compiled_only_where_it_is_asked_for(name: str, overrides: dict[str, Any]) -> None:
    # What the scene wants, what the pack of terms holds and what a function compiled for that pack reports are the same.
    scene = box(overrides)
    terms = make_terms(scene, place_particles(scene))
    expected = set(name.split()) | ({"wall_faces"} if any(kind.stands for kind in scene.walls.kinds) else set())
    assert {n for n, on in wanted_terms(scene).items() if on} == expected
    assert {n for n, on in zip(KEYS, active_terms(terms), strict=True) if on} == expected


# ---------------------------------------------------------------- the start


def test_initial_velocity_between_and_beyond_the_places() -> None:
    # Rows at y = 0.25, 0.75, ..., 3.75; the table is linear between y = 0, 1 and 4: by hand, exact to rounding.
    scene = box({"initial_velocity": VELOCITY})
    particles = place_particles(scene)
    state, n = initial_state(particles, scene), particles.n_soil
    y = particles.y[:n]
    np.testing.assert_allclose(state.vx[:n], np.where(y < 1, 2 * y, 2 - (y - 1)), atol=1e-14)
    np.testing.assert_allclose(state.vy[:n], np.where(y < 1, 1, (4 - y) / 3), atol=1e-14)
    assert not state.vx[n:].any() and not state.vy[n:].any(), "the box stands still"
    short = box({"initial_velocity": {"along": "x", "position": [2.0, 4.0], "x": [-1.0, 1.0], "y": [0.0, 0.5]}})
    state, x = initial_state(particles, short), particles.x[:n]
    np.testing.assert_allclose(state.vx[:n], np.clip(x - 3, -1, 1), atol=1e-14)
    np.testing.assert_allclose(state.vy[:n], np.clip(0.25 * (x - 2), 0, 0.5), atol=1e-14)


@pytest.mark.parametrize("walls", [{}, SLIP], ids=["fixed", "free_slip"])
@pytest.mark.parametrize("kPa", [100.0, -20.0, 0.0])
def test_uniform_stress_is_the_stress_at_the_start(kPa: float, walls: dict[str, Any]) -> None:
    # Through density and back: rounding of the density, 2e-16 of K = 1.8 GPa, is 4e-7 Pa.
    simulation = Simulation(box(walls | {"gravity.initial_stress": {"pressure": kPa}}))
    stress = np.empty((simulation.state.x.size, 4))
    cauchy_stress(simulation.state, simulation.terms, stress)
    held = simulation.terms.n_stressed
    np.testing.assert_allclose(stress[:held, :3], -1e3 * kPa, atol=2e-6)
    assert not stress[:, 3].any()
    np.testing.assert_allclose(stress[held:], 0.0, atol=2e-6, err_msg="free-slip walls have no stress of their own")


def test_a_fluid_has_failed_long_before_the_start() -> None:
    scene = box({"coupling.initial_state": "fluid"})
    state = initial_state(place_particles(scene), scene)
    assert np.all(state.phase == FAILED) and not state.beta.any() and not state.t_f.any()
    solid = box({})
    state = initial_state(place_particles(solid), solid)
    assert {*state.phase.tolist()} == {UNARMED, HELD} and np.all(state.beta == 1.0) and np.isnan(state.t_f).all()


def test_geostatic_stress_of_a_fluid() -> None:
    # sigma_yy = -rho g d and sigma_xx = nu / (1 - nu) sigma_yy as for a solid, to the rounding of the density.
    scene = box({"coupling.initial_state": "fluid", "gravity.ramp": 0.0, "gravity.initial_stress": "geostatic"})
    simulation = Simulation(scene)
    stress = np.empty((simulation.state.x.size, 4))
    cauchy_stress(simulation.state, simulation.terms, stress)
    n, ratio = simulation.particles.n_soil, scene.soil.poisson_ratio / (1 - scene.soil.poisson_ratio)
    weight = scene.soil.density * 9.81 * (4.0 - simulation.particles.y[:n])
    np.testing.assert_allclose(stress[:n, 1], -weight, atol=2e-6)
    np.testing.assert_allclose(stress[:n, 0], -ratio * weight, atol=2e-6)


def test_stored_runs_may_call_fixed_walls_sticky_and_scenes_may_not() -> None:
    stored = merge(make_scene(BOX).model_dump(mode="json"), {"walls": {"sides": "sticky", "base": "sticky", "top": "none"}})
    assert stored_scene(stored).walls.kinds[:2] == (KINDS["fixed"], KINDS["fixed"])
    with pytest.raises(ValueError, match=r"walls\.sides: .*'fixed'.*\(found 'sticky'\)"):
        make_scene(merge(BOX, {"walls": {"sides": "sticky"}}))


def test_a_run_stored_before_the_law_of_interfaces_repeats_without_it() -> None:
    own = load_scene(Path(__file__).parents[2] / "config" / "scenes" / "slope_on_rock.yaml")
    stored = json.loads(own.stored())
    assert stored_scene(stored) == own and own.numerics.interfaces == "weaker"
    del stored["numerics"]["interfaces"]
    assert stored_scene(stored).numerics.interfaces == "both"


@pytest.mark.parametrize("name", sorted(set(flat(RESOLVED)) - {"numerics.smoothing_ratio"}))  # whose paper's value needs thicker walls
def test_the_scheme_fills_in_nothing_that_a_stored_scene_lacks(name: str) -> None:
    """A file has all keys of its version; one that the scheme has set since then was not in force when it was written."""
    own = load_scene(Path(__file__).parents[2] / "config" / "scenes" / "slope_on_rock.yaml")
    assert make_scene(json.loads(own.stored())) == own, "else the key would be filled in"
    stored = json.loads(own.stored())
    *sections, key = name.split(".")
    at = stored
    for section in sections:
        at = at[section]
    del at[key]
    as_in_paper = stored_scene(stored | {"scheme": "paper"}).model_copy(update={"scheme": "resolved"})
    assert stored_scene(stored) == as_in_paper
