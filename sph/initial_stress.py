"""Starting from a computed stress instead of bringing gravity on.

Geostatic stress of soil at rest, elastic in plane strain and compressed vertically only, at the depth d below the ground:

    sigma_yy = -rho g d,   sigma_xx = sigma_zz = nu / (1 - nu) sigma_yy,   sigma_xy = 0.

It is in equilibrium under level ground.  Under a slope it is not (sigma_xx changes along x), and its strains do not fit together:
the gravity stage relaxes it to another stress than bringing gravity on does.
"""

from __future__ import annotations

import numpy as np

from sph.gravity import UniformStress
from sph.loading import Loading
from sph.particles import Particles
from sph.scene import Scene
from sph.state import State

NO_LOADING = Loading(*(np.zeros(1) for _ in Loading._fields))
"""Loads of a step in which nothing moves."""


def impose_stress(state: State, scene: Scene, particles: Particles, n_stressed: int) -> None:
    """Give the first ``n_stressed`` particles, those with a stress of their own, the scene's initial stress."""
    wanted = scene.gravity.initial_stress
    if isinstance(wanted, UniformStress):
        state.density[:n_stressed] = scene.soil.density * (1.0 + 1e3 * wanted.pressure / scene.soil.bulk_modulus_si)
        state.density_pairs[:] = state.density
    elif wanted == "geostatic":
        _impose_geostatic_stress(state, scene, particles, n_stressed)


def _impose_geostatic_stress(state: State, scene: Scene, particles: Particles, n_stressed: int) -> None:
    """Density and deviator of geostatic stress, in the fluid state as well where the scene starts with it.

    The depth counts from the ground vertically above; base particles continue it downwards, particles beside the box take
    the ground at the box's edge, and those above the ground have no stress.
    """
    soil = scene.soil
    surface_x, surface_y = scene.geometry.surface
    depth = np.maximum(np.interp(particles.x, surface_x, surface_y) - particles.y, 0.0)[:n_stressed]
    vertical = soil.density * scene.gravity.acceleration * depth
    ratio = soil.poisson_ratio / (1.0 - soil.poisson_ratio)
    mean = vertical * (1.0 + 2.0 * ratio) / 3.0
    state.density[:n_stressed] = soil.density * (1.0 + mean / soil.bulk_modulus_si)
    state.density_pairs[:] = state.density
    state.solid_d[:n_stressed] = 0.5 * (1.0 - ratio) * vertical
    state.solid_z[:n_stressed] = mean - ratio * vertical
    if scene.coupling.initial_state == "fluid":
        for solid, fluid in ((state.solid_d, state.fluid_d), (state.solid_q, state.fluid_q), (state.solid_z, state.fluid_z)):
            fluid[:] = solid
