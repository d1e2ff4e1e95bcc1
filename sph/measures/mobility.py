"""What is held beside a run-out, so that one that is too short is seen: the energy line of a sliding point, and slides of the field.

Both are lines from the original crest edge down to where they meet the ground.  The sliding point keeps the residual friction of its soil
(Heim 1932, Bergsturz und Menschenleben), on effective stress: the apparent friction (1 - r_u) tan(phi') of an undrained slide (Sassa
1988, Geotechnical model for the motion of landslides, 5th Int. Symp. on Landslides, 37-55), at the base of the mass, along which it slides.
The mass is what has gone at least ``PART`` as far as what went farthest: rock below a cover that has failed, too, moves by a metre where
the cover runs tens of metres, and is no part of it.  Cohesion, what the mass loses as it deforms,
and its spread about its centre are left out.  ASSUME: the mass keeps the r_u that it has where it starts.
"""

from __future__ import annotations

import math

import numpy as np

from sph.measures.sides import PART
from sph.output.run import Run
from sph.scene.geometry import Slope
from sph.scene.ground_line import GroundLine
from sph.solver.particles import overburden
from sph.solver.physics.pore_pressure import effective_overburden

COROMINAS = (-0.012, -0.105)
"""log10 of the tangent of the travel angle of a volume of 1 m3, and its change by log10 of the volume in m3, of debris flows, debris slides
and debris avalanches on all kinds of path (Corominas 1996, Canadian Geotechnical Journal 33, 260-271)."""


def sliding(run: Run, soil: np.ndarray) -> np.ndarray:
    """Which of some ``soil`` (soil,) belong to the mass that slides, by their displacement at the end."""
    by = np.hypot(*run.displacement())[run.soil]
    return soil & (by >= PART * by[soil].max(initial=0.0))


def residual_tangent(run: Run, soil: np.ndarray) -> float:
    """tan(phi_a) of some ``soil`` (soil,) that slides: the effective friction (1 - r_u) tan(phi_r) that its base keeps after failure, the
    mean over the columns of particles by their weight; NaN where nothing is left of it."""
    of = base_of(run, np.flatnonzero(run.soil)[soil])
    peak, layer = run.strength[:, of], run["layer"][of]
    tangent = np.zeros(of.size)
    for number, material in enumerate(run.scene.materials):
        here = layer == number
        angles = [material.kept(cohesion, angle, 1e3, math.radians(1.0))[1] for cohesion, angle in peak[:, here].T]
        tangent[here] = np.tan(angles)
    effective, weight = base_stress(run, of)
    mean = float((effective * tangent).sum() / weight.sum())
    return mean if mean > 0.0 else math.nan


def base_of(run: Run, of: np.ndarray) -> np.ndarray:
    """Numbers (columns,) of the lowest particles of a mass, as it lies at the start, of those with the numbers ``of``."""
    column, y = np.round(run["x0"][of] / run.scene.numerics.spacing), run["y0"][of]
    order = np.lexsort((y, column))
    return of[order[np.unique(column[order], return_index=True)[1]]]


def base_stress(run: Run, of: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Effective and total vertical stress (columns,) below the particles with the numbers ``of``, Pa.

    The pore pressure is that of the initial slope, and its largest rise by cyclic shear on top (``cyclic_pore_pressure``).  Standing water
    neither drives nor presses: under it the weight is that under buoyancy.
    """
    scene = run.scene
    x, y = run["x0"][of], run["y0"][of] - 0.5 * scene.numerics.spacing
    weight = scene.gravity.acceleration * overburden(scene, x, y)
    if scene.water is None:
        return weight, weight
    effective = effective_overburden(scene, x, y)
    if scene.water.r_u is None:
        weight = np.where(scene.water.surface(scene.geometry, x) > scene.geometry.ground(x), effective, weight)
    if "pore_pressure_ratio" in run:
        effective = effective * (1.0 - run["pore_pressure_ratio"][:, of].max(axis=0))
    return effective, weight


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
