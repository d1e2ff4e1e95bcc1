"""What is held beside a run-out, so that one that is too short is seen: the energy line of a sliding point, and slides of the field.

Both are lines from the original crest edge down to where they meet the ground.  The sliding point keeps the residual friction of its soil
(Heim 1932, Bergsturz und Menschenleben), on effective stress: the apparent friction (1 - r_u) tan(phi') of an undrained slide (Sassa
1988, Geotechnical model for the motion of landslides, 5th Int. Symp. on Landslides, 37-55).  Cohesion, what the mass loses as it deforms,
and its spread about its centre are left out.  ASSUME: the mass keeps the r_u that it has where it starts.
"""

from __future__ import annotations

import math

import numpy as np

from sph.output.run import Run
from sph.scene.geometry import Slope
from sph.scene.ground_line import GroundLine
from sph.solver.particles import overburden
from sph.solver.physics.pore_pressure import effective_overburden

COROMINAS = (-0.012, -0.105)
"""log10 of the tangent of the travel angle of a volume of 1 m3, and its change by log10 of the volume in m3, of debris flows, debris slides
and debris avalanches on all kinds of path (Corominas 1996, Canadian Geotechnical Journal 33, 260-271)."""


def residual_tangent(run: Run, soil: np.ndarray) -> float:
    """tan(phi_a) = (1 - r_u) tan(phi_r) of some ``soil`` (soil,): the mean over its mass of the tangent of the effective friction angle
    that it keeps after failure, times the share of its weight that water does not carry; NaN where nothing is left of it."""
    of = np.flatnonzero(run.soil)[soil]
    peak, layer, mass = run.strength[:, of], run["layer"][of], run["mass"][of]
    tangent = np.zeros(of.size)
    for number, material in enumerate(run.scene.materials):
        here = layer == number
        angles = [material.kept(cohesion, angle, 1e3, math.radians(1.0))[1] for cohesion, angle in peak[:, here].T]
        tangent[here] = np.tan(angles)
    mean = effective_share(run, of) * float(np.average(tangent, weights=mass))
    return mean if mean > 0.0 else math.nan


def effective_share(run: Run, of: np.ndarray) -> float:
    """1 - r_u at the base of a mass of particles with the numbers ``of``: effective over total stress, both vertical, summed over the base.

    The pore pressure is that of the initial slope, and its largest rise by cyclic shear on top (``cyclic_pore_pressure``).  Standing water
    neither drives nor presses: under it the weight is that under buoyancy.
    """
    scene = run.scene
    if scene.water is None:
        return 1.0
    x, y, spacing = run["x0"][of], run["y0"][of], scene.numerics.spacing
    order = np.lexsort((y, np.round(x / spacing)))
    lowest = order[np.unique(np.round(x[order] / spacing), return_index=True)[1]]  # particle of each column
    x, y = x[lowest], y[lowest] - 0.5 * spacing
    weight = scene.gravity.acceleration * overburden(scene, x, y)
    effective = effective_overburden(scene, x, y)
    if scene.water.r_u is None:
        weight = np.where(scene.water.surface(scene.geometry, x) > scene.geometry.ground(x), effective, weight)
    if "pore_pressure_ratio" in run:
        effective = effective * (1.0 - run["pore_pressure_ratio"][:, of[lowest]].max(axis=0))
    return float(effective.sum() / weight.sum())


def corominas_tangent(volume: float) -> float:
    """Mean tangent of the travel angle of debris slides and flows of a volume, m3."""
    return float(10.0 ** COROMINAS[0] * volume ** COROMINAS[1])


def line_runout(geometry: Slope | GroundLine, tangent: float) -> float:
    """Run-out (m) of a line that falls from the crest edge to the toe's side with a gradient and ends where it meets the ground, which is
    level beyond the model; at least 0; NaN without a gradient."""
    if math.isnan(tangent):
        return math.nan
    (crest_x, crest_y), (x, y) = geometry.crest, map(np.array, geometry.surface)
    before = x < crest_x
    x, y = np.append(x[before], crest_x)[::-1], np.append(y[before], crest_y)[::-1]  # from the crest edge downhill
    head = crest_y - tangent * (crest_x - x) - y
    head[0] = 0.0
    ended = np.flatnonzero(head[1:] < 0.0)
    if not ended.size:
        return max(0.0, float(geometry.toe[0] - x[-1] + head[-1] / tangent))
    first = int(ended[0])
    part = head[first] / (head[first] - head[first + 1])
    return max(0.0, float(geometry.toe[0] - (x[first] + part * (x[first + 1] - x[first]))))
