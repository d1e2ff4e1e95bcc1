"""Slopes that do not stand without shaking, and frames that exist whatever their interval."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
import xarray as xr
from small_scenes import DRAFT, PAPER

from sph.measures.metrics import measure
from sph.scene.configuration import dotted, merge
from sph.scene.schema import Scene, load_scene
from sph.solver.initial_state import initial_state
from sph.solver.particles import place_particles
from sph.solver.run import run
from sph.solver.state import HELD, UNARMED

SLIPPING = {"walls.sides": "free_slip", "walls.layers": 4, "coupling.S_R": 0.1}


def paper(overrides: dict[str, Any]) -> Scene:
    return load_scene(PAPER, merge(DRAFT, dotted(overrides)))


@pytest.mark.long
def test_weaker_soil_that_yields_under_gravity_does_not_move_less() -> None:
    # At S_R 0.5 the debris stays clear of the front wall (34 m and more at S_R 0.1, whatever the cohesion), so that the order shows.
    runs = [run(paper({**SLIPPING, "coupling.S_R": 0.5, "soil.cohesion": cohesion})) for cohesion in (150.0, 40.0, 0.0)]
    values = [measure(result.trajectory) for result in runs]
    moved = [float(value["displacement_magnitude"]) for value in values]
    assert np.all(np.diff(moved) > 1.0), moved
    assert [result.status for result in runs] == ["complete"] + ["failed_unshaken"] * 2
    unshaken = [float(value["failed_unshaken"]) for value in values]
    assert unshaken[0] == 0.0 and np.all(np.diff(unshaken) > 0.05)
    assert "of the soil yields under gravity alone" in runs[-1].trajectory.attrs["status_reason"]
    # What moves while gravity is brought on is in the table too.
    settled = [float(value["gravity_stage_displacement"]) for value in values]
    assert settled[0] < 0.01 and settled[-1] > 0.3


@pytest.mark.long
@pytest.mark.parametrize("cohesion", [10.0, 0.0])
def test_soil_that_yields_under_gravity_loses_its_strength(cohesion: float) -> None:
    # With its full strength kept where it yields, A moved 14 m; with all of it lost, 34 m (S_R 0.1).
    value = measure(run(paper({**SLIPPING, "soil.cohesion": cohesion})).trajectory)
    assert float(value["displacement_magnitude"]) > 30.0
    assert value["status"] == "failed_unshaken"
    assert value["first_failure_time"] == pytest.approx(3.0, rel=1e-12)


def test_soil_without_strength_is_no_unfailed_slope() -> None:
    value = measure(run(paper({**SLIPPING, "soil.cohesion": 0.0, "soil.friction_angle": 0.0})).trajectory)
    assert (value["status"], value["failed_unshaken"], value["collapse_class"]) == ("failed_unshaken", 1.0, "collapse")


def test_only_fixed_sides_and_lids_hold_soil() -> None:
    for sides, held in (("fixed", True), ("free_slip", False), ("none", False)):
        scene = paper({"walls.sides": sides, "walls.layers": 4})
        particles = place_particles(scene)
        phase, soil = initial_state(particles, scene).phase, slice(0, particles.n_soil)
        support, width = 2.0 * scene.numerics.smoothing_length, scene.lattice[0] * scene.numerics.spacing
        near = np.minimum(particles.x, width - particles.x)[soil] < support
        assert np.all(phase[soil] == np.where(near & held, HELD, UNARMED))
        assert np.all(phase[particles.n_soil :] == HELD)


@pytest.fixture(scope="module")
def framed() -> Callable[[float], xr.Dataset]:
    def made(interval: float) -> xr.Dataset:
        return run(paper({"coupling.S_R": 0.25, "duration": 11.0, "outputs.frame_interval": interval})).trajectory

    return made


@pytest.mark.long
def test_the_interval_of_frames_decides_no_number(framed: Callable[[float], xr.Dataset]) -> None:
    usual = framed(0.25)
    expected = measure(usual)
    for interval, times in ((20.0, [0.0, 3.0, 10.0, 11.0]), (2.0, [0.0, 2.0, 3.0, 4.0, 6.0, 8.0, 10.0, 11.0])):
        ds = framed(interval)
        np.testing.assert_allclose(ds["time"], times)
        np.testing.assert_array_equal(ds["x"].values[-1], usual["x"].values[-1])
        found = measure(ds)
        for name in expected.keys() - {
            "wall_time",
            "particle_steps_per_second",
            "time_step_ratio",
            "reached_side_time",
        }:  # the last two are of frames
            np.testing.assert_equal(found[name], expected[name], name)
