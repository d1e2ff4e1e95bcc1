"""The faces of the walls: no soil passes between the particles of a wall.

Walls are particles, and their forces alone do not keep loose soil in the box: nothing stops a particle half-way between two of the
wall's, so that debris sinks through a slip floor and a slamming soft soil enters a fixed wall.  The face, half a spacing before the wall's
first particles, therefore pushes with a linear, conservative spring: at a free-slip wall what comes nearer than 0.4 spacings, at a
fixed one, which the soil sticks to, only what is behind the face (``CONTACT``).  The initial lattice lies half a spacing away
and feels nothing; in the paper's scene no soil ever reaches a face.  Friction counts the push of a slip wall as it counts its stress.
"""

from __future__ import annotations

from sph.solver.compiled.jit import jit, rows


@jit
def add_contact(term, friction, state, mass, first, last):  # type: ignore[no-untyped-def]
    """Add the push of the walls' faces to soil particles first to last, and its friction; returns the energy it stores, J/m."""
    if term is None:
        return 0.0
    else:
        energy = 0.0
        for i in rows(first, last):
            x, y = state.x[i], state.y[i]
            across = up = 0.0  # how far the particle is in a contact, m, with the sign of the push
            if y <= term.height:
                across = _overlap(term, x - term.left, term.right - x, term.side_contact, term.side_contact)
            if term.begin <= x <= term.end:
                up = _overlap(term, y - term.bottom, term.top - y, term.bottom_contact, term.top_contact)
            if across != 0.0 or up != 0.0:
                energy += 0.5 * term.stiffness * (across * across + up * up)
                state.ax[i] += term.stiffness * across / mass[i]
                state.ay[i] += term.stiffness * up / mass[i]
                _rub(friction, state, i, term.stiffness * abs(across) / mass[i], term.stiffness * abs(up) / mass[i])
        return energy


@jit
def _overlap(term, low, high, low_contact, high_contact):  # type: ignore[no-untyped-def]
    """Overlap with the contact of the face below (positive) or above (negative) at these distances, m."""
    if -term.thickness < low < low_contact:
        return low_contact - low
    if -term.thickness < high < high_contact:
        return high - high_contact
    return 0.0


@jit
def _rub(term, state, i, push_x, push_y):  # type: ignore[no-untyped-def]
    if term is None:
        return
    else:
        state.friction_x[i] += term.base * push_y
        state.friction_y[i] += term.sides * push_x
