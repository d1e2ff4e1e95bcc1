"""Interfaces between soils of unlike strength: failed weak soil moves on stronger soil as on a no-slip wall that moves with it.

The usual sums over neighbours mix the two sides.  Strong soil beside weak soil that flows is strained by part of the velocity jump, resists
it with a strength that the weak soil does not have, and brakes it: a layer 2 m thick moved 0.66 of its way with four rows, 0.85 with eight.
Here a pair of particles of unlike soils has two weights, w_i + w_j = 2, with which each soil enters,

    L_i gains w_i (v_j - v_i) g_ij / rho_i,    a_i gains (w_i sigma_i / rho_i^2 + w_j sigma_j / rho_j^2) . g_ij.

With 1 and 1 these are the usual sums; with 2 on the weak side and 0 on the strong one they are those of a no-slip wall
(``sph.solver.boundaries.no_slip``): the weak soil takes all of the jump as its strain, and its stress is the traction.

* **Energy.**  The stress of a soil does work with the weight with which it is strained, so that forces and strain rates stay conjugate,
  whatever the weights.  They are made once a step.
* **Traction.**  It is that of the weak soil, at most its present strength.  The forces that carry a layer have the same weights as the
  shear that brakes it, so that their ratio is that of the soil at yield with any number of rows: soil that does not dilate bears
  c cos(phi) + sigma_n sin(phi) on the plane along which it shears (Davis 1968), with the effective normal stress sigma_n.
  The weights are those of effective stress; a pore pressure that soil carries along is the same on both sides and enters with 1 and 1.
  Weights of 2 and 0 would have the pressure of the lowest row, half a spacing above the interface, where friction would be too large: a
  wet layer of three rows would lose a tenth of its acceleration.  So its work is that on the plain sums (``keep_water``).
* **Slip.**  The velocity jump is shear of the rows of the weak soil beside the interface, and its plastic part counts as their slip
  (``sph.solver.physics.slip``).
* **Which soil is the weaker** say the present strengths k at the mean effective pressure of the pair, and from when on the weight of the
  solid state beta of the weaker one, which falls from 1 after its failure,

      w_i = 1 + (1 - beta) (2 k_j^4 / (k_i^4 + k_j^4) - 1).

  So nothing changes before soil fails: two elastic soils share the strain.  A step at k_i = k_j would let pairs of nearly equal strength
  change sides from step to step; with the fourth power the traction passes over smoothly, and exceeds the weaker strength by 8 % at most,
  where the other is 1.4 times as large (with the square by 21 %, with the eighth power by 4 %).

* **Time step.**  Weights of 2 double the stiffness of a row of weak soil towards its neighbours, which lowers the limit to 0.7 where the
  weak soil has the largest wave speed of the scene, and not at all where it is softer than that.  The limit is measured on the particles
  with the weights of soil that has lost its solid state, before any has.

Artificial viscosity acts across with the smaller weight: between two rows that slide it would be a drag of alpha rho V_p times their speed,
which took a tenth of the acceleration of a sliding layer.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from sph.scene.schema import Scene
from sph.solver.compiled.jit import jit
from sph.solver.compiled.records import by_reference
from sph.solver.compiled.slots import neighbours_of, slot
from sph.solver.compiled.threads import wait
from sph.solver.optional import Arrays, Term
from sph.solver.particles import Particles, overburden
from sph.solver.physics.artificial_viscosity import dissipation
from sph.solver.physics.elasticity import pressure
from sph.solver.physics.gradient_correction import transposed_shear
from sph.solver.physics.kernels import Kernel
from sph.solver.physics.material import material_of, materials_of
from sph.solver.physics.residual_viscosity import residual_dissipation
from sph.solver.physics.seams import across
from sph.solver.physics.sums import ForceSums, GradientSums

if TYPE_CHECKING:
    from sph.solver.compiled.threads import Team
    from sph.solver.neighbours import Pairs
    from sph.solver.physics.seams import Seams
    from sph.solver.terms import State, Terms

NO_SOIL = np.uint8(255)
"""Number of what has no interface: walls."""
STRENGTHLESS = 1.0
"""Pa, added to strengths, so that the ratio of two that vanish is 1."""


@by_reference
class Interface(NamedTuple):
    """Coefficients of the term, and what it keeps within a step, of soil beside an interface."""

    soil: np.ndarray
    """(particles,) uint8: number of the soil, the same for soils of the same strengths; ``NO_SOIL`` of walls"""
    cohesion: np.ndarray
    """(particles,) c cos(phi) in this step, Pa"""
    sine: np.ndarray
    """(particles,) sin(phi) in this step"""
    pressure: np.ndarray
    """(particles,) effective pressure in this step, not below 0, Pa"""
    lost: np.ndarray
    """(particles,) 1 - beta in this step"""
    opening: np.ndarray
    """(particles,) what the weights add to the sum of (v_j - v_i) . g_ij in this step, on which the water does no work"""


@slot
def alike_end(interface: Interface | None, pairs: Pairs, i: int) -> int:
    """End of the pairs of particle i whose soils weigh the same; those across an interface come after them."""
    return pairs.end[i]


@alike_end.of(Interface)
def _alike_end(interface: Interface, pairs: Pairs, i: int) -> int:
    return pairs.alike_end[i]


@slot
def part_unlike(
    interface: Interface | None,
    seams: Seams | None,
    pairs: Pairs,
    i: int,
    begin: np.uint64,
    count: np.uint64,
    row_dx: np.ndarray,
    row_dy: np.ndarray,
) -> None:
    """Put those last, among the ``count`` pairs of particle i from ``begin`` on, that lie across an interface and not across a seam."""


@part_unlike.of(Interface)
def _part_unlike(
    interface: Interface,
    seams: Seams | None,
    pairs: Pairs,
    i: int,
    begin: np.uint64,
    count: np.uint64,
    row_dx: np.ndarray,
    row_dy: np.ndarray,
) -> None:
    own, k, end = interface.soil[i], np.uint64(0), count if interface.soil[i] != NO_SOIL else np.uint64(0)
    alike = count
    while k < end:
        j = pairs.neighbour[begin + k]
        if interface.soil[j] == own or interface.soil[j] == NO_SOIL or across(seams, i, j):
            k += np.uint64(1)
        else:
            end -= np.uint64(1)
            pairs.neighbour[begin + k], pairs.neighbour[begin + end] = pairs.neighbour[begin + end], j
            row_dx[k], row_dx[end] = row_dx[end], row_dx[k]
            row_dy[k], row_dy[end] = row_dy[end], row_dy[k]
            alike = end
    pairs.alike_end[i] = begin + alike


@slot
def weigh_soils(interface: Interface | None, terms: Terms, state: State, pairs: Pairs, first: int, last: int, team: Team) -> None:
    """Note what the weights of this step are made of, for soil particles first to last beside an interface."""


@weigh_soils.of(Interface)
def _weigh_soils(interface: Interface, terms: Terms, state: State, pairs: Pairs, first: int, last: int, team: Team) -> None:
    for i in range(first, min(last, terms.n_soil)):
        if pairs.alike_end[i] < pairs.end[i]:
            soil, beta = material_of(terms.layers, terms.soil, i), state.beta[i]
            interface.cohesion[i] = beta * soil.solid.cohesion_term + (1.0 - beta) * soil.fluid.cohesion_term
            interface.sine[i] = beta * soil.solid.sine + (1.0 - beta) * soil.fluid.sine
            interface.pressure[i] = max(pressure(soil.bulk_modulus, state.density[i], terms.reference_density), 0.0)
            interface.lost[i] = 1.0 - beta
    wait(team)


class InterfaceState(NamedTuple):
    """What the term keeps of the state."""

    interface_water: np.ndarray  # (n,) pore pressure that the stress of the momentum equation holds, over density squared


def _start(scene: Scene, particles: Particles) -> InterfaceState:
    return InterfaceState(np.zeros(particles.x.size))


@slot
def keep_water(interface: Interface | None, state: State, i: int, value: float) -> float:
    """Keep the pore pressure over density squared of particle i.

    Returns the power, W/kg, that its water takes on the weighted sums of velocity differences beyond that on the plain ones.
    """
    return 0.0


@keep_water.of(Interface)
def _keep_water(interface: Interface, state: State, i: int, value: float) -> float:
    mean = 0.5 * (state.interface_water[i] + value)
    state.interface_water[i] = value
    return mean * interface.opening[i]


@jit
def weights(interface: Interface, i: int, j: int) -> tuple[float, float]:
    """Weights of the soils of particles i and j in their pair."""
    p = 0.5 * (interface.pressure[i] + interface.pressure[j])
    strength_i = interface.cohesion[i] + p * interface.sine[i] + STRENGTHLESS
    strength_j = interface.cohesion[j] + p * interface.sine[j] + STRENGTHLESS
    fourth_i, fourth_j = strength_i * strength_i * strength_i * strength_i, strength_j * strength_j * strength_j * strength_j
    lost = interface.lost[i] if strength_i < strength_j else interface.lost[j]
    weight_i = 1.0 + lost * (fourth_j - fourth_i) / (fourth_j + fourth_i)
    return weight_i, 2.0 - weight_i


@slot
def add_unlike_gradients(interface: Interface | None, terms: Terms, state: State, pairs: Pairs, i: int, sums: GradientSums) -> GradientSums:
    """Sums of velocity differences times g of particle i, and of artificial viscosity, with those of its pairs across an interface."""
    return sums


@add_unlike_gradients.of(Interface)
def _add_unlike_gradients(interface: Interface, terms: Terms, state: State, pairs: Pairs, i: int, sums: GradientSums) -> GradientSums:
    xx, xy, yx, yy, viscous_x, viscous_y = sums
    opening = 0.0
    for k in neighbours_of(pairs, pairs.alike_end[i], pairs.end[i]):
        j = pairs.neighbour[k]
        own, other = weights(interface, i, j)
        gx, gy = pairs.gx[k], pairs.gy[k]
        dvx, dvy = state.vx[j] - state.vx[i], state.vy[j] - state.vy[i]
        xx += own * dvx * gx
        xy += own * dvx * gy
        yx += own * dvy * gx
        yy += own * dvy * gy
        apart = dvx * gx + dvy * gy
        opening += (own - 1.0) * apart
        strength = dissipation(terms.artificial_viscosity, terms.layers, i, j, min(own, other) * apart, pairs.inverse_norm[k])
        viscous_x += strength * gx
        viscous_y += strength * gy
    interface.opening[i] = opening
    return GradientSums(xx, xy, yx, yy, viscous_x, viscous_y)


@slot
def add_unlike_stresses(
    interface: Interface | None, terms: Terms, state: State, pairs: Pairs, strain_rate: np.ndarray, i: int, sums: ForceSums
) -> ForceSums:
    """Sums of stresses times g of particle i, and of residual viscosity, with those of its pairs across an interface.

    Its own stress enters with its weight less 1, since the sum of g over all pairs holds it once.
    """
    return sums


@add_unlike_stresses.of(Interface)
def _add_unlike_stresses(
    interface: Interface, terms: Terms, state: State, pairs: Pairs, strain_rate: np.ndarray, i: int, sums: ForceSums
) -> ForceSums:
    ax, ay, viscous_x, viscous_y = sums
    sxx, syy, sxy = state.sxx, state.syy, state.sxy
    syx = transposed_shear(terms.gradient_correction, state, i)
    for k in neighbours_of(pairs, pairs.alike_end[i], pairs.end[i]):
        j = pairs.neighbour[k]
        own, other = weights(interface, i, j)
        gx, gy = pairs.gx[k], pairs.gy[k]
        more = own - 1.0
        u = more * state.interface_water[i] + (other - 1.0) * state.interface_water[j]
        ax += (more * sxx[i] + other * sxx[j] + u) * gx + (more * sxy[i] + other * sxy[j]) * gy
        ay += (more * syx + other * transposed_shear(terms.gradient_correction, state, j)) * gx + (more * syy[i] + other * syy[j] + u) * gy
        strength = residual_dissipation(terms.residual_viscosity, terms.layers, state, pairs, strain_rate, i, j, k)
        viscous_x += min(own, other) * (strength * gx)
        viscous_y += min(own, other) * (strength * gy)
    return ForceSums(ax, ay, viscous_x, viscous_y)


def once_lost(interface: Interface | None) -> Interface | None:
    """The term as if all soil beside an interface had lost its solid state: then it is stiffest."""
    return interface if interface is None else interface._replace(lost=np.ones_like(interface.lost))


def soil_numbers(scene: Scene) -> list[int]:
    """A number for each soil of a scene, the same for soils of which the same strengths are written.

    It does not depend on the scene's own S_R and gamma, so that runs which differ in these share what comes before the first failure.
    """
    kinds = [
        (soil.cohesion, soil.friction_angle, soil.gradient, soil.residual_cohesion, soil.residual_friction_angle, layer and layer.S_R)
        for soil, layer in zip(scene.soils, (None, *scene.layers.values()), strict=True)
    ]
    return [kinds.index(each) for each in kinds]


def _make(scene: Scene, particles: Particles, kernel: Kernel, dt: float) -> Interface:
    n, soil = particles.x.size, slice(0, particles.n_soil)
    number, cohesion, sine, vertical, layer = np.full(n, NO_SOIL), np.zeros(n), np.zeros(n), np.zeros(n), particles.layer[soil]
    number[soil] = np.array(soil_numbers(scene), np.uint8)[layer]
    # Until the first step, for the limit of the time step that is measured before it: the strengths at the start.
    fluid = scene.coupling.initial_state == "fluid"
    surfaces = [made.fluid if fluid else made.solid for made in materials_of(scene, dt)]
    cohesion[soil], sine[soil] = np.array([(each.cohesion_term, each.sine) for each in surfaces])[layer].T
    vertical[soil] = scene.gravity.acceleration * overburden(scene, particles.x[soil], particles.y[soil])
    return Interface(number, cohesion, sine, vertical, np.zeros(n), np.zeros(n))


class InterfacePairs(NamedTuple):
    """What the term keeps with the pairs."""

    alike_end: np.ndarray  # (n,) uint32, rows start[i] to alike_end[i]: pairs of soils that weigh the same


def _room(n: int, size: int, dtype: np.dtype[Any]) -> InterfacePairs:
    return InterfacePairs(np.zeros(n, np.uint32))


TERM = Term(
    "interface",
    "numerics.interfaces: weaker; soils of unlike strength",
    lambda scene: scene.numerics.interfaces == "weaker" and len(set(soil_numbers(scene))) > 1,
    _make,
    in_pairs=True,
    state=Arrays(InterfaceState, _start),
    pairs=Arrays(InterfacePairs, _room),
)
