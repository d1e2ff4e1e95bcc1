"""The state of a run: everything that changes, so that saving it saves the run (``sph.solver.terms.State``)."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

UNARMED, ARMED, FAILED, HELD, YIELDED = range(5)
"""Phases of a particle: the failure criterion does not count yet, counts, was met; it will count once the particle has come off the
surface at which a fixed wall holds it; it was met by gravity alone, and the particle fails in the step after the gravity stage."""

SHAKING, GRAVITY, INTERNAL, MASS_DAMPING, VISCOUS, WALLS, REPULSION = range(7)
"""Rows of ``State.work`` (J/m): work of the shaking (or of a prescribed motion) and of gravity and seepage on the soil, of strain on
the stress, and energy taken by mass-proportional damping, by artificial viscosity and stress, and by free-slip
walls, their friction and absorbing walls; energy stored in the short-range repulsion and in the contact with walls (a level, not a
sum).  The static reactions of absorbing walls are dead loads as gravity is, and their work counts with its."""
FAILURES = REPULSION + 1
"""Column of ``Team.sums`` after those of the works: particles that failed in the step."""


class Core(NamedTuple):
    """What every run has; arrays over all n particles unless said otherwise, SI units.  What a term keeps says its file."""

    x: np.ndarray
    y: np.ndarray
    vx: np.ndarray  # half a step behind the positions
    vy: np.ndarray
    ax: np.ndarray  # acceleration by stress, repulsion and artificial viscosity
    ay: np.ndarray
    density: np.ndarray  # of the scene's own soil in the particle's place, see sph.solver.physics.material
    solid_diff: np.ndarray  # deviator of the solid state, see sph.solver.physics.elasticity
    solid_xy: np.ndarray
    solid_zz: np.ndarray
    fluid_diff: np.ndarray  # deviator of the fluid state
    fluid_xy: np.ndarray
    fluid_zz: np.ndarray
    beta: np.ndarray  # weight of the solid state
    t_f: np.ndarray  # time of failure, NaN before
    phase: np.ndarray  # uint8: UNARMED, ARMED, FAILED, HELD, YIELDED
    sxx: np.ndarray  # stress of the momentum equation over density squared
    syy: np.ndarray
    sxy: np.ndarray
    syx: np.ndarray
    viscous_x: np.ndarray  # acceleration by artificial viscosity, artificial stress and other forces that dissipate
    viscous_y: np.ndarray
    x_pairs: np.ndarray  # positions at which the pairs were made
    y_pairs: np.ndarray
    density_pairs: np.ndarray  # and densities
    x_candidates: np.ndarray  # positions at which the candidates were made
    y_candidates: np.ndarray
    mode_x: np.ndarray  # shape of the stiffest mode, see sph.solver.time_step
    mode_y: np.ndarray
    work: np.ndarray  # (7,)
