"""Starting from a computed stress instead of bringing gravity on.

Geostatic stress of soil at rest at the depth d below the ground, the density rho summed through layers:

    sigma_yy = -rho g d,   sigma_xx = sigma_zz = K0 sigma_yy,   sigma_xy = 0;

with water these are effective stresses, and sigma_yy = -(rho g d - u) with the pore pressure u.  K0 is ``soil.K0``, which a layer may have
of its own, the same across the section as in it: of the two horizontal stresses only one is known, and level ground is alike in
both directions.  Where it is null, K0 = nu / (1 - nu), as in elastic soil that is compressed vertically only.

The peak strength of the soil has to hold K0 at every depth at which the soil lies (``check_at_rest``); where it varies in space, weak
places start on their yield surface.

It is in equilibrium under level ground.  Under a slope it is not (sigma_xx changes along x), and its strains do not fit together:
the gravity stage relaxes it to another stress than bringing gravity on does.
"""

from __future__ import annotations

import numpy as np

from sph.scene.gravity import UniformStress
from sph.scene.loading import Loading
from sph.scene.schema import Scene
from sph.scene.soil import Soil
from sph.solver.particles import Particles, peak_strength
from sph.solver.physics.pore_pressure import effective_overburden
from sph.solver.terms import State

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


def greatest_stress(scene: Scene, particles: Particles) -> list[float]:
    """Greatest vertical effective stress in each of the scene's soils, Pa; 0 in one that has no particle."""
    soil = slice(0, particles.n_soil)
    vertical = effective_overburden(scene, particles.x[soil], particles.y[soil])
    return [float(vertical[particles.layer[soil] == number].max(initial=0.0)) for number in range(len(scene.soils))]


def soils_at_greatest_stress(scene: Scene, particles: Particles) -> list[Soil]:
    """The scene's soils, those whose cohesion grows with depth with the least that any particle under the greatest stress in it has."""
    if not any(soil.gradient for soil in scene.soils):
        return list(scene.soils)
    inside = slice(0, particles.n_soil)
    vertical, layer = effective_overburden(scene, particles.x[inside], particles.y[inside]), particles.layer[inside]
    cohesion, found = peak_strength(scene, particles)[0, inside], []
    for number, soil in enumerate(scene.soils):
        there = np.flatnonzero(layer == number)
        deepest = there[np.argmax(vertical[there])] if there.size and soil.gradient else None
        held = soil if deepest is None else soil.at_depth((1e-3 * float(cohesion[deepest]) - soil.cohesion) / soil.gradient)
        found.append(held)
    return found


def check_at_rest(scene: Scene, particles: Particles) -> None:
    """ValueError for a K0 that the peak strength of its soil does not hold at the greatest effective stress in it, where cohesion helps
    least: the run would start from another stress than the scene's."""
    if all(soil.K0 is None for soil in scene.soils):
        return
    soils = soils_at_greatest_stress(scene, particles)
    for path, soil, stress in zip(scene.soil_keys, soils, greatest_stress(scene, particles), strict=True):
        if stress > 0.0:
            soil.check_at_rest(f"{path}.K0", stress, f" at its greatest vertical effective stress, {1e-3 * stress:.3g} kPa")


def _impose_geostatic_stress(state: State, scene: Scene, particles: Particles, n_stressed: int) -> None:
    """Density and deviator of geostatic stress, in the fluid state as well where the scene starts with it.

    The depth counts from the ground vertically above; base particles continue it downwards, particles beside the box take
    the ground at the box's edge, and those above the ground have no stress.
    """
    check_at_rest(scene, particles)
    layer = particles.layer[:n_stressed]
    vertical = effective_overburden(scene, particles.x[:n_stressed], particles.y[:n_stressed])
    ratio = np.array([soil.at_rest for soil in scene.soils])[layer]
    mean = vertical * (1.0 + 2.0 * ratio) / 3.0
    state.density[:n_stressed] = scene.soil.density * (1.0 + mean / np.array([soil.bulk_modulus_si for soil in scene.soils])[layer])
    state.density_pairs[:] = state.density
    state.solid_diff[:n_stressed] = 0.5 * (1.0 - ratio) * vertical
    state.solid_zz[:n_stressed] = mean - ratio * vertical
    if scene.coupling.initial_state == "fluid":
        for solid, fluid in ((state.solid_diff, state.fluid_diff), (state.solid_xy, state.fluid_xy), (state.solid_zz, state.fluid_zz)):
            fluid[:] = solid
