"""Soil with its state, terms and pairs before any step, for tests of single sums."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
import pytest

from sph.scene.configuration import dotted, merge
from sph.scene.schema import make_scene
from sph.solver.initial_state import initial_state
from sph.solver.particles import place_particles
from sph.solver.physics import gradient_correction, momentum  # by the module, in which tests may put the Python that is written
from sph.solver.renewal import make_lists
from sph.solver.terms import State, make_terms, only


class Placed:
    """Soil of a scene on its lattice, or off it by up to ``jitter`` (m)."""

    def __init__(self, base: Mapping[str, Any], overrides: Mapping[str, Any] | None = None, jitter: float = 0.0) -> None:
        self.scene = make_scene(merge(base, dotted(overrides or {})))
        self.particles = place_particles(self.scene)
        self.n = self.particles.n_soil
        self.state: State = initial_state(self.particles, self.scene)
        generator = np.random.default_rng(3)
        for name in ("x", "y"):
            moved = getattr(self.state, name)
            moved[: self.n] += generator.uniform(-jitter, jitter, self.n)
            for other in (f"{name}_pairs", f"{name}_candidates"):
                getattr(self.state, other)[:] = moved
        self.x, self.y = self.state.x[: self.n], self.state.y[: self.n]
        self.terms = make_terms(self.scene, self.particles)
        self.pairs: Any = make_lists(self.state, self.terms)[1]
        self.plain = only(self.terms, "gradient_correction", "no_slip", "contact")
        self.gradient = np.zeros((4, self.state.x.size))

    def strain(self) -> np.ndarray:
        """Velocity gradients (4, soil) of the plain sums, 1/s: xx, xy, yx, yy."""
        momentum.velocity_gradients(self.state, self.pairs, self.plain, self.gradient, 0, self.state.x.size)
        return self.gradient[:, : self.n] / self.state.density[: self.n]

    def accelerate(self) -> None:
        """The accelerations of the plain sums."""
        momentum.stress_accelerations(self.state, self.pairs, self.plain, self.gradient, 0, self.n)

    def take_no_energy(self) -> None:
        """Assert that at random velocities and stresses the power of the forces is that of the stress on the strain rates."""
        generator, s = np.random.default_rng(5), self.state
        for name in ("vx", "vy", "sxx", "syy", "sxy", "syx"):
            getattr(s, name)[: self.n] = generator.normal(size=self.n)
        if self.scene.numerics.gradient_correction is None:
            s.syx[:] = s.sxy
        self.strain()
        self.accelerate()
        forces = self.terms.cell_mass * sum(float(a[: self.n] @ v[: self.n]) for a, v in ((s.ax, s.vx), (s.ay, s.vy)))
        stresses = self.terms.cell_mass * sum(
            gradient_correction.power(self.terms.gradient_correction, s, self.gradient, i) for i in range(self.n)
        )
        assert abs(forces) > 1.0
        assert forces + stresses == pytest.approx(0.0, abs=1e-11 * abs(forces))
