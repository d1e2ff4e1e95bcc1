"""Free-slip side walls.

The paper's fixed boundary particles hold the soil: it hangs on the back wall and yields early.  A
free-slip wall particle mirrors the soil beside it instead of having a state of its own: it takes
the soil's mean vertical velocity and stands still across, so that no shear strain arises, and it
takes the soil's mean normal stresses without shear.  Means are weighted with the norm of the kernel
gradient; any positive weight would do.
"""

from __future__ import annotations

from sph.coupling import power
from sph.jit import jit
from sph.momentum import stress_accelerations
from sph.team import wait


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
    """Vertical velocity of the wall particles among first to last from the soil beside them, m/s."""
    if term is None:
        return
    else:
        for i in range(max(term.first, first), last):
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
def wall_work(term, state, pairs, correction, mass, gradient, first, last):  # type: ignore[no-untyped-def]
    """Energy that the walls among particles first to last take from the soil, over dt (W/m, negative: give).

    A frictionless wall should take none.  This one's particles stay where they are while the soil slides
    past, so the mirror is not exact: in a collapsing slope it gives some per cent of the energy released.
    """
    if term is None:
        return 0.0
    else:
        taken = 0.0
        for i in range(max(term.first, first), last):
            stress_accelerations(state, pairs, correction, i, i + 1)
            taken += mass[i] * (power(correction, state, gradient, i) + (state.ay[i] - state.viscous_y[i]) * state.vy[i])
        return taken
