"""Undrained soil: what pore pressure a particle keeps, by hand."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from sph.scene.configuration import merge
from sph.scene.schema import make_scene
from sph.solver.particles import place_particles
from sph.solver.physics.material import make_material
from sph.solver.physics.pore_pressure import PorePressure, carried_pressure, pore_pressure
from sph.solver.simulation import Simulation

BLOCK: dict[str, Any] = {
    "name": "block",
    "scheme": "paper",
    "duration": 5.0,
    "geometry": {"shape": "block", "width": 10.0, "height": 20.0},
    "soil": {"density": 2000.0, "cohesion": 10.0, "friction_angle": 30.0},
    "water": {"pressure": "carried", "level": 15.0},
}


def test_hydrostatic_below_the_line() -> None:
    scene = make_scene(BLOCK)
    found = pore_pressure(scene, np.full(4, 5.0), np.array([19.5, 15.0, 10.0, 0.5]))
    np.testing.assert_allclose(found, [0.0, 0.0, 5.0 * 9810.0, 14.5 * 9810.0])
    particles = place_particles(scene)
    np.testing.assert_array_equal(Simulation(scene).terms.pore_pressure.pressure, pore_pressure(scene, particles.x, particles.y))


def test_a_ratio_of_the_overburden_under_tilted_gravity() -> None:
    # The vertical depth of a layer that is tilted by 60 degrees is twice its depth across.
    scene = make_scene(merge(BLOCK, {"water": {"level": None, "r_u": 0.1}, "gravity": {"inclination": 60.0}}))
    assert pore_pressure(scene, np.array([5.0]), np.array([12.0]))[0] == pytest.approx(0.1 * 2000.0 * 9.81 * 8.0 / 0.5, rel=1e-9)


def test_it_grows_with_gravity_and_falls_as_soil_opens() -> None:
    scene = make_scene(BLOCK)
    soil = make_material(scene.materials[0], scene.coupling, 1e-3)
    apex = 10e3 / np.tan(np.radians(30.0))
    term = PorePressure(np.array([50e3]), 1.0)

    def found(beta: float, p: float, time: float = 2.0) -> float:
        return carried_pressure(term, soil, np.uint64(0), beta, p, 0.0, time)

    assert found(1.0, 80e3, 0.25) == pytest.approx(12.5e3)
    assert found(1.0, 80e3) == found(0.0, 80e3) == found(1.0, -0.99 * apex) == 50e3
    assert found(1.0, -apex - 20e3) == pytest.approx(30e3), "solid soil opens at its apex"
    assert found(0.0, -20e3) == pytest.approx(30e3), "failed soil bears no tension by default"
    assert found(0.0, -60e3) == 0.0
    assert carried_pressure(None, soil, np.uint64(0), 1.0, 80e3, 0.0, 2.0) == 0.0
