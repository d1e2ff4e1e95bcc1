"""The coefficients of a run: everything that does not change, one small immutable pack of numbers.

``TERMS`` lists the optional terms; from it follow the fields of ``Terms``, their limits of the time step, what ``sph info`` tells of them,
and the check that the compiled variant holds what the scene wants.  ``add_forces`` is where those act that are forces.
"""

from __future__ import annotations

import math
from collections import namedtuple
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numba.extending import overload

from sph.scene.schema import Scene
from sph.solver.boundaries import contact, dashpots, faces, free_field, free_slip, friction, no_slip, periodic
from sph.solver.boundaries.faces import push_from_faces
from sph.solver.compiled.jit import jit
from sph.solver.compiled.records import by_reference
from sph.solver.compiled.slots import fields_of, records_in
from sph.solver.optional import Term
from sph.solver.particles import Particles
from sph.solver.physics import (
    artificial_stress,
    artificial_viscosity,
    cyclic_pore_pressure,
    dilation,
    failed_solid,
    gradient_correction,
    initial_arrangement,
    interface,
    material,
    pore_pressure,
    prescribed_motion,
    rayleigh_damping,
    residual_viscosity,
    seams,
    seepage,
    short_range_repulsion,
    slip,
)
from sph.solver.physics.artificial_stress import add_artificial_stress
from sph.solver.physics.kernels import KERNELS, Kernel, central_value, kernel_of
from sph.solver.physics.material import FLUID_LAWS, STRENGTH_LOSSES, Material, loss_of, make_material
from sph.solver.physics.short_range_repulsion import add_repulsion
from sph.solver.state import Core

if TYPE_CHECKING:
    from sph.solver.neighbours import Pairs

TERMS: tuple[Term, ...] = (
    rayleigh_damping.TERM,
    artificial_viscosity.TERM,
    gradient_correction.TERM,
    short_range_repulsion.TERM,
    free_slip.TERM,
    faces.TERM,
    friction.TERM,
    periodic.TERM,
    artificial_stress.TERM,
    prescribed_motion.TERM,
    material.TERM,
    dashpots.TERM,
    free_field.TERM,
    no_slip.TERM,
    contact.TERM,
    seepage.TERM,
    pore_pressure.TERM,
    cyclic_pore_pressure.TERM,
    residual_viscosity.TERM,
    dilation.TERM,
    slip.TERM,
    seams.TERM,
    failed_solid.TERM,
    interface.TERM,
    initial_arrangement.TERM,
)


class Always(NamedTuple):
    """Coefficients that every run has."""

    zero: np.floating[Any]  # of the type in which kernel gradients are kept
    dt: float
    down_x: float  # direction of gravity
    down_y: float
    n_soil: int
    n_moving: int  # the soil and the boundary particles that follow it
    n_stressed: int  # particles with a stress of their own; no-slip and free-slip walls have none
    n_failing: int  # particles that can fail: with absorbing walls, whose particles stand for soil far away, the soil alone
    armed_from: float  # s, half a step before the end of the gravity stage
    pairs_tolerance: float  # m
    candidates_tolerance: float  # m
    reach: float  # support and skin, m
    close_range: float  # range of short-range forces and the tolerance, m
    reference_density: float
    least_density: float  # of a particle without neighbours, m W(0): scattered soil is not thinner
    cell_mass: float  # of the scene's own soil in the room of a particle, kg for a metre of thickness
    gradient_mass: float  # that times the scale of the kernel's gradient
    soil: Material
    kernel: Kernel


if TYPE_CHECKING:

    class Terms(Always):
        """``Always``, and the record or None of every optional term by its name."""

        def __getattr__(self, name: str) -> Any: ...
        def _replace(self, **changes: Any) -> Terms: ...
else:
    Terms = by_reference(namedtuple("Terms", (*Always._fields, *(term.name for term in TERMS))))


if TYPE_CHECKING:

    class State(Core):
        """``Core``, and the arrays that the optional terms keep."""

        def __getattr__(self, name: str) -> Any: ...
        def _replace(self, **changes: Any) -> State: ...
else:
    State = by_reference(
        namedtuple("State", (*Core._fields, *(name for term in TERMS if term.state for name in term.state.record._fields)))
    )


def own_state(scene: Scene, particles: Particles) -> dict[str, np.ndarray]:
    """The arrays of the state that terms keep, by name, at the start; those of terms that the scene does not want are empty."""
    found: dict[str, np.ndarray] = {}
    for term in TERMS:
        if term.state is not None:
            arrays, wanted = term.state.make(scene, particles)._asdict(), term.wanted(scene)
            found |= {name: array if wanted else array[..., :0].copy() for name, array in arrays.items()}
    return found


def restart_dims() -> dict[str, tuple[str, ...]]:
    """Names of the dimensions of what terms keep in the state, by the names of the arrays."""
    return {name: term.state.dims for term in TERMS if term.state is not None for name in term.state.record._fields}


def make_terms(scene: Scene, particles: Particles, substeps: int = 1) -> Terms:
    """``Terms`` of a scene whose time step is divided by ``substeps``; all floats, so that one scene compiles one variant."""
    soil, numerics = scene.soil, scene.numerics
    dt, dx = numerics.time_step / substeps, numerics.spacing
    kernel = kernel_of(scene)
    tilt = math.radians(scene.gravity.inclination)
    skin = numerics.neighbour_skin * dx
    pairs_tolerance = numerics.gradient_tolerance * dx
    repulsion = numerics.short_range_repulsion
    always = Always(
        zero=np.float32(0) if numerics.precision == "mixed" else np.float64(0),
        dt=float(dt),
        down_x=-math.sin(tilt),
        down_y=-math.cos(tilt),
        n_soil=particles.n_soil,
        n_moving=particles.first_fixed,
        n_stressed=particles.first_no_slip,
        n_failing=particles.n_soil if any(kind.absorbs for kind in scene.walls.kinds) else particles.first_no_slip,
        armed_from=float(scene.gravity.duration - 0.5 * dt),
        pairs_tolerance=float(pairs_tolerance),
        candidates_tolerance=float(0.5 * skin),
        reach=float(2.0 * numerics.smoothing_length + skin),
        close_range=0.0 if repulsion is None else float(repulsion.range * dx + 2.0 * pairs_tolerance),
        reference_density=float(soil.density),
        least_density=float(soil.density * dx * dx * central_value(kernel)),
        cell_mass=float(soil.density * dx * dx),
        gradient_mass=float(soil.density * dx * dx) * kernel.gradient_scale,
        soil=make_material(scene.materials[0], scene.coupling, dt),
        kernel=kernel,
    )
    return Terms(*always, *(term.make(scene, particles, kernel, dt) if term.wanted(scene) else None for term in TERMS))


def only(terms: Terms, *names: str) -> Terms:
    """Terms without the optional ones but these: a function that needs no other is then not compiled again for every variant."""
    return terms._replace(**{term.name: None for term in TERMS if term.name not in names})


def of_pairs(terms: Terms) -> Terms:
    """The terms that the lists of neighbours depend on."""
    return only(terms, *(term.name for term in TERMS if term.in_pairs))


@jit
def add_forces(terms: Terms, state: State, pairs: Pairs, mass: np.ndarray, first: int, last: int) -> float:
    """Add the accelerations of optional forces to particles first to last; returns the energy that they store, J/m."""
    add_artificial_stress(terms.artificial_stress, terms.layers, state, pairs, first, last)
    energy = add_repulsion(terms.short_range_repulsion, terms.periodic, terms.seams, state, pairs, mass, terms.n_moving, first, last)
    return energy + push_from_faces(terms.wall_faces, terms.wall_friction, state, mass, first, min(last, terms.n_soil))


# ---------------------------------------------------------------- what a variant holds

_KERNELS = list(KERNELS.items())[1:]
_LAWS = list(FLUID_LAWS.items())[1:]
_LOSSES = list(STRENGTH_LOSSES.items())[1:]
KEYS = (
    dict.fromkeys((name for name, _ in _KERNELS), "numerics.kernel")
    | dict.fromkeys((name for name, _ in _LAWS), "coupling.fluid.law")
    | dict.fromkeys((f"{name} loss by slip" for name, _ in _LOSSES), "coupling.softening.slip_at_residual")
    | {term.name: term.keys for term in TERMS}
)
"""Optional terms by name, and the keys of a scene that ask for them; first the kernels and laws that can replace the paper's."""


def wanted_terms(scene: Scene) -> dict[str, bool]:
    """Which optional terms a scene asks for, by name."""
    chosen = scene.numerics.kernel, scene.coupling.fluid.law, loss_of(scene.coupling)
    replaced = [name in chosen for name, _ in (*_KERNELS, *_LAWS, *_LOSSES)]
    return dict(zip(KEYS, [*replaced, *(term.wanted(scene) for term in TERMS)], strict=True))


def _held(terms: Terms) -> tuple[bool, ...]:
    """Which the records in their slots are; compiled code asks the types that it was compiled for."""
    of, soil = records_in(terms), records_in(fields_of(terms)["soil"])
    return (
        *(of["kernel"] is record for _, record in _KERNELS),
        *(soil["fluid_law"] is known.record for _, known in _LAWS),
        *(soil["loss"] is known.record for _, known in _LOSSES),
        *(of[term.name] is not type(None) for term in TERMS),
    )


@overload(_held)
def _held_by_type(terms):  # type: ignore[no-untyped-def]
    held = _held(terms)
    return lambda terms: held


@jit
def active_terms(terms: Terms) -> tuple[bool, ...]:
    """Which optional terms the compiled code that calls this holds, in the order of ``KEYS``, by the types it was compiled for."""
    return _held(terms)
