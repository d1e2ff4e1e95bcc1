"""Starting from a computed stress instead of bringing gravity on.

Geostatic stress of soil at rest, elastic in plane strain and compressed vertically only, at the depth d below the ground:

    sigma_yy = -rho g d,   sigma_xx = sigma_zz = nu / (1 - nu) sigma_yy,   sigma_xy = 0;

with water these are effective stresses, and sigma_yy = -(rho g d - u) with the pore pressure u.

It is in equilibrium under level ground.  Under a slope it is not (sigma_xx changes along x), and its strains do not fit together:
the gravity stage relaxes it to another stress than bringing gravity on does.
"""

from __future__ import annotations

import numpy as np

from sph.scene.gravity import UniformStress
from sph.scene.loading import Loading
from sph.scene.schema import Scene
from sph.solver.particles import Particles, overburden
from sph.solver.physics.pore_pressure import pore_pressure
from sph.solver.state import State

NO_LOADING = Loading(*(np.zeros(1) for _ in Loading._fields))
"""Loads of a step in which nothing moves."""


def impose_stress(state: State, scene: Scene, particles: Particles, n_stressed: int) -> None:
    """Give the first ``n_stressed`` particles, those with a stress of their own, the scene's initial stress."""
    wanted = scene.gravity.initial_stress
    if isinstance(wanted, UniformStress):
        bulk_modulus = np.array([soil.bulk_modulus_si for soil in scene.soils])[particles.layer[:n_stressed]]
        state.density[:n_stressed] = scene.soil.density * (1.0 + 1e3 * wanted.pressure / bulk_modulus)
        state.density_pairs[:] = state.density
    elif wanted == "geostatic":
        _impose_geostatic_stress(state, scene, particles, n_stressed)


def _impose_geostatic_stress(state: State, scene: Scene, particles: Particles, n_stressed: int) -> None:
    """Density and deviator of geostatic stress, in the fluid state as well where the scene starts with it.

    The depth counts from the ground vertically above; base particles continue it downwards, particles beside the box take
    the ground at the box's edge, and those above the ground have no stress.
    """
    layer = particles.layer[:n_stressed]
    places = particles.x[:n_stressed], particles.y[:n_stressed]
    vertical = scene.gravity.acceleration * overburden(scene, *places)
    if scene.water is not None:
        vertical = np.maximum(vertical - pore_pressure(scene, *places), 0.0)
    ratio = np.array([soil.poisson_ratio / (1.0 - soil.poisson_ratio) for soil in scene.soils])[layer]
    mean = vertical * (1.0 + 2.0 * ratio) / 3.0
    state.density[:n_stressed] = scene.soil.density * (1.0 + mean / np.array([soil.bulk_modulus_si for soil in scene.soils])[layer])
    state.density_pairs[:] = state.density
    state.solid_d[:n_stressed] = 0.5 * (1.0 - ratio) * vertical
    state.solid_z[:n_stressed] = mean - ratio * vertical
    if scene.coupling.initial_state == "fluid":
        for solid, fluid in ((state.solid_d, state.fluid_d), (state.solid_q, state.fluid_q), (state.solid_z, state.fluid_z)):
            fluid[:] = solid
