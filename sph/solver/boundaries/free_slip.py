"""Free-slip walls, and Coulomb friction on them.

The paper's fixed boundary particles hold the soil: it hangs on the back wall and yields early.  A
free-slip wall particle mirrors the soil beside it instead of having a state of its own: it takes
the soil's mean velocity along the wall and stands still across, so that no shear strain arises, and it
takes the soil's mean normal stresses without shear.  Means are weighted with the norm of the kernel
gradient; any positive weight would do.

Friction acts on the soil within the kernel's reach of a wall, each particle with as much of it as it has of the wall's
normal force: the wall's particles press on particle i with sum_j (sigma_i + sigma_j) . g_ij over them, and friction
opposes its velocity along the wall with the coefficient times that, or stops it (``sph.solver.integration``).  A wall that
pulls gives none.  The soil's own shear stress, which is there once friction acts, would pull at the wall as well
(sigma_i . g_ij has a part along the wall); that part is taken away, so that friction is all there is along the wall.
Steady sliding of an elastic body under constant friction is unstable in itself (Adams 1995): without damping a block of
stiff soil begins to hum after some tenths of a second, lifts off and slides wrongly.  Stiffness-proportional damping
(``damping`` with one of its frequencies near zero, so that no mass damping brakes the sliding) keeps it down.
"""

from __future__ import annotations

import math

from sph.solver.compiled.jit import jit
from sph.solver.compiled.threads import wait
from sph.solver.physics.coupling import power
from sph.solver.physics.material import lightness
from sph.solver.physics.momentum import stress_accelerations, transposed_shear


@jit
def _mean_of_soil(pairs, i, n_soil, values):  # type: ignore[no-untyped-def]
    total = weights = 0.0
    for k in range(pairs.start[i], pairs.end[i]):
        j = pairs.neighbour[k]
        if j < n_soil and pairs.inverse_norm[k] > 0.0:
            weight = 1.0 / pairs.inverse_norm[k]
            total += weight * values[j]
            weights += weight
    return total / weights if weights > 0.0 else 0.0


@jit
def mirror_velocity(term, state, pairs, n_soil, first, last, team):  # type: ignore[no-untyped-def]
    """Velocity along the wall of the wall particles among first to last, from the soil beside them, m/s."""
    if term is None:
        return
    else:
        for i in range(max(term.first, first), min(term.first_side, last)):
            state.vx[i] = _mean_of_soil(pairs, i, n_soil, state.vx)
        for i in range(max(term.first_side, first), last):
            state.vy[i] = _mean_of_soil(pairs, i, n_soil, state.vy)
        wait(team)


@jit
def mirror_stress(term, state, pairs, n_soil, first, last, team):  # type: ignore[no-untyped-def]
    """Normal stresses of the wall particles among first to last from the soil beside them; no shear."""
    if term is None:
        return
    else:
        for i in range(max(term.first, first), last):
            state.sxx[i] = _mean_of_soil(pairs, i, n_soil, state.sxx)
            state.syy[i] = _mean_of_soil(pairs, i, n_soil, state.syy)
        wait(team)


@jit
def wall_work(term, layers, state, pairs, correction, cell_mass, gradient, first, last):  # type: ignore[no-untyped-def]
    """Energy that the walls among particles first to last take from the soil, over dt (W/m, negative: give).

    A frictionless wall should take none.  This one's particles stay where they are while the soil slides
    past, so the mirror is not exact: in a collapsing slope it gives some per cent of the energy released.
    """
    if term is None:
        return 0.0
    else:
        taken = 0.0
        for i in range(max(term.first, first), last):
            stress_accelerations(state, pairs, correction, layers, i, i + 1)
            taken += cell_mass * (
                power(correction, state, gradient, i)
                + (state.ax[i] - state.viscous_x[i]) / lightness(layers, i) * state.vx[i]
                + (state.ay[i] - state.viscous_y[i]) / lightness(layers, i) * state.vy[i]
            )
        return taken


@jit
def set_friction(term, layers, slip, correction, state, pairs, mass, first, last):  # type: ignore[no-untyped-def]
    """Largest acceleration that the walls' friction can give soil particles first to last (m/s2), in place of the walls' shear.

    Returns the energy over dt that goes with the shear taken away, W/m.
    """
    if term is None or slip is None:
        return 0.0
    else:
        taken = 0.0
        sxx, syy, sxy = state.sxx, state.syy, state.sxy
        syx = transposed_shear(correction, state)
        for i in range(first, last):
            base = side = base_shear = side_shear = 0.0
            for k in range(pairs.start[i], pairs.end[i]):
                j = pairs.neighbour[k]
                gx, gy = pairs.gx[k], pairs.gy[k]  # towards the wall, compression is negative
                if j >= slip.first:
                    ax = (sxx[i] + sxx[j]) * gx + (sxy[i] + sxy[j]) * gy
                    ay = (syx[i] + syx[j]) * gx + (syy[i] + syy[j]) * gy
                    if j >= slip.first_side:
                        side -= math.copysign(1.0, gx) * ax
                        side_shear += ay
                    else:
                        base -= math.copysign(1.0, gy) * ay
                        base_shear += ax
            base_shear *= lightness(layers, i)
            side_shear *= lightness(layers, i)
            state.friction_x[i] = term.base * max(base, 0.0) * lightness(layers, i)
            state.friction_y[i] = term.sides * max(side, 0.0) * lightness(layers, i)
            state.ax[i] -= base_shear
            state.ay[i] -= side_shear
            taken += mass[i] * (base_shear * state.vx[i] + side_shear * state.vy[i])
        return taken
