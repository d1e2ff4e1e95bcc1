"""Mobilised strength: the share of its peak strength that soil mobilises, above all at the end of the gravity stage, before the shaking.

Of a particle it is the radius of the Mohr circle of its effective stress in the section over that of the circle at yield with the same
centre (Mohr-Coulomb, plane strain),

    r / r_y,   r^2 = ((sigma_xx - sigma_yy) / 2)^2 + sigma_xy^2,   r_y = c cos(phi) + p sin(phi),   p = -(sigma_xx + sigma_yy) / 2,

1 at yield.  Single particles scatter, so that of a layer it is the sum of r over the sum of r_y in a disc a half of the slope's height
wide, there where this is largest: in thin seams a stretch of that length, whatever the spacing and the size of the box.  Discs lie around
particles of the layer no further than the slope's height before the toe and behind the crest, and clear of walls on which soil hangs.
"""

from __future__ import annotations

import numpy as np
import scipy  # type: ignore[import-untyped]

from sph.output.run import Run
from sph.scene.geometry import SLOPES
from sph.scene.schema import Scene

DISC = 0.5
"""Diameter of the disc over the slope's height."""
FULL = 0.25
"""Least number of the layer's particles in a disc, over the largest: fewer, at the layer's ends, are single particles."""
MAX_DISCS = 4000
"""Most discs of a layer, around particles evenly through it."""


def circles(run: Run, frame: int) -> tuple[np.ndarray, np.ndarray]:
    """Radius of the Mohr circle of each particle (n,) in a frame, and that at yield, Pa."""
    cohesion, angle = run.strength
    xx, yy, xy = (run[f"stress_{axes}"][frame].astype(float) for axes in ("xx", "yy", "xy"))
    at_yield = cohesion * np.cos(angle) - 0.5 * (xx + yy) * np.sin(angle)
    return np.hypot(0.5 * (xx - yy), xy), np.maximum(at_yield, 0.0)


def mobilised(run: Run, frame: int) -> np.ndarray:
    """Share (n,) of its peak strength that each particle mobilises in a frame; 1 where it has none, as at the ground without cohesion."""
    radius, at_yield = circles(run, frame)
    return np.where(at_yield > 0.0, radius / np.where(at_yield > 0.0, at_yield, 1.0), 1.0)


def mobilised_by_layer(run: Run, frame: int) -> dict[str, float]:
    """Share of its peak strength that each layer near the slope mobilises in a frame, by name; ``soil`` is the scene's own."""
    scene = run.scene
    radius, at_yield = circles(run, frame)
    places, near = np.column_stack([run[axis][frame].astype(float) for axis in ("x", "y")]), _near(run)
    shares = {}
    for number, name in enumerate(("soil", *scene.layers)):
        there = run.soil & (run["layer"] == number) & np.isfinite(places).all(axis=1)
        centres = places[there & near]
        if not len(centres):
            continue
        tree = scipy.spatial.cKDTree(places[there])
        discs = tree.query_ball_point(centres[:: -(-len(centres) // MAX_DISCS)], 0.5 * DISC * height_of(scene))
        used, there_is, count = (np.array([of[there][disc].sum() for disc in discs]) for of in (radius, at_yield, np.ones_like(radius)))
        full = (count >= FULL * count.max()) & (there_is > 0.0)
        shares[name] = float((used[full] / there_is[full]).max()) if full.any() else 1.0
    return shares


def height_of(scene: Scene) -> float:
    """Height of the slope, or of a shape without one, m."""
    geometry = scene.geometry
    return geometry.slope_height if isinstance(geometry, SLOPES) else geometry.height


def _near(run: Run) -> np.ndarray:
    """Which particles (n,) lie near the slope, and clear of sides that hold soil; all of a shape without a slope."""
    scene, geometry, x = run.scene, run.scene.geometry, run["x0"]
    if not isinstance(geometry, SLOPES):
        return np.ones(x.size, bool)
    near = (geometry.toe[0] - height_of(scene) <= x) & (x <= geometry.crest[0] + height_of(scene))
    if scene.walls.kinds.sides.holds_soil:
        near &= np.minimum(x, geometry.width - x) > 2.0 * scene.numerics.smoothing_length + 0.5 * DISC * height_of(scene)
    return near
