"""Seams: soil slips along a given line with the strength of a shear box, whatever the spacing.

A layer of weak soil that is thinner than the kernel's reach shears the stronger soil beside it and appears too strong.  A seam is
instead a discontinuity between the particles on its two sides, that is those within the kernel's support of its line.

* **Kinematics.**  The gradient of a pair across the seam is turned normal to it, g_ij -> n (n . g_ij), in the loop over strains and in that
  over forces alike.  Sliding along the seam is then shear along it and nothing else: the steps of a lattice that does not follow the line
  do not interlock.  Pairs across it have neither artificial viscosity nor short-range repulsion.
* **Strength.**  The shear stress of these particles along the seam is at most tau = c + sigma_n tan(phi), with the effective normal stress
  sigma_n around the particle on its side; in tension beyond c / tan(phi) the seam opens.  The average goes by w_ij and by the gradients
  across the seam as they are, so that it is that of the force: single particles are pressed unevenly, and those that the other side has
  left not at all.  On all other planes the soil has its own strength, so that a seam is not squeezed out.
* **Slip.**  What exceeds the strength is plastic shear, (tau_trial - tau) / G.  A jump of 1 m across the line gives shear strains b(d) =
  integral of W along a line at the distance d.  So the slip is sum_j w_ij gamma_j / sum_j w_ij b(d_j), a displacement, without a width;
  w = (1 - (s / 2h)^2)^2 at the distance s along the seam, on one side of it.  It counts from the end of the gravity stage.  c and tan(phi)
  fall with it linearly from the peak's to the residual ones.
* Neither the spin of the slip nor its rate enters the rest: stress does not turn with it, and stiffness damping does not act on it.
  Mass-proportional damping, a drag on the velocity itself, would brake a block that slides without failing: with alpha = 0.47 1/s by 52 %
  of its speed after 4 s.  It fades with the part of a particle's velocity that is slip on the seams under it, and is off from one half on:
  the slip of single steps scatters by a quarter of its mean.

Sides and directions are those of the start.  Ubiquitous joints: Goodman, Taylor and Brekke (1968); strength on a given plane of soil that
does not dilate: Davis (1968), by whom an isotropic band with the same c and phi has c cos(phi) + sigma_n sin(phi).
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
import scipy  # type: ignore[import-untyped]

from sph.scene.places import shifted
from sph.scene.schema import Scene
from sph.solver.compiled.jit import compile_lock, jit
from sph.solver.compiled.records import by_reference
from sph.solver.compiled.slots import slot
from sph.solver.optional import Arrays, Term
from sph.solver.particles import Particles
from sph.solver.physics.elasticity import Deviator, rotate
from sph.solver.physics.kernels import Kernel, evaluate

if TYPE_CHECKING:
    from sph.solver.neighbours import Pairs
    from sph.solver.terms import State

OPENING = 0.99
"""Part of the tension that a seam bears, c / tan(phi), at which it opens."""
PARTS = 200
"""Parts in which the kernel is summed along a line."""


@by_reference
class Seams(NamedTuple):
    """Coefficients of the term."""

    side: np.ndarray
    """(particles,) int32: number of the seam from 1 on, negative on its right; 0 away from seams"""
    row: np.ndarray
    """(particles,) int32: where a particle of a seam stands in the arrays below, or -1; walls come after the soil"""
    particle: np.ndarray
    """(rows,) int32: the other way round"""
    soil_rows: int
    """rows of soil"""
    cosine: np.ndarray
    """(rows and those of walls,) of twice the angle of the seam"""
    sine: np.ndarray
    """(rows and those of walls,) likewise"""
    cohesion: np.ndarray
    """(rows, 2) at the peak, and lost in all, Pa"""
    friction: np.ndarray
    """(rows, 2) tan(phi), likewise"""
    slip_at_peak: np.ndarray
    """(rows,) m"""
    span: np.ndarray
    """(rows,) slip from there to the residual strength, m; infinite where nothing is lost"""
    first: np.ndarray
    """(rows + 1,) int32: where the neighbours of a row begin in the arrays below"""
    near: np.ndarray
    """(neighbours,) int32: rows on the same side within the kernel's support"""
    to_slip: np.ndarray
    """(neighbours,) slip over plastic shear, w / sum w b, m"""
    weight: np.ndarray
    """(neighbours,) w"""
    normal: np.ndarray
    """(rows,) effective normal stress on the seam in this step, compression positive, Pa"""
    shear: np.ndarray
    """(rows,) shear stress along the seam in this step, positive where it drives the soil above to the right, Pa"""
    foot: np.ndarray
    """(soil, most seams under a particle) rows of the upper side where seams pass under a particle, then -1"""
    along: np.ndarray
    """(rows, 2) direction of the seam, to the right"""
    dt: float
    """s"""
    armed_from: float
    """from when on slip counts, s"""


@jit
def _soil_row(seams: Seams, i: int) -> int:
    """Row of particle i among those of soil at seams; -1 for one that is not there."""
    k = seams.row[i]
    return k if k < seams.soil_rows else -1


@slot
def slide(seams: Seams | None, state: State, i: int, p: float, s: Deviator, weight: float, shear_modulus: float, time: float) -> Deviator:
    """Deviator (Pa) of a state of particle i, with its weight, whose stress on the seam is at most the seam's strength."""
    return s


@slide.of(Seams)
def _slide(seams: Seams, state: State, i: int, p: float, s: Deviator, weight: float, shear_modulus: float, time: float) -> Deviator:
    k = _soil_row(seams, i)
    if k < 0:
        return s
    cosine, sine = seams.cosine[k], seams.sine[k]
    in_plane = p + 0.5 * s.zz
    along, shear = s.diff * cosine + s.xy * sine, s.xy * cosine - s.diff * sine
    own = in_plane + along
    normal = state.seam_normal[i] if state.seam_normal[i] != 0.0 else own  # 0 before the first step only
    lost = min(max((state.seam_slip[i] - seams.slip_at_peak[k]) / seams.span[k], 0.0), 1.0)
    cohesion = seams.cohesion[k, 0] - lost * seams.cohesion[k, 1]
    friction = seams.friction[k, 0] - lost * seams.friction[k, 1]
    limit = max(cohesion + normal * friction, 0.0)
    held = min(max(shear, -limit), limit)
    if time >= seams.armed_from:
        state.seam_strain[i] += weight * abs(shear - held) / shear_modulus
    turned = rotate(Deviator(along, held, s.zz), 0.5 * (held - shear) / shear_modulus)  # back by the spin of the slip
    along, held = turned.diff, min(max(turned.xy, -limit), limit)
    opens = friction > 0.0 and normal * friction <= -OPENING * cohesion
    along += max(-cohesion / friction - (in_plane + along), 0.0) if opens else 0.0
    return Deviator(along * cosine - held * sine, along * sine + held * cosine, s.zz)


@slot
def keep_normal_stress(seams: Seams | None, i: int, p: float, s: Deviator) -> None:
    """Keep the effective normal stress of particle i on its seam."""


@keep_normal_stress.of(Seams)
def _keep_normal_stress(seams: Seams, i: int, p: float, s: Deviator) -> None:
    k = _soil_row(seams, i)
    if k >= 0:
        seams.normal[k] = p + 0.5 * s.zz + s.diff * seams.cosine[k] + s.xy * seams.sine[k]
        seams.shear[k] = s.xy * seams.cosine[k] - s.diff * seams.sine[k]


@slot
def without_slip(seams: Seams | None, i: int, rate: Deviator) -> Deviator:
    """Rate of the deviator of particle i without that of shear along its seam."""
    return rate


@without_slip.of(Seams)
def _without_slip(seams: Seams, i: int, rate: Deviator) -> Deviator:
    k = _soil_row(seams, i)
    if k < 0:
        return rate
    along = rate.diff * seams.cosine[k] + rate.xy * seams.sine[k]
    return Deviator(along * seams.cosine[k], along * seams.sine[k], rate.zz)


@slot
def average_seams(seams: Seams | None, state: State, pairs: Pairs, first: int, last: int) -> None:
    """Slip and mean normal stress of the particles first to last that lie at seams."""


@average_seams.of(Seams)
def _average_seams(seams: Seams, state: State, pairs: Pairs, first: int, last: int) -> None:
    for i in range(first, last):
        k = seams.row[i]
        if k >= 0:
            slip = normal = shear = grip = 0.0
            for m in range(seams.first[k], seams.first[k + 1]):
                j = seams.near[m]
                met = seams.weight[m] * pairs.grip[seams.particle[j]]
                slip += seams.to_slip[m] * state.seam_strain[seams.particle[j]]
                normal += met * seams.normal[j]
                shear += met * seams.shear[j]
                grip += met
            state.seam_speed[i] = math.copysign((slip - state.seam_slip[i]) / seams.dt, shear)
            state.seam_slip[i] = slip
            state.seam_normal[i] = normal / grip if grip > 0.0 else 0.0


@slot
def not_slip(seams: Seams | None, state: State, i: int) -> float:
    """Weight of particle i's mass-proportional damping: 1 if it does not slide on a seam, 0 if its velocity is slip by half or more."""
    return 1.0


@not_slip.of(Seams)
def _not_slip(seams: Seams, state: State, i: int) -> float:
    vx, vy = state.vx[i], state.vy[i]
    slip = 0.0
    for m in range(seams.foot.shape[1]):
        k = seams.foot[i, m]
        if k < 0:
            break
        slip += state.seam_speed[seams.particle[k]] * (vx * seams.along[k, 0] + vy * seams.along[k, 1])
    return 1.0 if slip <= 0.0 else max(1.0 - 2.0 * slip / (vx * vx + vy * vy), 0.0)


@slot
def across(seams: Seams | None, i: int, j: int) -> bool:
    """Whether particles i and j lie on the two sides of a seam."""
    return False


@across.of(Seams)
def _across(seams: Seams, i: int, j: int) -> bool:
    return seams.side[i] != 0 and seams.side[i] == -seams.side[j]


@slot
def turn_gradients(seams: Seams | None, pairs: Pairs, i: int, begin: int, count: int) -> None:
    """Turn the gradients of particle i's pairs across a seam, among the ``count`` from ``begin`` on, normal to it."""


@turn_gradients.of(Seams)
def _turn_gradients(seams: Seams, pairs: Pairs, i: int, begin: int, count: int) -> None:
    if seams.side[i] != 0:
        grip = 0.0
        for k in range(begin, begin + count):
            j = pairs.neighbour[k]
            if across(seams, i, j):
                a, b = seams.row[i], seams.row[j]
                c, s = 0.5 * (seams.cosine[a] + seams.cosine[b]), 0.5 * (seams.sine[a] + seams.sine[b])  # the same for both directions
                gx, gy = np.float64(pairs.gx[k]), np.float64(pairs.gy[k])
                nx, ny = 0.5 * ((1.0 - c) * gx - s * gy), 0.5 * ((1.0 + c) * gy - s * gx)
                pairs.gx[k] = nx
                pairs.gy[k] = ny
                pairs.inverse_norm[k] = 0.0  # no artificial viscosity
                grip += math.sqrt(nx * nx + ny * ny)
        pairs.grip[i] = grip


def line_integral(kernel: Kernel, distance: np.ndarray) -> np.ndarray:
    """Integral (n,) of W along a line at distances (n,) from it (m), 1/m; over both sides of the line it sums to 1."""
    reach = 2.0 * kernel.h
    along = (np.arange(PARTS) + 0.5) / PARTS * reach
    places = np.linspace(0.0, reach, PARTS + 1)
    with compile_lock(required=False):
        values = [2.0 * reach / PARTS * sum(evaluate(kernel, math.hypot(place, part))[0] for part in along) for place in places]
    found: np.ndarray = np.interp(distance, places, values, right=0.0)
    return found


def _in_survey(scene: Scene, particles: Particles) -> tuple[np.ndarray, np.ndarray]:
    """Places (n,) of particles in the coordinates of the seams, m; walls go on as the soil beside them."""
    geometry, half = scene.geometry, 0.5 * scene.numerics.spacing
    beside = np.clip(particles.x, half, geometry.width - half), np.maximum(particles.y, half)
    return geometry.in_survey(*shifted(*beside, scene.numerics.spacing, scene.numerics.lattice_shift))


def _feet(scene: Scene, particles: Particles, side: np.ndarray, row: np.ndarray) -> np.ndarray:
    """``Seams.foot``, by the side of a seam on which particles lie and their rows."""
    x, y = (places[: particles.n_soil] for places in _in_survey(scene, particles))
    feet = np.full((particles.n_soil, max(len(scene.seams), 1)), -1, np.int32)
    count = np.zeros(particles.n_soil, int)
    for number, seam in enumerate(scene.seams.values(), 1):
        height = seam.under(x, y)
        above = np.flatnonzero(scene.geometry.in_box(x, height)[1] > 0.0)  # where it has not left the ground through the base
        upper = above[np.abs(side[above]) == number]
        if upper.size:
            _, nearest = scipy.spatial.cKDTree(np.column_stack([x, y])[upper]).query(np.column_stack([x, height])[above])
            feet[above, count[above]] = row[upper[nearest]]
            count[above] += 1
    return feet[:, : max(int(count.max(initial=0)), 1)].copy()


def seam_sides(scene: Scene, particles: Particles) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Side of a seam (n,) on which particles lie, see ``Seams.side``, with their distance (n,) from it, m, and its angle (n,), rad.

    Those within the kernel's support of the nearest seam, which is infinitely far beyond its ends.
    """
    side, distance, angle = np.zeros(particles.x.size, np.int32), np.full(particles.x.size, np.inf), np.zeros(particles.x.size)
    x, y = _in_survey(scene, particles)
    for number, seam in enumerate(scene.seams.values(), 1):
        offset, direction = seam.offset(x, y)
        nearer = np.flatnonzero((np.abs(offset) < 2.0 * scene.numerics.smoothing_length) & (np.abs(offset) < distance))
        side[nearer] = np.where(offset[nearer] >= 0.0, number, -number)
        distance[nearer] = np.abs(offset[nearer])
        angle[nearer] = scene.geometry.direction * direction[nearer]
    return side, distance, angle


class SeamState(NamedTuple):
    """What the term keeps of the state."""

    seam_strain: np.ndarray  # (n,) plastic shear along a seam since the gravity stage
    seam_slip: np.ndarray  # (n,) displacement across the seam, m
    seam_normal: np.ndarray  # (n,) mean normal stress on it, Pa
    seam_speed: np.ndarray  # (n,) velocity of the soil above it over that below by the slip of the step, to the right, m/s


def _start(scene: Scene, particles: Particles) -> SeamState:
    n = particles.x.size
    return SeamState(np.zeros(n), np.zeros(n), np.zeros(n), np.zeros(n))


def _make(scene: Scene, particles: Particles, kernel: Kernel, dt: float) -> Seams:
    side, distance, angle = seam_sides(scene, particles)
    found = np.flatnonzero(side)
    row = np.full(particles.x.size, -1, np.int32)
    row[found] = np.arange(found.size)
    every, found = found, found[found < particles.n_soil]
    jump, reach = line_integral(kernel, distance[found]), 2.0 * kernel.h
    x, y = particles.x[found], particles.y[found]
    first, near, to_slip, weights = [0], [np.zeros(0, int)], [np.zeros(0)], [np.zeros(0)]
    for i, own in zip(range(found.size), side[found], strict=True):
        apart = (x - x[i]) ** 2 + (y - y[i]) ** 2 - (distance[found] - distance[found][i]) ** 2  # squared, along the seam
        there = np.flatnonzero((side[found] == own) & (apart < reach**2))
        weight = (1.0 - np.maximum(apart[there], 0.0) / reach**2) ** 2
        first.append(first[-1] + there.size)
        near.append(there)
        to_slip.append(weight / (weight @ jump[there]))
        weights.append(weight)
    dip = np.arctan(np.tan(angle[found]))
    seams = list(scene.seams.values())
    peak, residual, slips = (
        np.array(values)[np.abs(side[found]) - 1].reshape(found.size, 2)
        for values in (
            [seam.peak for seam in seams],
            [seam.residual for seam in seams],
            [(seam.slip_at_peak, math.inf if seam.slip_at_residual is None else seam.slip_at_residual) for seam in seams],
        )
    )
    return Seams(
        side,
        row,
        found.astype(np.int32),
        found.size,
        np.cos(2.0 * angle[every]),
        np.sin(2.0 * angle[every]),
        np.column_stack([peak[:, 0], (peak - residual)[:, 0]]),
        np.column_stack([peak[:, 1], (peak - residual)[:, 1]]),
        slips[:, 0].copy(),
        slips[:, 1] - slips[:, 0],
        np.array(first, np.int32),
        np.concatenate(near).astype(np.int32),
        np.concatenate(to_slip),
        np.concatenate(weights),
        np.zeros(found.size),
        np.zeros(found.size),
        _feet(scene, particles, side, row),
        np.column_stack([np.cos(dip), np.sin(dip)]),
        float(dt),
        float(scene.gravity.duration - 0.5 * dt),
    )


class SeamPairs(NamedTuple):
    """What the term keeps with the pairs."""

    grip: np.ndarray  # (n,) sum of |g| across a seam, kg/m4: how much of its other side a particle meets


def _room(n: int, size: int, dtype: np.dtype[Any]) -> SeamPairs:
    return SeamPairs(np.zeros(n))


TERM = Term(
    "seams",
    "seams: weak planes in the soil",
    lambda scene: bool(scene.seams),
    _make,
    in_pairs=True,
    state=Arrays(SeamState, _start),
    pairs=Arrays(SeamPairs, _room),
)
