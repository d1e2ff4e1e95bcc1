"""Whether failed soil met the sides of the box, which then limit its run-out and possibly the failure itself.

Met is a side where soil that has failed and has moved by more than a threshold since the gravity stage lies within a smoothing
length of it, in any frame.  Wherever it comes from: the apron that debris pushes ahead meets a side first, and moves little, since the side
holds it.  The threshold is therefore a part of the largest displacement where that is small: a slope of 8 m whose crest went 0.51 m
instead of 0.61 m had moved the failed apron at the side by 0.25 m, and sides that changed nothing by at most 3 % of what moved most.
Soil thrown ahead of the main mass does not count, soil that has left the box always does.
"""

from __future__ import annotations

import numpy as np

from sph.measures.linked import largest_mass
from sph.output.run import Run
from sph.solver.particles import SIDE

PART, LEAST = 0.1, 0.2
"""Part of the largest displacement of failed soil that counts as movement at a side, and the least over the threshold."""
FRONT, BACK, OVER = "front", "back", "over"
"""The end of the box in front of the toe; that behind the crest; over the top of a side, or out of the box."""


def reached_sides(run: Run, moved: float, link: float) -> dict[str, float]:
    """Time (s) of the first frame in which failed soil that has moved by more than ``moved`` (m) is at each side that it meets.

    At a side less counts where nothing has moved far: ``PART`` of the largest displacement of failed soil, at least ``LEAST`` of ``moved``.

    ``link``: distance (m) up to which particles hang together as one mass.  Periodic sides are none.
    """
    scene, sides = run.scene, run.scene.walls.kinds.sides
    if sides.periodic:
        return {}
    wall = run["kind"] == SIDE
    spacing, near = scene.numerics.spacing, scene.numerics.smoothing_length
    width = scene.lattice[0] * spacing
    x_wall, y_wall = run["x0"][wall], run["y0"][wall]
    tops = {
        side: float(y_wall[there].max(initial=-np.inf)) + 0.5 * spacing for side, there in ((FRONT, x_wall < 0), (BACK, x_wall > width))
    }
    start, reached = run.gravity_frame, dict[str, float]()
    from_x, from_y = run.soil_at(start, "displacement_x", "displacement_y")
    for frame, time in enumerate(run["time"][start:], start):
        x, y, by_x, by_y = run.soil_at(frame, "x", "y", "displacement_x", "displacement_y")
        failed, by = run["failed"][frame, run.soil] == 1, np.hypot(by_x - from_x, by_y - from_y)
        debris, pushed = failed & (by > moved), failed & (by > np.clip(PART * by[failed].max(initial=0.0), LEAST * moved, moved))
        if (debris & ((x < 0) | (x > width))).any():
            reached.setdefault(OVER, float(time))
        at = {FRONT: pushed & (x < near), BACK: pushed & (x > width - near)} if sides.has_particles else {}
        new = {side: there for side, there in at.items() if there.any() and not {side, OVER} <= reached.keys()}
        mass = largest_mass(x, y, link) if new else np.zeros(0, bool)
        for side, there in new.items():
            if (there & mass).any():
                reached.setdefault(side, float(time))
            if (there & debris & mass & (y > tops[side])).any():
                reached.setdefault(OVER, float(time))
    return {side: reached[side] for side in (FRONT, BACK, OVER) if side in reached}
